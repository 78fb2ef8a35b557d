"""Carter's closed form of the gap under slots."""

from __future__ import annotations

import math

from motionlab.motor_design.fem.geometry import Geometry


def carter(g: Geometry) -> float:
    """Return the permeance of one pitch over mu_0 and depth; one side has slots."""
    u = g.s / (2 * g.g)
    gamma = 4 / math.pi * (u * math.atan(u) - 0.5 * math.log(1 + u * u))
    return g.tau / g.g * (1 - gamma * g.g / g.tau)
