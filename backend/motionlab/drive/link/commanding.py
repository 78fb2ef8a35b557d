"""What the loop commands: the reference, the controller's half of the tick, outputs, samples.

The controller is the simulation's own compiled tick: its lanes hold the measured position in place
of the machine, and what it computes of the machine is thrown away.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.drive import faults
from motionlab.drive.libc import part
from motionlab.drive.link.bus import Bus, set_output
from motionlab.drive.link.kernel_symbols import run_plain, run_tabled
from motionlab.drive.link.memory import Count, Layout, Memory, enter, latch, with_torque
from motionlab.drive.link.shared import (
    RECORDED_ROWS,
    RING_TICKS,
    Command,
    Figure,
    Shared,
    State,
    Status,
)
from motionlab.drive.process_data import (
    CYCLIC_TORQUE,
    DISABLE_VOLTAGE,
    ENABLED,
    FAULT_RESET,
    NODES,
    SHUTDOWN,
    SWITCHED_ON,
)
from motionlab.kernel.layout import INPUT_ROWS, STATE_ROWS, Inputs, state_row
from motionlab.kernel.motion import AHEAD
from motionlab.lanes import WIDTH
from motionlab.telemetry.channels import CHANNELS, Owner, Sample
from motionlab.timing import CONTROL_PERIOD

ARMING = 2_000  # cycles until every drive must have enabled operation
REST = 100  # cycles at rest before a stop switches the torque off

_POSITION = state_row("plant.p")
_FAILED = state_row("failed")
_ROW = {name: row for row, name in enumerate(Inputs._fields)}
_P_REF, _V_REF, _A_REF = _ROW["p_ref"], _ROW["v_ref"], _ROW["a_ref"]
_COLUMN = {name: row for row, name in enumerate(Sample._fields)}
_CURRENT = _COLUMN["current_a"]
CURRENT_COMMAND = _COLUMN["current_command_a"]
_ERROR = _COLUMN["following_error"]
MEASURED = _COLUMN["position_measured"]
VELOCITY = _COLUMN["velocity_measured"]
UNKNOWN = tuple(_COLUMN[each.name] for each in CHANNELS if each.owner is Owner.MACHINE)
"""Channels of the simulated machine, which nothing measures on a drive; they are NaN."""


@part
def enable(shared: Shared, memory: Memory) -> None:
    """Begin to hold the position once every drive has enabled operation."""
    enabled = 0
    for node in range(NODES):
        if shared.status[Status.NODE_STATUS + node] & 0x6F == 0x27:
            enabled += 1
    if enabled < NODES:
        memory.count[Count.SINCE] += 1
        if memory.count[Count.SINCE] > ARMING:
            latch(shared, faults.NOT_ENABLED, 0, enabled, NODES)
        return
    memory.anchor[:] = memory.position
    memory.resting[:] = 0
    memory.state[:] = 0.0
    memory.state[_FAILED] = -1.0
    memory.outside[:] = 0
    memory.velocity[:] = 0.0
    memory.reference[:] = 0.0
    memory.inputs[:] = 0.0
    for axis in range(2):
        memory.reference[0, axis] = memory.position[axis]
    enter(shared, State.TESTING if memory.count[Count.TEST] else State.HOLDING)


@part
def _advance_reference(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Advance the reference by one tick along the motion, or while it brakes."""
    count, status, reference = memory.count, shared.status, memory.reference
    if status[Status.STATE] == State.MOVING:
        tick = count[Count.RUN_TICK]
        if tick < shared.command[Command.RUN_TICKS]:
            reference[:] = shared.reference[tick]
        else:
            reference[1:] = 0.0
            count[Count.RECORDING] = 0
            enter(shared, State.HOLDING)
        return
    if status[Status.STATE] == State.HOLDING:
        return
    moving = _brake(layout, reference)
    count[Count.SINCE] = 0 if moving else count[Count.SINCE] + 1
    if count[Count.SINCE] > REST:
        enter(shared, State.READY)


@part
def _brake(layout: Layout, reference: NDArray[np.float64]) -> bool:
    """Brake a reference, (3, 2), each axis by itself; return whether one still moves."""
    moving = False
    for axis in range(2):
        v = reference[1, axis]
        change = min(layout.deceleration[axis] * CONTROL_PERIOD, abs(v))
        after = v - np.sign(v) * change
        reference[0, axis] += 0.5 * (v + after) * CONTROL_PERIOD
        reference[1, axis] = after
        reference[2, axis] = (after - v) / CONTROL_PERIOD
        moving = moving or after != 0.0
    return moving


@part
def _look_ahead(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Write the motion to come into the inputs, as `Timeline.ahead`; at rest and braking, too."""
    command, ahead = shared.command, memory.inputs[0, INPUT_ROWS:]
    if shared.status[Status.STATE] != State.MOVING:
        ahead[0:3] = memory.reference
        _brake(layout, ahead[0:3])
        ahead[3:6] = ahead[0:3]
        _brake(layout, ahead[3:6])
        return  # the phase stays
    tick, last = memory.count[Count.RUN_TICK], command[Command.RUN_TICKS] - 1
    for k in range(1, AHEAD + 1):
        ahead[3 * k - 3 : 3 * k] = shared.reference[min(tick + k, last)]
    ticks, lap = command[Command.MOTION_TICKS], command[Command.LAP_TICKS]
    if lap > 0:
        place = min(max(tick - command[Command.RUN_FIRST], 0), ticks - 1)
        ahead[6] = ((place - ticks) % lap) / lap


@part
def control(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Compute the commands of one tick, and keep its sample while a motion is recorded.

    Without inputs the last command is held, and the controller goes on from the position that the
    last velocity leads to.
    """
    count, status = memory.count, shared.status
    _advance_reference(layout, shared, memory)
    if not with_torque(shared):
        return
    inputs, samples = memory.inputs, memory.samples
    _look_ahead(layout, shared, memory)
    for axis in range(2):
        position = memory.position[axis]
        if not good:
            position += count[Count.MISSED] * CONTROL_PERIOD * memory.velocity[axis]
        for lane in range(axis, WIDTH, 2):
            memory.state[_POSITION, lane] = position
        inputs[0, _P_REF, axis] = memory.reference[0, axis]
        inputs[0, _V_REF, axis] = memory.reference[1, axis]
        inputs[0, _A_REF, axis] = memory.reference[2, axis]
    chosen = _chosen(shared, memory)
    if chosen != status[Status.PARAMETERS]:
        status[Status.PARAMETERS_TICK] = count[Count.RUN_TICK] - shared.command[Command.RUN_FIRST]
    _run_controllers(chosen, shared, memory)
    status[Status.PARAMETERS] = chosen  # the other set may be overwritten from here on
    for axis in range(2):
        error = np.float64(samples[0, _ERROR, axis])
        shared.figures[Figure.FOLLOWING_ERROR + axis] = error
        shared.figures[Figure.REFERENCE + axis] = memory.reference[0, axis]
        memory.outside[axis] = memory.outside[axis] + 1 if abs(error) > layout.window[axis] else 0
        if memory.outside[axis] > layout.window_cycles[axis]:
            latch(shared, faults.FOLLOWING_ERROR, axis + 1, error, layout.window[axis])
        elif memory.state[_FAILED, axis] >= 0.0:
            latch(shared, faults.DIVERGED, axis + 1, error, 0.0)
    if good:
        _command_currents(layout, shared, memory)
    keep_sample(good, layout, shared, memory)


@part
def _chosen(shared: Shared, memory: Memory) -> int:
    """Return the set of parameters of this tick; one for a later tick of the motion waits."""
    chosen, present = shared.command[Command.PARAMETERS], shared.status[Status.PARAMETERS]
    first = shared.first[chosen]
    if chosen == present or first == 0:
        return chosen
    tick = memory.count[Count.RUN_TICK] - shared.command[Command.RUN_FIRST]
    moving = shared.status[Status.STATE] == State.MOVING
    return chosen if moving and tick >= first else present


@part
def _run_controllers(chosen: int, shared: Shared, memory: Memory) -> None:
    """Compute both axes by the kernels of the simulation, each axis by its own."""
    parameters, tables = shared.parameters[chosen], shared.tables[chosen]
    x_tabled, y_tabled = shared.tabled[chosen, 0] != 0, shared.tabled[chosen, 1] != 0
    state, samples, inputs = memory.state, memory.samples, memory.inputs
    other_state, other_samples = memory.other_state, memory.other_samples
    if x_tabled != y_tabled:
        for row in range(STATE_ROWS):
            for lane in range(WIDTH):
                other_state[row, lane] = state[row, lane]
        run_tabled(parameters, other_state, inputs, other_samples, tables, memory.laws)
    if x_tabled and y_tabled:
        run_tabled(parameters, state, inputs, samples, tables, memory.laws)
    else:
        run_plain(parameters, state, inputs, samples, None, memory.laws)
    if x_tabled != y_tabled:
        for lane in range(0 if x_tabled else 1, WIDTH, 2):
            for row in range(STATE_ROWS):
                state[row, lane] = other_state[row, lane]
            for row in range(RECORDED_ROWS):
                samples[0, row, lane] = other_samples[0, row, lane]


@part
def _command_currents(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Turn the controller's currents into per mille of rated, positive and within limits."""
    for node in range(NODES):
        axis = layout.axis[node]
        row = CURRENT_COMMAND + layout.phase[node]
        current = np.float64(memory.samples[0, row, axis])
        if not np.isfinite(current):
            latch(shared, faults.NOT_A_NUMBER, node + 1, 0.0, 0.0)
            memory.torque[node] = 0
            continue
        most, rated = np.float64(layout.current_max[axis]), np.float64(layout.rated[node])
        memory.torque[node] = per_mille(current, most, rated)


@part
def per_mille(current: float, most: float, rated: float) -> np.int64:
    """Return a current in per mille of the rated one, positive and within a limit."""
    return np.int64(np.rint(1000.0 * min(max(current, 0.0), most) / rated))


@part
def keep_sample(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Put a sample into the ring, with currents of the drives and NaN for what is not measured."""
    count, status, command = memory.count, shared.status, shared.command
    tick = count[Count.RUN_TICK]
    if not count[Count.RECORDING] or tick >= command[Command.RUN_TICKS]:
        return
    count[Count.RUN_TICK] += 1
    recorded = tick - command[Command.RUN_FIRST]
    if recorded < 0:
        return
    sample = memory.samples[0]
    for node in range(NODES):
        actual = status[Status.NODE_TORQUE + node] * layout.rated[node] * 1e-3
        sample[_CURRENT + layout.phase[node], layout.axis[node]] = actual
    place = recorded % RING_TICKS
    for axis in range(2):
        shared.samples[place, :, axis] = sample[:, axis]
        for row in UNKNOWN:
            shared.samples[place, row, axis] = np.nan
        # Without an answer nothing was measured; what was computed stays.
        if not good:
            shared.samples[place, MEASURED, axis] = np.nan
            shared.samples[place, _ERROR, axis] = np.nan
            shared.samples[place, VELOCITY, axis] = np.nan
    status[Status.END] = recorded + 1


@part
def all_off(bus: Bus) -> None:
    """Write outputs without torque."""
    for node in range(NODES):
        set_output(bus, node, DISABLE_VOLTAGE, 0, CYCLIC_TORQUE)


@part
def fill_outputs(bus: Bus, shared: Shared, memory: Memory) -> None:
    """Write control words and torques: torque only where the loop means it and the drive has it."""
    status, count = shared.status, memory.count
    state = status[Status.STATE]
    torque = with_torque(shared)
    count[Count.RESETTING] = max(0, count[Count.RESETTING] - 1)
    for node in range(NODES):
        if not torque:
            memory.torque[node] = 0
        word = status[Status.NODE_STATUS + node]
        if word & 0x4F == 0x08:
            control = FAULT_RESET if count[Count.RESETTING] % 20 >= 10 else DISABLE_VOLTAGE
        elif state == State.FAULT:
            control = DISABLE_VOLTAGE
        elif state < State.ARMING:
            control = SHUTDOWN
        elif word & 0x6F == 0x21:
            control = SWITCHED_ON
        elif word & 0x6B == 0x23:  # switched on, or enabled already
            control = ENABLED
        else:
            control = SHUTDOWN
        set_output(bus, node, control, memory.torque[node], CYCLIC_TORQUE)
