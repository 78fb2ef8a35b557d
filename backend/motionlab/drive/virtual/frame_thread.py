"""The thread that answers: socket, frames, faults on the way."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.drive.ethercat import ETHERTYPE
from motionlab.drive.libc import (
    Clock,
    age,
    new_clock,
    now,
    raise_event,
    receive_from,
    send_to,
    wait_readable,
)
from motionlab.drive.virtual.datagrams import answer
from motionlab.drive.virtual.events import catch_up
from motionlab.drive.virtual.layout import (
    BLACK_HOLE,
    DELAY,
    DROP,
    DUPLICATE,
    FREEZE,
    LAST,
    LOST,
    MAILS,
    NEVER,
    RANDOM,
    REORDER,
    Arrays,
    get8,
    kept,
    part,
)

FRAME_ROOM = 2048
ADDRESS_ROOM = 32
SLOTS = 64
"""Answers that can be under way late."""

MAC_HEADER = 14
WAKE_NS = 1_000_000
REORDER_NS = 2_000_000
"""Longest time an answer waits to be overtaken."""

_BURST = 64

# Carrier.numbers
SOCKET, HEADER, STOP, MAIL_EVENT, START_MONOTONIC, START_CLOCK, CARRIER_ROWS = range(7)


class Carrier(NamedTuple):
    """A socket and what is under way on it."""

    numbers: NDArray[np.int64]  # (CARRIER_ROWS,)
    drift: NDArray[np.float64]  # (1,), of the segment's clock, 1
    frame: NDArray[np.uint8]  # (FRAME_ROOM,)
    address: NDArray[np.uint8]  # (ADDRESS_ROOM,), of the sender
    address_size: NDArray[np.int32]  # (2,), of the sender's in its second place
    clock: Clock
    late_due: NDArray[np.int64]  # (SLOTS,), when an answer leaves; NEVER for an empty slot
    late_size: NDArray[np.int64]  # (SLOTS,)
    late_frame: NDArray[np.uint8]  # (SLOTS, FRAME_ROOM)
    late_address: NDArray[np.uint8]  # (SLOTS, ADDRESS_ROOM)


def carrier(descriptor: int, header: int, mail_event: int, drift: float, slow: int = 1) -> Carrier:
    """Return a carrier on a socket.

    `header` counts the bytes before the EtherCAT header; `mail_event` is the descriptor of an event
    counter that tells of mail; by `drift`, 1, the segment's clock is fast.
    """
    numbers = np.zeros(CARRIER_ROWS, dtype=np.int64)
    numbers[[SOCKET, HEADER, MAIL_EVENT]] = descriptor, header, mail_event
    return Carrier(
        numbers=numbers,
        drift=np.array([drift]),
        frame=np.zeros(FRAME_ROOM, dtype=np.uint8),
        address=np.zeros(ADDRESS_ROOM, dtype=np.uint8),
        address_size=np.zeros(2, dtype=np.int32),
        clock=new_clock(slow),
        late_due=np.full(SLOTS, NEVER, dtype=np.int64),
        late_size=np.zeros(SLOTS, dtype=np.int64),
        late_frame=np.zeros((SLOTS, FRAME_ROOM), dtype=np.uint8),
        late_address=np.zeros((SLOTS, ADDRESS_ROOM), dtype=np.uint8),
    )


@part
def _segment_time(c: Carrier, monotonic: int) -> int:
    """Return the segment's clock, ns, at a time of the machine's monotonic clock."""
    passed = monotonic - c.numbers[START_MONOTONIC]
    return c.numbers[START_CLOCK] + passed + int(passed * c.drift[0])


@part
def _chance(s: Arrays, share: float) -> bool:
    """Tell whether something happens this time."""
    if share <= 0.0:
        return False
    s.clock[RANDOM] = s.clock[RANDOM] * 48271 % 2_147_483_647
    return s.clock[RANDOM] < share * 2_147_483_647


@part
def _send(c: Carrier, frame: NDArray[np.uint8], size: int, address: NDArray[np.uint8]) -> None:
    send_to(c.numbers[SOCKET], frame, size, address, c.address_size[1])


@part
def _send_due(c: Carrier, instant: int) -> int:
    """Send late answers whose time has come; return when the next one is due."""
    following = NEVER
    for i in range(SLOTS):
        if c.late_due[i] <= instant:
            c.late_due[i] = NEVER
            _send(c, c.late_frame[i], c.late_size[i], c.late_address[i])
        following = min(following, c.late_due[i])
    return following


@part
def _keep(c: Carrier, size: int, due: int) -> None:
    """Keep an answer until it is due; without room it is lost."""
    for i in range(SLOTS):
        if c.late_due[i] == NEVER:
            for k in range(size):
                c.late_frame[i, k] = c.frame[k]
            for k in range(ADDRESS_ROOM):
                c.late_address[i, k] = c.address[k]
            c.late_size[i] = size
            c.late_due[i] = due
            return


@part
def _deliver(s: Arrays, c: Carrier, size: int, instant: int) -> None:
    """Send an answer by way of the faults that are switched on."""
    copies = 2 if _chance(s, s.switches[DUPLICATE]) else 1
    delay = int(1e9 * s.switches[DELAY])
    overtaken = _chance(s, s.switches[REORDER])
    for _ in range(copies):
        if overtaken:
            _keep(c, size, instant + delay + REORDER_NS)
        elif delay > 0:
            _keep(c, size, instant + delay)
        else:
            _send(c, c.frame, size, c.address)
    if not overtaken and s.switches[REORDER] > 0.0:
        for i in range(SLOTS):  # whatever waited to be overtaken has been
            if c.late_due[i] != NEVER and delay == 0:
                c.late_due[i] = instant


@part
def _handle(s: Arrays, c: Carrier, size: int, instant: int) -> None:
    """Answer one packet."""
    header = c.numbers[HEADER]
    if size < header:
        return
    if header:
        if (get8(c.frame, 12) << 8 | get8(c.frame, 13)) != ETHERTYPE:
            return
        c.frame[6] |= 2  # as every node marks the source of what has passed it
    time = max(_segment_time(c, instant - age(c.numbers[SOCKET], c.clock)), s.clock[LAST])
    lost = s.switches[BLACK_HOLE] > 0.0 or _chance(s, 0.5 * s.switches[DROP])
    came_back = not lost and answer(s, c.frame, header, size - header, time)
    if came_back and _chance(s, 0.5 * s.switches[DROP]):
        came_back, lost = False, True
    if lost:
        s.counters[LOST] += 1
    if came_back:
        _deliver(s, c, size, instant)


@kept
def run_loop(s: Arrays, c: Carrier) -> None:
    """Answer frames until told to stop.

    A frame counts from when the machine received it, not from when this thread got to it. So a
    thread that runs late is no late drive.
    """
    due = NEVER
    mails = s.clock[MAILS]
    c.numbers[START_MONOTONIC] = now(c.clock)
    c.numbers[START_CLOCK] = s.clock[LAST]
    while c.numbers[STOP] == 0:
        frozen = s.switches[FREEZE] > 0.0
        descriptor = -1 if frozen else c.numbers[SOCKET]
        wait_readable(descriptor, min(WAKE_NS, due - now(c.clock)), c.clock)
        for _ in range(_BURST):
            instant = now(c.clock)
            size = -1
            if not frozen:
                size = receive_from(descriptor, c.frame, c.address, c.address_size)
            if size < 0:
                # nothing older than `instant` is left unread
                catch_up(s, _segment_time(c, instant))
                break
            _handle(s, c, size, instant)
        if s.clock[MAILS] != mails:
            mails = s.clock[MAILS]
            raise_event(c.numbers[MAIL_EVENT], c.clock)
        due = _send_due(c, now(c.clock))
