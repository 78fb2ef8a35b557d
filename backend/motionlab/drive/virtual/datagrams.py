"""Frames on their way through the nodes: addressing, FMMUs, working counters.

Frames are read here, not by `ethercat.datagrams`, which the master has: one reading for both sides
would hide its mistakes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.ethercat import (
    APRD,
    APRW,
    APWR,
    ARMW,
    BRD,
    BRW,
    BWR,
    DATAGRAM_HEADER,
    FPRD,
    FPRW,
    FPWR,
    FRAME_HEADER,
    FRMW,
    LRD,
    LRW,
    LWR,
    REGISTER_DL_CONTROL,
    REGISTER_FMMU,
    REGISTER_STATION_ADDRESS,
    REGISTER_STATION_ALIAS,
    WORKING_COUNTER,
)
from motionlab.drive.virtual.esc import read_memory, write_memory
from motionlab.drive.virtual.events import catch_up
from motionlab.drive.virtual.layout import (
    FMMUS,
    FRAMES,
    MALFORMED,
    REACHED,
    WRONG_COUNTER,
    Arrays,
    get8,
    get16,
    get32,
    kept,
    part,
    put,
)

Bytes = NDArray[np.uint8]

FRAME_MAX = 1500
READS, WRITES = 1, 2
"""Parts of a command, and bits of an FMMU's type."""

_MORE, _LENGTH = 0x8000, 0x07FF


@part
def is_frame(frame: Bytes, first: int, size: int) -> bool:
    """Tell whether the bytes after `first` are a frame whose datagrams are as long as they say."""
    if size < FRAME_HEADER:
        return False
    header = get16(frame, first)
    at = first + FRAME_HEADER
    end = at + (header & _LENGTH)
    if header >> 12 != 1 or end > first + size:
        return False
    while True:
        if end < at + DATAGRAM_HEADER + WORKING_COUNTER:
            return False
        length = get16(frame, at + 6)
        at += DATAGRAM_HEADER + (length & _LENGTH) + WORKING_COUNTER
        if at > end:
            return False
        if not length & _MORE:
            return at == end


@part
def _parts(command: int) -> int:
    """Return what a command does at a node that it addresses."""
    if command in (APRD, FPRD, BRD, LRD):
        return READS
    if command in (APWR, FPWR, BWR, LWR):
        return WRITES
    return READS | WRITES if command in (APRW, FPRW, BRW, LRW) else 0


@part
def _addressed(s: Arrays, n: int, command: int, position: int) -> bool:
    memory = s.memory[n]
    if command in (BRD, BWR, BRW):
        return True
    if command in (APRD, APWR, APRW, ARMW):
        return position == 0
    alias = bool(memory[REGISTER_DL_CONTROL + 3] & 1)  # bit 24: the alias addresses the node too
    return position == get16(memory, REGISTER_STATION_ADDRESS) or (
        alias and position == get16(memory, REGISTER_STATION_ALIAS)
    )


@part
def _physical(s: Arrays, n: int, frame: Bytes, at: int, time: int) -> None:
    """Carry out a datagram that addresses registers and memory of nodes."""
    command = get8(frame, at)
    position, offset = get16(frame, at + 2), get16(frame, at + 4)
    size, data = get16(frame, at + 6) & _LENGTH, at + DATAGRAM_HEADER
    here = _addressed(s, n, command, position)
    # Each node counts on, so that the one meant reads its own place as 0.
    if command in (APRD, APWR, APRW, BRD, BWR, BRW, ARMW):
        put(frame, at + 2, position + 1, 2)
    todo = _parts(command) if here else 0
    if command in (ARMW, FRMW):
        todo = READS if here else WRITES
    count = 0
    read = bool(todo & READS) and read_memory(s, n, offset, size, time)
    if read:
        for i in range(size):
            s.scratch[i] = s.memory[n, offset + i]
        count += 1
    if bool(todo & WRITES) and write_memory(s, n, offset, frame, data, size, time):
        count += 2 if todo & READS else 1
    if read:
        # A broadcast ors the answers of all nodes.
        gathers = command in (BRD, BRW)
        for i in range(size):
            other = get8(frame, data + i) if gathers else 0
            frame[data + i] = get8(s.scratch, i) | other
    counter = data + size
    put(frame, counter, get16(frame, counter) + count, 2)


@part
def _mapped(  # noqa: PLR0911, PLR0913, PLR0917 - compiled: one place, no objects
    s: Arrays, n: int, fmmu: int, frame: Bytes, at: int, time: int, way: int
) -> bool:
    """Carry data of one FMMU between a logical datagram and the memory of a node, one way."""
    memory = s.memory[n]
    base = REGISTER_FMMU + 16 * fmmu
    if not memory[base + 12] & 1 or not memory[base + 11] & way:
        return False
    logical, length = get32(memory, base), get16(memory, base + 4)
    first_bit, last_bit = get8(memory, base + 6) & 7, get8(memory, base + 7) & 7
    physical, physical_bit = get16(memory, base + 8), get8(memory, base + 10) & 7
    start, size = get32(frame, at + 2), get16(frame, at + 6) & _LENGTH
    low, high = max(start, logical), min(start + size, logical + length)
    if low >= high:
        return False
    data, there = at + DATAGRAM_HEADER + low - start, physical + low - logical
    count = high - low
    if first_bit == 0 and last_bit == 7 and physical_bit == 0:
        if way == WRITES:
            return write_memory(s, n, there, frame, data, count, time)
        if not read_memory(s, n, there, count, time):
            return False
        for i in range(count):
            frame[data + i] = memory[there + i]
        return True
    # Bits: those from first_bit of the first byte to last_bit of the last one.
    if way == WRITES or low != logical or high != logical + length:
        return False
    bits = 8 * (length - 1) + last_bit - first_bit + 1
    if bits < 1 or not read_memory(s, n, there, (physical_bit + bits + 7) // 8, time):
        return False
    for i in range(bits):
        source, target = physical_bit + i, first_bit + i
        bit = (get8(memory, there + source // 8) >> (source % 8)) & 1
        byte = get8(frame, data + target // 8) & ~(1 << (target % 8))
        frame[data + target // 8] = byte | bit << (target % 8)
    return True


@part
def _logical(s: Arrays, n: int, frame: Bytes, at: int, time: int) -> None:
    """Carry out a datagram that addresses the process image."""
    todo = _parts(get8(frame, at))
    read = written = False
    if todo & WRITES:
        for fmmu in range(FMMUS):
            written |= _mapped(s, n, fmmu, frame, at, time, WRITES)
    if todo & READS:
        for fmmu in range(FMMUS):
            read |= _mapped(s, n, fmmu, frame, at, time, READS)
    count = int(read) + (2 if todo & READS else 1) * int(written)
    counter = at + DATAGRAM_HEADER + (get16(frame, at + 6) & _LENGTH)
    put(frame, counter, get16(frame, counter) + count, 2)


@kept
def answer(s: Arrays, frame: Bytes, first: int, size: int, time: int) -> bool:
    """Send a frame through the nodes; it becomes the answer.

    Its EtherCAT header is at `first`, and `size` counts from there. It arrives at `time`, ns of
    the segment's clock. Returns whether it was a frame, and came back.
    """
    catch_up(s, time)
    if size > FRAME_MAX or not is_frame(frame, first, size):
        s.counters[MALFORMED] += 1
        return False
    reached = int(s.switches[REACHED])
    at = first + FRAME_HEADER
    # One datagram after another passes all nodes, as it does on the wire.
    more = True
    while more:
        command, length = get8(frame, at), get16(frame, at + 6)
        end = at + DATAGRAM_HEADER + (length & _LENGTH)
        for n in range(reached):
            if command in (LRD, LWR, LRW):
                _logical(s, n, frame, at, time)
            elif APRD <= command <= FRMW:
                _physical(s, n, frame, at, time)
        if command in (LRD, LWR, LRW):
            put(frame, end, get16(frame, end) + int(s.switches[WRONG_COUNTER]), 2)
        more = bool(length & _MORE)
        at = end + WORKING_COUNTER
    s.counters[FRAMES] += 1
    return reached > 0
