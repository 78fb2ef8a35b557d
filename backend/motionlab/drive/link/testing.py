"""Open-loop tests: phase currents from a table, with no controller, within bounds of their own.

Before commutation and position are known no controller may hold the mover, and limits of position
mean nothing. In their place a test bounds current, speed, travel from where it began, and the time
that an axis may rest against something.
"""

from __future__ import annotations

import numpy as np

from motionlab.drive import faults
from motionlab.drive.libc import part
from motionlab.drive.link.commanding import (
    CURRENT_COMMAND,
    MEASURED,
    VELOCITY,
    keep_sample,
    per_mille,
)
from motionlab.drive.link.memory import Count, Layout, Memory, enter, latch
from motionlab.drive.link.shared import Command, Shared, State, Status
from motionlab.drive.process_data import NODES

STILL = 400e-6
"""Travel within which an axis counts as at rest, m."""


@part
def command_test(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Command the currents of the next tick of the table; end at its end, or at rest for too long.

    Without inputs the last command is held, and the table goes on with time.
    """
    tick = memory.count[Count.RUN_TICK]
    if tick >= shared.command[Command.RUN_TICKS]:
        enter(shared, State.READY)
        return
    sample = memory.samples[0]
    sample[:] = np.nan  # of the controller, which does not run
    for node in range(NODES):
        axis, phase = layout.axis[node], layout.phase[node]
        current = np.float64(shared.reference[tick, phase, axis])
        sample[CURRENT_COMMAND + phase, axis] = current
        if not np.isfinite(current):
            latch(shared, faults.NOT_A_NUMBER, node + 1, 0.0, 0.0)
            memory.torque[node] = 0
        elif good:
            most, rated = np.float64(layout.test_current[axis]), np.float64(layout.rated[node])
            memory.torque[node] = per_mille(current, most, rated)
    for axis in range(2):
        sample[MEASURED, axis] = memory.position[axis]
        sample[VELOCITY, axis] = memory.velocity[axis]
    keep_sample(good, layout, shared, memory)
    _judge_rest(tick, shared, memory)


@part
def judge_bounds(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Latch a fault where an axis goes too far from where the test began, or too fast."""
    for axis in range(2):
        travel = abs(memory.position[axis] - memory.reference[0, axis])
        most = min(1e-9 * shared.command[Command.TRAVEL_X + axis], layout.test_travel[axis])
        speed = abs(memory.velocity[axis])
        if travel > most:
            latch(shared, faults.TRAVEL, axis + 1, travel, most)
        elif speed > layout.test_velocity[axis]:
            latch(shared, faults.SPEED_LIMIT, axis + 1, speed, layout.test_velocity[axis])


@part
def _judge_rest(tick: int, shared: Shared, memory: Memory) -> None:
    """End the test where an axis with current has rested for too long: it is at a stop."""
    command = shared.command
    for axis in range(2):
        moved = abs(memory.position[axis] - memory.anchor[axis]) > STILL
        pulls = shared.reference[tick, :, axis].max() > 0.0 and tick >= command[Command.REST_FROM]
        if moved or not pulls:
            memory.anchor[axis] = memory.position[axis]
            memory.resting[axis] = 0
            continue
        memory.resting[axis] += 1
        if memory.resting[axis] > command[Command.REST_TICKS] > 0:
            shared.status[Status.AT_STOP] = axis + 1
            enter(shared, State.READY)
