"""Decimation that keeps extremes: the smallest and the largest sample of each bin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached, compiled


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
    return extremes(columns, size)


@cached
def extremes(
    columns: NDArray[np.float32], size: int
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Return the minimum and the maximum of each bin of `size` ticks; the last may hold fewer."""
    low = np.empty((len(columns), -(-columns.shape[1] // size)), dtype=np.float32)
    high = np.empty_like(low)
    for column in range(len(columns)):
        write_extremes(columns[column], size, low[column], high[column])
    return low, high


@compiled
def write_extremes(
    values: NDArray[np.float32], size: int, low: NDArray[np.float32], high: NDArray[np.float32]
) -> None:
    """Write the extremes of each bin of one column into `low` and `high`."""
    for i in range(len(low)):
        least = most = values[i * size]
        for k in range(i * size + 1, min((i + 1) * size, len(values))):
            value = values[k]
            # One that is not a number makes its whole bin one: the curve ends there.
            least = value if value < least or np.isnan(value) else least
            most = value if value > most or np.isnan(value) else most
        low[i], high[i] = least, most
