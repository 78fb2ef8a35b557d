"""The paper's motor in plain numbers, SI, for tests that need no configuration."""

from __future__ import annotations

import math
from typing import NamedTuple

CONTROL_PERIOD = 0.5e-3


class Axis(NamedTuple):
    """Mass, LuGre parameters and gains of one axis."""

    M: float
    sigma_0: float
    sigma_1: float
    sigma_2: float
    F_c: float
    F_s: float
    v_s: float
    k_p: float
    k_d: float


# Gains: x and y of the circle; those of the trapezoid are Table 1's.
X = Axis(5.9, 118913.2532, 1162.3, 10.3128, 0.2399, 3.5908, 0.0436, 200.3e3, 1530.0)
Y = Axis(13.9, 84737.0, 1493.5, 25.8778, 0.8179, 4.3917, 0.0222, 280.5e3, 1080.0)
Y_TRAPEZOID = Y._replace(k_p=987e3, k_d=1600.0)

FORCE_LIMIT = 40.0
POLE_PITCH = 7.2e-3
PEAK_FORCE = 34.1
PEAK_NORMAL_FORCE = 380.1
PEAK_CURRENT = 10.0
KNEE_CURRENT = 5.5
CURRENT_BANDWIDTH = 1000.0
ENCODER_COUNT = 50e-9
STROKE = {"x": 0.085, "y": 0.145}
CIRCLE_RADIUS = 15e-3
CIRCLE_FREQUENCY = 1.0 / 3.0


def low_pass(bandwidth: float) -> float:
    """Return the coefficient of a first-order low-pass filter of `bandwidth`, Hz."""
    return 1.0 - math.exp(-2.0 * math.pi * bandwidth * CONTROL_PERIOD)
