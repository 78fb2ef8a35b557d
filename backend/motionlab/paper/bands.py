"""Bands of the measured motions, derived from unprinted choices; fixed before any run.

* Encoder: one count of 50 nm.
* Printed digits: half of the last one.
* Motion profile of edges that stop at the corners. The error that acceleration alone makes is
  ``M a/k_p``, eq. (40). For an edge of length d in the time T the peak acceleration is
  4 d/T^2 at least (bang-bang), 5.77 d/T^2 by minimum jerk, which is what runs here, 6.28 d/T^2 by
  the cycloid. The band is the share by which ours may exceed the least, 31 % of ``M a/k_p``.
* Motion profile of moves on y. The paper prints up to 1.66 m/s^2 and no acceleration; without
  compensation the nominal motor's own steady state goes from 0.95 to 1.90 um (trapezoid) and from
  0.80 to 2.00 um (staircase) between 1.66 and 1.0 m/s^2. The band is half of that.
"""

from __future__ import annotations

import math

from motionlab.config.load import load_scenario

COUNT = 50e-9
"""One encoder count, m."""

MINIMUM_JERK = 10.0 / math.sqrt(3.0)
"""Peak acceleration of minimum jerk, in d/T^2."""

BANG_BANG = 4.0
"""The least there can be between two rests, in d/T^2."""

TRAPEZOID, STAIRCASE = 0.475e-6, 0.60e-6
"""Half of the spread of the steady state over accelerations from 1.0 to 1.66 m/s^2, m."""


def gains(scenario: str, axis: str) -> tuple[float, float, float]:
    """Return mass, k_p and k_d, SI, of a shipped scenario's PD controller: the printed ones."""
    controller = load_scenario(scenario).variants["A"].controller
    own = getattr(controller, axis)
    return getattr(controller.model, axis).mass, own.k_p, own.k_d


def edge_law(scenario: str, axis: str) -> float:
    """Return the possible effect of an edge's unprinted motion profile on the error, m.

    ``(5.77 - 4) M d/(T^2 k_p)`` with d the length of an edge along the axis and T its duration.
    """
    M, k_p, _ = gains(scenario, axis)
    d, T = _EDGES[scenario, axis]
    return (MINIMUM_JERK - BANG_BANG) * M * d / (T**2 * k_p)


# The pentagram's edges along an axis: 57.06 mm on x, 57.06 mm sin 72 deg on y.
_EDGES = {
    ("rhombus", "x"): (0.03, 0.75),
    ("rhombus", "y"): (0.03, 0.75),
    ("pentagram", "x"): (0.05706, 0.6),
    ("pentagram", "y"): (0.05706 * math.sin(0.4 * math.pi), 0.6),
}
