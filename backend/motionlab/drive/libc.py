"""Calls of the C library for compiled code, by symbol: such code can be cached.

Loop and virtual drive read, sleep and wait on the clock of this module alone. It is the machine's
monotonic clock, divided by `slow`: a link that runs slower than real time has as many times longer
for everything, on both sides alike.
"""

from __future__ import annotations

import ctypes
import socket
import time
from typing import Any

import numba
import numpy as np
from numba import types
from numpy.typing import NDArray

_numba: Any = numba  # whose types do not name all that it exports
_int, _word, _size = types.int32, types.intp, types.uintp

_PLAIN = {_int: ctypes.c_int32, _word: ctypes.c_int64, _size: ctypes.c_uint64}


def _call(name: str, result: Any, *arguments: Any) -> Any:
    """Return a function of the C library for compiled code, or for Python where nothing is."""
    if _numba.config.DISABLE_JIT:
        function = getattr(ctypes.CDLL(None), name)
        function.restype, *function.argtypes = (_PLAIN[kind] for kind in (result, *arguments))
        return lambda *values: function(*map(int, values))
    return types.ExternalFunction(name, result(*arguments))


_clock_gettime = _call("clock_gettime", _int, _int, _word)
_clock_nanosleep = _call("clock_nanosleep", _int, _int, _int, _word, _word)
_ppoll = _call("ppoll", _int, _word, _size, _word, _word)
_send = _call("send", _word, _int, _word, _size, _int)
_recv = _call("recv", _word, _int, _word, _size, _int)
_ioctl = _call("ioctl", _int, _int, _word, _word)
_write = _call("write", _word, _int, _word, _size)
_recvfrom = _call("recvfrom", _word, _int, _word, _size, _int, _word, _word)
_sendto = _call("sendto", _word, _int, _word, _size, _int, _word, _int)

_MONOTONIC, _REALTIME = time.CLOCK_MONOTONIC, time.CLOCK_REALTIME
_ABSOLUTE = 1  # TIMER_ABSTIME
_NO_WAIT = int(socket.MSG_DONTWAIT)
_SEND = _NO_WAIT | int(socket.MSG_NOSIGNAL)  # which raw sockets refuse where it is received
_READABLE = 1  # POLLIN
_ARRIVAL = 0x8907  # SIOCGSTAMPNS: when the last packet read from a socket had arrived
_SECOND = 1_000_000_000
_SLOW = 3

part = numba.njit(error_model="numpy", nogil=True)
"""Compile a function that kept functions call."""

Clock = NDArray[np.int64]
"""A timespec and a pollfd for the calls below to read and write, then `slow`."""


def new_clock(slow: int = 1) -> Clock:
    """Return a clock that is `slow` times slower than the machine's, one for each thread."""
    return np.array([0, 0, 0, slow], dtype=np.int64)


@part
def now(clock: Clock) -> int:
    """Return the time, ns."""
    _clock_gettime(np.int32(_MONOTONIC), clock.ctypes.data)
    return (clock[0] * _SECOND + clock[1]) // clock[_SLOW]


@part
def machine_time(instant: int, clock: Clock) -> int:
    """Return an instant of this clock as the machine's monotonic clock has it, ns."""
    return instant * clock[_SLOW]


@part
def sleep_until(instant: int, clock: Clock) -> None:
    """Sleep until an instant, ns."""
    at = machine_time(instant, clock)
    clock[0], clock[1] = at // _SECOND, at % _SECOND
    while (
        _clock_nanosleep(np.int32(_MONOTONIC), np.int32(_ABSOLUTE), clock.ctypes.data, 0) != 0
    ):  # interrupted by a signal
        pass


@part
def wait_readable(descriptor: int, nanoseconds: int, clock: Clock) -> bool:
    """Return whether a descriptor can be read within a time, ns; one below 0 never can."""
    wait = max(nanoseconds, 0) * clock[_SLOW]
    clock[0], clock[1] = wait // _SECOND, wait % _SECOND
    # struct pollfd: descriptor, events, revents
    clock[2] = (descriptor & 0xFFFF_FFFF) | _READABLE << 32
    return _ppoll(clock[2:].ctypes.data, 1, clock.ctypes.data, 0) > 0


@part
def send(descriptor: int, data: NDArray[np.uint8], count: int) -> bool:
    """Send the first bytes of an array on a connected socket, without waiting."""
    return _send(np.int32(descriptor), data.ctypes.data, count, np.int32(_SEND)) == count


@part
def receive(descriptor: int, data: NDArray[np.uint8]) -> int:
    """Receive one packet into an array, without waiting, and return its length; < 0 for none."""
    return _recv(np.int32(descriptor), data.ctypes.data, data.size, np.int32(_NO_WAIT))


@part
def send_to(
    descriptor: int, data: NDArray[np.uint8], count: int, address: NDArray[np.uint8], size: int
) -> None:
    """Send the first bytes of an array to an address of `size` bytes, without waiting."""
    _sendto(
        np.int32(descriptor),
        data.ctypes.data,
        count,
        np.int32(_SEND),
        address.ctypes.data,
        np.int32(size),
    )


@part
def receive_from(
    descriptor: int, data: NDArray[np.uint8], address: NDArray[np.uint8], size: NDArray[np.int32]
) -> int:
    """Receive one packet and its sender's address, of ``size[1]`` bytes, as `receive` does."""
    size[0] = address.size
    count = _recvfrom(
        np.int32(descriptor),
        data.ctypes.data,
        data.size,
        np.int32(_NO_WAIT),
        address.ctypes.data,
        size.ctypes.data,
    )
    if count >= 0:
        size[1] = size[0]
    return count


@part
def age(descriptor: int, clock: Clock) -> int:
    """Return how long ago the last packet read from a socket arrived, ns; 0 where unknown."""
    if _ioctl(np.int32(descriptor), _ARRIVAL, clock.ctypes.data) != 0:
        return 0
    arrived = clock[0] * _SECOND + clock[1]
    _clock_gettime(np.int32(_REALTIME), clock.ctypes.data)
    passed = clock[0] * _SECOND + clock[1] - arrived
    return passed // clock[_SLOW] if 0 <= passed < _SECOND else 0


@part
def raise_event(descriptor: int, clock: Clock) -> None:
    """Add 1 to an event counter."""
    clock[0] = 1
    _write(np.int32(descriptor), clock.ctypes.data, 8)
