"""Lines, Bezier curves and arcs as files have them, m."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from motionlab.trajectories.path import Array, Vector

SHORTEST = 1e-8
"""Segments shorter than this are left out, m."""

SEGMENTS_MAX = 100_000
"""Most segments of a drawing."""


@dataclass(frozen=True)
class Bezier:
    """A Bezier curve of degree 1, a line, 2 or 3 by its control points."""

    points: tuple[Vector, ...]

    @property
    def cubic(self) -> tuple[Vector, Vector, Vector, Vector]:
        """The control points of the same curve of degree 3."""
        match self.points:
            case (a, b):
                return a, _between(a, b, 1 / 3), _between(a, b, 2 / 3), b
            case (a, b, c):
                return a, _between(a, b, 2 / 3), _between(c, b, 2 / 3), c
            case (a, b, c, d):
                return a, b, c, d
        raise ValueError(f"a curve of {len(self.points)} control points")


@dataclass(frozen=True)
class Arc:
    r"""A part of an ellipse, or of a spiral.

    .. math:: p(t) = c + (1 + g t) (u \cos \varphi + v \sin \varphi), \quad
              \varphi = start + t \cdot sweep, \quad 0 \le t \le 1

    Attributes
    ----------
    center, u, v : tuple of float
        Centre and conjugate half diameters, m.
    start, sweep : float
        Angles, rad.
    growth : float
        g; 0 of an ellipse.
    """

    center: Vector
    u: Vector
    v: Vector
    start: float
    sweep: float
    growth: float = 0.0


Segment = Bezier | Arc


def line(start: Vector, end: Vector) -> Bezier:
    """Return the straight segment between two points."""
    return Bezier((start, end))


@dataclass
class Drawing:
    """What was read from a file.

    Attributes
    ----------
    segments : list of Segment
        Each begins where the one before ends, connecting moves included.
    read : str
        What the file has, for people.
    moves : int
        Connecting moves among the segments.
    v_max, lap_time : float or None
        Feed, m/s, or time of the whole, s, of a file that says so.
    dwells : dict of int to float
        Time to rest before the segment of this number, s; at the end, before the one that is not.
    notes : list of str
        What was left out or taken otherwise.
    thinned : float
        Largest distance by which points were moved when they were read, m.
    """

    segments: list[Segment] = field(default_factory=list)
    read: str = ""
    moves: int = 0
    v_max: float | None = None
    lap_time: float | None = None
    dwells: dict[int, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    thinned: float = 0.0


class Chain:
    """Segments as arrays: places and directions at s, the number of a segment plus 0 to 1."""

    def __init__(self, segments: Sequence[Segment]) -> None:
        n = len(segments)
        self.count = n
        self._control = np.zeros((n, 4, 2))
        self._arc = np.zeros((n, 9))
        self._round = np.zeros(n, dtype=np.bool_)
        for k, each in enumerate(segments):
            if isinstance(each, Bezier):
                self._control[k] = each.cubic
            else:
                turn = each.start, each.sweep, each.growth
                self._arc[k] = *each.center, *each.u, *each.v, *turn
                self._round[k] = True
        self.straight = np.array([isinstance(s, Bezier) and len(s.points) == 2 for s in segments])

    def at(self, s: Array) -> Array:
        """Return places, shape (n, 2), m."""
        k, t = self._split(s)
        places = np.empty((len(s), 2))
        bent = self._round[k]
        a, b, c, d = (self._control[k[~bent], i] for i in range(4))
        u = t[~bent, None]
        w = 1.0 - u
        places[~bent] = w**3 * a + 3 * w**2 * u * b + 3 * w * u**2 * c + u**3 * d
        arc, u = self._arc[k[bent]], t[bent, None]
        angle = arc[:, 6:7] + u * arc[:, 7:8]
        ray = arc[:, 2:4] * np.cos(angle) + arc[:, 4:6] * np.sin(angle)
        places[bent] = arc[:, :2] + (1.0 + arc[:, 8:9] * u) * ray
        return places

    def directions(self) -> tuple[Array, Array]:
        """Return the unit tangents, (segments, 2), where segments begin and where they end."""
        step = 1e-4
        whole = np.arange(self.count, dtype=np.float64)
        ends = []
        for here, there in ((0.0, step), (1.0 - step, 1.0)):
            way = self._inside(whole, there) - self._inside(whole, here)
            ends.append(way / np.maximum(np.hypot(*way.T), 1e-300)[:, None])
        return ends[0], ends[1]

    def lengths(self, parts: int = 16) -> Array:
        """Return the length of each segment, m, that of its chords."""
        whole = np.arange(self.count, dtype=np.float64)
        places = np.stack([self._inside(whole, t) for t in np.linspace(0.0, 1.0, parts + 1)])
        return np.hypot(*np.moveaxis(np.diff(places, axis=0), 2, 0)).sum(axis=0)

    def samples(self, error: float) -> Array:
        """Return s of samples whose chords leave the curve by about `error`, m, at most."""
        control, arc = self._control, self._arc
        bend = 6.0 * np.hypot(*np.moveaxis(np.diff(control, n=2, axis=1), 2, 0)).max(axis=1)
        radius = np.maximum(np.hypot(*arc[:, 2:4].T), np.hypot(*arc[:, 4:6].T))
        bend = np.where(self._round, radius * arc[:, 7] ** 2, bend)
        parts = np.clip(np.ceil(np.sqrt(bend / (8.0 * error))), 8, 1000).astype(int)
        parts[self.straight] = 4
        return np.concatenate([k + np.arange(n) / n for k, n in enumerate(parts)] + [[self.count]])

    def _inside(self, whole: Array, t: float) -> Array:
        return self.at(np.nextafter(whole + 1.0, 0.0) if t == 1.0 else whole + t)

    def _split(self, s: Array) -> tuple[NDArray[np.int64], Array]:
        k = np.minimum(s.astype(np.int64), self.count - 1)
        return k, s - k


def without_short(segments: Sequence[Segment]) -> tuple[list[Segment], list[int]]:
    """Return the segments that have a length, and the number each of the given ones has then."""
    if not segments:
        return [], []
    long = Chain(segments).lengths() >= SHORTEST
    numbers = np.concatenate(([0], np.cumsum(long)))
    return [s for s, keep in zip(segments, long, strict=True) if keep], numbers.tolist()


def circle_arc(start: Vector, end: Vector, center: Vector, *, ccw: bool) -> Arc:
    """Return the arc from start to end about a centre; all the way round where they are the same.

    Where the two radii differ, the radius grows evenly from one to the other.
    """
    u = start[0] - center[0], start[1] - center[1]
    w = end[0] - center[0], end[1] - center[1]
    sweep = math.atan2(u[0] * w[1] - u[1] * w[0], u[0] * w[0] + u[1] * w[1])
    if math.dist(start, end) < SHORTEST:
        sweep = 2 * math.pi
    elif sweep < 0:
        sweep += 2 * math.pi
    if not ccw and math.dist(start, end) >= SHORTEST:
        sweep -= 2 * math.pi
    elif not ccw:
        sweep = -sweep
    growth = math.hypot(*w) / math.hypot(*u) - 1.0
    return Arc(center, u, (-u[1], u[0]), 0.0, sweep, growth)


def _between(a: Vector, b: Vector, share: float) -> Vector:
    return a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])
