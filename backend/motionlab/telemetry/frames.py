"""Binary telemetry frames; docs/stream.md describes them byte by byte."""

from __future__ import annotations

import struct
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

MAGIC = b"PSRM"
PROTOCOL = 1
THINNED = 2
"""In place of the protocol: a frame whose samples stand for several ticks each."""

_HEADER = struct.Struct("<4sHHIIQ")
_STRIDE = struct.Struct("<II")
HEADER_BYTES = _HEADER.size
"""Bytes before the payload: 24, a multiple of 8; 8 more of a thinned frame."""


@dataclass(frozen=True)
class Frame:
    """A decoded frame.

    Attributes
    ----------
    sequence : int
        Number of the frame on its connection.
    first_tick : int
        Tick of the first sample.
    columns : ndarray of float32, shape (columns, samples)
        In the order of the subscription.
    stride : int
        Ticks that each sample stands for. Above 1, two samples are the extremes of twice as many
        ticks, in the order in which they came.
    """

    sequence: int
    first_tick: int
    columns: NDArray[np.float32]
    stride: int = 1

    @property
    def end(self) -> int:
        """The tick after its last."""
        return self.first_tick + self.columns.shape[1] * self.stride


def header(columns: int, sequence: int, samples: int, first_tick: int, stride: int = 1) -> bytes:
    """Return a frame's header."""
    kind = PROTOCOL if stride == 1 else THINNED
    head = _HEADER.pack(MAGIC, kind, columns, sequence, samples, first_tick)
    return head if stride == 1 else head + _STRIDE.pack(stride, 0)


def encode(frame: Frame) -> bytes:
    """Return a frame as bytes."""
    count, samples = frame.columns.shape
    head = header(count, frame.sequence, samples, frame.first_tick, frame.stride)
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
    magic, protocol, count, sequence, samples, first_tick = _HEADER.unpack_from(data)
    if magic != MAGIC or protocol not in {PROTOCOL, THINNED}:
        raise ValueError(f"{magic!r} of protocol {protocol} is no frame")
    begin = HEADER_BYTES + (_STRIDE.size if protocol == THINNED else 0)
    if len(data) != begin + 4 * count * samples:
        raise ValueError(f"{len(data)} bytes cannot hold {count} columns of {samples} samples")
    stride = _STRIDE.unpack_from(data, HEADER_BYTES)[0] if protocol == THINNED else 1
    columns = np.frombuffer(data, dtype="<f4", offset=begin).reshape(count, samples)
    return Frame(sequence, first_tick, columns, stride)
