"""Arrays of a segment: what its compiled functions read and write, and where in them.

A segment is one record. Times are whole nanoseconds of its clock, which counts from 2000-01-01.
"""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.compile_cache import Kept
from motionlab.drive.libc import part
from motionlab.drive.process_data import NODES
from motionlab.kernel.layout import INPUT_ROWS, PARAMETER_ROWS, PlantState
from motionlab.lanes import WIDTH

cache = Kept("vdrive", "*.py", "virtual/*.py")
kept = cache.function
"""Compile a function that Python calls, and keep it."""

PLANT_ROWS = len(PlantState._fields)
NOISE_PERIODS = 2**15
"""Periods of noise that are drawn; then they repeat, after 16.4 s."""

EEPROM = 1024
"""Bytes of slave information of a node."""

MEMORY = 0x2000
"""Bytes of registers and process memory of a node."""

PROCESS_MEMORY = 0x1000
"""First byte of the process memory."""

OUTPUT_ADDRESS, INPUT_ADDRESS = 0x1100, 0x1180
"""Where the slave information puts process data; a master may choose otherwise."""

FMMUS = SYNC_MANAGERS = 4
STEP_NS = 100_000
"""One step of the plant, `timing.PLANT_STEP`."""

CONTROL_PERIOD_NS = 500_000
HOP_NS = 300
"""Time from one node to the next."""

IDLE_NS = 2_000_000
"""Time without outputs or SYNC0 after which a node reads its encoder by itself."""

CATCH_UP_NS = 500_000_000
"""Most time that is made up after the process has stood still."""

NEVER = 2**62

# Columns of `nodes` of a segment
(
    DRIVE_STATE,  # of cia402.py
    ERROR_CODE,  # object 603F
    CONTROL_LAST,  # control word of the last step
    MODE_DISPLAY,  # object 6061
    STATUS_WORD,  # object 6041
    LIMITED,  # whether the last target was cut
    TARGET,  # current command, mA
    POSITION,  # counts
    VELOCITY,  # counts/s
    TORQUE,  # actual current, per mille of rated
    COUNTED,  # counts at the last step, before switches
    LAST_STEP,  # time of the last step of the drive
    LAST_OUTPUT,  # time of the last complete output data; what the watchdog counts from
    FRESH,  # outputs arrived since the last step
    MISSED,  # SYNC0 without new outputs before it
    CLOCK,  # local clock minus that of the segment, ns
    SYNC_NEXT,  # next SYNC0 in the node's system time; NEVER without
    SYNC_CYCLE,  # ns
    SYNC_COUNT,  # SYNC0 since the activation
    MAIL,  # the master's mailbox is full
    ANSWER,  # the node's mailbox is full
    MAIL_EPOCH,  # counts resets of the mailboxes
    FAULT_REQUEST,  # error code asked for by a switch
    DROP_REQUEST,  # AL status code asked for by a switch
    NODE_COLUMNS,
) = range(25)

# Columns of `objects`: settings that are lost at INIT
(
    SYNC_TYPE,  # 1C32:01
    MAX_TORQUE,  # 6072, per mille
    MAX_CURRENT,  # 6073, per mille
    TORQUE_SLOPE,  # 6087, per mille/s
    FOLLOWING_WINDOW,  # 6065, counts
    FOLLOWING_TIMEOUT,  # 6066, ms
    POSITION_MIN,  # 607D:01, counts
    POSITION_MAX,  # 607D:02, counts
    MAX_SPEED,  # 6080, counts/s
    QUICK_STOP_DECELERATION,  # 6085, counts/s^2
    SYNC_ERROR_LIMIT,  # 10F1:02
    CYCLE_TIME,  # 1C32:02, ns
    INTERPOLATION_TIME,  # 60C2:01, in units of ...
    INTERPOLATION_UNIT,  # ... ten to the power of 60C2:02, s
    OBJECT_COLUMNS,
) = range(15)

# Rows of `clock`
LAST, PLANT_TIME, STEPS, MAILS, RANDOM, PERIODS, CLOCK_ROWS = range(7)

# Rows of `switches`; motionlab.drive.virtual.switches tells what they do
(
    DROP,
    DUPLICATE,
    REORDER,
    DELAY,
    BLACK_HOLE,
    FREEZE,
    REACHED,
    WRONG_COUNTER,
    JUMP_X,
    JUMP_Y,
    STUCK_X,
    STUCK_Y,
    ENCODER_LOST_X,
    ENCODER_LOST_Y,
    STO,
    PUSH_X,
    PUSH_Y,
    PUSH_STEPS_X,
    PUSH_STEPS_Y,
    SWITCH_ROWS,
) = range(20)

# Rows of `counters`
(
    FRAMES,  # processed
    MALFORMED,
    LOST,  # by switches
    WATCHDOGS,  # expired
    SKIPPED,  # ns that were not made up
    LATEST,  # largest time from SYNC0 to outputs, ns
    EARLIEST,  # smallest
    COUNTER_ROWS,
) = range(8)


ARRAYS = np.dtype(
    [
        ("memory", np.uint8, (NODES, MEMORY)),  # registers and process memory
        ("writable", np.uint8, MEMORY),  # bits of a byte that a master may write
        ("eeprom", np.uint8, (NODES, EEPROM)),  # slave information
        ("scratch", np.uint8, 2048),  # one datagram's data
        ("nodes", np.int64, (NODES, NODE_COLUMNS)),
        ("objects", np.int64, (NODES, OBJECT_COLUMNS)),
        ("defaults", np.int64, (NODES, OBJECT_COLUMNS)),  # `objects` after INIT
        ("ratings", np.int64, NODES),  # 6075, rated current, mA
        ("wiring", np.int64, (NODES, 3)),  # lane, phase, lane of the encoder or -1
        ("clock", np.int64, CLOCK_ROWS),
        ("counters", np.int64, COUNTER_ROWS),
        ("tables", np.int64, 2),  # address and size of the force maps
        ("switches", np.float64, SWITCH_ROWS),
        ("scales", np.float64, (2, 3)),  # per lane direction, m a count, m at count 0
        ("plant", np.float64, (PLANT_ROWS, WIDTH)),  # `PlantState`
        ("command", np.float64, (3, WIDTH)),  # currents commanded to the amplifiers, A
        ("measured", np.float64, (1, WIDTH)),  # encoder readings, m
        ("at", np.float64, (1, INPUT_ROWS, 2)),  # load and noise of one step
        ("parameters", np.float64, (PARAMETER_ROWS, WIDTH)),
        ("inputs", np.float64, (NOISE_PERIODS, INPUT_ROWS, 2)),  # as many as `clock` says, repeated
    ],
    align=True,
)
"""State of a segment: one record, so that compiled functions hand on one address."""

Arrays: TypeAlias = Any
"""A record of `ARRAYS`."""


def new_arrays() -> Arrays:
    """Return a record of `ARRAYS`, all zero."""
    return np.zeros(1, dtype=ARRAYS).view(np.recarray)[0]


@part
def get8(values: NDArray[np.uint8], at: int) -> int:
    """Return a byte; numba makes ``int`` of it unsigned, and a float of what is added to it."""
    return int(np.int64(values[at]))


@part
def get16(values: NDArray[np.uint8], at: int) -> int:
    """Return an unsigned number of two bytes."""
    return get8(values, at) | get8(values, at + 1) << 8


@part
def get32(values: NDArray[np.uint8], at: int) -> int:
    """Return an unsigned number of four bytes."""
    return get16(values, at) | get16(values, at + 2) << 16


@part
def get64(values: NDArray[np.uint8], at: int) -> int:
    """Return a signed number of eight bytes."""
    high = get32(values, at + 4)
    if high >= 0x8000_0000:
        high -= 0x1_0000_0000
    return high * 0x1_0000_0000 + get32(values, at)


@part
def put(values: NDArray[np.uint8], at: int, value: int, count: int) -> None:
    """Write the low `count` bytes of a number."""
    for i in range(count):
        values[at + i] = (value >> (8 * i)) & 0xFF


__all__ = [
    "ARRAYS",
    "NODES",
    "Arrays",
    "cache",
    "get8",
    "get16",
    "get32",
    "get64",
    "kept",
    "new_arrays",
    "part",
    "put",
]
