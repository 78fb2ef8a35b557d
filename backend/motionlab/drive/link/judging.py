"""What the loop makes of its inputs: positions taken over, link and drives judged."""

from __future__ import annotations

from motionlab.drive import faults
from motionlab.drive.ethercat import OP
from motionlab.drive.libc import part
from motionlab.drive.link.bus import Bus, Inputs, i16, i32, input_at, u16
from motionlab.drive.link.memory import Count, Layout, Memory, latch, with_torque
from motionlab.drive.link.shared import ROUND_TRIP_BINS, Figure, Shared, State, Status
from motionlab.drive.link.testing import judge_bounds
from motionlab.drive.process_data import CYCLIC_TORQUE, NODES, STO_ACTIVE
from motionlab.timing import CONTROL_PERIOD

_PLAUSIBLE = 40  # missed cycles over which a change of position is still judged


@part
def take_inputs(bus: Bus, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Take over status words, errors, currents and positions."""
    status = shared.status
    for node in range(NODES):
        at = input_at(bus, node)
        status[Status.NODE_STATUS + node] = u16(bus.answer, at)
        status[Status.NODE_TORQUE + node] = i16(bus.answer, at + 10)
        status[Status.NODE_MODE + node] = bus.answer[at + 12]
        status[Status.NODE_ERROR + node] = u16(bus.answer, at + 14)
    cycles = memory.count[Count.MISSED] + 1
    for axis in range(2):
        counts = i32(bus.answer, input_at(bus, layout.encoder[axis]) + 2)
        position = layout.resolution[axis] * counts + layout.offset[axis]
        moved = position - memory.position[axis]
        most = 2.0 * layout.velocity_max[axis] * cycles * CONTROL_PERIOD
        if with_torque(shared) and cycles <= _PLAUSIBLE and abs(moved) > most:
            latch(shared, faults.ENCODER, axis + 1, moved, most)
        memory.position[axis] = position
        memory.velocity[axis] = moved / (cycles * CONTROL_PERIOD)
        shared.figures[Figure.POSITION + axis] = position
        shared.figures[Figure.VELOCITY + axis] = memory.velocity[axis]


@part
def judge_loss(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Latch a fault once inputs, or outputs, have not passed for too long."""
    count = memory.count
    missed = max(count[Count.MISSED], count[Count.UNCONFIRMED])
    shared.status[Status.MISSED_NOW] = missed
    if missed >= layout.loss_cycles:
        limit = layout.loss_cycles * CONTROL_PERIOD
        latch(shared, faults.LINK_LOST, 0, missed * CONTROL_PERIOD, limit)


@part
def judge_link(read: Inputs, good: bool, layout: Layout, shared: Shared, memory: Memory) -> None:
    """Count what was missed; latch a fault where the link is lost or the drives are not in OP."""
    status, count = shared.status, memory.count
    status[Status.WORKING_COUNTER] = read.working_counter
    status[Status.ROUND_TRIP] = read.round_trip
    took = min(read.round_trip // 1000, ROUND_TRIP_BINS - 1)
    shared.waits[took] += 1
    if read.good:
        shared.round_trips[took] += 1
        status[Status.AL_STATUS] = read.al_status
    confirmed = read.written == NODES or count[Count.CYCLE] == 0
    count[Count.MISSED] = 0 if good else count[Count.MISSED] + 1
    count[Count.UNCONFIRMED] = 0 if confirmed else count[Count.UNCONFIRMED] + 1
    if not (good and confirmed):
        status[Status.MISSED] += 1
    judge_loss(layout, shared, memory)
    if read.good and read.al_status != OP:
        latch(shared, faults.LEFT_OPERATION, 0, read.al_status, OP)


@part
def judge_drives(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Latch a fault where a drive, a position or a speed is not as it must be with torque."""
    status = shared.status
    state = status[Status.STATE]
    for node in range(NODES):
        word = status[Status.NODE_STATUS + node]
        if word & 0x08:
            if memory.count[Count.RESETTING] == 0:
                error = status[Status.NODE_ERROR + node]
                latch(shared, faults.DRIVE_FAULT, node + 1, error, 0.0)
        elif state >= State.ARMING and word & STO_ACTIVE:
            latch(shared, faults.STO, node + 1, 0.0, 0.0)
        elif word & 0x6F != 0x27:
            if state >= State.HOLDING:
                latch(shared, faults.NOT_ENABLED, node + 1, word, 0.0)
        elif state >= State.ARMING and status[Status.NODE_MODE + node] != CYCLIC_TORQUE:
            latch(shared, faults.WRONG_MODE, node + 1, 0.0, 0.0)
    if state == State.TESTING:
        judge_bounds(layout, shared, memory)
    elif with_torque(shared):
        _judge_limits(layout, shared, memory)


@part
def _judge_limits(layout: Layout, shared: Shared, memory: Memory) -> None:
    """Latch a fault where a position or a speed is beyond its limit."""
    for axis in range(2):
        position, speed = memory.position[axis], abs(memory.velocity[axis])
        if position < layout.position_min[axis]:
            latch(shared, faults.POSITION_LIMIT, axis + 1, position, layout.position_min[axis])
        elif position > layout.position_max[axis]:
            latch(shared, faults.POSITION_LIMIT, axis + 1, position, layout.position_max[axis])
        elif speed > layout.velocity_max[axis]:
            latch(shared, faults.SPEED_LIMIT, axis + 1, speed, layout.velocity_max[axis])
