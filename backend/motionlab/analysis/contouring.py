"""Contouring error: distance from the path, independent of time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached, compiled

Array = NDArray[np.float64]

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
    here = path[slice(*window)]
    spacing = FINENESS * float(np.hypot(*following_error.T).max())
    kept = _thin(path, spacing)
    present = _last_kept(kept, *window)
    return _nearest(path[kept], here, present, np.ascontiguousarray(following_error))


@cached
def _thin(path: Array, spacing: float) -> NDArray[np.int64]:
    """Return the samples that lie apart by `spacing` or more; a hold is one point."""
    kept = [0]
    for k in range(1, len(path)):
        i = kept[-1]
        way = np.hypot(path[k, 0] - path[i, 0], path[k, 1] - path[i, 1])
        if way > 0.0 and way >= spacing:
            kept.append(k)
    return np.array(kept)


@cached
def _last_kept(kept: NDArray[np.int64], start: int, end: int) -> NDArray[np.int64]:
    """Return for each tick which of the samples that were kept is the last until then."""
    present = np.empty(end - start, dtype=np.int64)
    i = 0
    for k in range(start, end):
        while i + 1 < len(kept) and kept[i + 1] <= k:
            i += 1
        present[k - start] = i
    return present


@cached
def _nearest(path: Array, here: Array, present: NDArray[np.int64], following_error: Array) -> Array:
    """Return distance, lag, nearest point less reference, and direction of the path there."""
    nearest_points = np.empty((len(present), 6))
    for n in range(len(present)):
        # From the present reference: e is good to picometres, absolute float32 positions are not.
        x, y = -following_error[n, 0], -following_error[n, 1]
        best = x * x + y * y
        reach = REACH * np.sqrt(best)
        lag, foot_x, foot_y = 0.0, 0.0, 0.0
        # The path before and after the nearest point, of which one may be missing.
        i = present[n]
        kept = here[n, 0] == path[i, 0] and here[n, 1] == path[i, 1]
        before, after = max(i - 1, 0) if kept else i, min(i + 1, len(path) - 1)
        in_x, in_y = here[n, 0] - path[before, 0], here[n, 1] - path[before, 1]
        out_x, out_y = path[after, 0] - here[n, 0], path[after, 1] - here[n, 1]
        for way in (-1, 1):
            # Backwards the last sample that was kept comes first.
            i, travelled = present[n] + (1 if way < 0 else 0), 0.0
            a_x, a_y = 0.0, 0.0
            while travelled < reach and 0 <= i + way < len(path):
                i += way
                b_x, b_y = path[i, 0] - here[n, 0], path[i, 1] - here[n, 1]
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
                    if share == 1.0 and 0 <= i + way < len(path):
                        next_x = way * (path[i + way, 0] - path[i, 0])
                        next_y = way * (path[i + way, 1] - path[i, 1])
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
        nearest_points[n, 0], nearest_points[n, 1], nearest_points[n, 2] = (
            np.sqrt(best),
            lag,
            foot_x,
        )
        nearest_points[n, 3], nearest_points[n, 4], nearest_points[n, 5] = foot_y, along_x, along_y
    return nearest_points


@compiled
def _share(x: float, y: float, along_x: float, along_y: float) -> float:
    """Return the share of the segment from the origin to `along` that is nearest to (x, y)."""
    squared = along_x * along_x + along_y * along_y
    share = (x * along_x + y * along_y) / squared if squared > 0.0 else 0.0  # it may underflow
    return min(max(share, 0.0), 1.0)
