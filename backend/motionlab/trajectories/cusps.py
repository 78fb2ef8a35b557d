"""Places at which a spline turns back on the spot, and what to do about them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.trajectory import Sequence, TrajectoryConfig
from motionlab.trajectories.drawn_motion import curve_of
from motionlab.trajectories.path import Vector
from motionlab.trajectories.spline import slow_places

_REACH = 5e-6
"""Arc length before and after a place between which the curve turns back, m."""
_AT_POINT = 1e-6
"""Arc length within which a place is that of a point, m."""


class Cusp(NamedTuple):
    """A place at which a spline turns by more than a right angle within 10 um, without a stop.

    Attributes
    ----------
    place : tuple of float
        Position (x, y), m.
    way : float
        Arc length from the start of the path, m.
    edge : int
        Point that it is at, or that begins its edge.
    at_point : bool
        Whether it is at that point.
    """

    place: Vector
    way: float
    edge: int
    at_point: bool


def cusps(config: DrawnPath) -> list[Cusp]:
    """Return the cusps of a spline between its corners and ends, in order."""
    if config.geometry != "spline":
        return []
    curve = curve_of(config)
    ways = slow_places(config.points, closed=config.closed, corners=config.corners)
    stops = curve.marks[[0, *config.corners, -1]]
    ways = ways[np.min(np.abs(ways[:, None] - stops), axis=1, initial=np.inf) > 2.0 * _REACH]
    if not len(ways):
        return []
    _, before, _ = curve.path(ways - _REACH)
    _, after, _ = curve.path(ways + _REACH)
    ways = ways[np.sum(before * after, axis=1) < 0.0]
    ways = ways[np.diff(ways, prepend=-np.inf) > 2.0 * _REACH]  # each once
    places, _, _ = curve.path(ways)
    turns = []
    for (x, y), way in zip(places.tolist(), ways.tolist(), strict=True):
        nearest = int(np.argmin(np.abs(curve.marks - way)))
        at_point = abs(float(curve.marks[nearest]) - way) < _AT_POINT
        edge = nearest if at_point else int(np.searchsorted(curve.marks, way)) - 1
        turns.append(Cusp((x, y), way, edge, at_point))
    return turns


def cusp_note(config: TrajectoryConfig) -> str:
    """Return what to do about the first cusp of a drawn path; empty if it has none.

    Of a sequence the first part that has one is named.
    """
    if isinstance(config, Sequence):
        notes = (f"parts.{k}: {cusp_note(part)}" for k, part in enumerate(config.parts))
        return next((note for note in notes if not note.endswith(": ")), "")
    if not isinstance(config, DrawnPath) or not (turns := cusps(config)):
        return ""
    (x, y), way, edge, at_point = turns[0]
    corner = edge if at_point else edge + 1
    shifted = [k + (not at_point and k > edge) for k in config.corners]
    corners = sorted([*shifted, corner])
    what = "a corner" if at_point else f"a point between points {edge} and {edge + 1} and a corner"
    more = f"; {len(turns) - 1} more" if turns[1:] else ""
    law = ", and take a law that stops there" if config.law == "constant_speed" else ""
    return (
        f"the spline turns back on the spot at x = {x:.6g} m, y = {y:.6g} m, s = {way:.6g} m along "
        f"the path: add {what} there, corners = {corners} (points count from 0){law}{more}"
    )
