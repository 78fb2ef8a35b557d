"""What the model is written in: operations on numbers that are several lanes wide.

A *lane* is one axis of one controller of one run. The model is written once, as if for a single
lane, with ``+ - * /``, comparisons, and the few functions below; where it branches it selects.

From Python it runs as it stands here, on numpy arrays of shape (8,), on plain numbers, or on
whatever else has these operators. Compiled by numba (`motionlab.lanes.compiler`) a value is one
LLVM vector ``<8 x double>``, so that the vector unit is used by construction and a lane's bits
cannot depend on its neighbours. Batches use sixteen lanes, two such vectors side by side: twice the
lanes wait for the same chain of operations, and each vector's code, so each lane's bits, stays
what it is alone. A vector of sixteen would not do: of two products that may be fused with their
sum, LLVM picks another one there.

The floating-point liberties that compiled code takes are fused multiply-add, reciprocals of shared
divisors, and the sign of zero. numba's ``fastmath=True`` would fold ``isfinite`` to True and let
NaN pass unseen.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias, TypeVar

import numpy as np

WIDTH = 8
"""Lanes in one vector: of a single run."""

WIDE = 16
"""Lanes of a batch: two vectors side by side."""

Lanes: TypeAlias = Any
"""A vector of WIDTH or WIDE doubles: an LLVM vector when compiled, otherwise an array."""

Mask: TypeAlias = Any
"""A vector of as many truth values."""

Function = TypeVar("Function", bound=Callable[..., Any])

DECLARED: list[Callable[..., Any]] = []
"""Functions that compiled code may call, until the compiler takes them."""

TAKERS: list[Callable[[], None]] = []
"""What takes them, once it has been imported."""


def compiled(function: Function) -> Function:
    """Let compiled code call a function on lanes, inlined; from Python it runs as it is.

    Division by zero gives inf or NaN there, as in hardware.
    """
    DECLARED.append(function)
    for take in TAKERS:
        take()
    return function


def select(mask: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where `mask` holds and `no` elsewhere."""
    return np.where(mask, yes, no)


def anywhere(mask: Any) -> bool:
    """Return whether `mask` holds in any lane: what no lane needs can be left out."""
    return bool(np.any(mask))


def square_root(x: Any) -> Any:
    """Return the square root of `x`."""
    return np.sqrt(x)


def round_down(x: Any) -> Any:
    """Return the greatest whole number not above `x`."""
    return np.floor(x)


def round_nearest(x: Any) -> Any:
    """Return the whole number nearest to `x`, halves to even."""
    return np.rint(x)


def power_of_two(n: Any) -> Any:
    """Return 2**n for whole `n` with -1022 <= n <= 1023."""
    return np.ldexp(1.0, n.astype(np.int64))


# -- arrays ---------------------------------------------------------------------------------------
# The type of an array does not contain the width of its lanes: a reader takes it from a constant or
# by lanes that are as wide.


def unpack(record: Any, array: Any, first: int = 0, width: Any = WIDTH) -> Any:
    """Return rows `first`, ... of `array`, shape (rows, width), as a named tuple of lanes."""
    return record(*array[first : first + len(record._fields)])


def axes_at(record: Any, array: Any, tick: Any, width: Any = WIDTH) -> Any:
    """Return ``array[tick]``, shape (fields, 2) at least, as a tuple: x in even lanes, y in odd."""
    fields = array[tick, : len(record._fields)]
    return record(*np.tile(fields, (width if isinstance(width, int) else len(width)) // 2))


def pack(values: Any, array: Any) -> None:
    """Write a named tuple of lanes into the rows of `array`, shape (fields, width)."""
    for row, value in zip(array, values, strict=True):
        row[:] = value


def load_vectors(record: Any, array: Any, first: Any, width: Any) -> Any:
    """Return rows `first`, ... of `array`, shape (vectors, rows, WIDTH), as lanes side by side."""
    rows = array[:, first : first + len(record._fields)]
    return record(*np.swapaxes(rows, 0, 1).reshape(len(record._fields), -1).copy())


def store_vectors(values: Any, array: Any, first: Any) -> None:
    """Write a named tuple of lanes into rows of `array`, shape (vectors, rows, WIDTH)."""
    for row, value in enumerate(values):
        array[:, first + row] = np.reshape(value, (-1, array.shape[2]))


def record(values: Any, array: Any, tick: Any) -> None:
    """Write a named tuple of lanes into ``array[tick]``'s first rows, in the array's precision."""
    pack(values, array[tick, : len(values)])


def recorded(record: Any, array: Any, tick: Any, width: Any = WIDTH) -> Any:
    """Return ``array[tick]``, shape (fields, width), in single precision, as lanes."""
    return record(*array[tick].astype(np.float64))


def load_four(table: Any, index: Any) -> Any:
    """Return four neighbouring numbers of a table for each lane.

    Parameters
    ----------
    table : ndarray, shape (n,)
        What to read; nothing checks that it is long enough.
    index : Lanes
        Whole numbers from 0 to n - 4: where each lane's four numbers begin.

    Returns
    -------
    tuple of four Lanes
        The first, second, third and fourth number of each lane.
    """
    first = np.asarray(index).astype(np.int64)
    return tuple(table[first + k] for k in range(4))


def flush_subnormals() -> int:
    """Flush subnormal numbers to zero in this thread; return the mode for `restore_mode`."""
    return 0


def restore_mode(mode: int) -> None:
    """Restore the floating-point mode that flush_subnormals returned."""
