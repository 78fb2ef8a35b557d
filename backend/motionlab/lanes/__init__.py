"""Numbers that are eight or sixteen lanes wide, and the functions that work on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeAlias

import numba

from motionlab.lanes.compile_cache import model_hash, use_cache
from motionlab.lanes.gather import load_four
from motionlab.lanes.load_store import axes_at, pack, record, recorded, unpack
from motionlab.lanes.subnormals import flush_subnormals, restore_mode
from motionlab.lanes.vector import (
    WIDE,
    WIDTH,
    power_of_two,
    round_down,
    round_nearest,
    select,
    square_root,
)

use_cache()  # before the first function is decorated

Lanes: TypeAlias = Any
"""A vector of WIDTH or WIDE doubles: an LLVM vector when compiled, otherwise an array."""

Mask: TypeAlias = Any
"""A vector of as many truth values."""

compiled: Callable[[Any], Any] = numba.njit(error_model="numpy", forceinline=True)
"""Compile a function on lanes; division by zero gives inf or NaN, as in hardware."""

cached: Callable[[Any], Any] = numba.njit(error_model="numpy", nogil=True, cache=True)
"""Compile a function that is called from Python, and keep its code for later processes."""

__all__ = [
    "WIDE",
    "WIDTH",
    "Lanes",
    "Mask",
    "axes_at",
    "cached",
    "compiled",
    "flush_subnormals",
    "load_four",
    "model_hash",
    "pack",
    "power_of_two",
    "record",
    "recorded",
    "restore_mode",
    "round_down",
    "round_nearest",
    "select",
    "square_root",
    "unpack",
]
