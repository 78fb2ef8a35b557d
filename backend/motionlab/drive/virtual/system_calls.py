"""Calls of the C library from compiled code."""

from __future__ import annotations

import ctypes
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

_numba: Any = numba  # whose types do not name all that it exports
_int, _word, _size = types.int32, types.intp, types.intp


def _call(name: str, result: Any, *arguments: Any) -> Any:
    """Return a function of the C library for compiled code, or for Python where nothing is."""
    if _numba.config.DISABLE_JIT:
        return getattr(ctypes.CDLL(None), name)
    return types.ExternalFunction(name, result(*arguments))


recvfrom = _call("recvfrom", _size, _int, _word, _size, _int, _word, _word)
sendto = _call("sendto", _size, _int, _word, _size, _int, _word, _int)
ioctl = _call("ioctl", _int, _int, types.int64, _word)
write = _call("write", _size, _int, _word, _size)
_clock_gettime = _call("clock_gettime", _int, _int, _word)
_ppoll = _call("ppoll", _int, _word, _word, _word, _word)

MSG_DONTWAIT = 0x40
SIOCGSTAMPNS = 0x8907
"""When the last packet read from a socket had arrived."""

CLOCK_REALTIME, CLOCK_MONOTONIC = 0, 1
_POLLIN = 1
SECOND = 1_000_000_000


@numba.njit(nogil=True)
def clock_ns(clock: int, pair: NDArray[np.int64]) -> int:
    """Return a clock, ns; `pair` is room for two numbers."""
    _clock_gettime(clock, pair.ctypes.data)
    return pair[0] * SECOND + pair[1]


@numba.njit(nogil=True)
def wait_for(descriptor: int, time: int, pair: NDArray[np.int64]) -> None:
    """Wait until a descriptor, or none where it is negative, can be read, but not above `time` ns.

    `pair` is room for three numbers.
    """
    time = max(time, 0)
    pair[0], pair[1] = time // SECOND, time % SECOND
    # struct pollfd: descriptor, events, revents.
    pair[2] = (descriptor & 0xFFFF_FFFF) | _POLLIN << 32
    _ppoll(pair[2:].ctypes.data, 1, pair.ctypes.data, 0)
