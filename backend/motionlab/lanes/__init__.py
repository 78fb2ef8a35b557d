"""Numbers that are eight lanes wide, and the functions that work on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numba

from motionlab.lanes.cache import model_hash, use_cache
from motionlab.lanes.vector import (
    WIDTH,
    axes_at,
    flush_subnormals,
    pack,
    power_of_two,
    record,
    restore_mode,
    round_down,
    round_nearest,
    select,
    square_root,
    unpack,
)

use_cache()  # before the first function is decorated

Lanes: TypeAlias = Any
"""A vector of WIDTH doubles: an LLVM vector when compiled, an array of shape (WIDTH,) otherwise."""

Mask: TypeAlias = Any
"""A vector of WIDTH truth values."""

compiled: Callable[[Any], Any] = numba.njit(error_model="numpy", forceinline=True)
"""Compile a function on lanes; division by zero gives inf or NaN, as in hardware."""

__all__ = [
    "WIDTH",
    "Lanes",
    "Mask",
    "axes_at",
    "compiled",
    "flush_subnormals",
    "model_hash",
    "pack",
    "power_of_two",
    "record",
    "restore_mode",
    "round_down",
    "round_nearest",
    "select",
    "square_root",
    "unpack",
]
