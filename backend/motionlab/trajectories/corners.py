"""Corners of a motion, and the drawn path through them."""

from __future__ import annotations

import math
from typing import Any, assert_never

from pydantic import ValidationError

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.moves import Line, Staircase, Trapezoid, Waypoints
from motionlab.config.shapes import Circle, Polygon, Star
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.trajectories.path import Vector, star_vertices

Figure = Polygon | Star
Move = Line | Waypoints | Trapezoid | Staircase

_ON_A_CIRCLE = 12
_NANOMETRES = 9
"""Decimals of points that are computed, m."""


def corners(config: Figure | Move) -> tuple[Vector, ...]:
    """Return the points at which a motion of straight edges stops, in order, m.

    Parameters
    ----------
    config : Polygon, Star, Line, Waypoints, Trapezoid or Staircase
        Of a figure, its corners once round.
    """
    match config:
        case Polygon():
            return config.vertices
        case Waypoints():
            return config.points
        case Star():
            return star_vertices(
                center=(config.center.x, config.center.y),
                circumradius=config.circumradius,
                points=config.points,
                density=config.density,
                start_angle=config.start_angle,
            )
        case Line() | Trapezoid():
            there, back = (config.start.x, config.start.y), (config.end.x, config.end.y)
            if isinstance(config, Line) or not config.there_and_back:
                return there, back
            return there, *((back, there) * config.cycles)
        case Staircase():
            start, step = config.start, config.step
            up = [(start.x + k * step.x, start.y + k * step.y) for k in range(config.count + 1)]
            return *up, *(up[-2::-1] if config.there_and_back else ())
        case _:
            assert_never(config)


def drawn(config: TrajectoryConfig) -> DrawnPath | None:
    """Return a motion as a drawn path with the same corners and about the same time.

    A circle becomes the closed spline through twelve of its points.

    Returns
    -------
    DrawnPath or None
        None for a motion without corners, and for one that no drawn path holds.
    """
    match config:
        case Circle():
            turn = 1 if config.direction == "ccw" else -1
            angles = [
                config.start_angle + turn * 2 * math.pi * k / _ON_A_CIRCLE
                for k in range(_ON_A_CIRCLE)
            ]
            center, radius = config.center, config.radius
            points = tuple(
                (center.x + radius * math.cos(angle), center.y + radius * math.sin(angle))
                for angle in angles
            )
            fields: dict[str, Any] = _lap(config) | {"geometry": "spline", "law": "constant_speed"}
        case Polygon() | Star():
            points, fields = corners(config), _lap(config)
        case Line() | Waypoints():
            points, fields = corners(config), _limits(config)
            if config.edge_time is not None:
                fields["lap_time"] = config.edge_time * (len(points) - 1)
            if isinstance(config, Waypoints) and config.laps > 1:
                points, fields = points[:-1], fields | {"closed": True, "laps": config.laps}
        case Trapezoid() | Staircase():
            points, fields = corners(config), _limits(config) | {"law": "trapezoid"}
        case _:
            return None
    places = [tuple(round(value, _NANOMETRES) + 0.0 for value in point) for point in points]
    try:
        return DrawnPath(points=places, **fields)  # pyright: ignore[reportArgumentType]
    except ValidationError:  # too many points, too long a lap, true steps
        return None


def _lap(config: Circle | Polygon | Star) -> dict[str, Any]:
    kept = {"laps": config.laps, "for_ever": config.for_ever}
    if not isinstance(config, Circle):
        kept["dwell"] = config.dwell
    return {"closed": True, "lap_time": 1.0 / config.frequency} | kept


def _limits(config: Move) -> dict[str, Any]:
    kept = {} if isinstance(config, Line) else {"for_ever": config.for_ever}
    return {"v_max": config.v_max, "a_max": config.a_max, "dwell": config.dwell} | kept
