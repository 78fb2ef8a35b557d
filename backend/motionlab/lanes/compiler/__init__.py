"""The compiler of functions on lanes: numba, taught their types and operations.

Imported by the first function that is compiled; functions that are only declared need no numba.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba
from numba.extending import overload

from motionlab.lanes.compiler import gather, load_store, subnormals, vector
from motionlab.lanes.compiler.cache import use_cache
from motionlab.lanes.operations import DECLARED, TAKERS

use_cache()  # before the first function is decorated

cached: Callable[[Any], Any] = numba.njit(error_model="numpy", nogil=True, cache=True)


def entry(signature: Any) -> Callable[[Any], Any]:
    """Compile a function of pointers, which has an `address`, and keep its code."""
    return numba.cfunc(signature, error_model="numpy", cache=True)


def _take() -> None:
    while DECLARED:
        _register(DECLARED.pop())


def _register(function: Callable[..., Any]) -> None:
    @overload(function, jit_options={"error_model": "numpy", "forceinline": True}, strict=False)
    def _overload(*_args: Any) -> Any:
        return function


TAKERS.append(_take)
_take()

__all__ = ["cached", "entry", "gather", "load_store", "subnormals", "vector"]
