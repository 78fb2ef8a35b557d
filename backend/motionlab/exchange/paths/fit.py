"""Splines with corners through a drawing, within a tolerance."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drawn_path import POINTS_MAX
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.segments import Chain, Segment
from motionlab.trajectories.path import Array, Vector
from motionlab.trajectories.spline import cubics

CORNER = math.radians(20.0)
"""Sharpest turn between two segments that is no corner."""

_CUT = 10.0
"""Tolerances by which a curve through the ends of two segments may leave them, else a corner."""

_SAME = 1e-9
_MANY = 0.5
_EVENLY = 512
"""Most edges that are spread evenly between two corners."""
_NANOMETRES = 9
_LOOP = 1e-7
"""Shortest way back to the same place that is more than rounding, m."""


@dataclass(frozen=True)
class Fitted:
    """A path of splines between corners.

    Attributes
    ----------
    points : tuple of tuple of float
        As of a drawn path, to a nanometre, m.
    closed : bool
        Whether it ends where it begins.
    corners : tuple of int
        As of a drawn path.
    deviation : float
        Largest distance of the drawing from the path, m.
    """

    points: tuple[Vector, ...]
    closed: bool
    corners: tuple[int, ...]
    deviation: float


def fit(segments: Sequence[Segment], *, tolerance: float, stops: Iterable[int] = ()) -> Fitted:
    """Return a path of splines that leaves segments by no more than a tolerance.

    Two segments meet in a corner if they turn by more than `CORNER`, or if the chord of the shorter
    one, of length L, and the turn make a sagitta L turn / 8 of more than ten tolerances. Between
    corners knots are spread evenly, more and more of them, while the spline is too far away in many
    places; where it still is in some, knots are added half-way, at ends of segments first.

    Parameters
    ----------
    segments : sequence of Segment
        Each longer than `segments.SHORTEST`, one after another.
    tolerance : float
        Largest distance, m.
    stops : iterable of int
        Segments that begin with a corner in any case.

    Raises
    ------
    ConfigError
        If more points would be needed than a path may have.
    """
    chain = Chain(segments)
    hard = _corners(chain, tolerance, set(stops))
    closed = math.dist(*chain.at(np.array([0.0, chain.count])).tolist()) < _SAME
    smooth = closed and len(hard) == 2 and not _turns(chain, tolerance)[-1]
    samples = chain.samples(tolerance / 8.0)
    where = chain.at(samples)
    spread = _Spread(chain, hard, samples, where, least=4 if smooth else 2)
    s, places = _apart(chain, spread.unlooped(spread.knots()), hard)
    while True:
        fitted = _fitted(s, places, closed, () if smooth else hard)
        _refuse_many(len(fitted[0]), tolerance)
        away, edge = _away(chain, s, samples, where, fitted)
        bad = np.unique(edge[away > tolerance])
        grown = spread.refined(s, bad)
        finer = spread.knots() if grown else np.union1d(s, _halved(chain, s, bad))
        finer, places = _apart(chain, spread.unlooped(finer), hard)
        if not grown and np.array_equal(finer, s):  # loops may have those knots already
            break
        s = finer
    points, closed, corners = fitted
    return Fitted(points, closed, corners, float(away.max()))


def _refuse_many(count: int, tolerance: float) -> None:
    if count > POINTS_MAX:
        message = f"needs more points than a path may have, {POINTS_MAX}: allow more"
        raise ConfigError(FieldError("tolerance", message, tolerance, unit="m"))


class _Spread:
    """Knots that are spread evenly between corners."""

    def __init__(self, chain: Chain, hard: Array, samples: Array, where: Array, least: int) -> None:
        self._chain, self._hard, self._samples = chain, hard, samples
        ways = np.hypot(*np.diff(where, axis=0).T)
        self._arc = np.concatenate(([0.0], np.cumsum(ways)))
        one_line = (np.diff(hard) == 1) & chain.straight[hard[:-1].astype(int)]
        self._edges = np.where(one_line, 1, least)  # two: both ends may be at the same place
        self._growing = ~one_line

    def knots(self) -> Array:
        """Return s of all knots, corners included."""
        ends = np.interp(self._hard, self._samples, self._arc)
        inner = [
            np.linspace(low, high, edges + 1)[1:-1]
            for low, high, edges in zip(ends[:-1], ends[1:], self._edges.tolist(), strict=True)
            if edges > 1
        ]
        inside = np.interp(np.concatenate([np.empty(0), *inner]), self._arc, self._samples)
        return np.union1d(self._hard, inside)

    def unlooped(self, s: Array) -> Array:
        """Add knots between neighbours at one place that the drawing leaves in between.

        A closed contour that is travelled several times is back where it began at every knot that
        a whole number of laps lies before.
        """
        while True:
            places = np.round(self._chain.at(s), _NANOMETRES)
            arc = np.interp(s, self._samples, self._arc)
            same = (places[1:] == places[:-1]).all(axis=1)
            loops = np.flatnonzero(same & (np.diff(arc) > _LOOP))
            if not loops.size or len(s) > 2 * POINTS_MAX:
                return s
            middles = 0.5 * (arc[loops] + arc[loops + 1])
            s = np.union1d(s, np.interp(middles, self._arc, self._samples))

    def refined(self, s: Array, bad: NDArray[np.int64]) -> bool:
        """Double the knots of stretches that are too far away in half of their edges, if any."""
        middles = 0.5 * (s[:-1] + s[1:])
        of = np.searchsorted(self._hard, middles) - 1
        share = np.bincount(of[bad], minlength=len(self._edges)) / np.bincount(of)
        self._growing &= (share >= _MANY) & (self._edges < _EVENLY)
        self._edges[self._growing] *= 2
        return bool(self._growing.any())


def _corners(chain: Chain, tolerance: float, stops: set[int]) -> Array:
    """Return s of corners and ends."""
    turns = np.flatnonzero(_turns(chain, tolerance)[:-1]) + 1
    return np.unique([0.0, *turns.tolist(), *stops, float(chain.count)])


def _turns(chain: Chain, tolerance: float) -> NDArray[np.bool_]:
    """Return whether there is a corner after each segment; after the last, back to the first."""
    first, last = chain.directions()
    after = np.roll(first, -1, axis=0)
    cross = last[:, 0] * after[:, 1] - last[:, 1] * after[:, 0]
    turn = np.abs(np.arctan2(cross, (last * after).sum(axis=1)))
    length = chain.lengths()
    shorter = np.minimum(length, np.roll(length, -1))
    return (turn > CORNER) | (shorter * turn / 8.0 > _CUT * tolerance)


def _apart(chain: Chain, s: Array, hard: Array) -> tuple[Array, Array]:
    """Return the knots and their places without those that round to the place of the one before."""
    places = np.round(chain.at(s), _NANOMETRES) + 0.0
    keep = np.ones(len(s), dtype=np.bool_)
    same = (places[1:] == places[:-1]).all(axis=1)
    is_hard = np.isin(s, hard)
    keep[1:] &= ~(same & ~is_hard[1:])
    keep[:-1] &= ~(same & is_hard[1:] & ~is_hard[:-1])
    return s[keep], places[keep]


def _fitted(
    s: Array, places: Array, closed: bool, hard: Array | tuple[()]
) -> tuple[tuple[Vector, ...], bool, tuple[int, ...]]:
    points = [(float(x), float(y)) for x, y in places]
    corners = np.flatnonzero(np.isin(s, hard)).tolist()
    if closed and len(points) > 3:
        points = points[:-1]
        corners = [k for k in corners if k < len(points)]
    else:
        closed = False
        corners = [k for k in corners if 0 < k < len(points) - 1]
    return tuple(points), closed, tuple(corners)


def _away(
    chain: Chain,
    s: Array,
    samples: Array,
    where: Array,
    fitted: tuple[tuple[Vector, ...], bool, tuple[int, ...]],
) -> tuple[Array, NDArray[np.int64]]:
    """Return how far samples of the drawing are from the spline, and on which edge they are."""
    points, closed, corners = fitted
    control = cubics(points, closed=closed, corners=corners)
    shares = np.array([0.2, 0.4, 0.6, 0.8])
    between = (s[:-1, None] + np.diff(s)[:, None] * shares).ravel()
    places = np.concatenate((where, chain.at(between)))
    edge = np.searchsorted(s, np.concatenate((samples, between)), side="right") - 1
    edge = np.clip(edge, 0, len(control) - 1)
    a, b, c, d = (control[edge, i] for i in range(4))
    best, start = np.full(len(edge), np.inf), np.zeros(len(edge))
    for u in np.linspace(0.0, 1.0, 9):
        square = ((_bernstein(a, b, c, d, np.full(len(edge), u)) - places) ** 2).sum(axis=1)
        nearer = square < best
        best, start = np.where(nearer, square, best), np.where(nearer, u, start)
    u = start
    for _ in range(4):  # Gauss-Newton towards the foot of the perpendicular
        t = u[:, None]
        slope = 3 * ((1 - t) ** 2 * (b - a) + 2 * t * (1 - t) * (c - b) + t**2 * (d - c))
        gap = places - _bernstein(a, b, c, d, u)
        u = np.clip(
            u + (gap * slope).sum(axis=1) / np.maximum((slope**2).sum(axis=1), 1e-300), 0, 1
        )
    squares = ((_bernstein(a, b, c, d, u) - places) ** 2).sum(axis=1)
    return np.sqrt(np.minimum(best, squares)), edge


def _bernstein(a: Array, b: Array, c: Array, d: Array, u: Array) -> Array:
    t = u[:, None]
    w = 1 - t
    return w**3 * a + 3 * w**2 * t * b + 3 * w * t**2 * c + t**3 * d


def _halved(chain: Chain, s: Array, edges: NDArray[np.int64]) -> Array:
    """Return new knots in the middle of some edges, at the end of a segment where there is one."""
    low, high = s[edges], s[np.minimum(edges + 1, len(s) - 1)]
    middle = 0.5 * (low + high)
    joint = np.round(middle)
    inside = np.abs(joint - middle) < 0.499 * (high - low)
    new = np.where(inside, joint, middle)
    ways = chain.at(high) - chain.at(low)
    long = (np.hypot(*ways.T) > 4 * 10.0**-_NANOMETRES) | (high - low > 1.0)
    return new[long & (new > low) & (new < high)]
