"""Binary telemetry frames; docs/stream.md describes them byte by byte."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAGIC = b"PSRM"
PROTOCOL = 1

_HEADER = struct.Struct("<4sHHIIQ")
HEADER_BYTES = _HEADER.size
"""Bytes before the payload: 24, a multiple of 8."""


@dataclass(frozen=True)
class Frame:
    """A decoded frame.

    Attributes
    ----------
    sequence : int
        Number of the frame on its connection.
    first_tick : int
        Tick of the first sample.
    columns : ndarray of float32, shape (columns, ticks)
        In the order of the subscription.
    """

    sequence: int
    first_tick: int
    columns: NDArray[np.float32]


def header(columns: int, sequence: int, ticks: int, first_tick: int) -> bytes:
    """Return a frame's header."""
    return _HEADER.pack(MAGIC, PROTOCOL, columns, sequence, ticks, first_tick)


def encode(frame: Frame) -> bytes:
    """Return a frame as bytes."""
    count, ticks = frame.columns.shape
    head = header(count, frame.sequence, ticks, frame.first_tick)
    return head + np.ascontiguousarray(frame.columns, dtype="<f4").tobytes()


def decode(data: bytes) -> Frame:
    """Return the frame that bytes hold; its columns are a view of them.

    Raises
    ------
    ValueError
        If the bytes are not a whole frame of this protocol.
    """
    if len(data) < HEADER_BYTES:
        raise ValueError(f"{len(data)} bytes are less than a header")
    magic, protocol, count, sequence, ticks, first_tick = _HEADER.unpack_from(data)
    if magic != MAGIC or protocol != PROTOCOL:
        raise ValueError(f"{magic!r} of protocol {protocol} is no frame")
    if len(data) != HEADER_BYTES + 4 * count * ticks:
        raise ValueError(f"{len(data)} bytes cannot hold {count} columns of {ticks} ticks")
    columns = np.frombuffer(data, dtype="<f4", offset=HEADER_BYTES).reshape(count, ticks)
    return Frame(sequence, first_tick, columns)
