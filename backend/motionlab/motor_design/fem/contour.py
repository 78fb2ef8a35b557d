"""Lines of equal value over a triangle mesh, as polylines."""

from __future__ import annotations

from collections import defaultdict
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


class Triangles(NamedTuple):
    """A linear function on triangles."""

    corners: Array  # x or y, corner, triangle
    nodes: Indices  # corner, triangle: the same number where triangles meet
    values: Array  # corner, triangle


def contour(triangles: Triangles, level: float, *, tolerance: float) -> list[Array]:
    """Return the lines on which a function has one value.

    Parameters
    ----------
    triangles : Triangles
        The function. Neighbours may lie apart, as at the ends of a periodic mesh: lines end there.
    level : float
        The value.
    tolerance : float
        How far a line may lie from the one through every triangle's edge.

    Returns
    -------
    list of array, shape (points, 2)
        Closed lines repeat their first point.
    """
    above = triangles.values > level
    crossed = np.flatnonzero(above.any(axis=0) & ~above.all(axis=0))
    ends: list[list[tuple[tuple[int, int], Array]]] = []
    for t in crossed.tolist():
        ends.append([_crossing(triangles, t, a, level) for a in range(3) if _cut(above[:, t], a)])
    return [thinned(np.array(line), tolerance) for line in _chained(ends)]


def _cut(above: NDArray[np.bool_], a: int) -> bool:
    return bool(above[a] != above[(a + 1) % 3])


def _crossing(triangles: Triangles, t: int, a: int, level: float) -> tuple[tuple[int, int], Array]:
    """Return the edge from corner `a` of a triangle, and the point on it with the value."""
    b = (a + 1) % 3
    from_, to = triangles.values[a, t], triangles.values[b, t]
    share = (level - from_) / (to - from_)
    start, end = triangles.corners[:, a, t], triangles.corners[:, b, t]
    i, j = int(triangles.nodes[a, t]), int(triangles.nodes[b, t])
    return (min(i, j), max(i, j)), start + share * (end - start)


def _chained(ends: list[list[tuple[tuple[int, int], Array]]]) -> list[list[Array]]:
    """Return segments joined where they share an edge and a point."""
    at: dict[tuple[tuple[int, int], tuple[int, int]], list[int]] = defaultdict(list)
    keys = [[(edge, _rounded(point)) for edge, point in pair] for pair in ends]
    for k, pair in enumerate(keys):
        for key in pair:
            at[key].append(k)
    unused, lines = set(range(len(ends))), []
    # Lines with ends are walked from an end, closed ones from anywhere.
    starts = [key for key, members in at.items() if len(members) == 1]
    for key in [*starts, *at]:
        while members := [k for k in at[key] if k in unused]:
            line, here, k = [], key, members[0]
            while True:
                unused.discard(k)
                side = keys[k].index(here)
                if not line:
                    line.append(ends[k][side][1])
                line.append(ends[k][1 - side][1])
                here = keys[k][1 - side]
                following = [m for m in at[here] if m in unused]
                if not following:
                    break
                k = following[0]
            lines.append(line)
    return lines


def _rounded(point: Array) -> tuple[int, int]:
    x, y = np.round(point * 1e9)
    return int(x), int(y)


def thinned(line: Array, tolerance: float) -> Array:
    """Return a polyline simplified by Douglas and Peucker."""
    kept = np.zeros(len(line), dtype=bool)
    kept[[0, -1]] = True
    waiting = [(0, len(line) - 1)]
    while waiting:
        first, last = waiting.pop()
        between = line[first + 1 : last] - line[first]
        if not len(between):
            continue
        along = line[last] - line[first]
        length = float(np.hypot(*along))
        if length > 0:
            away = np.abs(between[:, 0] * along[1] - between[:, 1] * along[0]) / length
        else:
            away = np.hypot(*between.T)
        furthest = int(np.argmax(away))
        if away[furthest] > tolerance:
            middle = first + 1 + furthest
            kept[middle] = True
            waiting += [(first, middle), (middle, last)]
    return line[kept]
