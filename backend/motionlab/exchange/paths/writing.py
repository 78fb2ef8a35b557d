"""A trajectory as a file of another program."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Literal

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.shapes import Circle
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.fit import fit
from motionlab.exchange.paths.segments import (
    SEGMENTS_MAX,
    SHORTEST,
    Bezier,
    Chain,
    circle_arc,
    line,
)
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.corners import drawn
from motionlab.trajectories.drawn_motion import curve_of
from motionlab.trajectories.path import Array, Vector
from motionlab.trajectories.reference import sample, ticks_of
from motionlab.trajectories.spline import cubics

ExportFormat = Literal["csv", "points", "svg", "gcode"]

ENDINGS: dict[ExportFormat, str] = {"csv": "csv", "points": "csv", "svg": "svg", "gcode": "ngc"}
"""Ending of a file of each format."""

MEDIA_TYPES: dict[ExportFormat, str] = {
    "csv": "text/csv",
    "points": "text/csv",
    "svg": "image/svg+xml",
    "gcode": "text/plain",
}

ROWS_MAX = 1_000_000
"""Most ticks that are written."""

CHORD = 1e-6
"""Largest distance of G-code from a smooth path, and of a path through samples from them, m."""

_FLAT = 1e-9
_REACH = 1.0
_MARGIN = 2.0  # mm around a picture


def write_trajectory(trajectory: TrajectoryConfig, format: ExportFormat) -> str:
    """Return a trajectory as text of another program's format, lengths in mm.

    Parameters
    ----------
    trajectory : TrajectoryConfig
        Any kind. As SVG, G-code and points a motion that is no drawn path becomes one, if
        need be through its samples.
    format : str
        ``csv``: time, x and y at every tick; ``points``: x and y of the points of the path;
        ``svg``: one path of lines and cubic curves, exactly; ``gcode``: lines, of a smooth path
        chords within `CHORD`, one lap, with F and dwells.

    Raises
    ------
    ConfigError
        If it lasts too long to be written.
    """
    match format:
        case "csv":
            return _samples(trajectory)
        case "points":
            rows = (f"{_mm(x)},{_mm(y)}\n" for x, y in _loop(path_of(trajectory)))
            return "x [mm],y [mm]\n" + "".join(rows)
        case "svg":
            return _svg(path_of(trajectory))
        case "gcode":
            return "\n".join(_gcode(path_of(trajectory))) + "\n"


def path_of(trajectory: TrajectoryConfig) -> DrawnPath:
    """Return a motion as one drawn path: itself, its corners, or a path through its samples."""
    if isinstance(trajectory, DrawnPath):
        return trajectory
    path = None if isinstance(trajectory, Circle) else drawn(trajectory)
    if path is not None:
        return path
    if isinstance(trajectory, Circle):
        x, y = trajectory.center.x, trajectory.center.y
        start = (
            x + trajectory.radius * np.cos(trajectory.start_angle),
            y + (trajectory.radius * np.sin(trajectory.start_angle)),
        )
        segments = [circle_arc(start, start, (x, y), ccw=trajectory.direction == "ccw")]
        speed = 2 * np.pi * trajectory.radius * trajectory.frequency
    else:
        _refuse_long(trajectory)
        reference = sample(trajectory)
        corners = _simplified(np.vstack((reference.position, reference.end)))
        ends = [(float(a), float(b)) for a, b in corners]
        pairs = itertools.pairwise(ends)
        segments = [line(a, b) for a, b in pairs if np.hypot(*np.subtract(a, b)) >= SHORTEST]
        speed = float(np.hypot(*reference.velocity.T).max())
    if not segments:
        raise ConfigError(FieldError("trajectory", "rests: there is no path to write"))
    if len(segments) > SEGMENTS_MAX // 10:
        raise ConfigError(FieldError("trajectory", "is too long for a path: write it as csv"))
    fitted = fit(segments, tolerance=0.5 * CHORD)
    reach = float(np.abs(np.array(fitted.points)).max())
    if reach > _REACH:
        message = "leaves the range of a path: write it as csv"
        raise ConfigError(FieldError("trajectory", message, reach, f"<= {_REACH:g}", "m"))
    return DrawnPath(
        points=fitted.points,
        closed=fitted.closed,
        geometry="spline",
        corners=fitted.corners,
        v_max=float(np.clip(speed, 1e-4, 10.0)),
        a_max=1.0,
    )


def _samples(trajectory: TrajectoryConfig) -> str:
    _refuse_long(trajectory)
    reference = sample(trajectory)
    places = np.vstack((reference.position, reference.end)) * 1e3
    rows = [
        f"{k * CONTROL_PERIOD:.4f},{x:.6f},{y:.6f}\n" for k, (x, y) in enumerate(places.tolist())
    ]
    return "t [s],x [mm],y [mm]\n" + "".join(rows)


def _refuse_long(trajectory: TrajectoryConfig) -> None:
    ticks = ticks_of(trajectory)
    if ticks > ROWS_MAX:
        message = "lasts too long to be written"
        longest = ROWS_MAX * CONTROL_PERIOD
        raise ConfigError(
            FieldError("trajectory", message, ticks * CONTROL_PERIOD, f"<= {longest:g}", "s")
        )


def _edges(path: DrawnPath) -> list[Bezier]:
    """Return the edges of a path; those that are straight as lines."""
    if path.geometry == "polyline":
        return [line(a, b) for a, b in itertools.pairwise(_loop(path))]
    control = cubics(path.points, closed=path.closed, corners=path.corners)
    straight = control[:, :1] + (control[:, 3:] - control[:, :1]) * np.array([[1 / 3], [2 / 3]])
    flat = np.abs(control[:, 1:3] - straight).max(axis=(1, 2)) < _FLAT
    visited = _loop(path)
    return [
        line(visited[k], visited[k + 1])
        if flat[k]
        else Bezier((visited[k], *((x, y) for x, y in edge[1:3].tolist()), visited[k + 1]))
        for k, edge in enumerate(control)
    ]


def _loop(path: DrawnPath) -> tuple[Vector, ...]:
    return (*path.points, path.points[0]) if path.closed else path.points


def _svg(path: DrawnPath) -> str:
    def at(point: Vector) -> str:
        return f"{_mm(point[0])} {_mm(-point[1])}"

    edges = _edges(path)
    data = [f"M {at(path.points[0])}"]
    for edge in edges:
        letter = "L" if len(edge.points) == 2 else "C"
        data.append(f"{letter} " + " ".join(at(point) for point in edge.points[1:]))
    if path.closed:
        data.append("Z")
    places = 1e3 * np.array([point for edge in edges for point in edge.points])
    west, south = places.min(axis=0) - _MARGIN
    east, north = places.max(axis=0) + _MARGIN
    width, height = east - west, north - south
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.6f}mm" height="{height:.6f}mm" '
        f'viewBox="{west:.6f} {-north:.6f} {width:.6f} {height:.6f}">\n'
        f'<path fill="none" stroke="black" stroke-width="0.3" d="{" ".join(data)}"/>\n</svg>\n'
    )


def _gcode(path: DrawnPath) -> Iterator[str]:
    length = curve_of(path).length
    speed = path.v_max if path.v_max is not None else length / (path.lap_time or 1.0)
    rest = [f"G4 P{path.dwell:.9g}"] if path.dwell > 0 and path.law != "constant_speed" else []
    yield "G17 G21 G90"
    x, y = path.points[0]
    yield f"G0 X{_mm(x)} Y{_mm(y)}"
    yield f"F{speed * 60e3:.9g}"
    yield from rest
    edges = _edges(path)
    stops = set(path.corners) if path.geometry == "spline" else set(range(len(edges)))
    for k, edge in enumerate(edges, start=1):
        for x, y in _chords(edge):
            yield f"G1 X{_mm(x)} Y{_mm(y)}"
        if k in stops or k == len(edges):
            yield from rest
    yield "M2"


def _chords(edge: Bezier) -> list[Vector]:
    if len(edge.points) == 2:
        return [edge.points[1]]
    chain = Chain([edge])
    return [(x, y) for x, y in chain.at(chain.samples(CHORD)[1:]).tolist()]


def _simplified(places: Array) -> Array:
    """Return samples without those nearer than half a `CHORD` to the chords of the others.

    References
    ----------
    Douglas, Peucker, "Algorithms for the reduction of the number of points required to represent a
    digitized line or its caricature", Cartographica 1973.
    """
    keep = np.zeros(len(places), dtype=np.bool_)
    keep[[0, -1]] = True
    left = [(0, len(places) - 1)]
    while left:
        first, last = left.pop()
        if last - first < 2:
            continue
        way, inner = places[last] - places[first], places[first + 1 : last] - places[first]
        square = float(way @ way)
        along = np.clip(inner @ way / square, 0.0, 1.0) if square > 0 else np.zeros(len(inner))
        away = np.hypot(*(inner - along[:, None] * way).T)
        worst = int(np.argmax(away))
        if away[worst] > 0.5 * CHORD:
            middle = first + 1 + worst
            keep[middle] = True
            left += [(first, middle), (middle, last)]
    return places[keep]


def _mm(metres: float) -> str:
    return f"{metres * 1e3 + 0.0:.6f}"
