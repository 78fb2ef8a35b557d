"""Paths through points, run through by arc length: polylines and cubic splines.

As in `motionlab.trajectory.path` a path maps its parameter q to a position and two derivatives;
here q is the way along the path in m, so the first derivative is the unit tangent and the second
the curvature.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.trajectory.path import Array, Path, Vector

_NODES = 4096
_NODES_PER_EDGE = (16, 256)
_ABSCISSAE, _WEIGHTS = np.polynomial.legendre.leggauss(5)
_SLOWEST = 1e-9  # of the mean slope; below, the spline turns on the spot


@dataclass(frozen=True)
class Curve:
    """A path by arc length.

    Attributes
    ----------
    path : Path
        Way along the path, m, to position, unit tangent and curvature; a closed one goes round and
        round.
    marks : ndarray, shape (points,) or (points + 1,)
        Way to each point; a closed path has its start once more at the end, m.
    """

    path: Path
    marks: Array

    @property
    def length(self) -> float:
        """Arc length of the whole path, m."""
        return float(self.marks[-1])


def polyline(points: Sequence[Vector], *, closed: bool) -> Curve:
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

    return Curve(at, marks)


def spline(points: Sequence[Vector], *, closed: bool) -> Curve:
    r"""Return the cubic spline through points, of continuous tangent and curvature.

    Its knots are spaced by the square root of the distance between points (centripetal), which
    keeps it from overshooting where near and far points alternate. An open one has no curvature at
    its ends. Continuous curvature makes the acceleration of a smooth motion profile continuous,
    unlike a local cubic (Catmull-Rom). In return a point moves the whole curve, by a factor of
    about -0.27 less for each point further away.

    The arc length is integrated by Gauss-Legendre quadrature between nodes and inverted by cubic
    Hermite interpolation and a step of Newton.

    Parameters
    ----------
    points : sequence of tuple
        Points (x, y), neighbours different, m.
    closed : bool
        Whether the curve goes on smoothly from the last point to the first.

    References
    ----------
    Lee, "Choosing nodes in parametric curve interpolation", Computer-Aided Design 1989.
    """
    corners = _corners(points, closed=closed)
    knots, moments = _fit(corners, closed=closed)
    steps = np.diff(knots)
    cubic = _coefficients(corners, steps, moments)
    nodes_per_edge = int(np.clip(_NODES // len(steps), *_NODES_PER_EDGE))
    ways, parameters, pace = _table(cubic, knots, nodes_per_edge)
    marks = ways[::nodes_per_edge].copy()

    def at(q: Array) -> tuple[Array, Array, Array]:
        q = _once_round(q, marks[-1]) if closed else q
        return _follow(cubic, knots, nodes_per_edge, ways, parameters, pace, q)

    return Curve(at, marks)


@numba.njit(error_model="numpy", nogil=True, cache=True)
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
    """Bring ways along a closed path into its first lap."""
    if q.size and 0.0 <= q.min() and q.max() < length:
        return q
    return np.mod(q, length)


@numba.njit(error_model="numpy", nogil=True, cache=True)
def locate(marks: Array, q: Array) -> NDArray[np.int64]:
    """Return the interval between marks that holds each q; fast where q hardly jumps."""
    found = np.empty(len(q), dtype=np.int64)
    last = len(marks) - 2
    i = 0
    for k in range(len(q)):
        while i < last and q[k] >= marks[i + 1]:
            i += 1
        while i > 0 and q[k] < marks[i]:
            i -= 1
        found[k] = i
    return found


def _fit(corners: Array, *, closed: bool) -> tuple[Array, Array]:
    """Return the knots and the second derivatives at them of the interpolating spline."""
    edges = np.diff(corners, axis=0)
    steps = np.sqrt(np.hypot(edges[:, 0], edges[:, 1]))
    knots = np.concatenate(([0.0], np.cumsum(steps)))
    slopes = edges / steps[:, None]
    moments = np.zeros_like(corners)
    if closed:
        before = np.roll(steps, 1)
        jumps = 6.0 * (slopes - np.roll(slopes, 1, axis=0))
        moments[:-1] = _solve_cyclic(before, 2.0 * (before + steps), steps, jumps)
        moments[-1] = moments[0]
    elif len(steps) > 1:
        jumps = 6.0 * np.diff(slopes, axis=0)
        moments[1:-1] = _solve(steps[:-1], 2.0 * (steps[:-1] + steps[1:]), steps[1:], jumps)
    return knots, moments


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _solve(lower: Array, middle: Array, upper: Array, right: Array) -> Array:
    """Solve tridiagonal equations without corners for each column of `right`."""
    n = len(middle)
    factor = np.empty(n)
    result = right.copy()
    pivot = middle[0]
    result[0] /= pivot
    for i in range(1, n):
        factor[i] = upper[i - 1] / pivot
        pivot = middle[i] - lower[i] * factor[i]
        result[i] = (result[i] - lower[i] * result[i - 1]) / pivot
    for i in range(n - 2, -1, -1):
        result[i] -= factor[i + 1] * result[i + 1]
    return result


def _solve_cyclic(lower: Array, middle: Array, upper: Array, right: Array) -> Array:
    """Solve tridiagonal equations with the corners lower[0] and upper[-1], by Sherman-Morrison."""
    corner, other = lower[0], upper[-1]
    gamma = -middle[0]
    inner = middle.copy()
    inner[0] -= gamma
    inner[-1] -= corner * other / gamma
    rank_one = np.zeros((len(middle), 1))
    rank_one[0, 0], rank_one[-1, 0] = gamma, other
    solution: Array = _solve(lower, inner, upper, np.hstack((right, rank_one)))
    y, z = solution[:, :-1], solution[:, -1]
    ratio = corner / gamma
    return y - z[:, None] * ((y[0] + ratio * y[-1]) / (1.0 + z[0] + ratio * z[-1]))


def _coefficients(corners: Array, steps: Array, moments: Array) -> Array:
    """Return the polynomial coefficients of each edge, shape (4, edges, 2), constant first."""
    h = steps[:, None]
    edges = np.diff(corners, axis=0)
    b = edges / h - h * (2.0 * moments[:-1] + moments[1:]) / 6.0
    d = np.diff(moments, axis=0) / (6.0 * h)
    return np.stack((corners[:-1], b, moments[:-1] / 2.0, d))


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _pace(cubic: Array, edge: int, u: float) -> float:
    """Return d(arc length)/d(parameter) at u of an edge."""
    x = cubic[1, edge, 0] + u * (2.0 * cubic[2, edge, 0] + u * (3.0 * cubic[3, edge, 0]))
    y = cubic[1, edge, 1] + u * (2.0 * cubic[2, edge, 1] + u * (3.0 * cubic[3, edge, 1]))
    return math.sqrt(x * x + y * y)


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _slope(cubic: Array, u: Array) -> Array:
    """Return the length of the derivative at u, shape (edges, n), of every edge."""
    slope = np.empty(u.shape)
    for edge in range(len(u)):
        for k in range(u.shape[1]):
            slope[edge, k] = _pace(cubic, edge, u[edge, k])
    return slope


def _table(cubic: Array, knots: Array, nodes: int) -> tuple[Array, Array, Array]:
    """Return arc length, parameter and its derivative at nodes evenly spaced in each edge."""
    fine = np.diff(knots)[:, None] / nodes
    starts = np.arange(nodes) * fine
    arc = np.zeros_like(starts)
    for abscissa, weight in zip(_ABSCISSAE, _WEIGHTS, strict=True):
        arc += weight * _slope(cubic, starts + 0.5 * (1.0 + abscissa) * fine)
    ways = np.concatenate(([0.0], np.cumsum(0.5 * fine * arc)))
    parameters = np.append(knots[:-1, None] + starts, knots[-1])
    slopes = np.append(_slope(cubic, starts), _slope(cubic[:, -1:], fine[-1:] * nodes))
    return ways, parameters, 1.0 / np.maximum(slopes, _SLOWEST * ways[-1] / knots[-1])


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _arc(cubic: Array, edge: int, start: float, end: float) -> float:
    """Return the arc length between two parameters of an edge."""
    half = 0.5 * (end - start)
    arc = 0.0
    for i in range(len(_ABSCISSAE)):
        arc += _WEIGHTS[i] * _pace(cubic, edge, start + half * (1.0 + _ABSCISSAE[i]))
    return half * arc


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _follow(  # noqa: PLR0913, PLR0917 - the tables of a spline
    cubic: Array,
    knots: Array,
    nodes: int,
    ways: Array,
    parameters: Array,
    pace: Array,
    q: Array,
) -> tuple[Array, Array, Array]:
    """Return position, unit tangent and curvature at ways q."""
    n = len(q)
    place, tangent, bend = np.empty((n, 2)), np.empty((n, 2)), np.empty((n, 2))
    node = locate(ways, q)
    slowest = _SLOWEST * ways[-1] / knots[-1]
    for k in range(n):
        i = node[k]
        edge = i // nodes
        width = ways[i + 1] - ways[i]
        rise = parameters[i + 1] - parameters[i]
        # Where the spline all but stands the slopes would throw the cubic about: 3 is monotone.
        start = min(pace[i] * width, 3.0 * rise)
        end = min(pace[i + 1] * width, 3.0 * rise)
        r = min(max((q[k] - ways[i]) / width, 0.0), 1.0)
        way = start + r * (3.0 * rise - 2.0 * start - end + r * (start + end - 2.0 * rise))
        u_0 = float(parameters[i] - knots[edge])
        u = u_0 + r * way
        # One step of Newton: near a narrow bend the cubic alone is off by some thousandths.
        arc, slope = _arc(cubic, edge, u_0, u), _pace(cubic, edge, u)
        if slope > slowest:
            last = u_0 + rise
            u = min(max(u - (ways[i] + arc - q[k]) / slope, u_0), last)
        for axis in range(2):
            a, b = cubic[0, edge, axis], cubic[1, edge, axis]
            c, d = cubic[2, edge, axis], cubic[3, edge, axis]
            place[k, axis] = a + u * (b + u * (c + u * d))
            tangent[k, axis] = b + u * (2.0 * c + u * (3.0 * d))
            bend[k, axis] = 2.0 * c + 6.0 * d * u
        speed = max(np.hypot(tangent[k, 0], tangent[k, 1]), slowest)
        tangent[k] /= speed
        along = bend[k, 0] * tangent[k, 0] + bend[k, 1] * tangent[k, 1]
        for axis in range(2):
            bend[k, axis] = (bend[k, axis] - along * tangent[k, axis]) / speed**2
    return place, tangent, bend
