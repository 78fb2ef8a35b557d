"""Application layer of a node: INIT, PREOP, SAFEOP, OP, their checks, the watchdog."""

from __future__ import annotations

from motionlab.drive.ethercat import (
    AL_ERROR,
    BOOT,
    INIT,
    OP,
    PREOP,
    REGISTER_AL_CONTROL,
    REGISTER_AL_STATUS,
    REGISTER_AL_STATUS_CODE,
    REGISTER_SYNC_MANAGER,
    REGISTER_WATCHDOG_DIVIDER,
    REGISTER_WATCHDOG_PROCESS_DATA,
    REGISTER_WATCHDOG_STATUS,
    SAFEOP,
)
from motionlab.drive.process_data import INPUT_BYTES, OUTPUT_BYTES
from motionlab.drive.virtual.cia402 import (
    FAULT,
    FAULT_REACTION,
    INPUT_SYNC,
    LINK_ERROR,
    OUTPUT_SYNC,
    SWITCH_ON_DISABLED,
    fail,
    release,
)
from motionlab.drive.virtual.layout import (
    ANSWER,
    CONTROL_LAST,
    DRIVE_STATE,
    FRESH,
    LAST_OUTPUT,
    LAST_STEP,
    MAIL,
    MAIL_EPOCH,
    MEMORY,
    MODE_DISPLAY,
    NEVER,
    OBJECT_COLUMNS,
    PROCESS_MEMORY,
    STEP_NS,
    SYNC_COUNT,
    SYNC_CYCLE,
    SYNC_NEXT,
    SYNC_TYPE,
    WATCHDOGS,
    Arrays,
    get8,
    get16,
    part,
    put,
)

INVALID_CHANGE, UNKNOWN_STATE, NO_BOOT = 0x11, 0x12, 0x13
BAD_MAILBOX, WATCHDOG_EXPIRED, BAD_OUTPUTS, BAD_INPUTS, BAD_WATCHDOG = 0x16, 0x1B, 0x1D, 0x1E, 0x1F
SYNC_LOST, NO_SYNC, BAD_SYNC, BAD_CYCLE = 0x1A, 0x2D, 0x30, 0x35

BY_OUTPUTS, BY_SYNC0 = 1, 2
"""Object 1C32:01: what makes the drive act."""

MAILBOX_BYTES = 128
MAILBOX_OUT, MAILBOX_IN = 0x1000, 0x1080
"""Where a master writes and reads its mail."""

BUFFERED, MAILBOX = 0, 2
TO_MASTER, FROM_MASTER = 0, 1
WATCHED = 0x40
"""Bit of a sync manager's control byte: its outputs feed the watchdog."""

CYCLE_MAX_NS = 10_000_000
WATCHDOG_MAX_NS = 100_000_000
BASE_TICK_NS = 40


@part
def al_state(s: Arrays, n: int) -> int:
    """Return the state of the application layer."""
    return get8(s.memory[n], REGISTER_AL_STATUS) & 0x0F


@part
def set_state(s: Arrays, n: int, state: int, code: int) -> None:
    """Set state and status code; a code raises the error indication."""
    put(s.memory[n], REGISTER_AL_STATUS, state | (AL_ERROR if code else 0), 2)
    put(s.memory[n], REGISTER_AL_STATUS_CODE, code, 2)


@part
def watchdog_time(s: Arrays, n: int) -> int:
    """Return the time without outputs that a node stands, ns; 0 for ever."""
    memory = s.memory[n]
    if not memory[REGISTER_SYNC_MANAGER + 8 * OUTPUT_SYNC + 4] & WATCHED:
        return 0
    tick = (get16(memory, REGISTER_WATCHDOG_DIVIDER) + 2) * BASE_TICK_NS
    return get16(memory, REGISTER_WATCHDOG_PROCESS_DATA) * tick


@part
def watchdog_expires(s: Arrays, n: int) -> int:
    """Return when the watchdog of a node expires unless outputs come; NEVER outside OP."""
    if al_state(s, n) != OP:
        return NEVER
    time = watchdog_time(s, n)
    return s.nodes[n, LAST_OUTPUT] + time if time else NEVER


@part
def expire_watchdog(s: Arrays, n: int) -> None:
    """Fall to SAFEOP for want of outputs."""
    s.counters[WATCHDOGS] += 1
    put(s.memory[n], REGISTER_WATCHDOG_STATUS, 0, 2)
    expired = get8(s.memory[n], REGISTER_WATCHDOG_STATUS + 2)
    put(s.memory[n], REGISTER_WATCHDOG_STATUS + 2, min(expired + 1, 255), 1)
    drop(s, n, WATCHDOG_EXPIRED)


@part
def drop(s: Arrays, n: int, code: int) -> None:
    """Fall from OP to SAFEOP with an AL status code; the drive fails."""
    if al_state(s, n) == OP:
        set_state(s, n, SAFEOP, code)
        fail(s, n, LINK_ERROR)


@part
def _sync_manager(  # noqa: PLR0913, PLR0917 - one for each field that is checked
    s: Arrays, n: int, k: int, mode: int, direction: int, size: int
) -> bool:
    """Tell whether a sync manager is set up as the node needs it."""
    at = REGISTER_SYNC_MANAGER + 8 * k
    memory = s.memory[n]
    start, length, control = get16(memory, at), get16(memory, at + 2), get8(memory, at + 4)
    if length != size or control & 0x03 != mode or (control >> 2) & 0x03 != direction:
        return False
    inside = start >= PROCESS_MEMORY and start + length <= MEMORY
    return bool(memory[at + 6] & 1) and inside


@part
def _mailbox_fault(s: Arrays, n: int) -> int:
    memory = s.memory[n]
    at = REGISTER_SYNC_MANAGER
    there = get16(memory, at) == MAILBOX_OUT and get16(memory, at + 8) == MAILBOX_IN
    ready = _sync_manager(s, n, 0, MAILBOX, FROM_MASTER, MAILBOX_BYTES) and _sync_manager(
        s, n, 1, MAILBOX, TO_MASTER, MAILBOX_BYTES
    )
    return 0 if there and ready else BAD_MAILBOX


@part
def _process_data_fault(s: Arrays, n: int) -> int:
    if not _sync_manager(s, n, OUTPUT_SYNC, BUFFERED, FROM_MASTER, OUTPUT_BYTES):
        return BAD_OUTPUTS
    if not _sync_manager(s, n, INPUT_SYNC, BUFFERED, TO_MASTER, INPUT_BYTES):
        return BAD_INPUTS
    if not 0 < watchdog_time(s, n) <= WATCHDOG_MAX_NS:
        return BAD_WATCHDOG
    if s.objects[n, SYNC_TYPE] == BY_SYNC0:
        cycle = s.nodes[n, SYNC_CYCLE]
        if s.nodes[n, SYNC_NEXT] == NEVER:
            return BAD_SYNC
        if not STEP_NS <= cycle <= CYCLE_MAX_NS or cycle % STEP_NS:
            return BAD_CYCLE
    return 0


@part
def _enable_process_data(s: Arrays, n: int, enabled: bool) -> None:
    """Let the master at sync managers 2 and 3, or lock them; they begin empty."""
    for k in (OUTPUT_SYNC, INPUT_SYNC):
        at = REGISTER_SYNC_MANAGER + 8 * k
        s.memory[n, at + 7] = 0 if enabled else 1
        if enabled:
            put(s.memory[n], get16(s.memory[n], at), 0, get16(s.memory[n], at + 2))


@part
def reset_settings(s: Arrays, n: int) -> None:
    """Forget what was set since power-on, and mail under way."""
    node = s.nodes[n]
    for i in range(OBJECT_COLUMNS):
        s.objects[n, i] = s.defaults[n, i]
    node[MODE_DISPLAY] = node[CONTROL_LAST] = 0
    node[MAIL] = node[ANSWER] = 0
    node[MAIL_EPOCH] += 1


@part
def _rise_fault(s: Arrays, n: int, state: int, target: int) -> int:
    """Return the AL status code that keeps a node from rising to the next state; 0 for none."""
    node = s.nodes[n]
    code = 0
    if (state, target) == (INIT, PREOP):
        code = _mailbox_fault(s, n)
    elif (state, target) == (PREOP, SAFEOP):
        code = _process_data_fault(s, n)
    elif (state, target) == (SAFEOP, OP):
        if s.objects[n, SYNC_TYPE] == BY_SYNC0 and not node[SYNC_COUNT]:
            code = NO_SYNC
    else:
        code = INVALID_CHANGE
    return code


@part
def request_state(s: Arrays, n: int, time: int) -> None:
    """Carry out what the master has written into AL control."""
    node = s.nodes[n]
    control = get16(s.memory[n], REGISTER_AL_CONTROL)
    target = control & 0x0F
    state = al_state(s, n)
    failed = bool(s.memory[n, REGISTER_AL_STATUS] & AL_ERROR)
    if failed and not control & AL_ERROR and target > state:
        return  # the error has to be acknowledged first
    code = 0
    if target == BOOT:
        code = NO_BOOT
    elif target not in (INIT, PREOP, SAFEOP, OP):
        code = UNKNOWN_STATE
    elif target > state:
        code = _rise_fault(s, n, state, target)
    if code:
        if state == OP:
            fail(s, n, LINK_ERROR)
            state = SAFEOP
        set_state(s, n, state, code)
        return
    set_state(s, n, target, 0)
    if state == OP and target < OP:
        release(s, n)
        if node[DRIVE_STATE] not in (FAULT, FAULT_REACTION):
            node[DRIVE_STATE] = SWITCH_ON_DISABLED
    if target == OP and state == SAFEOP:
        node[LAST_OUTPUT] = time
        put(s.memory[n], REGISTER_WATCHDOG_STATUS, 1, 2)
    if target < SAFEOP or state < SAFEOP:
        _enable_process_data(s, n, target >= SAFEOP)
        node[FRESH] = 0
        node[LAST_STEP] = time
    if target == INIT:
        reset_settings(s, n)
