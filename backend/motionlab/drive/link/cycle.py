"""The loop: one control period after another, compiled, without Python's lock.

A period: sleep until its start; read inputs; judge them; compute the controller's half of the tick
from the position just read; write outputs. The controller is the simulation's own compiled tick:
its lanes hold the measured position in place of the machine, and what it computes of the machine
is thrown away.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.drive import faults
from motionlab.drive.compile_cache import Kept
from motionlab.drive.ethercat import OP
from motionlab.drive.libc import machine_time, now, part, sleep_until
from motionlab.drive.link.bus import (
    Bus,
    Inputs,
    i16,
    i32,
    input_at,
    read_inputs,
    set_output,
    u16,
    write_outputs,
)
from motionlab.drive.link.shared import (
    RING_TICKS,
    ROUND_TRIP_BINS,
    Command,
    Figure,
    Order,
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
    STO_ACTIVE,
    SWITCHED_ON,
)
from motionlab.kernel.layout import INPUT_ROWS, state_row
from motionlab.kernel.layout import Inputs as Driven
from motionlab.kernel.tick import run_lanes
from motionlab.lanes import WIDTH
from motionlab.telemetry.channels import Sample

PERIOD = round(CONTROL_PERIOD * 1e9)  # ns
ANSWER = 6 * PERIOD // 10  # ns after the start of a period, until which an answer is waited for
HEARTBEAT = 500_000_000  # ns without one until a motion is stopped
ARMING = 2_000  # cycles until every drive must have enabled operation
RESETTING = 40  # cycles in which a reset of the drives is asked for, twice
REST = 100  # cycles at rest before a stop switches the torque off
PHASE_LIMIT = PERIOD // 10  # ns, within which the exchange is in phase
PHASE_CYCLES = 400  # cycles within it until the phase counts as locked
PULL = 2_000  # ns; most that a period is made longer or shorter to follow the clock of the drives
MOST_MISSED_PLAUSIBLE = 40  # cycles over which a change of position is still judged

_POSITION = state_row("plant.p")
_FAILED = state_row("failed")
_ROW = {name: row for row, name in enumerate(Driven._fields)}
_P_REF, _V_REF, _A_REF = _ROW["p_ref"], _ROW["v_ref"], _ROW["a_ref"]
_COLUMN = {name: row for row, name in enumerate(Sample._fields)}
_CURRENT = _COLUMN["current_a"]
_CURRENT_COMMAND = _COLUMN["current_command_a"]
_ERROR = _COLUMN["following_error"]
_MEASURED = _COLUMN["position_measured"]
_VELOCITY = _COLUMN["velocity_measured"]
UNKNOWN = tuple(
    _COLUMN[name]
    for name in (
        "position",
        "velocity",
        "acceleration",
        "friction",
        "bristle",
        "thrust",
        "normal_force",
    )
)
"""Channels of the simulated machine, which nothing measures on a drive; they are NaN."""

# Reasons to leave the loop
QUITTING, GONE, BRING_UP = 1, 2, 3

_STATE, _FAULT, _PLACE = int(Status.STATE), int(Status.FAULT), int(Status.FAULT_PLACE)
_READY, _ARMING, _HOLDING = int(State.READY), int(State.ARMING), int(State.HOLDING)
_MOVING, _STOPPING, _FAULTED = int(State.MOVING), int(State.STOPPING), int(State.FAULT)


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
    loss_cycles: int
    clocks: int  # whether the drives act at SYNC0
    sync_start: int  # system time of a SYNC0, ns
    sync_shift: int  # ns from SYNC0 to the exchange


class Memory(NamedTuple):
    """What the loop remembers from one cycle to the next."""

    count: NDArray[np.int64]  # pyright: ignore[reportIncompatibleMethodOverride]
    state: NDArray[np.float64]  # of eight lanes; lane 0 is x, lane 1 is y
    inputs: NDArray[np.float64]  # of one tick
    samples: NDArray[np.float32]  # of one tick
    position: NDArray[np.float64]  # last measured, m
    velocity: NDArray[np.float64]  # m/s
    reference: NDArray[np.float64]  # (3, 2): position, velocity, acceleration
    torque: NDArray[np.int64]  # last command of each drive, per mille
    outside: NDArray[np.int64]  # cycles in which the following error was outside its window


# Rows of `Memory.count`
_CYCLE, _NEXT, _RUN_TICK, _SINCE, _MISSED, _RESETTING, _LATE_RUN, _IN_PHASE, _RECORDING = range(9)


def new_memory() -> Memory:
    """Return the memory of a loop that begins."""
    return Memory(
        np.zeros(9, np.int64),
        np.zeros((state_row("failed") + 1, WIDTH)),
        np.zeros((1, INPUT_ROWS, 2)),
        np.zeros((1, len(Sample._fields), WIDTH), np.float32),
        np.zeros(2),
        np.zeros(2),
        np.zeros((3, 2)),
        np.zeros(NODES, np.int64),
        np.zeros(2, np.int64),
    )


_kept = Kept("link", "*.py", "link/*.py").function


@_kept
def run(bus: Bus, layout: Layout, shared: Shared, memory: Memory) -> int:
    """Run the loop until an order to quit, a silent server, or drives that must be brought up.

    Returns
    -------
    int
        `QUITTING`, `GONE` or `BRING_UP`.
    """
    count, status = memory.count, shared.status
    count[_NEXT] = now(bus.clock) + PERIOD
    count[_MISSED] = count[_RESETTING] = count[_IN_PHASE] = 0
    while True:
        sleep_until(count[_NEXT], bus.clock)
        start = count[_NEXT]
        status[Status.WAKE_LATE] = max(status[Status.WAKE_LATE], now(bus.clock) - start)
        read = read_inputs(bus, count[_CYCLE], start + ANSWER)
        good = read.good and read.working_counter == NODES
        if good:
            _take_inputs(bus, layout, shared, memory)
        _judge_link(read, good, layout, shared, memory)
        if good:
            _judge_drives(bus, layout, shared, memory)
        leave = _obey(machine_time(start, bus.clock), shared, memory)
        if leave:
            _all_off(bus)
            write_outputs(bus, count[_CYCLE])
            return leave
        begun = now(bus.clock)
        if _HOLDING <= status[_STATE] <= _STOPPING:
            _control(good, layout, shared, memory)
        spent = now(bus.clock) - begun
        status[Status.CONTROL_TIME] = max(status[Status.CONTROL_TIME], spent)
        _fill_outputs(bus, shared, memory)
        if not write_outputs(bus, count[_CYCLE]):
            status[Status.LOST_SENDS] += 1
        _next_period(read, layout, bus, shared, memory)


@part
def _fault(shared: Shared, code: int, place: int, value: float, limit: float) -> None:
    """Latch a fault, unless one is latched: the first is the cause."""
    if shared.status[_STATE] == _FAULTED:
        return
    shared.status[_FAULT] = code
    shared.status[_PLACE] = place
    shared.figures[Figure.FAULT_VALUE] = value
    shared.figures[Figure.FAULT_LIMIT] = limit
    shared.status[_STATE] = _FAULTED


@part
def _take_inputs(bus: Bus, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Take over status words, errors, currents and positions."""
    status = shared.status
    for node in range(NODES):
        at = input_at(bus, node)
        status[Status.NODE_STATUS + node] = u16(bus.answer, at)
        status[Status.NODE_TORQUE + node] = i16(bus.answer, at + 10)
        status[Status.NODE_ERROR + node] = u16(bus.answer, at + 14)
    cycles = memory.count[_MISSED] + 1
    for axis in range(2):
        counts = i32(bus.answer, input_at(bus, layout.encoder[axis]) + 2)
        position = layout.resolution[axis] * counts + layout.offset[axis]
        moved = position - memory.position[axis]
        torque = status[_STATE] in (_HOLDING, _MOVING, _STOPPING)
        most = 2.0 * layout.velocity_max[axis] * cycles * CONTROL_PERIOD
        if torque and cycles <= MOST_MISSED_PLAUSIBLE and abs(moved) > most:
            _fault(shared, faults.ENCODER, axis + 1, moved, most)
        memory.position[axis] = position
        memory.velocity[axis] = moved / (cycles * CONTROL_PERIOD)
        shared.figures[Figure.POSITION + axis] = position
        shared.figures[Figure.VELOCITY + axis] = memory.velocity[axis]


@part
def _judge_link(read: Inputs, good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Count what was missed; latch a fault once the link has been lost for too long."""
    status, count = shared.status, memory.count
    status[Status.WORKING_COUNTER] = read.working_counter
    status[Status.ROUND_TRIP] = read.round_trip
    if read.good:
        shared.round_trips[min(read.round_trip // 1000, ROUND_TRIP_BINS - 1)] += 1
        status[Status.AL_STATUS] = read.al_status
    good = good and (read.written < 0 or read.written == NODES)
    count[_MISSED] = 0 if good else count[_MISSED] + 1
    status[Status.MISSED_NOW] = count[_MISSED]
    if not good:
        status[Status.MISSED] += 1
    if count[_MISSED] >= layout.loss_cycles:
        lost = count[_MISSED] * CONTROL_PERIOD
        _fault(shared, faults.LINK_LOST, 0, lost, layout.loss_cycles * CONTROL_PERIOD)
    elif read.good and read.al_status != OP:
        _fault(shared, faults.LEFT_OPERATION, 0, read.al_status, OP)


@part
def _judge_drives(bus: Bus, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Latch a fault where a drive, a position or a speed is not as it must be with torque."""
    status = shared.status
    state = status[_STATE]
    for node in range(NODES):
        word = status[Status.NODE_STATUS + node]
        if word & 0x08:
            _fault(shared, faults.DRIVE_FAULT, node + 1, status[Status.NODE_ERROR + node], 0.0)
        elif state >= _ARMING and word & STO_ACTIVE:
            _fault(shared, faults.STO, node + 1, 0.0, 0.0)
        elif state >= _HOLDING and word & 0x6F != 0x27:
            _fault(shared, faults.NOT_ENABLED, node + 1, word, 0.0)
    if state == _ARMING:
        _enable(shared, memory)
    if not _HOLDING <= state <= _STOPPING:
        return
    for axis in range(2):
        position, speed = memory.position[axis], abs(memory.velocity[axis])
        if position < layout.position_min[axis]:
            _fault(shared, faults.POSITION_LIMIT, axis + 1, position, layout.position_min[axis])
        elif position > layout.position_max[axis]:
            _fault(shared, faults.POSITION_LIMIT, axis + 1, position, layout.position_max[axis])
        elif speed > layout.velocity_max[axis]:
            _fault(shared, faults.SPEED_LIMIT, axis + 1, speed, layout.velocity_max[axis])


@part
def _enable(shared: Shared, memory: Memory) -> None:
    """Begin to hold the position once every drive has enabled operation."""
    enabled = 0
    for node in range(NODES):
        if shared.status[Status.NODE_STATUS + node] & 0x6F == 0x27:
            enabled += 1
    if enabled < NODES:
        memory.count[_SINCE] += 1
        if memory.count[_SINCE] > ARMING:
            _fault(shared, faults.NOT_ENABLED, 0, enabled, NODES)
        return
    memory.state[:] = 0.0
    memory.state[_FAILED] = -1.0
    memory.outside[:] = 0
    memory.velocity[:] = 0.0
    memory.reference[:] = 0.0
    for axis in range(2):
        memory.reference[0, axis] = memory.position[axis]
    shared.status[_STATE] = _HOLDING


@part
def _obey(instant: int, shared: Shared, memory: Memory) -> int:
    """Carry out a new order; return why the loop is to be left, or 0.

    `instant` is the machine's time, in which heartbeats are, however slow the link.
    """
    command, status = shared.command, shared.status
    silent = instant - command[Command.HEARTBEAT] > HEARTBEAT
    if silent or status[Status.STOPS_SEEN] != command[Command.STOPS]:
        status[Status.STOPS_SEEN] = command[Command.STOPS]
        _stop(shared, memory)
    if silent and not _HOLDING <= status[_STATE] <= _STOPPING:
        return GONE
    if status[Status.DONE] == command[Command.SEQUENCE]:
        return 0
    leave = _carry_out(command[Command.ORDER], shared, memory)
    status[Status.DONE] = command[Command.SEQUENCE]
    return leave


@part
def _carry_out(order: int, shared: Shared, memory: Memory) -> int:
    """Carry out one order where the state allows it; return why the loop is to be left, or 0."""
    status, count = shared.status, memory.count
    state = status[_STATE]
    refused = 0
    if order == Order.QUIT:
        return QUITTING
    if order == Order.DISARM:
        if _ARMING <= state <= _STOPPING:
            status[_STATE] = _READY
    elif order == Order.RESET and state == _FAULTED:
        if status[Status.AL_STATUS] != OP or count[_MISSED] > 0:
            return BRING_UP
        count[_RESETTING] = RESETTING
        status[_STATE] = _READY
        status[_FAULT] = 0
    elif order == Order.ARM and state == _READY and status[Status.PHASE_LOCKED]:
        status[_STATE], count[_SINCE] = _ARMING, 0
    elif order == Order.START and state == _HOLDING:
        count[_RUN_TICK] = 0
        count[_RECORDING] = 1
        status[Status.END] = 0
        status[Status.RUN] = shared.command[Command.RUN]
        status[_STATE] = _MOVING
    elif order != Order.RESET:
        refused = 1
    status[Status.REFUSED] = refused
    return 0


@part
def _stop(shared: Shared, memory: Memory) -> None:
    """Begin to brake; drives that are on their way to torque turn back."""
    state = shared.status[_STATE]
    if state == _ARMING:
        shared.status[_STATE] = _READY
    elif _HOLDING <= state < _STOPPING:
        shared.status[_STATE] = _STOPPING
        memory.count[_SINCE] = 0


@part
def _advance_reference(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Advance the reference by one tick along the motion, or while it brakes."""
    count, status, reference = memory.count, shared.status, memory.reference
    if status[_STATE] == _MOVING:
        tick = count[_RUN_TICK]
        if tick < shared.command[Command.RUN_TICKS]:
            reference[:] = shared.reference[tick]
        else:
            reference[1:] = 0.0
            status[_STATE] = _HOLDING
            count[_RECORDING] = 0
        return
    if status[_STATE] == _HOLDING:
        return
    moving = False
    for axis in range(2):
        v = reference[1, axis]
        change = min(layout.deceleration[axis] * CONTROL_PERIOD, abs(v))
        after = v - np.sign(v) * change
        reference[0, axis] += 0.5 * (v + after) * CONTROL_PERIOD
        reference[1, axis] = after
        reference[2, axis] = (after - v) / CONTROL_PERIOD
        moving = moving or after != 0.0
    count[_SINCE] = 0 if moving else count[_SINCE] + 1
    if count[_SINCE] > REST:
        status[_STATE] = _READY


@part
def _control(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Compute the commands of one tick, and keep its sample while a motion is recorded.

    Without an answer the last command is held, and the controller goes on from the position that
    the last velocity leads to.
    """
    count, status = memory.count, shared.status
    _advance_reference(layout, shared, memory)
    if not _HOLDING <= status[_STATE] <= _STOPPING:
        return
    state, inputs, samples = memory.state, memory.inputs, memory.samples
    for axis in range(2):
        position = memory.position[axis]
        if not good:
            position += count[_MISSED] * CONTROL_PERIOD * memory.velocity[axis]
        for lane in range(axis, WIDTH, 2):
            state[_POSITION, lane] = position
        inputs[0, _P_REF, axis] = memory.reference[0, axis]
        inputs[0, _V_REF, axis] = memory.reference[1, axis]
        inputs[0, _A_REF, axis] = memory.reference[2, axis]
    run_lanes(shared.parameters[shared.command[Command.PARAMETERS]], state, inputs, samples, None)
    for axis in range(2):
        error = np.float64(samples[0, _ERROR, axis])
        shared.figures[Figure.FOLLOWING_ERROR + axis] = error
        shared.figures[Figure.REFERENCE + axis] = memory.reference[0, axis]
        memory.outside[axis] = memory.outside[axis] + 1 if abs(error) > layout.window[axis] else 0
        if memory.outside[axis] > layout.window_cycles[axis]:
            _fault(shared, faults.FOLLOWING_ERROR, axis + 1, error, layout.window[axis])
        elif state[_FAILED, axis] >= 0.0:
            _fault(shared, faults.DIVERGED, axis + 1, error, 0.0)
    if good:
        _command_currents(layout, shared, memory)
    _keep_sample(good, layout, shared, memory)


@part
def _command_currents(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Turn the controller's currents into per mille of rated, positive and within limits."""
    for node in range(NODES):
        axis = layout.axis[node]
        row = _CURRENT_COMMAND + layout.phase[node]
        current = np.float64(memory.samples[0, row, axis])
        if not np.isfinite(current):
            _fault(shared, faults.NOT_A_NUMBER, node + 1, 0.0, 0.0)
            memory.torque[node] = 0
            continue
        current = min(max(current, 0.0), layout.current_max[axis])
        memory.torque[node] = np.int64(np.rint(1000.0 * current / layout.rated[node]))


@part
def _keep_sample(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Put a sample into the ring, with currents of the drives and NaN for what is not measured."""
    count, status = memory.count, shared.status
    if not count[_RECORDING] or status[_STATE] < _MOVING:
        return
    tick = count[_RUN_TICK]
    count[_RUN_TICK] += 1
    recorded = tick - shared.command[Command.RUN_FIRST]
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
        if not good:
            shared.samples[place, _MEASURED, axis] = np.nan
            shared.samples[place, _ERROR, axis] = np.nan
            shared.samples[place, _VELOCITY, axis] = np.nan
    status[Status.END] = recorded + 1


@part
def _all_off(bus: Bus) -> None:
    for node in range(NODES):
        set_output(bus, node, DISABLE_VOLTAGE, 0, CYCLIC_TORQUE)


@part
def _fill_outputs(bus: Bus, shared: Shared, memory: Memory) -> None:
    """Write control words and torques: torque only where the loop means it and the drive has it."""
    status, count = shared.status, memory.count
    state = status[_STATE]
    torque = _HOLDING <= state <= _STOPPING
    count[_RESETTING] = max(0, count[_RESETTING] - 1)
    for node in range(NODES):
        if not torque:
            memory.torque[node] = 0
        word = status[Status.NODE_STATUS + node]
        if word & 0x4F == 0x08:
            control = FAULT_RESET if count[_RESETTING] % 20 >= 10 else DISABLE_VOLTAGE
        elif state == _FAULTED:
            control = DISABLE_VOLTAGE
        elif state < _ARMING:
            control = SHUTDOWN
        elif word & 0x6F == 0x21:
            control = SWITCHED_ON
        elif word & 0x6B == 0x23:  # switched on, or enabled already
            control = ENABLED
        else:
            control = SHUTDOWN
        set_output(bus, node, control, memory.torque[node], CYCLIC_TORQUE)


@part
def _next_period(read: Inputs, layout: Layout, bus: Bus, shared: Shared, memory: Memory) -> None:
    """Set the start of the next period: in phase with SYNC0, and never in the past."""
    status, count = shared.status, memory.count
    pull = 0
    if layout.clocks and read.good:
        shift = layout.sync_start + layout.sync_shift
        phase = (read.system_time - shift + PERIOD // 2) % PERIOD - PERIOD // 2
        status[Status.PHASE_ERROR] = phase
        pull = min(max(-phase // 16, -PULL), PULL)
        count[_IN_PHASE] = count[_IN_PHASE] + 1 if abs(phase) < PHASE_LIMIT else 0
        if count[_IN_PHASE] >= PHASE_CYCLES:
            status[Status.PHASE_LOCKED] = 1
        elif status[_STATE] == _READY:
            status[Status.PHASE_LOCKED] = 0
    elif not layout.clocks:
        status[Status.PHASE_LOCKED] = 1
    count[_NEXT] += PERIOD + pull
    count[_CYCLE] += 1
    status[Status.CYCLES] += 1
    instant = now(bus.clock)
    late = instant > count[_NEXT]
    if late:
        status[Status.LATE] += 1
        count[_LATE_RUN] += 1
        status[Status.LATE_RUN] = max(status[Status.LATE_RUN], count[_LATE_RUN])
        skipped = (instant - count[_NEXT]) // PERIOD
        if skipped > 0:
            status[Status.LATE] += skipped
            count[_MISSED] += skipped
            count[_NEXT] += skipped * PERIOD
    else:
        count[_LATE_RUN] = 0
    status[Status.UPDATED] = instant
