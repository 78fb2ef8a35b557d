"""Numbers that are eight or sixteen lanes wide, and the functions that work on them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from motionlab.lanes.operations import (
    WIDE,
    WIDTH,
    Lanes,
    Mask,
    anywhere,
    axes_at,
    compiled,
    flush_subnormals,
    load_four,
    load_vectors,
    pack,
    power_of_two,
    record,
    recorded,
    restore_mode,
    round_down,
    round_nearest,
    select,
    square_root,
    store_vectors,
    unpack,
)
from motionlab.lanes.sources import model_hash, module_hash


def cached(function: Callable[..., Any]) -> Any:
    """Compile a function that is called from Python, and keep its code for later processes."""
    from motionlab.lanes.compiler import cached  # noqa: PLC0415 - numba is imported on first use

    return cached(function)


__all__ = [
    "WIDE",
    "WIDTH",
    "Lanes",
    "Mask",
    "anywhere",
    "axes_at",
    "cached",
    "compiled",
    "flush_subnormals",
    "load_four",
    "load_vectors",
    "model_hash",
    "module_hash",
    "pack",
    "power_of_two",
    "record",
    "recorded",
    "restore_mode",
    "round_down",
    "round_nearest",
    "select",
    "square_root",
    "store_vectors",
    "unpack",
]
