"""Least squares on made-up friction: estimates, intervals, and what cannot be known."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.identify.fit import fit_presliding, fit_sliding
from motionlab.identify.presliding import force_ramp, model_response
from motionlab.identify.stribeck import curve_half_width, stribeck_curve
from motionlab.plant.friction import LuGre

TRUE = (0.24, 3.59, 0.0436, 10.3, 0.05)
NAMES = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
SPEEDS = np.geomspace(0.5e-3, 0.15, 32)
VELOCITY = np.concatenate([SPEEDS, -SPEEDS])


def test_exact_data_give_exact_parameters() -> None:
    fitted = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE))
    assert [fitted[name] for name in NAMES] == pytest.approx(TRUE, rel=1e-6)
    assert fitted.residual_rms < 1e-8
    assert fitted.warnings == []


def test_the_intervals_hold_what_they_promise() -> None:
    """95 % of 300 noisy experiments, give or take three standard deviations of that count."""
    rng = np.random.default_rng(1)
    repeats = 300
    inside = np.zeros(len(NAMES))
    for _ in range(repeats):
        noise = 0.02 * rng.standard_normal(len(VELOCITY))
        fitted = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE) + noise)
        inside += np.abs(fitted.values - TRUE) <= fitted.half_width
    assert inside / repeats == pytest.approx(0.95, abs=0.04)


def test_the_band_holds_the_true_curve_as_often_as_it_says() -> None:
    """300 repetitions; at each velocity 95 % but for three standard deviations of that count."""
    rng = np.random.default_rng(6)
    repeats = 300
    v = np.array([-0.12, -0.03, -0.005, 0.002, 0.02, 0.044, 0.1])
    true = stribeck_curve(v, TRUE)
    inside = np.zeros(len(v))
    for _ in range(repeats):
        noise = 0.02 * rng.standard_normal(len(VELOCITY))
        fitted = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE) + noise)
        half = curve_half_width(v, fitted)
        assert half is not None
        inside += np.abs(stribeck_curve(v, fitted.values) - true) <= half
    assert inside / repeats == pytest.approx(0.95, abs=0.04)


def test_a_curve_that_is_not_determined_has_no_band() -> None:
    fast = VELOCITY[np.abs(VELOCITY) > 0.02]
    fitted = fit_sliding(fast, np.sign(fast) * 1.0 + 10.0 * fast)
    assert curve_half_width(fast, fitted) is None


def test_without_slow_speeds_stiction_is_not_known() -> None:
    fast = np.abs(VELOCITY) > 0.08
    noise = 0.01 * np.random.default_rng(2).standard_normal(int(fast.sum()))
    fitted = fit_sliding(VELOCITY[fast], stribeck_curve(VELOCITY[fast], TRUE) + noise)
    text = "; ".join(fitted.warnings)
    assert "F_s" in text
    assert "v_s" in text


def test_without_a_stribeck_effect_v_s_cannot_be_identified() -> None:
    flat = stribeck_curve(VELOCITY, (1.0, 1.0, 0.04, 10.0, 0.0))
    noise = 0.01 * np.random.default_rng(3).standard_normal(len(flat))
    fitted = fit_sliding(VELOCITY, flat + noise)
    assert any(w.startswith("v_s") for w in fitted.warnings), fitted.warnings


def test_what_no_datum_depends_on_has_no_error() -> None:
    """All speeds so far above v_s that the falling part is zero to the last bit."""
    fast = VELOCITY[np.abs(VELOCITY) > 0.02]
    force = np.sign(fast) * 1.0 + 10.0 * fast
    fitted = fit_sliding(fast, force)
    unknown = [n for n, e in zip(fitted.names, fitted.errors, strict=True) if np.isinf(e)]
    assert "v_s" in unknown
    assert not {"sigma_2", "f_0"} & set(unknown)
    assert any(w.startswith("v_s") for w in fitted.warnings)


def test_friction_that_only_rises_is_no_lugre_model() -> None:
    rising = stribeck_curve(VELOCITY, (2.0, 1.0, 0.03, 5.0, 0.0))
    assert any("is below F_c" in w for w in fit_sliding(VELOCITY, rising).warnings)


def test_ramps_give_back_what_made_them() -> None:
    sliding = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE))
    forces = [force_ramp(1.8, rate) for rate in (20.0, 50.0, 100.0)]
    friction = LuGre(118913.0, 1162.0, 10.3, 0.24, 3.59, 0.0436)
    exact = model_response(friction, 5.9, forces)
    rng = np.random.default_rng(4)
    places = [[d + 2e-8 * rng.standard_normal(len(d)) for d in exact] for _ in range(4)]
    fitted = fit_presliding(places, [forces] * 4, sliding, 5.0)
    assert [fitted[n] for n in ("sigma_0", "sigma_1", "M")] == pytest.approx(
        [118913.0, 1162.0, 5.9], rel=2e-3
    )
    assert np.all(np.abs(fitted.values - [118913.0, 1162.0, 5.9]) <= 3 * fitted.half_width)
    assert fitted.warnings == []


def test_a_slow_ramp_tells_nothing_of_damping() -> None:
    sliding = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE))
    force = [force_ramp(0.1, 0.5)]
    exact = model_response(LuGre(118913.0, 1162.0, 10.3, 0.24, 3.59, 0.0436), 5.9, force)
    rng = np.random.default_rng(5)
    places = [[d + 5e-8 * rng.standard_normal(len(d)) for d in exact] for _ in range(5)]
    fitted = fit_presliding(places, [force] * 5, sliding, 5.9)
    assert fitted["sigma_0"] == pytest.approx(118913.0, rel=0.05)
    assert any(w.startswith(("sigma_1", "M")) for w in fitted.warnings), fitted.warnings
