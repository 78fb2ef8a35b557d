"""What makes a node act: SYNC0, outputs that arrive, the watchdog, or nothing for a while."""

from __future__ import annotations

from motionlab.drive.ethercat import (
    OP,
    REGISTER_DC_SYSTEM_TIME_OFFSET,
    REGISTER_WATCHDOG_STATUS,
    SAFEOP,
)
from motionlab.drive.virtual.al import (
    BY_SYNC0,
    SYNC_LOST,
    al_state,
    drop,
    expire_watchdog,
    watchdog_expires,
)
from motionlab.drive.virtual.cia402 import step_drive
from motionlab.drive.virtual.layout import (
    CATCH_UP_NS,
    CLOCK,
    CONTROL_PERIOD_NS,
    DROP_REQUEST,
    EARLIEST,
    FAULT_REQUEST,
    FRESH,
    IDLE_NS,
    LAST,
    LAST_OUTPUT,
    LAST_STEP,
    LATEST,
    MISSED,
    NEVER,
    NODES,
    PLANT_TIME,
    SKIPPED,
    STEP_NS,
    STEPS,
    SYNC_COUNT,
    SYNC_CYCLE,
    SYNC_NEXT,
    SYNC_TYPE,
    Arrays,
    get64,
    part,
    put,
)
from motionlab.drive.virtual.machine import run_machine, run_machine_to

_TOLERANCE_NS = STEP_NS // 5
"""By how much SYNC0 of two nodes may differ and still be one instant of the plant."""


@part
def _sync_time(s: Arrays, n: int) -> int:
    """Return the next SYNC0 of a node by the segment's clock; NEVER without."""
    at = s.nodes[n, SYNC_NEXT]
    if at == NEVER:
        return NEVER
    return at - s.nodes[n, CLOCK] - get64(s.memory[n], REGISTER_DC_SYSTEM_TIME_OFFSET)


@part
def by_sync0(s: Arrays, n: int) -> bool:
    """Tell whether a node acts at SYNC0: object 1C32:01 says so, and it runs."""
    return s.objects[n, SYNC_TYPE] == BY_SYNC0 and s.nodes[n, SYNC_NEXT] != NEVER


@part
def _leader(s: Arrays) -> int:
    """Return the first node that acts at SYNC0; the steps of the plant begin at its SYNC0."""
    for n in range(NODES):
        if by_sync0(s, n):
            return n
    return -1


@part
def _sync(s: Arrays, n: int, time: int) -> None:
    """Act at SYNC0 of a node."""
    node = s.nodes[n]
    cycle = node[SYNC_CYCLE]
    node[SYNC_NEXT] += cycle
    node[SYNC_COUNT] += 1
    if s.objects[n, SYNC_TYPE] != BY_SYNC0:
        return
    ahead = time - s.clock[PLANT_TIME]
    if n != _leader(s):
        run_machine_to(s, time + _TOLERANCE_NS)
    elif node[SYNC_COUNT] == 1:  # the plant's steps begin anew here
        run_machine_to(s, time)
        s.clock[PLANT_TIME] = time
        s.clock[STEPS] = 0
        run_machine(s, 0)
    else:
        run_machine(s, max((ahead + STEP_NS // 2) // STEP_NS, 0))
        s.clock[PLANT_TIME] = time
    state = al_state(s, n)
    if state == OP and not node[FRESH]:
        node[MISSED] += 1
    elapsed = time - node[LAST_STEP]
    if abs(elapsed - cycle) < _TOLERANCE_NS:
        elapsed = cycle
    step_drive(s, n, time, elapsed, state == OP)


@part
def outputs_arrived(s: Arrays, n: int, time: int) -> None:
    """Feed the watchdog; without distributed clocks, act."""
    node = s.nodes[n]
    state = al_state(s, n)
    if state < SAFEOP:
        return
    node[LAST_OUTPUT] = time
    node[FRESH] = 1
    put(s.memory[n], REGISTER_WATCHDOG_STATUS, 1, 2)
    if s.objects[n, SYNC_TYPE] == BY_SYNC0:
        if node[SYNC_COUNT]:
            since = node[SYNC_CYCLE] - (_sync_time(s, n) - time)
            s.counters[LATEST] = max(s.counters[LATEST], since)
            s.counters[EARLIEST] = min(s.counters[EARLIEST], since)
        return
    run_machine_to(s, time)
    step_drive(s, n, time, time - node[LAST_STEP], state == OP)


@part
def sync_stopped(s: Arrays, n: int) -> None:
    """Fall to SAFEOP where a node that acts at SYNC0 loses it in OP."""
    if s.objects[n, SYNC_TYPE] == BY_SYNC0:
        drop(s, n, SYNC_LOST)


@part
def _idle(s: Arrays, n: int, time: int) -> None:
    """Let a node act that nothing has made act for a while, with the outputs it has."""
    node = s.nodes[n]
    if node[DROP_REQUEST]:
        drop(s, n, node[DROP_REQUEST])
        node[DROP_REQUEST] = 0
    waiting = time - node[LAST_STEP]
    if waiting >= IDLE_NS or (node[FAULT_REQUEST] and waiting >= CONTROL_PERIOD_NS):
        if by_sync0(s, n) and node[SYNC_COUNT]:
            return
        run_machine_to(s, time)
        step_drive(s, n, time, waiting, al_state(s, n) == OP)


@part
def _skip(s: Arrays, time: int) -> None:
    """Leave out what is too much to make up after a long standstill."""
    late = time - s.clock[LAST] - CATCH_UP_NS
    if late <= 0:
        return
    s.counters[SKIPPED] += late
    s.clock[PLANT_TIME] += late
    for n in range(NODES):
        at = _sync_time(s, n)
        cycle = s.nodes[n, SYNC_CYCLE]
        if at < time - CATCH_UP_NS:
            s.nodes[n, SYNC_NEXT] += (time - CATCH_UP_NS - at) // cycle * cycle


@part
def catch_up(s: Arrays, time: int) -> None:
    """Let everything happen that is due until `time`, in its order."""
    if time <= s.clock[LAST]:
        return
    _skip(s, time)
    while True:
        # The earliest of all: a SYNC0, or a watchdog that expires.
        who, when, expires = -1, time + 1, False
        for n in range(NODES):
            at = _sync_time(s, n)
            if at < when:
                who, when, expires = n, at, False
            at = watchdog_expires(s, n)
            if at < when:
                who, when, expires = n, at, True
        if who < 0:
            break
        if expires:
            run_machine_to(s, when)
            expire_watchdog(s, who)
        else:
            _sync(s, who, when)
    for n in range(NODES):
        _idle(s, n, time)
    s.clock[LAST] = time
