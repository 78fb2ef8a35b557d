"""Calls of the C library for compiled code, by symbol: such code can be cached."""

from __future__ import annotations

import socket
import time

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

_clock_gettime = types.ExternalFunction("clock_gettime", types.int32(types.int32, types.intp))
_clock_nanosleep = types.ExternalFunction(
    "clock_nanosleep", types.int32(types.int32, types.int32, types.intp, types.intp)
)
_ppoll = types.ExternalFunction(
    "ppoll", types.int32(types.intp, types.uintp, types.intp, types.intp)
)
_send = types.ExternalFunction(
    "send", types.intp(types.int32, types.intp, types.uintp, types.int32)
)
_recv = types.ExternalFunction(
    "recv", types.intp(types.int32, types.intp, types.uintp, types.int32)
)

MONOTONIC = time.CLOCK_MONOTONIC
_ABSOLUTE = 1  # TIMER_ABSTIME
_NO_WAIT = int(socket.MSG_DONTWAIT) | int(socket.MSG_NOSIGNAL)
_READABLE = 1  # POLLIN
_SECOND = 1_000_000_000

Scratch = NDArray[np.int64]
"""Three numbers for the structures that calls read and write: a timespec and a pollfd."""


def scratch() -> Scratch:
    """Return room for the structures of the calls below, one for each thread."""
    return np.zeros(3, dtype=np.int64)


@numba.njit(nogil=True, cache=True)
def now(room: Scratch) -> int:
    """Return the time of the monotonic clock, ns."""
    _clock_gettime(MONOTONIC, room.ctypes.data)
    return room[0] * _SECOND + room[1]


@numba.njit(nogil=True, cache=True)
def sleep_until(instant: int, room: Scratch) -> None:
    """Sleep until an instant of the monotonic clock, ns."""
    room[0] = instant // _SECOND
    room[1] = instant % _SECOND
    while _clock_nanosleep(MONOTONIC, _ABSOLUTE, room.ctypes.data, 0) != 0:
        pass


@numba.njit(nogil=True, cache=True)
def wait_readable(descriptor: int, nanoseconds: int, room: Scratch) -> bool:
    """Return whether a descriptor can be read within a time, ns."""
    room[0] = max(nanoseconds, 0) // _SECOND
    room[1] = max(nanoseconds, 0) % _SECOND
    room[2] = descriptor | _READABLE << 32
    return _ppoll(room[2:].ctypes.data, 1, room.ctypes.data, 0) > 0


@numba.njit(nogil=True, cache=True)
def send(descriptor: int, data: NDArray[np.uint8], count: int) -> bool:
    """Send the first bytes of an array on a connected socket, without waiting."""
    return _send(descriptor, data.ctypes.data, count, _NO_WAIT) == count


@numba.njit(nogil=True, cache=True)
def receive(descriptor: int, data: NDArray[np.uint8]) -> int:
    """Receive one packet into an array, without waiting, and return its length; < 0 for none."""
    return _recv(descriptor, data.ctypes.data, data.size, _NO_WAIT)
