"""What the compiled loop knows of its drives, and what it remembers between cycles."""

from __future__ import annotations

import enum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.compile_cache import Kept
from motionlab.drive.libc import part
from motionlab.drive.link.shared import RECORDED_ROWS, Figure, Shared, State, Status
from motionlab.drive.process_data import NODES
from motionlab.kernel.law_calls import Laws, all_laws
from motionlab.kernel.layout import INPUT_ROWS, STATE_ROWS
from motionlab.kernel.motion import Ahead
from motionlab.lanes import WIDTH
from motionlab.timing import CONTROL_PERIOD

kept = Kept("link", "*.py", "link/*.py").function
"""Compile a function that Python calls, and keep it."""

PERIOD = round(CONTROL_PERIOD * 1e9)  # ns


class Layout(NamedTuple):
    """Facts of drives and axes; arrays over nodes, or over x and y."""

    axis: NDArray[np.int64]  # of each node
    phase: NDArray[np.int64]
    rated: NDArray[np.float64]  # A
    encoder: NDArray[np.int64]  # node that reads it
    resolution: NDArray[np.float64]  # m per count, negative where counts fall
    offset: NDArray[np.float64]  # m
    position_min: NDArray[np.float64]  # m
    position_max: NDArray[np.float64]
    velocity_max: NDArray[np.float64]  # m/s
    deceleration: NDArray[np.float64]  # m/s^2
    window: NDArray[np.float64]  # following error, m
    window_cycles: NDArray[np.int64]
    current_max: NDArray[np.float64]  # A
    test_current: NDArray[np.float64]  # A, of open-loop tests
    test_velocity: NDArray[np.float64]  # m/s
    test_travel: NDArray[np.float64]  # m, from where a test began
    loss_cycles: int
    clocks: int  # whether the drives act at SYNC0
    sync_start: int  # system time of a SYNC0, ns
    sync_shift: int  # ns from SYNC0 to the exchange


class Memory(NamedTuple):
    """What the loop remembers from one cycle to the next."""

    count: NDArray[np.int64]  # pyright: ignore[reportIncompatibleMethodOverride]
    state: NDArray[np.float64]  # of eight lanes; lane 0 is x, lane 1 is y
    inputs: NDArray[np.float64]  # of one tick, with the motion to come
    samples: NDArray[np.float32]  # of one tick, with the states of laws
    other_state: NDArray[np.float64]  # of lanes with tables, beside some without
    other_samples: NDArray[np.float32]
    position: NDArray[np.float64]  # last measured, m
    velocity: NDArray[np.float64]  # m/s
    reference: NDArray[np.float64]  # (3, 2): position, velocity, acceleration
    torque: NDArray[np.int64]  # last command of each drive, per mille
    outside: NDArray[np.int64]  # cycles in which the following error was outside its window
    anchor: NDArray[np.float64]  # of a test: where an axis moved last, m
    resting: NDArray[np.int64]  # of a test: ticks since
    laws: Laws  # of eight lanes


class Count(enum.IntEnum):
    """Rows of `Memory.count`."""

    CYCLE = 0  # since the loop began
    NEXT = 1  # start of the next period, ns
    RUN_TICK = 2  # tick of the motion, its approach included
    SINCE = 3  # cycles of arming, or at rest after braking
    MISSED = 4  # cycles in a row without inputs
    UNCONFIRMED = 5  # cycles in a row whose outputs not every drive took
    SKIPPED = 6  # periods that the loop itself slept through before this cycle
    RESETTING = 7  # cycles left in which drives are asked to reset their faults
    LATE_RUN = 8
    IN_PHASE = 9  # cycles in a row in phase; below 0 out of it
    RECORDING = 10
    PHASE = 11  # phase error, its magnitude averaged over about 64 cycles, ns
    TEST = 12  # whether drives are enabled for a test


def new_memory() -> Memory:
    """Return the memory of a loop that begins."""
    return Memory(
        np.zeros(len(Count), np.int64),
        np.zeros((STATE_ROWS, WIDTH)),
        np.zeros((1, INPUT_ROWS + len(Ahead._fields), 2)),
        np.zeros((1, RECORDED_ROWS, WIDTH), np.float32),
        np.zeros((STATE_ROWS, WIDTH)),
        np.zeros((1, RECORDED_ROWS, WIDTH), np.float32),
        np.zeros(2),
        np.zeros(2),
        np.zeros((3, 2)),
        np.zeros(NODES, np.int64),
        np.zeros(2, np.int64),
        np.zeros(2),
        np.zeros(2, np.int64),
        all_laws(),
    )


@part
def with_torque(shared: Shared) -> bool:
    """Return whether the drives are to have torque."""
    return State.HOLDING <= shared.status[Status.STATE] <= State.STOPPING


@part
def enter(shared: Shared, state: int) -> None:
    """Change the state of the loop."""
    shared.status[Status.STATE] = state


@part
def latch(shared: Shared, code: int, place: int, value: float, limit: float) -> None:
    """Latch a fault, unless one is latched: the first is the cause.

    `place` is the drive or axis from 1 that it concerns, 0 for the link; `value` and `limit` are in
    SI units.
    """
    if shared.status[Status.STATE] == State.FAULT:
        return
    shared.status[Status.FAULT] = code
    shared.status[Status.FAULT_PLACE] = place
    shared.figures[Figure.FAULT_VALUE] = value
    shared.figures[Figure.FAULT_LIMIT] = limit
    enter(shared, State.FAULT)
