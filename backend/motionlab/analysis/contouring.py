"""Contouring error: distance from the path, independent of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached, compiled

Array = NDArray[np.float64]
Errors = NDArray[np.float64] | NDArray[np.float32]

REACH = 4.0
"""How far along the path the nearest point is looked for, in lengths of the following error.

A mover that lags on the path by abs(e) is at most abs(e)/sin(theta/2) behind along it if the path
turned a corner of interior angle theta in between: 3.24 abs(e) for the pentagram's 36 degrees.
"""

AROUND = 20_000
"""Most samples of the path before and after a stretch that the search may go to: 10 s."""

_BEYOND = 1.0
"""Length of the lines that prolong a path, m: further than the search goes."""

_TURNED = 1e-12
"""Below this the sum of two unit vectors, squared, is nothing."""

FINENESS = 4e-3
"""Shortest segment looked at, in largest following errors; it bounds the work of slow motions."""


class Nearest(NamedTuple):
    """Nearest point of the reference path to each measured position.

    Attributes
    ----------
    contour : ndarray, shape (n,)
        Signed distance from the path, positive to the left of its direction, m.
    lag : ndarray, shape (n,)
        How far along the path the nearest point lies behind the reference, m.
    foot : ndarray, shape (n, 2)
        The nearest point less the reference, m.
    """

    contour: Array
    lag: Array
    foot: Array


def contour_error(path: Array, window: tuple[int, int], following_error: Array) -> Array:
    """Return the distance from the measured position to the nearest point of the reference path.

    The path is the polyline through the reference samples, those closer together than ``FINENESS``
    of the largest following error left out. The nearest point is looked for up to
    ``REACH abs(e)`` along the path before and after the present sample: round a corner, but not on
    another branch of a path that crosses itself, which is further away along the path.

    Parameters
    ----------
    path : ndarray, shape (ticks, 2)
        Reference positions of the whole run, m.
    window : tuple of int
        Ticks [start, end) of the n samples.
    following_error : ndarray, shape (n, 2)
        Reference less measured position over the window, m.

    Returns
    -------
    ndarray, shape (n,)
        Distances, m; never larger than the length of the following error.
    """
    return _looked_for(path, window, following_error)[:, 0]


def prolonged(path: Array, window: tuple[int, int]) -> tuple[Array, tuple[int, int]]:
    """Return a path with a straight line at each end at which it moves, and the window of it.

    For stretches cut out of a longer motion: a mover that lags at their first sample is near the
    path before it, which is not known, and would be that far off the path without.
    """
    into, out = _straight(path[:2]), _straight(path[-2:])
    whole = np.concatenate([path[:1] - into, path, path[-1:] + out])
    return whole, (window[0] + len(into), window[1] + len(into))


def _straight(ends: Array) -> Array:
    """Return the straight continuation of a path by two samples, shape (1, 2); (0, 2) at rest."""
    step = np.diff(ends, axis=0)
    length = np.hypot(*step.T)
    moving = length > 0.0
    return _BEYOND * step[moving] / length[moving, None]


def nearest(path: Array, window: tuple[int, int], following_error: Array) -> Nearest:
    """Return the nearest points of the reference path; parameters as `contour_error`.

    At a corner that is nearest, left and right are those of the mean of both directions: a corner
    is nearest from its outside only.
    """
    distance, lag, foot_x, foot_y, along_x, along_y = _looked_for(path, window, following_error).T
    off_x, off_y = -following_error[:, 0] - foot_x, -following_error[:, 1] - foot_y
    side = np.where(along_x * off_y - along_y * off_x < 0.0, -1.0, 1.0)
    return Nearest(side * distance, lag, np.stack([foot_x, foot_y], axis=1))


def _looked_for(path: Array, window: tuple[int, int], following_error: Array) -> Array:
    kept = np.empty(len(path), dtype=np.int64)
    points = np.empty((window[1] - window[0], 6))
    _search(path, window[0], np.ascontiguousarray(following_error), kept, points)
    return points


@cached
def _search(
    path: Array, start: int, following_error: Array, kept: NDArray[np.int64], points: Array
) -> None:
    write_nearest(path, start, following_error, kept, points)


@compiled
def write_nearest(
    path: Array, start: int, following_error: Errors, kept: NDArray[np.int64], points: Array
) -> None:
    """Write the nearest point of a path to each measured position, without allocating memory.

    Parameters
    ----------
    path : ndarray, shape (ticks, 2)
        Reference positions, m.
    start : int
        Tick of the path at which the window begins.
    following_error : ndarray of float32 or float64, shape (n, 2)
        Reference less measured position over the window, m.
    kept : ndarray of int64, shape (ticks,)
        Overwritten: room for the samples of the path that are looked at.
    points : ndarray, shape (n, 6)
        Overwritten: distance, lag, nearest point less reference, direction of the path there.
    """
    largest = 0.0
    for n in range(len(following_error)):
        x, y = np.float64(following_error[n, 0]), np.float64(following_error[n, 1])
        largest = max(largest, x * x + y * y)
    count = _thin(path, FINENESS * np.sqrt(largest), kept)
    last = 0
    for n in range(len(following_error)):
        while last + 1 < count and kept[last + 1] <= start + n:
            last += 1
        _nearest(path, kept[:count], (last, start + n), following_error[n], points[n])


@compiled
def _thin(path: Array, spacing: float, kept: NDArray[np.int64]) -> int:
    """Write the samples that lie apart by `spacing` or more, and return how many; a hold is one."""
    kept[0] = 0
    count = 1
    for k in range(1, len(path)):
        i = kept[count - 1]
        step_x, step_y = path[k, 0] - path[i, 0], path[k, 1] - path[i, 1]
        way = np.sqrt(step_x * step_x + step_y * step_y)
        if way > 0.0 and way >= spacing:
            kept[count] = k
            count += 1
    return count


@compiled
def _nearest(
    path: Array, kept: NDArray[np.int64], present: tuple[int, int], error: Errors, point: Array
) -> None:
    """Write a row of `write_nearest`; present: the last sample that was kept, and the tick."""
    last, tick = present
    here_x, here_y = path[tick, 0], path[tick, 1]
    # From the present reference: e is good to picometres, absolute float32 positions are not.
    x, y = -np.float64(error[0]), -np.float64(error[1])
    best = x * x + y * y
    reach = REACH * np.sqrt(best)
    lag, foot_x, foot_y = 0.0, 0.0, 0.0
    # The path before and after the nearest point, of which one may be missing.
    at = kept[last]
    on_it = here_x == path[at, 0] and here_y == path[at, 1]
    before = kept[max(last - 1, 0) if on_it else last]
    after = kept[min(last + 1, len(kept) - 1)]
    in_x, in_y = here_x - path[before, 0], here_y - path[before, 1]
    out_x, out_y = path[after, 0] - here_x, path[after, 1] - here_y
    for way in (-1, 1):
        # Backwards the last sample that was kept comes first.
        i, travelled = last + (1 if way < 0 else 0), 0.0
        a_x, a_y = 0.0, 0.0
        while travelled < reach and 0 <= i + way < len(kept):
            i += way
            b_x, b_y = path[kept[i], 0] - here_x, path[kept[i], 1] - here_y
            step_x, step_y = b_x - a_x, b_y - a_y
            length = np.sqrt(step_x**2 + step_y**2)
            share = _share(x - a_x, y - a_y, step_x, step_y)
            squared = (x - a_x - share * step_x) ** 2 + (y - a_y - share * step_y) ** 2
            if squared < best:
                best = squared
                lag = -way * (travelled + share * length)
                foot_x, foot_y = a_x + share * step_x, a_y + share * step_y
                in_x, in_y = way * step_x, way * step_y
                out_x, out_y = in_x, in_y
                if share == 1.0 and 0 <= i + way < len(kept):
                    ahead, at = kept[i + way], kept[i]
                    next_x = way * (path[ahead, 0] - path[at, 0])
                    next_y = way * (path[ahead, 1] - path[at, 1])
                    if way > 0:
                        out_x, out_y = next_x, next_y
                    else:
                        in_x, in_y = next_x, next_y
            travelled += length
            a_x, a_y = b_x, b_y
    into, out = np.sqrt(in_x**2 + in_y**2), np.sqrt(out_x**2 + out_y**2)
    into, out = (into if into > 0.0 else 1.0), (out if out > 0.0 else 1.0)
    along_x, along_y = in_x / into + out_x / out, in_y / into + out_y / out
    if along_x**2 + along_y**2 < _TURNED:  # the path goes back the way it came
        along_x, along_y = in_x, in_y
    point[0], point[1], point[2], point[3] = np.sqrt(best), lag, foot_x, foot_y
    point[4], point[5] = along_x, along_y


@compiled
def _share(x: float, y: float, along_x: float, along_y: float) -> float:
    """Return the share of the segment from the origin to `along` that is nearest to (x, y)."""
    squared = along_x * along_x + along_y * along_y
    share = (x * along_x + y * along_y) / squared if squared > 0.0 else 0.0  # it may underflow
    return min(max(share, 0.0), 1.0)
