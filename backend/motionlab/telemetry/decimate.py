"""Decimation that keeps extremes: the smallest and the largest sample of each bin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def min_max(
    columns: NDArray[np.float32], bins: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the minimum and the maximum of each of about `bins` equal bins.

    Parameters
    ----------
    columns : ndarray, shape (columns, ticks)
        What to decimate.
    bins : int
        Bins at most; fewer where there are fewer ticks.

    Returns
    -------
    tuple of ndarray, each of shape (columns, bins)
        Minima and maxima; every bin holds the same number of ticks but the last, which may hold
        fewer.
    """
    size = max(1, -(-columns.shape[1] // bins))
    starts = np.arange(0, columns.shape[1], size)
    return (
        np.minimum.reduceat(columns, starts, axis=1),
        np.maximum.reduceat(columns, starts, axis=1),
    )
