"""The rational model of a measured plant: what it finds of plants that are known, and of noise."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import control
import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.studies.response.documents import FittedPlant, ResponseRequest
from motionlab.studies.response.measure import measure, plan
from motionlab.studies.response.model import FittedModel, fit

T = 5e-4
Complex = np.ndarray[Any, np.dtype[np.complex128]]
Array = np.ndarray[Any, np.dtype[np.float64]]
MASS = np.array([8.0, 1.3e-4])
MODE = np.array([180.0, 0.03, -0.2])


def known(terms: tuple[str, ...], *values: Sequence[float] | Array) -> FittedModel:
    of = np.concatenate([np.asarray(each, dtype=np.float64) for each in values])
    return FittedModel(terms, of, np.zeros_like(of), T, np.zeros(0, np.complex128), 0.0)


def noisy(model: FittedModel, lines: Array, share: float, seed: int) -> tuple[Complex, Array]:
    rng = np.random.default_rng(seed)
    P = model.response(lines)
    noise = rng.standard_normal((2, len(lines))) * share * np.abs(P) / np.sqrt(2.0)
    return P + noise[0] + 1j * noise[1], share * np.abs(P)


LINES = np.unique(np.round(np.geomspace(1.0, 700.0, 60)))


def test_a_sampled_model_is_what_python_control_makes_of_it() -> None:
    model = known(("mass", "lag", "damping", "stiffness", "mode"), MASS, [2e-4, 30.0, 900.0], MODE)
    zeros, poles, gain = model.zeros_poles_gain()
    sampled = control.sample_system(control.zpk(zeros, poles, gain), T, method="zoh")
    z = np.exp(2j * np.pi * LINES * T)
    whole = known(model.terms, [8.0, 0.0], [2e-4, 30.0, 900.0], MODE).response(LINES)
    np.testing.assert_allclose(whole, sampled(z), rtol=2e-3)
    late = known(model.terms, [8.0, T], [2e-4, 30.0, 900.0], MODE).response(LINES)
    np.testing.assert_allclose(late, sampled(z) / z, rtol=2e-3)


def test_terms_and_values_of_a_plant_are_recovered_within_their_errors() -> None:
    true = known(("mass", "damping", "mode"), MASS, [40.0], MODE)
    away = []
    for seed in range(30):
        P, deviation = noisy(true, LINES, 0.02, seed)
        model = fit(LINES, P, deviation, T)
        assert model is not None
        assert sorted(model.terms) == sorted(true.terms)
        assert model.misfit == pytest.approx(1.0, abs=0.35)
        parts = dict(model.parts())
        for term, of_true in true.parts():
            for name, (value, error) in parts[term].items():
                away.append((value - of_true[name][0]) / error)
    assert np.mean(np.abs(away) < 1.96) == pytest.approx(0.95, abs=0.04)


def test_noise_has_no_modes() -> None:
    plain = known(("mass",), MASS)
    terms = []
    for seed in range(60):
        P, deviation = noisy(plain, LINES, 0.1, seed)
        # Intervals that are half of what they should be change nothing.
        model = fit(LINES, P, deviation * (0.5 if seed % 2 else 1.0), T)
        assert model is not None
        terms.append(model.terms)
    assert terms.count(("mass",)) >= 57


def test_a_single_bad_line_is_no_mode() -> None:
    P, deviation = noisy(known(("mass",), MASS), LINES, 0.02, 5)
    P[30] *= 1.5  # an outlier of 25 deviations
    fitted = fit(LINES, P, deviation, T)
    assert fitted is not None
    assert "mode" not in fitted.terms


def test_three_modes_are_told_apart() -> None:
    modes = [np.array([f, 0.02, share]) for f, share in ((60.0, 0.3), (180.0, -0.2), (420.0, 0.4))]
    true = known(("mass", "mode", "mode", "mode"), MASS, *modes)
    lines = np.unique(np.round(np.geomspace(2.0, 800.0, 150)))
    P, deviation = noisy(true, lines, 0.02, 5)
    model = fit(lines, P, deviation, T)
    assert model is not None and model.terms.count("mode") == 3
    found = sorted(part["mode_frequency"][0] for term, part in model.parts() if term == "mode")
    assert found == pytest.approx([60.0, 180.0, 420.0], rel=0.01)


def test_a_plant_without_noise_is_fitted() -> None:
    P = known(("mass",), MASS).response(LINES)
    model = fit(LINES, P, np.zeros(len(LINES)), T)
    assert model is not None
    assert model.values == pytest.approx(MASS, rel=1e-6)
    assert fit(LINES[:7], P[:7], np.zeros(7), T) is None


def fitted(scenario: str, axis: str) -> FittedPlant:
    request = ResponseRequest.model_validate({"scenario": scenario, "axis": axis})
    found = measure(plan(request)).fitted
    assert found is not None
    return found


@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_motor_tells_its_mode_and_current_loop(axis: str) -> None:
    model = fitted("circle-resonant", axis)
    motor = getattr(load_scenario("circle-resonant").plant, axis)
    (mode,) = model.modes
    of_mode = motor.resonance
    for each, true, slack in (
        (mode.frequency, of_mode.frequency, 0.003),
        (mode.damping, of_mode.damping, 0.15),
        (mode.coupling, of_mode.coupling, 0.08),
    ):
        assert each.value == pytest.approx(true, rel=slack)
        assert abs(each.value - true) < 4.0 * each.error
    assert model.lag is not None
    late = model.lag.value + model.delay.value
    assert late == pytest.approx(1.0 / (2.0 * np.pi * motor.amplifiers.bandwidth), rel=0.15)
    assert model.mass.model is not None
    assert model.mass.value == pytest.approx(model.mass.model, rel=0.03)
    assert model.misfit < 1.6


def test_the_mass_is_that_of_the_motor_and_of_its_friction() -> None:
    """At 43 mm/s on y: what bristles add, sigma_1 g'(v), is 0.2 kg."""
    model = fitted("circle", "y")
    assert not model.modes
    assert model.mass.value == pytest.approx(load_scenario("circle").plant.y.mass, rel=0.03)
    assert len(model.residual) == 48
    here, there = model.margins["phase_margin"], model.margins["crossover"]
    assert here is not None and there is not None
    assert 0.3 < here < 1.5 and 20.0 < there < 200.0
