"""Frames of the cyclic exchange: their bytes, and how compiled code sends and reads them.

Two frames a period. The first reads the inputs of all drives (LRD), their application-layer status
(BRD) and distributes the clock of the first (ARMW); the second writes the outputs (LWR) that the
loop computed from these inputs, so that a command acts one period after the position it is from.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.ethercat import (
    ARMW,
    BRD,
    DATAGRAM_HEADER,
    FRAME_HEADER,
    LRD,
    LWR,
    NOP,
    REGISTER_AL_STATUS,
    REGISTER_DC_SYSTEM_TIME,
    WORKING_COUNTER,
    Datagram,
    frame,
)
from motionlab.drive.libc import Clock, now, part, receive, send, wait_readable
from motionlab.drive.process_data import INPUT_BYTES, NODES, OUTPUT_BYTES

Bytes = NDArray[np.uint8]

OUTPUTS_AT = 0
INPUTS_AT = NODES * OUTPUT_BYTES
"""Logical addresses of process data."""

_INPUTS = NODES * INPUT_BYTES
_OUTPUTS = NODES * OUTPUT_BYTES
_FIRST_DATA = FRAME_HEADER + DATAGRAM_HEADER
_INDEX = FRAME_HEADER + 1
_CLOCK_INDEX = _FIRST_DATA + _INPUTS + WORKING_COUNTER + 1
_CLOCK_DATA = _FIRST_DATA + _INPUTS + WORKING_COUNTER + DATAGRAM_HEADER
_AL_INDEX = _CLOCK_DATA + 8 + WORKING_COUNTER + 1
_AL_DATA = _CLOCK_DATA + 8 + WORKING_COUNTER + DATAGRAM_HEADER
_READ_BYTES = _AL_DATA + 2 + WORKING_COUNTER
_WRITE_BYTES = _FIRST_DATA + _OUTPUTS + WORKING_COUNTER
_ROOM = 1600

SPIN = 100_000
"""ns for which an answer is polled for before the loop sleeps: to wake up takes longer."""


class Bus(NamedTuple):
    """Socket and frames of a link; the loop's own."""

    descriptor: int
    header: int  # bytes before a frame: those of Ethernet, or none in UDP
    read: Bytes
    write: Bytes
    answer: Bytes
    clock: Clock
    spin: int  # ns


class Inputs(NamedTuple):
    """What the first frame of a cycle brought, beside the bytes of the inputs."""

    good: bool
    working_counter: int
    al_status: int
    system_time: int  # of the first node, ns
    round_trip: int  # ns
    written: int  # working counter of the outputs before, -1 while not seen


def cyclic_bus(descriptor: int, header: bytes, clock: Clock, *, clocks: bool, spin: int = 0) -> Bus:
    """Return the bus over a connected socket.

    `header` is the Ethernet header of each frame, empty for UDP. Without `clocks` the datagram of
    the first node's clock does nothing. An answer is polled for `spin` ns before the loop sleeps.
    """
    distribute = ARMW if clocks else NOP
    read = frame(
        [
            Datagram(LRD, INPUTS_AT, 0, bytes(_INPUTS)),
            Datagram(distribute, 0, REGISTER_DC_SYSTEM_TIME, bytes(8)),
            Datagram(BRD, 0, REGISTER_AL_STATUS, bytes(2)),
        ]
    )
    write = frame([Datagram(LWR, OUTPUTS_AT, 0, bytes(_OUTPUTS))])
    return Bus(
        descriptor,
        len(header),
        np.frombuffer(bytearray(header + read), np.uint8),
        np.frombuffer(bytearray(header + write), np.uint8),
        np.zeros(_ROOM, np.uint8),
        clock,
        spin,
    )


@part
def u16(data: Bytes, at: int) -> int:
    """Return a little-endian number of 16 bits."""
    return int(np.int64(data[at]) | np.int64(data[at + 1]) << 8)


@part
def i16(data: Bytes, at: int) -> int:
    """Return a little-endian signed number of 16 bits."""
    value = u16(data, at)
    return value - 0x10000 if value & 0x8000 else value


@part
def i32(data: Bytes, at: int) -> int:
    """Return a little-endian signed number of 32 bits."""
    value = u16(data, at) | u16(data, at + 2) << 16
    return value - 0x1_0000_0000 if value & 0x8000_0000 else value


@part
def put16(data: Bytes, at: int, value: int) -> None:
    """Write a little-endian number of 16 bits."""
    data[at] = value & 0xFF
    data[at + 1] = value >> 8 & 0xFF


@part
def read_inputs(bus: Bus, cycle: int, deadline: int) -> Inputs:
    """Send the first frame of a cycle and wait for its answer until `deadline`, ns.

    Answers to earlier frames are taken from the socket and, but for the working counter of the
    outputs before, thrown away. The inputs stay in ``bus.answer``.

    The cycle's number stands in the indices of all three datagrams. That of one repeats after 128
    cycles: answers that waited as long would be taken for new ones, and always be as late.
    """
    index = 2 * cycle & 0xFF
    before = index - 1 & 0xFF
    bus.read[bus.header + _INDEX] = index
    bus.read[bus.header + _CLOCK_INDEX] = cycle >> 7 & 0xFF
    bus.read[bus.header + _AL_INDEX] = cycle >> 15 & 0xFF
    sent = now(bus.clock)
    written = -1
    if not send(bus.descriptor, bus.read, bus.read.size):
        return Inputs(False, 0, 0, 0, 0, -2)
    while True:
        length = receive(bus.descriptor, bus.answer) - bus.header
        if length < 0:
            instant = now(bus.clock)
            if instant < min(sent + bus.spin, deadline):
                continue
            left = deadline - instant
            if left <= 0 or not wait_readable(bus.descriptor, left, bus.clock):
                return Inputs(False, 0, 0, 0, now(bus.clock) - sent, written)
            continue
        data = bus.answer[bus.header :]
        if length >= _WRITE_BYTES and data[_INDEX - 1] == LWR and data[_INDEX] == before:
            written = u16(data, _FIRST_DATA + _OUTPUTS)
        elif length >= _READ_BYTES and data[_INDEX - 1] == LRD and data[_INDEX] == index:
            if data[_CLOCK_INDEX] == cycle >> 7 & 0xFF and data[_AL_INDEX] == cycle >> 15 & 0xFF:
                break
        if now(bus.clock) >= deadline:  # however many others come
            return Inputs(False, 0, 0, 0, now(bus.clock) - sent, written)
    data = bus.answer[bus.header :]
    system_time = 0
    for i in range(7, -1, -1):
        system_time = int(system_time << 8 | np.int64(data[_CLOCK_DATA + i]))
    return Inputs(
        True,
        u16(data, _FIRST_DATA + _INPUTS),
        u16(data, _AL_DATA),
        system_time,
        now(bus.clock) - sent,
        written,
    )


@part
def input_at(bus: Bus, node: int) -> int:
    """Return where the inputs of a node begin in ``bus.answer``."""
    return bus.header + _FIRST_DATA + node * INPUT_BYTES


@part
def set_output(bus: Bus, node: int, control: int, torque: int, mode: int) -> None:
    """Write the outputs of one node into the second frame; `torque` in per mille."""
    at = bus.header + _FIRST_DATA + node * OUTPUT_BYTES
    put16(bus.write, at, control)
    put16(bus.write, at + 2, torque)
    bus.write[at + 4] = mode


@part
def write_outputs(bus: Bus, cycle: int) -> bool:
    """Send the second frame of a cycle; its answer is read in the next."""
    bus.write[bus.header + _INDEX] = 2 * cycle + 1 & 0xFF
    return send(bus.descriptor, bus.write, bus.write.size)
