"""The loop: one control period after another, compiled, without Python's lock.

A period: sleep until its start; read inputs; judge them; obey; compute the controller's half of the
tick from the position just read; write outputs.
"""

from __future__ import annotations

from motionlab.drive import faults
from motionlab.drive.ethercat import OP
from motionlab.drive.libc import machine_time, now, part, sleep_until
from motionlab.drive.link.bus import Bus, Inputs, read_inputs, write_outputs
from motionlab.drive.link.commanding import all_off, control, enable, fill_outputs
from motionlab.drive.link.judging import judge_drives, judge_link, judge_loss, take_inputs
from motionlab.drive.link.memory import (
    PERIOD,
    Count,
    Layout,
    Memory,
    enter,
    kept,
    latch,
    with_torque,
)
from motionlab.drive.link.shared import Command, Order, Shared, State, Status
from motionlab.drive.link.testing import command_test
from motionlab.drive.process_data import NODES

ANSWER = 6 * PERIOD // 10  # ns after the start of a period, until which an answer is waited for
HEARTBEAT = 2_000_000_000  # ns of the machine's time without one until a motion is stopped: a lease
RESETTING = 40  # cycles in which a reset of the drives is asked for, twice
PHASE_LIMIT = PERIOD // 10  # ns of mean error, within which the exchange is in phase
PHASE_CYCLES = 400  # cycles within it until it is locked, or out of it until that is a fault
PULL = 2_000  # ns; most that a period is made longer or shorter to follow the clock of the drives

# Reasons to leave the loop
QUITTING, GONE, BRING_UP = 1, 2, 3


@kept
def run(bus: Bus, layout: Layout, shared: Shared, memory: Memory) -> int:
    """Run the loop and return why it ended: `QUITTING`, `GONE` (a silent server) or `BRING_UP`."""
    count, status = memory.count, shared.status
    count[Count.NEXT] = now(bus.clock) + PERIOD
    for row in (Count.CYCLE, Count.MISSED, Count.UNCONFIRMED, Count.SKIPPED, Count.IN_PHASE):
        count[row] = 0
    while True:
        sleep_until(count[Count.NEXT], bus.clock)
        start = count[Count.NEXT]
        status[Status.WAKE_LATE] = max(status[Status.WAKE_LATE], now(bus.clock) - start)
        read = read_inputs(bus, count[Count.CYCLE], start + ANSWER)
        leave = act(read, machine_time(start, bus.clock), bus, layout, shared, memory)
        if not write_outputs(bus, count[Count.CYCLE]):
            status[Status.LOST_SENDS] += 1
        if leave:
            return leave
        _next_period(read, layout, bus, shared, memory)


@kept
def act(  # noqa: PLR0913, PLR0917 - all that a cycle touches
    read: Inputs, instant: int, bus: Bus, layout: Layout, shared: Shared, memory: Memory
) -> int:
    """Judge the inputs of a cycle, obey, control, and fill in the outputs.

    Process data is read from ``bus.answer`` and written to ``bus.write``. `instant` is the
    machine's time, in which heartbeats are, ns. Returns why the loop is to be left, or 0.
    """
    status = shared.status
    good = read.good and read.working_counter == NODES
    _make_up(layout, shared, memory)
    if good:
        take_inputs(bus, layout, shared, memory)
        if status[Status.STATE] == State.OFFLINE:
            enter(shared, State.READY)
    # Faults before orders: none is carried out on drives that have just failed.
    judge_link(read, good, layout, shared, memory)
    if good:
        judge_drives(layout, shared, memory)
        if status[Status.STATE] == State.ARMING:
            enable(shared, memory)
    leave = _obey(instant, shared, memory)
    if leave:
        all_off(bus)
        return leave
    begun = now(bus.clock)
    _command(good, layout, shared, memory)
    spent = now(bus.clock) - begun
    status[Status.CONTROL_LAST] = spent
    status[Status.CONTROL_TIME] = max(status[Status.CONTROL_TIME], spent)
    fill_outputs(bus, shared, memory)
    return 0


@part
def _command(good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Compute the commands of one tick, where the drives are to have torque."""
    if shared.status[Status.STATE] == State.TESTING:
        command_test(good, layout, shared, memory)
    elif with_torque(shared):
        control(good, layout, shared, memory)


@part
def _make_up(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Treat periods that the loop slept through as those without an answer.

    The reference goes on with time, and the controller from where the mover must have been.
    """
    count = memory.count
    for _ in range(count[Count.SKIPPED]):
        count[Count.MISSED] += 1
        shared.status[Status.MISSED] += 1
        judge_loss(layout, shared, memory)
        _command(False, layout, shared, memory)
    count[Count.SKIPPED] = 0


@part
def _obey(instant: int, shared: Shared, memory: Memory) -> int:
    """Carry out a new order; return why the loop is to be left, or 0."""
    command, status = shared.command, shared.status
    silent = instant - command[Command.HEARTBEAT] > HEARTBEAT
    if silent or status[Status.STOPS_SEEN] != command[Command.STOPS]:
        status[Status.STOPS_SEEN] = command[Command.STOPS]
        _stop(shared, memory)
    if silent and not with_torque(shared):
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
    state = status[Status.STATE]
    status[Status.REFUSED] = 0
    if order == Order.QUIT:
        return QUITTING
    if order == Order.DISARM:
        if State.ARMING <= state <= State.STOPPING:
            enter(shared, State.READY)
    elif order == Order.RESET:
        if state == State.FAULT:
            count[Count.RESETTING] = RESETTING
            if status[Status.AL_STATUS] != OP or status[Status.MISSED_NOW] > 0:
                return BRING_UP
            status[Status.FAULT] = 0
            enter(shared, State.READY)
    elif shared.command[Command.STOPS] != shared.command[Command.STOPS_BEFORE]:
        status[Status.REFUSED] = 1  # what needs torque was asked for before a stop
    else:
        _begin(order, state, shared, memory)
    return 0


@part
def _begin(order: int, state: int, shared: Shared, memory: Memory) -> None:
    """Switch the torque on, or begin a motion with it, where the state allows it."""
    status, count = shared.status, memory.count
    if order == Order.START and state == State.HOLDING:
        _begin_record(shared, memory)
        enter(shared, State.MOVING)
        return
    testing = order == Order.TEST
    possible = state == State.READY and status[Status.PHASE_LOCKED]
    if not possible or not (testing or order == Order.ARM):
        status[Status.REFUSED] = 1
        return
    if testing:
        _begin_record(shared, memory)
        status[Status.AT_STOP] = 0
    count[Count.TEST] = testing
    count[Count.SINCE] = 0
    enter(shared, State.ARMING)


@part
def _begin_record(shared: Shared, memory: Memory) -> None:
    """Begin to record a motion, or a test, from its first tick."""
    memory.count[Count.RUN_TICK] = 0
    memory.count[Count.RECORDING] = 1
    shared.status[Status.END] = 0
    shared.status[Status.RUN] = shared.command[Command.RUN]


@part
def _stop(shared: Shared, memory: Memory) -> None:
    """Begin to brake; drives that have no controller to brake with lose their torque."""
    state = shared.status[Status.STATE]
    if State.HOLDING <= state <= State.MOVING:
        memory.count[Count.SINCE] = 0
        enter(shared, State.STOPPING)
    elif State.ARMING <= state <= State.TESTING:
        enter(shared, State.READY)


@part
def _follow_clock(read: Inputs, layout: Layout, shared: Shared, memory: Memory) -> int:
    """Return by how much the next period is longer, ns, to stay in phase with SYNC0."""
    status, count = shared.status, memory.count
    if not layout.clocks:
        status[Status.PHASE_LOCKED] = 1
        return 0
    if not read.good:
        return 0
    shift = layout.sync_start + layout.sync_shift
    phase = (read.system_time - shift + PERIOD // 2) % PERIOD - PERIOD // 2
    status[Status.PHASE_ERROR] = phase
    before = count[Count.IN_PHASE]
    count[Count.PHASE] += (abs(phase) - count[Count.PHASE]) // 64  # one late exchange is no phase
    inside = count[Count.PHASE] < PHASE_LIMIT
    count[Count.IN_PHASE] = max(before, 0) + 1 if inside else min(before, 0) - 1
    if count[Count.IN_PHASE] >= PHASE_CYCLES:
        status[Status.PHASE_LOCKED] = 1
    elif with_torque(shared):
        if count[Count.IN_PHASE] <= -PHASE_CYCLES:
            latch(shared, faults.PHASE, 0, phase * 1e-9, PHASE_LIMIT * 1e-9)
    elif status[Status.STATE] == State.READY:
        status[Status.PHASE_LOCKED] = 0
    return min(max(-phase // 16, -PULL), PULL)


@part
def _next_period(read: Inputs, layout: Layout, bus: Bus, shared: Shared, memory: Memory) -> None:
    """Set the start of the next period: in phase with SYNC0, and never in the past."""
    status, count = shared.status, memory.count
    count[Count.NEXT] += PERIOD + _follow_clock(read, layout, shared, memory)
    count[Count.CYCLE] += 1
    status[Status.CYCLES] += 1
    instant = now(bus.clock)
    status[Status.UPDATED] = machine_time(instant, bus.clock)
    late = instant - count[Count.NEXT]
    if late <= 0:
        count[Count.LATE_RUN] = 0
        return
    skipped = late // PERIOD
    status[Status.LATE] += 1 + skipped
    count[Count.LATE_RUN] += 1
    status[Status.LATE_RUN] = max(status[Status.LATE_RUN], count[Count.LATE_RUN])
    count[Count.SKIPPED] = skipped
    count[Count.NEXT] += skipped * PERIOD
