"""Contouring error: how far the mover is from the path, whatever the time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def contour_error(path: Array, following_error: Array, window: tuple[int, int]) -> Array:
    """Return the distance from the measured position to the nearest point of the reference path.

    The path is the polyline through the reference samples. The search starts at the present sample
    and walks along the path while the distance falls, so it never jumps to another branch of a path
    that crosses itself.

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
    start, end = window
    here = path[start:end]
    # Differences first: e is exact to picometres, absolute positions in float32 are not.
    best = np.hypot(following_error[:, 0], following_error[:, 1])
    point = -following_error  # measured position relative to the present reference
    for way in (-1, 1):
        active = np.arange(len(here))
        offset = 0
        while len(active):
            near = np.clip(active + start + offset, 0, len(path) - 1)
            far = np.clip(near + way, 0, len(path) - 1)
            a = path[near] - here[active]
            distance = _to_segment(point[active], a, path[far] - here[active])
            closer = distance < best[active]
            still = ~closer & (near != far) & np.all(path[near] == path[far], axis=1)
            best[active] = np.where(closer, distance, best[active])
            active = active[closer | still]
            offset += way
    return best


def _to_segment(point: Array, a: Array, b: Array) -> Array:
    """Return the distance from points to segments a-b, row by row."""
    along = b - a
    length2 = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", point - a, along) / np.where(length2 > 0.0, length2, 1.0)
    nearest = a + np.clip(share, 0.0, 1.0)[:, None] * along
    return np.hypot(point[:, 0] - nearest[:, 0], point[:, 1] - nearest[:, 1])
