"""A node's registers and process memory as datagrams see them: what reading and writing does."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.ethercat import (
    OP,
    REGISTER_AL_CONTROL,
    REGISTER_DC_ACTIVATION,
    REGISTER_DC_RECEIVE_TIME,
    REGISTER_DC_START_TIME,
    REGISTER_DC_SYNC0_CYCLE,
    REGISTER_DC_SYSTEM_TIME,
    REGISTER_DC_SYSTEM_TIME_DELAY,
    REGISTER_DC_SYSTEM_TIME_DIFFERENCE,
    REGISTER_DC_SYSTEM_TIME_OFFSET,
    REGISTER_DL_STATUS,
    REGISTER_SII_ADDRESS,
    REGISTER_SII_CONTROL,
    REGISTER_SII_DATA,
    REGISTER_SYNC_MANAGER,
)
from motionlab.drive.virtual.al import (
    BY_OUTPUTS,
    FROM_MASTER,
    MAILBOX,
    al_state,
    request_state,
)
from motionlab.drive.virtual.cia402 import OUTPUT_SYNC
from motionlab.drive.virtual.events import outputs_arrived, sync_stopped
from motionlab.drive.virtual.layout import (
    ANSWER,
    CLOCK,
    HOP_NS,
    MAIL,
    MAIL_EPOCH,
    MAILS,
    MEMORY,
    NEVER,
    PROCESS_MEMORY,
    REACHED,
    SYNC_COUNT,
    SYNC_CYCLE,
    SYNC_MANAGERS,
    SYNC_NEXT,
    Arrays,
    get8,
    get16,
    get32,
    get64,
    part,
    put,
)

Bytes = NDArray[np.uint8]

SII_READ, SII_RELOAD = 1, 4
SII_EIGHT_BYTES, SII_REFUSED = 0x0040, 0x2000
SYNC_ACTIVE = 0x03
"""Register 0x0981: cyclic operation and SYNC0."""

LINKS, LAST_LINK = 0x5A33, 0x5613
"""Register 0x0110: links at ports 0 and 1, or at port 0 alone."""

REPEAT = 0x02
CORRECTION_MAX_NS = 1000
"""Most by which one comparison of clocks moves a local clock."""


@part
def arrival(n: int, time: int) -> int:
    """Return when a frame that the first node sees at `time` is at node `n`."""
    return time + n * HOP_NS


@part
def local_time(s: Arrays, n: int, time: int) -> int:
    """Return the local clock of a node, ns."""
    return time + s.nodes[n, CLOCK]


@part
def system_time(s: Arrays, n: int, time: int) -> int:
    """Return the node's copy of the system time, ns since 2000-01-01 once a master has set it."""
    return local_time(s, n, time) + get64(s.memory[n], REGISTER_DC_SYSTEM_TIME_OFFSET)


@part
def touches(at: int, size: int, first: int, count: int) -> bool:
    """Tell whether two ranges of addresses have a byte in common."""
    return at < first + count and first < at + size


@part
def _blocking_manager(s: Arrays, n: int, at: int, size: int, direction: int) -> bool:
    """Tell whether a sync manager refuses the master's access to a range of process memory."""
    memory = s.memory[n]
    for k in range(SYNC_MANAGERS):
        base = REGISTER_SYNC_MANAGER + 8 * k
        start, length = get16(memory, base), get16(memory, base + 2)
        if not memory[base + 6] & 1 or not touches(at, size, start, length):
            continue
        control = get8(memory, base + 4)
        if memory[base + 7] & 1 or (control >> 2) & 0x03 != direction:
            return True
        if control & 0x03 == MAILBOX:
            full = s.nodes[n, MAIL] if direction == FROM_MASTER else s.nodes[n, ANSWER]
            if bool(full) == (direction == FROM_MASTER):
                return True  # a full box is not written, an empty one not read
    return False


@part
def _access_done(  # noqa: PLR0913, PLR0917 - an access: where, which way, when
    s: Arrays, n: int, at: int, size: int, direction: int, time: int
) -> None:
    """Carry out what follows when the last byte of a sync manager's area has been accessed."""
    memory = s.memory[n]
    for k in range(SYNC_MANAGERS):
        base = REGISTER_SYNC_MANAGER + 8 * k
        last = get16(memory, base) + get16(memory, base + 2) - 1
        if not memory[base + 6] & 1 or not at <= last < at + size:
            continue
        control = get8(memory, base + 4)
        if control & 0x03 != MAILBOX:
            if direction == FROM_MASTER and k == OUTPUT_SYNC:
                outputs_arrived(s, n, time)
        elif direction == FROM_MASTER:
            s.nodes[n, MAIL] = 1
            s.clock[MAILS] += 1
        else:
            s.nodes[n, ANSWER] = 0
            s.clock[MAILS] += 1  # for what has waited for the room


@part
def _refresh(s: Arrays, n: int, at: int, size: int, time: int) -> None:
    """Bring registers up to date that change by themselves."""
    memory = s.memory[n]
    if touches(at, size, REGISTER_DC_SYSTEM_TIME, 8):
        put(memory, REGISTER_DC_SYSTEM_TIME, system_time(s, n, arrival(n, time)), 8)
    if touches(at, size, REGISTER_DL_STATUS, 2):
        put(memory, REGISTER_DL_STATUS, LAST_LINK if n + 1 == s.switches[REACHED] else LINKS, 2)
    if touches(at, size, REGISTER_SYNC_MANAGER, 16):
        memory[REGISTER_SYNC_MANAGER + 5] = 8 if s.nodes[n, MAIL] else 0
        memory[REGISTER_SYNC_MANAGER + 13] = 8 if s.nodes[n, ANSWER] else 0


@part
def read_memory(s: Arrays, n: int, at: int, size: int, time: int) -> bool:
    """Tell whether a range can be read, and do what reading brings about."""
    if at + size > MEMORY:
        return False
    if at + size > PROCESS_MEMORY:
        if _blocking_manager(s, n, at, size, 0):
            return False
        _access_done(s, n, at, size, 0, time)
    _refresh(s, n, at, size, time)
    return True


@part
def write_memory(  # noqa: PLR0913, PLR0917 - an access: where, with what, when
    s: Arrays, n: int, at: int, data: Bytes, first: int, size: int, time: int
) -> bool:
    """Write ``data[first : first + size]`` at an address, and do what that brings about.

    Returns whether the node took it.
    """
    if at + size > MEMORY:
        return False
    if at + size > PROCESS_MEMORY and _blocking_manager(s, n, at, size, FROM_MASTER):
        return False
    memory = s.memory[n]
    repeat = memory[REGISTER_SYNC_MANAGER + 14] & REPEAT
    for i in range(size):
        mask = s.writable[at + i]
        memory[at + i] = (memory[at + i] & ~mask) | (data[first + i] & mask)
    if at + size > PROCESS_MEMORY:
        _access_done(s, n, at, size, FROM_MASTER, time)
    # Registers whose write has consequences.
    if touches(at, size, REGISTER_SYNC_MANAGER, 8 * SYNC_MANAGERS):
        _sync_managers_written(s, n, repeat)
    if touches(at, size, REGISTER_AL_CONTROL, 1):
        request_state(s, n, time)
    if touches(at, size, REGISTER_SII_CONTROL + 1, 1):
        _slave_information(s, n)
    if touches(at, size, REGISTER_DC_RECEIVE_TIME, 4):
        _latch_times(s, n, time)
    if at <= REGISTER_DC_SYSTEM_TIME and at + size >= REGISTER_DC_SYSTEM_TIME + 4:
        _compare_clocks(s, n, get32(data, first + REGISTER_DC_SYSTEM_TIME - at), time)
    if touches(at, size, REGISTER_DC_ACTIVATION, 1):
        _activate_sync(s, n, time)
    return True


@part
def _sync_managers_written(s: Arrays, n: int, repeat: Any) -> None:
    """Empty mailboxes that were switched off; send the last answer again where asked."""
    memory, node = s.memory[n], s.nodes[n]
    base = REGISTER_SYNC_MANAGER
    if not memory[base + 6] & 1:
        node[MAIL] = 0
        node[MAIL_EPOCH] += 1
    if not memory[base + 14] & 1:
        node[ANSWER] = 0
    elif (memory[base + 14] & REPEAT) != repeat:
        node[ANSWER] = 1
        memory[base + 15] = (memory[base + 15] & 0xFD) | (memory[base + 14] & REPEAT)


@part
def _slave_information(s: Arrays, n: int) -> None:
    """Carry out a command of the slave information interface."""
    memory = s.memory[n]
    command = get8(memory, REGISTER_SII_CONTROL + 1) & 0x07
    status = SII_EIGHT_BYTES
    if command in (SII_READ, SII_RELOAD):
        at = 2 * get32(memory, REGISTER_SII_ADDRESS)
        for i in range(8):
            inside = 0 <= at + i < s.eeprom.shape[1]
            memory[REGISTER_SII_DATA + i] = s.eeprom[n, at + i] if inside else 0xFF
    elif command:
        status |= SII_REFUSED  # it cannot be written
    put(memory, REGISTER_SII_CONTROL, status, 2)


@part
def _latch_times(s: Arrays, n: int, time: int) -> None:
    """Note when this frame passes: out through port 1 and back, where there is a next node."""
    memory = s.memory[n]
    there = local_time(s, n, arrival(n, time))
    beyond = max(int(s.switches[REACHED]) - 1 - n, 0)
    put(memory, REGISTER_DC_RECEIVE_TIME, there, 4)
    back = there + 2 * beyond * HOP_NS if beyond else 0
    put(memory, REGISTER_DC_RECEIVE_TIME + 4, back, 4)
    put(memory, REGISTER_DC_RECEIVE_TIME + 8, 0, 8)
    put(memory, REGISTER_DC_RECEIVE_TIME + 0x18, there, 8)


@part
def _compare_clocks(s: Arrays, n: int, received: int, time: int) -> None:
    """Move the local clock towards the reference clock's time in the datagram."""
    memory = s.memory[n]
    expected = received + get32(memory, REGISTER_DC_SYSTEM_TIME_DELAY)
    ahead = (system_time(s, n, arrival(n, time)) - expected) & 0xFFFF_FFFF
    if ahead >= 0x8000_0000:
        ahead -= 0x1_0000_0000
    sign = 0x8000_0000 if ahead < 0 else 0
    put(memory, REGISTER_DC_SYSTEM_TIME_DIFFERENCE, sign | min(abs(ahead), 0x7FFF_FFFF), 4)
    s.nodes[n, CLOCK] -= min(max(ahead, -CORRECTION_MAX_NS), CORRECTION_MAX_NS)


@part
def _activate_sync(s: Arrays, n: int, time: int) -> None:
    """Start SYNC0 at its start time, or stop it; never where the start time has passed."""
    memory, node = s.memory[n], s.nodes[n]
    node[SYNC_COUNT] = 0
    node[SYNC_CYCLE] = get32(memory, REGISTER_DC_SYNC0_CYCLE)
    start = get64(memory, REGISTER_DC_START_TIME)
    active = get8(memory, REGISTER_DC_ACTIVATION) & SYNC_ACTIVE == SYNC_ACTIVE
    if active and node[SYNC_CYCLE] > 0 and start > system_time(s, n, arrival(n, time)):
        node[SYNC_NEXT] = start
        return
    node[SYNC_NEXT] = NEVER
    if al_state(s, n) == OP:
        sync_stopped(s, n)


__all__ = ["BY_OUTPUTS", "read_memory", "write_memory"]
