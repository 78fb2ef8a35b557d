"""Filters of the feedback: their response, off by default, and the loop with them in the kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.control.filters import PASS, Biquad, sampled_filter, sampled_notch
from motionlab.errors import ConfigError
from motionlab.loop.linearise import linearise
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import SHORT, play, same_bits

FREQUENCY = 160.0
FILTERS = {
    "filter_1": {"poles_frequency": 600.0, "poles_damping": 0.8},
    "filter_2": {
        "zeros_frequency": 100.0,
        "zeros_damping": 0.9,
        "poles_frequency": 180.0,
        "poles_damping": 0.9,
    },
    "filter_3": {
        "zeros_frequency": 400.0,
        "zeros_damping": 0.05,
        "poles_frequency": 350.0,
        "poles_damping": 0.5,
    },
}
"""A low-pass, a lead, and a notch whose poles lie elsewhere."""


def notch(gain: float = 0.1, damping: float = 0.4, frequency: float = FREQUENCY) -> dict[str, Any]:
    """Changes to a scenario: both axes of B have a notch."""
    values = {"frequency": frequency, "damping": damping, "gain": gain}
    return {f"variants.B.controller.{a}.notch.{k}": v for a in "xy" for k, v in values.items()}


def response(f: Biquad, frequency: Any) -> Any:
    """Of the sampled filter, from its difference equation."""
    z = np.exp(2j * np.pi * np.asarray(frequency) * CONTROL_PERIOD)
    return (f.b_0 + f.b_1 / z + f.b_2 / z**2) / (1.0 + f.a_1 / z + f.a_2 / z**2)


@pytest.mark.parametrize("frequency", [20.0, 160.0, 850.0])
@pytest.mark.parametrize("gain", [0.0, 0.1, 0.7])
def test_the_response_is_the_warped_one_of_the_formula(frequency: float, gain: float) -> None:
    f = sampled_notch(frequency=frequency, damping=0.4, gain=gain)
    seen = np.array([1.0, 0.9 * frequency, frequency, 1.1 * frequency, 990.0])
    there = response(f, seen)
    s = 1j * np.tan(np.pi * seen * CONTROL_PERIOD) / np.tan(np.pi * frequency * CONTROL_PERIOD)
    expected = (s**2 + 0.8 * gain * s + 1.0) / (s**2 + 0.8 * s + 1.0)
    assert np.abs(there - expected).max() < 1e-12
    assert abs(there[2]) == pytest.approx(gain, abs=1e-12)


def test_a_gain_of_one_is_no_notch() -> None:
    assert sampled_notch(frequency=100.0, damping=0.3, gain=1.0) == PASS
    plain = play("circle-matched", SHORT)
    idle = play("circle-matched", SHORT | notch(gain=1.0, damping=1.5, frequency=33.0))
    assert same_bits(plain.samples("B"), idle.samples("B"))


@pytest.mark.parametrize("zeros", [0.0, 60.0, 300.0])
@pytest.mark.parametrize("poles", [80.0, 500.0])
def test_a_filter_has_its_zeros_and_poles_where_they_are_declared(
    zeros: float, poles: float
) -> None:
    f = sampled_filter(
        zeros_frequency=zeros, zeros_damping=0.2, poles_frequency=poles, poles_damping=0.6
    )
    seen = np.array([0.0, 1.0, 60.0, 80.0, 300.0, 500.0, 990.0])
    s = 1j * np.tan(np.pi * seen * CONTROL_PERIOD)

    def pair(frequency: float, damping: float) -> Any:
        own = np.tan(np.pi * frequency * CONTROL_PERIOD)
        return (s / own) ** 2 + 2.0 * damping * s / own + 1.0

    expected = (pair(zeros, 0.2) if zeros else 1.0) / pair(poles, 0.6)
    assert np.abs(response(f, seen) - expected).max() < 1e-11
    assert response(f, 0.0) == pytest.approx(1.0, abs=1e-12)


def test_two_filters_of_a_notch_s_form_are_its_square() -> None:
    plain = sampled_notch(frequency=FREQUENCY, damping=0.4, gain=0.1)
    other = sampled_filter(
        zeros_frequency=FREQUENCY,
        zeros_damping=0.04,
        poles_frequency=FREQUENCY,
        poles_damping=0.4,
    )
    assert np.array(other) == pytest.approx(np.array(plain), abs=1e-14)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"zeros_frequency": 100.0}, "zeros alone differentiate"),
        ({"poles_frequency": 100.0, "poles_damping": 0.001}, "poles_damping"),
        ({"poles_frequency": 1000.0}, "poles_frequency"),
        ({"poles_frequency": 1e-200}, "at least 1 Hz"),
        ({"zeros_frequency": 1e-9, "poles_frequency": 100.0}, "at least 1 Hz"),
    ],
)
def test_filters_that_cannot_be_are_refused(values: dict[str, float], words: str) -> None:
    changes = {f"variants.B.controller.x.filter_2.{k}": v for k, v in values.items()}
    with pytest.raises(ConfigError, match=words):
        load_scenario("circle", changes)


@pytest.mark.parametrize(("axis", "delay"), [("x", 0), ("y", 1)])
@pytest.mark.parametrize("controller", ["pd", "lugre-reference"])
def test_a_sweep_of_the_simulation_finds_the_linearised_loop(
    controller: str, axis: str, delay: int
) -> None:
    v = 0.02
    changes = {"variants.B.controller": controller, "variants.B.controller.delay": delay}
    changes |= notch()
    for number, values in FILTERS.items():
        path = f"variants.B.controller.{axis}.{number}"
        changes |= {f"{path}.{k}": v for k, v in values.items()}
    changes[f"plant.{axis}.encoder.resolution"] = 0.0
    changes["variants.B.controller.y.k_d"] = 2000.0
    changes["variants.B.controller.disturbance_observer.bandwidth"] = 30.0
    scenario = load_scenario("circle", changes)
    measured = frequency_sweep(
        scenario, "B", axis, [5.0, 30.0, 120.0, FREQUENCY, 220.0], v=v, force=1.0
    )
    # 5 N would take 50 N of u at the notch, more than its limit.
    ratio = measured.open / linearise(scenario, "B", axis, v=v).open(measured.frequency)
    assert np.abs(ratio) == pytest.approx(1.0, abs=0.03)
    assert np.angle(ratio) == pytest.approx(0.0, abs=0.06)
