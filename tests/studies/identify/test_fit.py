"""Least squares on made-up friction: estimates, intervals, and what cannot be known."""

from __future__ import annotations

import functools

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.plant.friction import LuGre
from motionlab.studies.identify.fit import (
    Fitted,
    curve_half_width,
    fit_presliding,
    fit_sliding,
    stribeck_curve,
)
from motionlab.studies.identify.presliding import force_ramp, model_response
from motionlab.timing import SUBSTEPS

TRUE = (0.24, 3.59, 0.0436, 10.3, 0.05)
UNLOADED = (*TRUE[:4], 0.0)
NAMES = ("F_c", "F_s", "v_s", "sigma_2", "f_0")
SPEEDS = np.geomspace(0.5e-3, 0.15, 32)
VELOCITY = np.concatenate([SPEEDS, -SPEEDS])
MOTION = np.tile(np.arange(len(SPEEDS)), 2)


def test_exact_data_give_exact_parameters() -> None:
    fitted = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, TRUE), motion=MOTION)
    assert [fitted[name] for name in NAMES] == pytest.approx(TRUE, rel=1e-6)
    assert fitted.residual_rms < 1e-8
    assert fitted.warnings == []


def causes(kind: str, rng: np.random.Generator) -> NDArray[np.float64]:
    """Return errors of 64 means, N: alike, larger for slow motions, or of a motion as a whole."""
    own = 0.02 * rng.standard_normal(len(VELOCITY))
    if kind == "slow":
        return own * np.tile(np.geomspace(3.0, 0.3, len(SPEEDS)), 2)
    if kind == "motion":
        return np.sign(VELOCITY) * np.tile(own[: len(SPEEDS)], 2)
    return own


@functools.cache
def repeated(kind: str) -> list[Fitted]:
    """Return the fits of 150 noisy experiments."""
    rng = np.random.default_rng(1)
    true = stribeck_curve(VELOCITY, TRUE)
    return [fit_sliding(VELOCITY, true + causes(kind, rng), motion=MOTION) for _ in range(150)]


@pytest.mark.parametrize("kind", ["alike", "slow", "motion"])
def test_the_intervals_hold_what_they_promise(kind: str) -> None:
    """At least 95 % of 150 noisy experiments, but for three standard deviations of that count.

    Where few motions tell a parameter, the jackknife and few degrees of freedom make it more.
    """
    fits = repeated(kind)
    misses = np.array([np.abs(fitted.values - TRUE) for fitted in fits])
    inside = misses <= [fitted.half_width for fitted in fits]
    by_all = [2, 4]  # v_s and f_0
    if kind == "motion":  # both ways of a motion err alike, and f_0 is exact but for rounding
        assert misses[:, 4].max() < 1e-7
        inside, by_all = inside[:, :4], [2]
    share = inside.mean(axis=0)
    assert share.min() >= 0.9, share
    assert share[by_all].max() <= 0.99, share


def test_few_motions_widen_an_interval_and_say_so() -> None:
    few = np.isin(MOTION, (0, 8, 16, 24, 28))
    noise = 0.01 * np.random.default_rng(9).standard_normal(int(few.sum()))
    force = stribeck_curve(VELOCITY[few], TRUE) + noise
    fitted = fit_sliding(VELOCITY[few], force, motion=MOTION[few])
    assert any("is wide because few measurements" in w for w in fitted.warnings), fitted.warnings
    assert np.max(fitted.half_width / fitted.errors) > 3.0


def test_longer_means_weigh_more_where_they_are_surer() -> None:
    """Errors that fall with the time of a mean: weights make the slow motions, long ones, tell."""
    rng = np.random.default_rng(10)
    time = np.tile(np.geomspace(20.0, 1.0, len(SPEEDS)), 2)
    misses = np.zeros((2, len(NAMES)))
    for _ in range(30):
        force = stribeck_curve(VELOCITY, TRUE) + 0.02 / time * rng.standard_normal(len(time))
        for k, known in enumerate((None, time)):
            fitted = fit_sliding(VELOCITY, force, motion=MOTION, time=known)
            misses[k] += (fitted.values - TRUE) ** 2
    assert np.all(misses[1, :3] < 0.5 * misses[0, :3]), misses


def test_the_band_holds_the_true_curve_as_often_as_it_says() -> None:
    """150 repetitions; at each velocity 95 % at least, but for three standard deviations."""
    v = np.array([-0.12, -0.03, -0.005, 0.002, 0.02, 0.044, 0.1])
    true = stribeck_curve(v, TRUE)
    fits = repeated("alike")
    inside = np.zeros(len(v))
    for fitted in fits:
        half = curve_half_width(v, fitted)
        assert half is not None
        inside += np.abs(stribeck_curve(v, fitted.values) - true) <= half
    share = inside / len(fits)
    assert share.min() >= 0.9, share
    assert share.mean() < 0.995, share


def test_a_curve_that_is_not_determined_has_no_band() -> None:
    chosen = np.abs(VELOCITY) > 0.02
    fast = VELOCITY[chosen]
    fitted = fit_sliding(fast, np.sign(fast) * 1.0 + 10.0 * fast, motion=MOTION[chosen])
    assert curve_half_width(fast, fitted) is None


def test_without_slow_speeds_stiction_is_not_known() -> None:
    fast = np.abs(VELOCITY) > 0.08
    noise = 0.01 * np.random.default_rng(2).standard_normal(int(fast.sum()))
    fitted = fit_sliding(
        VELOCITY[fast], stribeck_curve(VELOCITY[fast], TRUE) + noise, motion=MOTION[fast]
    )
    text = "; ".join(fitted.warnings)
    assert "F_s" in text
    assert "v_s" in text


def test_without_a_stribeck_effect_v_s_cannot_be_identified() -> None:
    flat = stribeck_curve(VELOCITY, (1.0, 1.0, 0.04, 10.0, 0.0))
    noise = 0.01 * np.random.default_rng(3).standard_normal(len(flat))
    fitted = fit_sliding(VELOCITY, flat + noise, motion=MOTION)
    assert any(w.startswith("v_s") for w in fitted.warnings), fitted.warnings


def test_what_no_datum_depends_on_has_no_error() -> None:
    """All speeds so far above v_s that the falling part is zero to the last bit."""
    chosen = np.abs(VELOCITY) > 0.02
    fast = VELOCITY[chosen]
    fitted = fit_sliding(fast, np.sign(fast) * 1.0 + 10.0 * fast, motion=MOTION[chosen])
    unknown = [n for n, e in zip(fitted.names, fitted.errors, strict=True) if np.isinf(e)]
    assert "v_s" in unknown
    assert not {"sigma_2", "f_0"} & set(unknown)
    assert any(w.startswith("v_s") for w in fitted.warnings)


def test_friction_that_only_rises_is_no_lugre_model() -> None:
    rising = stribeck_curve(VELOCITY, (2.0, 1.0, 0.03, 5.0, 0.0))
    assert any("is below F_c" in w for w in fit_sliding(VELOCITY, rising, motion=MOTION).warnings)


def within(force: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return a force that is held over every tick, at each step of the plant."""
    return np.repeat(force[:, None], SUBSTEPS, axis=1)


def test_ramps_give_back_what_made_them() -> None:
    sliding = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, UNLOADED), motion=MOTION)
    forces = [within(force_ramp(1.8, rate)) for rate in (20.0, 50.0, 100.0)]
    friction = LuGre(118913.0, 1162.0, 10.3, 0.24, 3.59, 0.0436)
    exact = model_response(friction, 5.9, forces, [0.0] * 3)
    rng = np.random.default_rng(4)
    places = [[d + 2e-8 * rng.standard_normal(len(d)) for d in exact] for _ in range(4)]
    fitted = fit_presliding(places, [forces] * 4, [1.0] * 3, sliding, 5.0)
    assert [fitted[n] for n in ("sigma_0", "sigma_1", "M")] == pytest.approx(
        [118913.0, 1162.0, 5.9], rel=2e-3
    )
    assert np.all(np.abs(fitted.values - [118913.0, 1162.0, 5.9]) <= 3 * fitted.half_width)
    assert fitted.warnings == []


def test_a_slow_ramp_tells_nothing_of_damping() -> None:
    sliding = fit_sliding(VELOCITY, stribeck_curve(VELOCITY, UNLOADED), motion=MOTION)
    force = [within(force_ramp(0.1, 0.5))]
    exact = model_response(LuGre(118913.0, 1162.0, 10.3, 0.24, 3.59, 0.0436), 5.9, force, [0.0])
    rng = np.random.default_rng(5)
    places = [[d + 5e-8 * rng.standard_normal(len(d)) for d in exact] for _ in range(5)]
    fitted = fit_presliding(places, [force] * 5, [1.0], sliding, 5.9)
    assert fitted["sigma_0"] == pytest.approx(118913.0, rel=0.05)
    assert any(w.startswith(("sigma_1", "M")) for w in fitted.warnings), fitted.warnings
