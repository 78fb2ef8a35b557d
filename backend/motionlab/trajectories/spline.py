"""Paths through points, run through by arc length: polylines and cubic splines.

As in `motionlab.trajectories.path` a path maps its parameter q to a position and two derivatives;
here q is the arc length in m, so the first derivative is the unit tangent and the second
the curvature.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached
from motionlab.trajectories.path import Array, Path, Vector

_CORNERS = 2048
_CORNERS_PER_EDGE = (4, 64)
_NODES = 4096
_NODES_PER_EDGE = (16, 256)
_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_SLOWEST = 1e-9  # of the mean slope; below, the spline turns on the spot


@dataclass(frozen=True)
class ArcLengthCurve:
    """A path by arc length.

    Attributes
    ----------
    path : Path
        Arc length, m, to position, unit tangent and curvature; a closed one goes round and
        round.
    marks : ndarray, shape (points,) or (points + 1,)
        Arc length at each point; a closed path has its start once more at the end, m.
    """

    path: Path
    marks: Array

    @property
    def length(self) -> float:
        """Arc length of the whole path, m."""
        return float(self.marks[-1])


def polyline(points: Sequence[Vector], *, closed: bool) -> ArcLengthCurve:
    """Return the straight edges between neighbouring points.

    At a corner the tangent is that of the edge that begins.

    Parameters
    ----------
    points : sequence of tuple
        Points (x, y), neighbours different, m.
    closed : bool
        Whether the last point is joined to the first.
    """
    corners = _corners(points, closed=closed)
    edges = np.diff(corners, axis=0)
    lengths = np.hypot(edges[:, 0], edges[:, 1])
    tangents = edges / lengths[:, None]
    marks = np.concatenate(([0.0], np.cumsum(lengths)))

    def at(q: Array) -> tuple[Array, Array, Array]:
        q = _once_round(q, marks[-1]) if closed else q
        return _along(corners, tangents, marks, q)

    return ArcLengthCurve(at, marks)


def spline(
    points: Sequence[Vector], *, closed: bool, corners: Sequence[int] = ()
) -> ArcLengthCurve:
    r"""Return the cubic spline through points, of continuous tangent and curvature but at corners.

    Its knots are spaced by the square root of the distance between points (centripetal), which
    keeps it from overshooting where near and far points alternate. An open one has no curvature at
    its ends. Continuous curvature makes the acceleration of a smooth motion profile continuous,
    unlike a local cubic (Catmull-Rom). In return a point moves the whole curve, by a factor of
    about -0.27 less for each point further away. Corners join splines of their own.

    The arc length is integrated by Gauss-Legendre quadrature between nodes and inverted by cubic
    Hermite interpolation and a step of Newton.

    Parameters
    ----------
    points : sequence of tuple
        Points (x, y), neighbours different, m.
    closed : bool
        Whether the curve goes on from the last point to the first, smoothly without corners.
    corners : sequence of int
        Points at which the spline ends and another one begins, both without curvature there; any
        makes one of a closed curve's start too.

    References
    ----------
    Lee, "Choosing nodes in parametric curve interpolation", Computer-Aided Design 1989.
    """
    knots, cubic = _fit(points, closed=closed, breaks=corners)
    nodes_per_edge = int(np.clip(_NODES // cubic.shape[1], *_NODES_PER_EDGE))
    arc_lengths, parameters, pace = _table(cubic, knots, nodes_per_edge)
    marks = arc_lengths[::nodes_per_edge].copy()

    def at(q: Array) -> tuple[Array, Array, Array]:
        q = _once_round(q, marks[-1]) if closed else q
        return _follow(cubic, knots, nodes_per_edge, arc_lengths, parameters, pace, q)

    return ArcLengthCurve(at, marks)


def outline(
    points: Sequence[Vector], *, closed: bool, corners: Sequence[int] = ()
) -> tuple[Array, NDArray[np.int64]]:
    """Return corners on the spline through points, for drawing, and the edge each belongs to.

    An edge has equally many corners, evenly spaced in the parameter, the first at its point.

    Parameters
    ----------
    points, closed, corners
        As of `spline`.

    Returns
    -------
    places : ndarray, shape (corners, 2)
        Places on the curve from end to end, m.
    edges : ndarray, shape (corners,)
        Edge k goes from point k to the next; the last corner belongs to the last edge.
    """
    visited = _corners(points, closed=closed)
    knots, cubic = _fit(points, closed=closed, breaks=corners)
    per_edge = int(np.clip(_CORNERS // cubic.shape[1], *_CORNERS_PER_EDGE))
    u = (np.diff(knots)[:, None] * (np.arange(per_edge) / per_edge))[..., None]
    a, b, c, d = cubic[:, :, None]
    places = (a + u * (b + u * (c + u * d))).reshape(-1, 2)
    edges = np.repeat(np.arange(len(knots) - 1), per_edge)
    return np.vstack((places, visited[-1:])), np.append(edges, edges[-1])


@cached
def _along(corners: Array, tangents: Array, marks: Array, q: Array) -> tuple[Array, Array, Array]:
    edge = locate(marks, q)
    place, tangent = np.empty((len(q), 2)), np.empty((len(q), 2))
    for k in range(len(q)):
        i = edge[k]
        for axis in range(2):
            tangent[k, axis] = tangents[i, axis]
            place[k, axis] = corners[i, axis] + tangents[i, axis] * (q[k] - marks[i])
    return place, tangent, np.zeros((len(q), 2))


def _corners(points: Sequence[Vector], *, closed: bool) -> Array:
    corners = np.array(points, dtype=np.float64)
    return np.vstack((corners, corners[:1])) if closed else corners


def _once_round(q: Array, length: float) -> Array:
    """Bring arc lengths of a closed path into its first lap."""
    if q.size and 0.0 <= q.min() and q.max() < length:
        return q
    return np.mod(q, length)


@cached
def locate(marks: Array, q: Array) -> NDArray[np.int64]:
    """Return the interval between marks that holds each q; fast where q hardly jumps."""
    intervals = np.empty(len(q), dtype=np.int64)
    last = len(marks) - 2
    i = 0
    if len(q):
        i = min(max(np.searchsorted(marks, q[0], side="right") - 1, 0), last)
    for k in range(len(q)):
        while i < last and q[k] >= marks[i + 1]:
            i += 1
        while i > 0 and q[k] < marks[i]:
            i -= 1
        intervals[k] = i
    return intervals


def cubics(points: Sequence[Vector], *, closed: bool, corners: Sequence[int] = ()) -> Array:
    """Return the cubic edges of a spline as Bezier curves, shape (edges, 4, 2), m.

    Parameters
    ----------
    points, closed, corners
        As of `spline`.
    """
    knots, cubic = _fit(points, closed=closed, breaks=corners)
    h = np.diff(knots)[:, None]
    a, b, c, d = cubic[0], cubic[1] * h, cubic[2] * h**2, cubic[3] * h**3
    return np.stack((a, a + b / 3, a + (2 * b + c) / 3, a + b + c + d), axis=1)


def slow_places(points: Sequence[Vector], *, closed: bool, corners: Sequence[int] = ()) -> Array:
    """Return the arc lengths, m, in order, at which a spline slows down much in its parameter.

    There the length of its derivative has a local minimum below a tenth of its mean; where a spline
    turns back on itself it is zero. A place at a node may be returned twice.

    Parameters
    ----------
    points, closed, corners
        As of `spline`.
    """
    knots, cubic = _fit(points, closed=closed, breaks=corners)
    nodes = int(np.clip(_NODES // cubic.shape[1], *_NODES_PER_EDGE))
    arc_lengths, parameters, _ = _table(cubic, knots, nodes)
    edge = np.repeat(np.arange(cubic.shape[1]), nodes)
    _, b, c, d = cubic[:, edge]
    start = parameters[:-1] - knots[edge]
    width = (np.diff(knots) / nodes)[edge]

    def slope(u: Array) -> Array:
        return b + u[:, None] * (2.0 * c + u[:, None] * (3.0 * d))

    # Between two nodes the derivative is nearly linear: where is it closest to zero?
    first = slope(start)
    change = slope(start + width) - first
    share = -np.sum(first * change, axis=1) / np.maximum(np.sum(change**2, axis=1), 1e-300)
    least = np.hypot(*(first + share[:, None] * change).T)
    candidates = (np.abs(share - 0.5) < 0.51) & (least < 0.1 * arc_lengths[-1] / knots[-1])
    ways = [
        arc_lengths[i] + _arcs(cubic[:, edge[i]], start[i : i + 1], u)[0][0]
        for i in np.flatnonzero(candidates)
        for u in [start[i : i + 1] + np.clip(share[i], 0.0, 1.0) * width[i]]
    ]
    return np.array(ways)


def _fit(points: Sequence[Vector], *, closed: bool, breaks: Sequence[int]) -> tuple[Array, Array]:
    """Return centripetal knots and the coefficients between them, (4, edges, 2), constant first."""
    return _fitted(tuple(map(tuple, points)), closed, tuple(breaks))


@functools.lru_cache(maxsize=1)  # a check asks for motion and outline
def _fitted(
    points: tuple[Vector, ...], closed: bool, breaks: tuple[int, ...]
) -> tuple[Array, Array]:
    corners = _corners(points, closed=closed)
    edges = np.diff(corners, axis=0)
    knots = np.concatenate(([0.0], np.cumsum(np.sqrt(np.hypot(edges[:, 0], edges[:, 1])))))
    if closed and not breaks:
        from scipy.interpolate import CubicSpline  # noqa: PLC0415 - slow, for drawn paths only

        cubic = CubicSpline(knots, corners, bc_type="periodic")
        return knots, np.ascontiguousarray(cubic.c[::-1])
    return knots, _natural(knots, corners, [0, *breaks, len(knots) - 1])


def _natural(knots: Array, corners: Array, ends: Sequence[int]) -> Array:
    r"""Return the coefficients of splines without curvature at their ends.

    With the second derivatives M, widths h and slopes d of the edges, at all other knots

    .. math:: h_{i-1} M_{i-1} + 2 (h_{i-1} + h_i) M_i + h_i M_{i+1} = 6 (d_i - d_{i-1})
    """
    from scipy.linalg import solve_banded  # noqa: PLC0415 - slow, for drawn paths only

    h = np.diff(knots)
    slopes = np.diff(corners, axis=0) / h[:, None]
    bands, bend = np.zeros((3, len(knots))), np.zeros((len(knots), 2))
    bands[0, 2:], bands[2, :-2] = h[1:], h[:-1]
    bands[1, 1:-1] = 2.0 * (h[:-1] + h[1:])
    bend[1:-1] = 6.0 * np.diff(slopes, axis=0)
    at = np.unique(ends)
    bands[1, at], bend[at] = 1.0, 0.0
    bands[0, at[:-1] + 1] = 0.0
    bands[2, at[1:] - 1] = 0.0
    second = solve_banded((1, 1), bands, bend)
    before, after, wide = second[:-1], second[1:], h[:, None]
    return np.stack(
        (
            corners[:-1],
            slopes - wide * (2.0 * before + after) / 6.0,
            before / 2.0,
            (after - before) / (6.0 * wide),
        )
    )


@cached
def _pace(cubic: Array, u: float) -> float:
    """Return d(arc length)/d(parameter) at u of an edge with coefficients (4, 2)."""
    x = cubic[1, 0] + u * (2.0 * cubic[2, 0] + u * (3.0 * cubic[3, 0]))
    y = cubic[1, 1] + u * (2.0 * cubic[2, 1] + u * (3.0 * cubic[3, 1]))
    return math.sqrt(x * x + y * y)


@cached
def _slope(cubic: Array, u: Array) -> Array:
    """Return the length of the derivative at u, shape (edges, n), of every edge."""
    slope = np.empty(u.shape)
    for edge in range(len(u)):
        for k in range(u.shape[1]):
            slope[edge, k] = _pace(cubic[:, edge], u[edge, k])
    return slope


def _table(cubic: Array, knots: Array, nodes: int) -> tuple[Array, Array, Array]:
    """Return arc length and parameter at nodes evenly spaced in each edge.

    Third comes d(parameter)/d(arc length), (intervals, 2), where the interval between two nodes
    begins and where it ends: at a corner it jumps.
    """
    fine = np.diff(knots)[:, None] / nodes
    starts = np.arange(nodes) * fine
    arc = np.zeros_like(starts)
    for abscissa, weight in zip(_ABSCISSAE, _WEIGHTS, strict=True):
        arc += weight * _slope(cubic, starts + 0.5 * (1.0 + abscissa) * fine)
    arc_lengths = np.concatenate(([0.0], np.cumsum(0.5 * fine * arc)))
    parameters = np.append(knots[:-1, None] + starts, knots[-1])
    slopes = _slope(cubic, np.arange(nodes + 1) * fine)
    slowest = _SLOWEST * arc_lengths[-1] / knots[-1]
    ends = np.stack((slopes[:, :-1].ravel(), slopes[:, 1:].ravel()), axis=1)
    return arc_lengths, parameters, 1.0 / np.maximum(ends, slowest)


@cached
def _follow(  # noqa: PLR0913, PLR0917 - the tables of a spline
    cubic: Array,
    knots: Array,
    nodes: int,
    arc_lengths: Array,
    parameters: Array,
    pace: Array,
    q: Array,
) -> tuple[Array, Array, Array]:
    """Return position, unit tangent and curvature at arc_lengths q."""
    n = len(q)
    place, tangent, bend = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    node = locate(arc_lengths, q)
    u, start, rest = np.empty(n), np.empty(n), np.empty(n)
    slowest = _SLOWEST * arc_lengths[-1] / knots[-1]
    k = 0
    while k < n:
        # Places on one edge share its coefficients: loops over them work on several at once.
        edge = node[k] // nodes
        first = k
        while k < n and edge * nodes <= node[k] < (edge + 1) * nodes:
            i = node[k]
            width = arc_lengths[i + 1] - arc_lengths[i]
            rise = parameters[i + 1] - parameters[i]
            # Where the spline is almost at rest, the slopes would make the cubic overshoot: 3 is
            # monotone.
            a, b = min(pace[i, 0] * width, 3.0 * rise), min(pace[i, 1] * width, 3.0 * rise)
            r = min(max((q[k] - arc_lengths[i]) / width, 0.0), 1.0)
            start[k] = parameters[i] - knots[edge]
            rest[k] = rise
            u[k] = start[k] + r * (a + r * (3.0 * rise - 2.0 * a - b + r * (a + b - 2.0 * rise)))
            k += 1
        # One step of Newton: near a narrow bend the cubic alone is off by some thousandths.
        arcs, slopes = _arcs(cubic[:, edge], start[first:k], u[first:k])
        for j in range(first, k):
            if slopes[j - first] > slowest:
                off = arc_lengths[node[j]] + arcs[j - first] - q[j]
                last = start[j] + rest[j]
                u[j] = min(max(u[j] - off / slopes[j - first], start[j]), last)
        _bent(cubic[:, edge], u[first:k], slowest, place[first:k], tangent[first:k], bend[first:k])
    return place, tangent, bend


@cached
def _arcs(cubic: Array, start: Array, end: Array) -> tuple[Array, Array]:
    """Return the arc length between parameters of an edge, and its derivative at their ends."""
    n = len(end)
    half, arc, slope = np.empty(n), np.zeros(n), np.empty(n)
    for k in range(n):
        half[k] = 0.5 * (end[k] - start[k])
    for i in range(len(_ABSCISSAE)):
        for k in range(n):
            arc[k] += _WEIGHTS[i] * _pace(cubic, start[k] + half[k] * (1.0 + _ABSCISSAE[i]))
    for k in range(n):
        arc[k] *= half[k]
        slope[k] = _pace(cubic, end[k])
    return arc, slope


@cached
def _bent(  # noqa: PLR0913, PLR0917 - where the results go
    cubic: Array, u: Array, slowest: float, place: Array, tangent: Array, bend: Array
) -> None:
    """Set position, unit tangent and curvature at parameters u of an edge."""
    for axis in range(2):
        a, b, c, d = cubic[0, axis], cubic[1, axis], cubic[2, axis], cubic[3, axis]
        for k in range(len(u)):
            place[k, axis] = a + u[k] * (b + u[k] * (c + u[k] * d))
            tangent[k, axis] = b + u[k] * (2.0 * c + u[k] * (3.0 * d))
            bend[k, axis] = 2.0 * c + 6.0 * d * u[k]
    for k in range(len(u)):
        speed = max(np.hypot(tangent[k, 0], tangent[k, 1]), slowest)
        x, y = tangent[k, 0] / speed, tangent[k, 1] / speed
        along = bend[k, 0] * x + bend[k, 1] * y
        tangent[k, 0], tangent[k, 1] = x, y
        bend[k, 0] = (bend[k, 0] - along * x) / speed**2
        bend[k, 1] = (bend[k, 1] - along * y) / speed**2
