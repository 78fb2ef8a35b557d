"""Contouring error: distance from the path, independent of time."""

from __future__ import annotations

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import compiled

Array = NDArray[np.float64]

REACH = 4.0
"""How far along the path the nearest point is looked for, in lengths of the following error.

A mover that lags on the path by abs(e) is at most abs(e)/sin(theta/2) behind along it if the path
turned a corner of interior angle theta in between: 3.24 abs(e) for the pentagram's 36 degrees.
"""

FINENESS = 4e-3
"""Shortest segment looked at, in largest following errors; it bounds the work of slow motions."""


def contour_error(path: Array, following_error: Array, window: tuple[int, int]) -> Array:
    """Return the distance from the measured position to the nearest point of the reference path.

    The path is the polyline through the reference samples, those closer together than ``FINENESS``
    of the largest following error left out. The nearest point is looked for up to
    ``REACH abs(e)`` along the path before and after the present sample: round a corner, but not on
    another branch of a path that crosses itself, which is further away along the path.

    Parameters
    ----------
    path : ndarray, shape (ticks, 2)
        Reference positions of the whole run, m.
    following_error : ndarray, shape (n, 2)
        Reference less measured position over the window, m.
    window : tuple of int
        Ticks [start, end) of the n samples.

    Returns
    -------
    ndarray, shape (n,)
        Distances, m; never larger than the length of the following error.
    """
    here = path[slice(*window)]
    spacing = FINENESS * float(np.hypot(*following_error.T).max())
    kept = _thin(path, spacing)
    present = _last_kept(kept, *window)
    return _nearest(path[kept], here, present, np.ascontiguousarray(following_error))


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _thin(path: Array, spacing: float) -> NDArray[np.int64]:
    """Return the samples that lie apart by `spacing` or more; a hold is one point."""
    kept = [0]
    for k in range(1, len(path)):
        i = kept[-1]
        way = np.hypot(path[k, 0] - path[i, 0], path[k, 1] - path[i, 1])
        if way > 0.0 and way >= spacing:
            kept.append(k)
    return np.array(kept)


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _last_kept(kept: NDArray[np.int64], start: int, end: int) -> NDArray[np.int64]:
    """Return for each tick which of the samples that were kept is the last until then."""
    present = np.empty(end - start, dtype=np.int64)
    i = 0
    for k in range(start, end):
        while i + 1 < len(kept) and kept[i + 1] <= k:
            i += 1
        present[k - start] = i
    return present


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _nearest(path: Array, here: Array, present: NDArray[np.int64], following_error: Array) -> Array:
    distance = np.empty(len(present))
    for n in range(len(present)):
        # From the present reference: e is good to picometres, absolute float32 positions are not.
        x, y = -following_error[n, 0], -following_error[n, 1]
        best = x * x + y * y
        reach = REACH * np.sqrt(best)
        for way in (-1, 1):
            i, travelled = present[n], 0.0
            a_x, a_y = 0.0, 0.0
            while travelled < reach and 0 <= i + way < len(path):
                i += way
                b_x, b_y = path[i, 0] - here[n, 0], path[i, 1] - here[n, 1]
                travelled += np.sqrt((b_x - a_x) ** 2 + (b_y - a_y) ** 2)
                best = min(best, _to_segment(x - a_x, y - a_y, b_x - a_x, b_y - a_y))
                a_x, a_y = b_x, b_y
        distance[n] = np.sqrt(best)
    return distance


@compiled
def _to_segment(x: float, y: float, along_x: float, along_y: float) -> float:
    """Return the squared distance from (x, y) to the segment from the origin to `along`."""
    squared = along_x * along_x + along_y * along_y
    share = (x * along_x + y * along_y) / squared if squared > 0.0 else 0.0  # it may underflow
    share = min(max(share, 0.0), 1.0)
    return (x - share * along_x) ** 2 + (y - share * along_y) ** 2
