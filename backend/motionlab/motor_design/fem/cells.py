"""A table over position and current as bicubic cells that follow from their corners."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

_WRAP = 8
"""Nodes repeated beyond each end, so that a spline's end conditions have no effect."""

Array = NDArray[np.float64]


class Cells:
    """Bicubic Hermite cells between the nodes of a table, periodic over x and even in i.

    The slopes at the nodes are those of a spline of the fifth degree over x and the third over i:
    near the aligned position thrust changes within a step of the table, and a cubic's slopes there
    err by three times as much.

    Parameters
    ----------
    x, i : array
        Nodes, m and A, evenly over one pitch with both ends, and evenly from 0.
    table : array, shape (len(x), len(i))
        Values at the nodes.

    Attributes
    ----------
    nodes : array, shape (4, len(x), len(i))
        Value, d/dx, d/di and d2/dx di at the nodes.
    """

    def __init__(self, x: Array, i: Array, table: Array) -> None:
        from scipy.interpolate import RectBivariateSpline

        self._x, self._i = x, i
        pitch = x[-1] - x[0]
        around, mirrored = min(_WRAP, len(x) - 2), min(_WRAP, len(i) - 1)
        wide_x = np.concatenate([x[-1 - around : -1] - pitch, x, x[1 : 1 + around] + pitch])
        wide = np.concatenate([table[-1 - around : -1], table, table[1 : 1 + around]])
        wide_i = np.concatenate([-i[mirrored:0:-1], i])
        wide = np.concatenate([wide[:, mirrored:0:-1], wide], axis=1)
        ev = RectBivariateSpline(wide_x, wide_i, wide, kx=5, ky=3, s=0).ev
        at = np.meshgrid(x, i, indexing="ij")
        self.nodes: Array = np.array(
            [table, ev(*at, dx=1), ev(*at, dy=1), ev(*at, dx=1, dy=1)], dtype=float
        )

    def at(self, x: Array, i: Array, *, dx: int = 0, di: int = 0) -> Array:
        """Return the value, or its first derivative over x or i, within the table."""
        step_x, step_i = self._x[1] - self._x[0], self._i[1] - self._i[0]
        cell_x, s = _cell(x, self._x[0], step_x, len(self._x) - 1)
        cell_i, t = _cell(i, self._i[0], step_i, len(self._i) - 1)
        along_x = np.array(_hermite(s, dx)) / step_x**dx
        along_i = np.array(_hermite(t, di)) / step_i**di
        scaled = self.nodes * np.array([1, step_x, step_i, step_x * step_i])[:, None, None]
        total = np.zeros(np.broadcast_shapes(np.shape(x), np.shape(i)))
        for a in (0, 1):
            for b in (0, 1):
                value, slope_x, slope_i, twist = scaled[:, cell_x + a, cell_i + b]
                total += along_i[2 * b] * (along_x[2 * a] * value + along_x[2 * a + 1] * slope_x)
                total += along_i[2 * b + 1] * (
                    along_x[2 * a] * slope_i + along_x[2 * a + 1] * twist
                )
        return total


def _cell(place: Array, first: float, step: float, count: int) -> tuple[NDArray[np.int64], Array]:
    """Return which cell a place lies in, and its share of the cell that lies before it."""
    steps = (place - first) / step
    cell = np.clip(np.floor(steps).astype(np.int64), 0, count - 1)
    return cell, steps - cell


def _hermite(t: Array, order: int) -> tuple[Array, Array, Array, Array]:
    """Return the Hermite weights of value and slope at both ends of a cell at `t`; or slopes."""
    if order:
        return 6 * t * (t - 1), (3 * t - 1) * (t - 1), 6 * t * (1 - t), t * (3 * t - 2)
    return (
        (1 + 2 * t) * (1 - t) ** 2,
        t * (1 - t) ** 2,
        t * t * (3 - 2 * t),
        t * t * (t - 1),
    )
