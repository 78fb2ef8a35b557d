"""The notch filter: its response, that it is off by default, and the loop with it in the kernel."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.control.notch import PASS, sampled_notch
from motionlab.loop.linearise import linearise
from motionlab.studies.loop.frequency_sweep import frequency_sweep
from motionlab.timing import CONTROL_PERIOD
from tests.simulated import SHORT, play, same_bits

FREQUENCY = 160.0


def notch(gain: float = 0.1, damping: float = 0.4, frequency: float = FREQUENCY) -> dict[str, Any]:
    """Changes to a scenario: both axes of B have a notch."""
    values = {"frequency": frequency, "damping": damping, "gain": gain}
    return {f"variants.B.controller.{a}.notch.{k}": v for a in "xy" for k, v in values.items()}


@pytest.mark.parametrize("frequency", [20.0, 160.0, 850.0])
@pytest.mark.parametrize("gain", [0.0, 0.1, 0.7])
def test_the_response_is_the_warped_one_of_the_formula(frequency: float, gain: float) -> None:
    f = sampled_notch(frequency=frequency, damping=0.4, gain=gain)
    seen = np.array([1.0, 0.9 * frequency, frequency, 1.1 * frequency, 990.0])
    z = np.exp(2j * np.pi * seen * CONTROL_PERIOD)
    response = (f.b_0 + f.b_1 / z + f.b_2 / z**2) / (1.0 + f.a_1 / z + f.a_2 / z**2)
    s = 1j * np.tan(np.pi * seen * CONTROL_PERIOD) / np.tan(np.pi * frequency * CONTROL_PERIOD)
    expected = (s**2 + 0.8 * gain * s + 1.0) / (s**2 + 0.8 * s + 1.0)
    assert np.abs(response - expected).max() < 1e-12
    assert abs(response[2]) == pytest.approx(gain, abs=1e-12)


def test_a_gain_of_one_is_no_notch() -> None:
    assert sampled_notch(frequency=100.0, damping=0.3, gain=1.0) == PASS
    plain = play("circle-matched", SHORT)
    idle = play("circle-matched", SHORT | notch(gain=1.0, damping=1.5, frequency=33.0))
    assert same_bits(plain.samples("B"), idle.samples("B"))


@pytest.mark.parametrize(("axis", "delay"), [("x", 0), ("y", 1)])
@pytest.mark.parametrize("controller", ["pd", "lugre-reference"])
def test_a_sweep_of_the_simulation_finds_the_linearised_loop(
    controller: str, axis: str, delay: int
) -> None:
    v = 0.02
    changes = {"variants.B.controller": controller, "variants.B.controller.delay": delay}
    changes |= notch()
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
