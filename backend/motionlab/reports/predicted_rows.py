"""Smooth rows of numbers, smaller by what polynomials predict of them, to the last bit."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

ORDER_MAX = 6


def predicted_rows(rows: NDArray[np.float64]) -> tuple[list[int], NDArray[np.float64]]:
    """Return of each row the order of its prediction, and its residuals, which compress well.

    A number is predicted by the polynomial through those before it, as many as the order, from the
    nearest to the furthest: sum of (-1)^(j + 1) binomial(order, j) x[k - j]. The first numbers of a
    row are predicted to be 0. Residuals are differences of bit patterns, their sign in the last
    bit; equal bytes of all are side by side. Sums of products in one order give the same bits
    everywhere, so nothing is lost.

    Parameters
    ----------
    rows : ndarray, shape (rows, n)
        Rows such as positions and velocities.

    Returns
    -------
    tuple
        Orders, and residuals in the place of float64, shape (rows, n).
    """
    residuals = np.empty_like(rows)
    orders = []
    for row, into in zip(rows, residuals, strict=True):
        each = [_residuals(row, order) for order in range(min(ORDER_MAX, len(row)) + 1)]
        # Bits that residuals take, more or less.
        order = int(np.argmin([np.log2(1.0 + bits.astype(np.float64)).sum() for bits in each]))
        orders.append(order)
        planes = each[order].astype("<u8").view(np.uint8).reshape(-1, 8).T
        into.view(np.uint8)[:] = planes.reshape(-1)
    return orders, residuals


def _residuals(row: NDArray[np.float64], order: int) -> NDArray[np.uint64]:
    prediction = np.zeros_like(row)
    for j in range(1, order + 1):
        weight = (-1.0) ** (j + 1) * math.comb(order, j)
        prediction[order:] += weight * row[order - j : len(row) - j]
    difference = row.view(np.int64) - prediction.view(np.int64)
    return ((difference << 1) ^ (difference >> 63)).view(np.uint64)
