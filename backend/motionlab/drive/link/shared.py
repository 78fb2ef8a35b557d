"""Memory that the loop shares with the process that commands it.

One anonymous file, mapped by both. Each number has one writer, and is written whole; a command
counts once `SEQUENCE` has grown, samples once `END` has.
"""

from __future__ import annotations

import enum
import mmap
import os
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.loop_parameters import TABLE_NUMBERS, LoopParameters
from motionlab.drive.process_data import NODES
from motionlab.kernel.layout import PARAMETER_ROWS, SAMPLE_ROWS, LawState
from motionlab.lanes import WIDTH
from motionlab.timing import to_ticks

RUN_TICKS_MAX = to_ticks(300.0)
"""Longest motion, its approach included, ticks."""
RECORDED_ROWS = SAMPLE_ROWS + len(LawState._fields)
"""Channels of a lane, then the numbers of its law's state."""
RING_TICKS = 1 << 16
"""Ticks whose samples are held: 33 s."""
NEVER = RUN_TICKS_MAX
"""A tick that no motion reaches."""
ROUND_TRIP_BINS = 512
"""Bins of 1 us; the last takes all that is longer."""


TEST_CURRENT = 0.4
"""Largest current of an open-loop test, of the largest current of the axis."""
TEST_SPEED = 0.4
"""Largest speed of a test, of the largest speed of the axis."""
TEST_BEYOND = 0.02
"""Largest travel of a test beyond the range of positions, m."""


class State(enum.IntEnum):
    """What the loop does; its names are those of the Drive screen."""

    OFFLINE = 0  # no process data
    READY = 1  # drives operational, no torque
    ARMING = 2  # drives on their way to operation enabled
    HOLDING = 3  # torque, at rest
    MOVING = 4  # torque, along a motion
    TESTING = 5  # torque, phase currents from a table, no controller
    STOPPING = 6  # torque, braking to rest
    FAULT = 7  # no torque, latched


class Order(enum.IntEnum):
    """Orders to the loop."""

    NONE = 0
    ARM = 1
    DISARM = 2
    RESET = 3
    START = 4
    QUIT = 5
    TEST = 6


class Command(enum.IntEnum):
    """Numbers that the commanding process writes."""

    HEARTBEAT = 0  # the machine's monotonic time, ns
    ORDER = 1
    RUN_TICKS = 2  # length of the motion to start
    RUN_FIRST = 3  # its first tick that is recorded; before it is the approach
    RUN = 4  # number of the motion
    PARAMETERS = 5  # which of the two sets of parameters is to be in effect
    STOPS = 6  # grows with each stop, which waits for no other order
    SEQUENCE = 7  # grows with each order, after its numbers
    STOPS_BEFORE = 8  # stops that the order knew of: one with torque is refused after another
    TRAVEL_X = 9  # of a test, from where it begins, nm
    TRAVEL_Y = 10
    REST_TICKS = 11  # ticks at rest after which a test ends; 0 for never
    REST_FROM = 12  # first tick of a test that counts as rest
    MOTION_TICKS = 13  # of the motion from its first recorded tick on, without its braking
    LAP_TICKS = 14  # of its laps, or all of them; 0 for no phase


class Status(enum.IntEnum):
    """Numbers that the loop writes."""

    STATE = 0
    FAULT = 1  # code of `faults`
    FAULT_PLACE = 2  # drive from 1, or axis, that it concerns; 0 for the link
    DONE = 3  # sequence of the latest order carried out
    CYCLES = 4
    END = 5  # samples of the present motion
    RUN = 6  # number of the present motion
    LATE = 7  # cycles whose answer came after their period
    LATE_RUN = 8  # longest run of such cycles
    MISSED = 9  # cycles without good inputs, or whose outputs not every drive took
    MISSED_NOW = 10  # in a row, at the moment
    LOST_SENDS = 11  # frames that the socket did not take
    WORKING_COUNTER = 12  # of the latest inputs and outputs
    AL_STATUS = 13  # of all nodes, or-ed
    PHASE_ERROR = 14  # of the exchange against SYNC0, ns
    PHASE_LOCKED = 15
    ROUND_TRIP = 16  # ns
    CONTROL_TIME = 17  # longest, ns
    UPDATED = 18  # the machine's monotonic time at the end of the latest cycle, ns
    PRIORITY = 19  # under SCHED_FIFO; 0 without
    MEMORY_LOCKED = 20
    WAKE_LATE = 21  # longest, ns
    REFUSED = 22  # whether the latest order was refused in the state of the loop
    STOPS_SEEN = 23
    PARAMETERS = 24  # which of the two sets the loop reads
    PARAMETERS_TICK = 25  # first tick computed with it; below 0 on the approach
    CONTROL_LAST = 26  # time of the latest control half, ns
    NODE_STATUS = 27  # status words
    NODE_ERROR = NODE_STATUS + NODES  # error codes
    NODE_TORQUE = NODE_ERROR + NODES  # per mille
    NODE_MODE = NODE_TORQUE + NODES  # mode of operation display
    AT_STOP = NODE_MODE + NODES  # axis from 1 that ended a test by resting; else 0
    COUNT = AT_STOP + 1


class Figure(enum.IntEnum):
    """Numbers with a fraction that the loop writes; x first, then y."""

    POSITION = 0  # m
    VELOCITY = 2  # m/s
    FOLLOWING_ERROR = 4  # m
    REFERENCE = 6  # m
    FAULT_VALUE = 8
    FAULT_LIMIT = 9
    COUNT = 10


class Shared(NamedTuple):
    """The arrays of the shared memory."""

    command: NDArray[np.int64]
    status: NDArray[np.int64]
    figures: NDArray[np.float64]
    round_trips: NDArray[np.int64]  # histogram, us
    waits: NDArray[np.int64]  # the same of every cycle, whether an answer came or not
    parameters: NDArray[np.float64]  # two sets, as `LoopParameters` has them
    tabled: NDArray[np.int64]
    tables: NDArray[np.float64]
    first: NDArray[np.int64]  # tick of the motion from which each set holds; 0 for at once
    reference: NDArray[np.float64]
    """(ticks, 3, 2): position, velocity, acceleration, or currents of the phases, of x and y"""
    samples: NDArray[np.float32]  # (ticks, RECORDED_ROWS, 2), a ring


_SHAPES: tuple[tuple[Any, tuple[int, ...]], ...] = (
    (np.int64, (len(Command),)),
    (np.int64, (Status.COUNT,)),
    (np.float64, (Figure.COUNT,)),
    (np.int64, (ROUND_TRIP_BINS,)),
    (np.int64, (ROUND_TRIP_BINS,)),
    (np.float64, (2, PARAMETER_ROWS, WIDTH)),
    (np.int64, (2, 2)),
    (np.float64, (2, TABLE_NUMBERS)),
    (np.int64, (2,)),
    (np.float64, (RUN_TICKS_MAX, 3, 2)),
    (np.float32, (RING_TICKS, RECORDED_ROWS, 2)),
)
_LINE = 64  # bytes; two writers never share a cache line


def _size(kind: Any, shape: tuple[int, ...]) -> int:
    return -(-int(np.prod(shape)) * np.dtype(kind).itemsize // _LINE) * _LINE


def create() -> int:
    """Return the descriptor of a new shared memory, all zero."""
    descriptor = os.memfd_create("motionlab-drive", os.MFD_CLOEXEC)
    os.ftruncate(descriptor, sum(_size(*entry) for entry in _SHAPES))
    return descriptor


def attach(descriptor: int) -> Shared:
    """Return the arrays of a shared memory."""
    memory = mmap.mmap(descriptor, sum(_size(*entry) for entry in _SHAPES))
    arrays: list[Any] = []
    at = 0
    for kind, shape in _SHAPES:
        count = int(np.prod(shape))
        arrays.append(np.frombuffer(memory, kind, count, at).reshape(shape))
        at += _size(kind, shape)
    return Shared(*arrays)


def write_set(shared: Shared, number: int, parameters: LoopParameters, first: int = 0) -> None:
    """Write one of the two sets of parameters, which the loop must not be reading.

    `first` is the tick of the motion from which it holds; 0 for at once.
    """
    shared.first[number] = first
    shared.parameters[number] = parameters.lanes
    shared.tabled[number] = parameters.tabled
    shared.tables[number, : parameters.tables.size] = parameters.tables
