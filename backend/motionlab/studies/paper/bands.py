"""Bands of the measured motions, all from what the paper leaves open; fixed before any run.

* Encoder: one count of 50 nm.
* Printed digits: half of the last one.
* Time law of edges that stop at the corners. The error that acceleration alone makes is
  ``M a/k_p``, eq. (40). For an edge of length d in the time T the peak acceleration is
  4 d/T^2 at least (bang-bang), 5.77 d/T^2 by minimum jerk, which is what runs here, 6.28 d/T^2 by
  the cycloid. The band is the share by which ours may exceed the least, 31 % of ``M a/k_p``.
* Time law of moves on y. The paper prints up to 1.66 m/s^2 and no acceleration; without
  compensation the nominal motor's own steady state goes from 0.95 to 1.90 um (trapezoid) and from
  0.80 to 2.00 um (staircase) between 1.66 and 1.0 m/s^2. The band is half of that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

COUNT = 50e-9
"""One encoder count, m."""

MINIMUM_JERK = 10.0 / math.sqrt(3.0)
"""Peak acceleration of minimum jerk, in d/T^2."""

BANG_BANG = 4.0
"""The least there can be between two rests, in d/T^2."""

TRAPEZOID, STAIRCASE = 0.475e-6, 0.60e-6
"""Half of the spread of the steady state over accelerations from 1.0 to 1.66 m/s^2, m."""


class Edge(NamedTuple):
    """One edge of a polygon as an axis sees it."""

    M: float  # moving mass, kg
    k_p: float  # N/m
    d: float  # length along the axis, m
    T: float  # duration, s


def edge_law(edge: Edge) -> float:
    """Return what the unknown time law of an edge may add to the following error, m.

    ``(5.77 - 4) M d/(T^2 k_p)``.
    """
    return (MINIMUM_JERK - BANG_BANG) * edge.M * edge.d / (edge.T**2 * edge.k_p)
