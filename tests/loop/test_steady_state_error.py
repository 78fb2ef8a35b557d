"""Steady state of the ideal frictionless plant against eqs (40) to (42) of the paper, within 1 %.

PD alone on a mass: E/R = M s^2/(M s^2 + k_d s + k_p).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motionlab.config.planar import AXES
from tests.simulated import IDEAL, play

GAINS = {  # N/m, N s/m: Table 1
    "pentagram": {"x": (200.3e3, 1530.0), "y": (280.5e3, 1080.0)},
    "rhombus": {"x": (400e3, 1480.0), "y": (501.6e3, 1570.0)},
}
MASS = {"x": 5.9, "y": 13.9}


def ideal(trajectory: dict[str, Any], gains: str = "pentagram") -> Any:
    changes = IDEAL | {"trajectory": trajectory}
    for axis, (k_p, k_d) in GAINS[gains].items():
        changes[f"variants.A.controller.{axis}.k_p"] = k_p
        changes[f"variants.A.controller.{axis}.k_d"] = k_d
    return play("circle", changes)


@pytest.mark.parametrize("gains", GAINS)
def test_step_leaves_no_error(gains: str) -> None:
    height = 8e-6
    played = ideal({"kind": "step", "height": {"x": height, "y": -height}, "dwell": 0.9}, gains)
    for axis in AXES:
        error = np.abs(played.channel("A", "following_error", axis))
        assert error.max() == pytest.approx(height, rel=1e-6)
        assert error[-100:].max() < 1e-4 * height


@pytest.mark.parametrize("gains", GAINS)
def test_ramp_leaves_no_error(gains: str) -> None:
    velocity = {"x": 0.1, "y": -0.12}
    played = ideal({"kind": "ramp", "velocity": velocity, "lead_in": 0.1, "duration": 0.8}, gains)
    for axis in AXES:
        error = np.abs(played.channel("A", "following_error", axis))
        assert error.max() > 10e-6
        assert error[-100:].max() < 1e-3 * error.max()
        reached = played.channel("A", "velocity", axis)[-1]
        assert reached == pytest.approx(velocity[axis], rel=1e-5)


@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("R", [0.5, -0.25])
def test_parabola_leaves_2_m_r_over_k_p(gains: str, R: float) -> None:
    start = -math.copysign(0.07, R)
    played = ideal(
        {
            "kind": "parabola",
            "start": {"x": start, "y": start},
            "coefficient": {"x": R, "y": R},
            "duration": 0.5,
        },
        gains,
    )
    for axis in AXES:
        expected = 2.0 * MASS[axis] * R / GAINS[gains][axis][0]  # eq. (40), k_p in N/m
        error = played.channel("A", "following_error", axis)[-50:]
        assert error == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("frequency", [1 / 3, 2.0, 8.0])
def test_sine_leaves_amplitude_and_phase(gains: str, frequency: float) -> None:
    B = min(0.02, 1.5 / (2 * math.pi * frequency) ** 2)  # 1.5 m/s^2 at most
    played = ideal(
        {
            "kind": "sine",
            "amplitude": {"x": B, "y": B},
            "phase": {"x": 0.0, "y": 0.5},
            "frequency": frequency,
            "cycles": 6,
            "lead_in": 0.3,
        },
        gains,
    )
    reference = played.prepared.reference
    window = slice(*reference.window)
    w = 2 * math.pi * frequency
    for index, axis in enumerate(AXES):
        M = MASS[axis]
        k_p, k_d = GAINS[gains][axis]
        sine = reference.position[window, index] / B
        cosine = reference.velocity[window, index] / (B * w)
        error = played.channel("A", "following_error", axis)[window]
        (a, b), *_ = np.linalg.lstsq(np.stack([sine, cosine], axis=1), error, rcond=None)

        # eqs (41) and (42): the phase needs atan2, k_p - M w^2 may have either sign
        amplitude = M * w**2 * B / math.hypot(M * w**2 - k_p, w * k_d)
        phase = math.pi - math.atan2(w * k_d, k_p - M * w**2)
        assert math.hypot(a, b) == pytest.approx(amplitude, rel=0.01)
        assert math.atan2(b, a) == pytest.approx(phase, rel=0.01)
        left = error - (a * sine + b * cosine)
        assert np.abs(left).max() < 0.01 * amplitude


def test_sine_above_the_stiffness_line_turns_its_phase() -> None:
    # k_p < M w^2: atan instead of atan2 would be out by pi
    frequency, B = 60.0, 1e-5
    w = 2 * math.pi * frequency
    changes = IDEAL | {
        "trajectory": {
            "kind": "sine",
            "amplitude": {"x": B},
            "frequency": frequency,
            "cycles": 60,
        },
    }
    changes |= {"variants.A.controller.x.k_p": 200e3, "variants.A.controller.x.k_d": 300.0}
    played = play("circle", changes)
    reference = played.prepared.reference
    window = slice(*reference.window)
    basis = np.stack([reference.position[window, 0] / B, reference.velocity[window, 0] / (B * w)])
    error = played.channel("A", "following_error", "x")[window]
    (a, b), *_ = np.linalg.lstsq(basis.T, error, rcond=None)
    M = MASS["x"]
    assert M * w**2 > 200e3
    phase = math.pi - math.atan2(w * 300.0, 200e3 - M * w**2)
    assert math.atan2(b, a) == pytest.approx(phase, abs=0.05)
