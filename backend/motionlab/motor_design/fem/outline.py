"""The edges of iron and coils of one phase, for drawing."""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from motionlab.config.quantity import Config
from motionlab.motor_design.fem.geometry import Geometry

_METRE_DIGITS = 7

Part = Literal["stator", "mover", "coil_in", "coil_out"]
Polyline = list[tuple[float, float]]


class Outline(Config):
    """The edge of iron or of a coil side."""

    part: Part = Field(
        description="stator or mover: iron; coil_in, coil_out: current away from and to the viewer"
    )
    points: Polyline = Field(description="x and y, m; the last joins the first")


def outlines(g: Geometry, position: float, half_width: float) -> list[Outline]:
    """Return the edges of iron and coils in the mover's frame.

    Parameters
    ----------
    g : Geometry
        Of one phase.
    position : float
        x of the mover on the stator, m.
    half_width : float
        Where the stator, which has no end, is cut on either side, m.
    """
    tip, root = g.g / 2, g.g / 2 + g.stator_tooth_depth
    first = int(np.floor((position - half_width) / g.tau)) - 1
    last = int(np.ceil((position + half_width) / g.tau)) + 1
    edge: Polyline = []
    for k in range(first, last + 1):  # teeth stand in the middle of each pitch
        left = k * g.tau + g.s / 2 - position
        right = left + g.p
        edge += [(left, -root), (left, -tip), (right, -tip), (right, -root)]
    inside = [(float(np.clip(x, -half_width, half_width)), y) for x, y in edge]
    bottom = -(root + g.stator_back)
    stator = [(-half_width, bottom), (-half_width, -root), *inside]
    stator += [(half_width, -root), (half_width, bottom)]

    base = g.g / 2 + g.tooth_depth
    window, yoke = base + g.shoe, base + g.shoe + g.window
    top, outer, opening = yoke + g.yoke, g.width / 2, g.window_width / 2
    right_half: Polyline = [(g.s / 2, window), (g.s / 2, base)]
    for k in range(g.n):
        left = k * g.tau + g.s / 2
        right_half += [(left, base), (left, tip), (left + g.p, tip), (left + g.p, base)]
    right_half += [(outer, base), (outer, top)]
    inner = [(opening, yoke), (opening, window)]
    right_side = [*inner, *right_half]
    mover = [*right_side, *((-x, y) for x, y in reversed(right_side))]
    outlines = [
        Outline(part="stator", points=_thin(stator)),
        Outline(part="mover", points=_thin(mover)),
    ]
    for sign in (-1, 1):
        sides: list[tuple[Part, float, float]] = [
            ("coil_in", opening - g.coil, opening),
            ("coil_out", outer, outer + g.coil),
        ]
        for part, near, far in sides:
            corners = [(near, window), (far, window), (far, yoke), (near, yoke)]
            outlines.append(Outline(part=part, points=_thin([(sign * x, y) for x, y in corners])))
    return outlines


def _thin(points: Polyline) -> Polyline:
    """Return points rounded, without those that repeat the one before."""
    corners = rounded(np.array(points))
    return [p for k, p in enumerate(corners) if k == 0 or p != corners[k - 1]]


def rounded(line: NDArray[np.float64]) -> Polyline:
    """Return a polyline's points to a tenth of a micrometre."""
    return [(float(x), float(y)) for x, y in np.round(line, _METRE_DIGITS)]
