"""The loop never waits past its deadline, whatever its peer does: on a clock of the test's own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.drive import faults
from motionlab.drive.link import bus, cycle
from motionlab.drive.link.memory import PERIOD
from motionlab.drive.link.shared import Command, Figure, Order, State, Status
from tests.drive.link.lockstep import Lockstep

CYCLES = 400
CALL = 500
"""ns that any call of the operating system takes."""
TRIP = 60_000
"""ns from a frame to its answer."""
NEVER = 1 << 62


def frozen(frame: int) -> int:
    """Answer the frames of 100 cycles all at once."""
    return TRIP + (400 - frame) // 2 * PERIOD if 200 <= frame < 400 else TRIP


def lossy(frame: int) -> int:
    """Lose 5 %."""
    return NEVER if frame * 48_271 % 2_147_483_647 % 20 == 0 else TRIP


class Network:
    """Clock and socket of the loop, and the drives behind them.

    Parameters
    ----------
    loop : Lockstep
        Drives that move.
    delay : callable
        Time from a frame, by its number, to its answer, ns; `NEVER` where it is lost.
    junk : int
        Interval of packets that answer nothing, ns.
    """

    def __init__(self, loop: Lockstep, delay: Callable[[int], int], junk: int) -> None:
        self.loop, self.delay, self.junk = loop, delay, junk
        self.time = loop.now
        self.end = loop.now + 2 * CYCLES * PERIOD
        self.cycles = self.frames = 0
        self.under_way: list[tuple[int, bytes]] = []
        self.following = self.time + junk

    def now(self, clock: object = None) -> int:
        self.time += CALL
        assert self.time < self.end, "the loop does not end a cycle"
        return self.time

    def sleep_until(self, instant: int, clock: object) -> None:
        """Begin a cycle; order to quit with the last."""
        self.time = max(self.time, instant)
        self.cycles += 1
        command = self.loop.shared.command
        command[Command.HEARTBEAT] = self.time
        if self.cycles == CYCLES:
            command[Command.ORDER] = Order.QUIT
            command[Command.SEQUENCE] += 1

    def send(self, descriptor: int, data: NDArray[np.uint8], count: int) -> bool:
        now = self.now()
        delay = self.delay(self.frames)
        self.frames += 1
        if delay < NEVER:
            answer = self.loop.segment.exchange(bytes(data[:count]), now)
            assert answer is not None
            self.under_way.append((now + delay, answer))
        return True

    def receive(self, descriptor: int, data: NDArray[np.uint8]) -> int:
        now = self.now()
        packet = b""
        due = min((due for due, _ in self.under_way[:1]), default=NEVER)
        if self.following <= min(due, now):
            self.following += self.junk
            packet = bytes(64)
        elif due <= now:
            _, packet = self.under_way.pop(0)
        data[: len(packet)] = np.frombuffer(packet, np.uint8)
        return len(packet) or -1

    def wait_readable(self, descriptor: int, nanoseconds: int, clock: object) -> bool:
        now = self.now()
        coming = min(self.following, *(due for due, _ in self.under_way[:1]), NEVER)
        self.time = max(now, min(coming, now + max(nanoseconds, 0)))
        return coming <= self.time


def plain(function: Any) -> Any:
    """Return a function as Python runs it, with the present names of its module."""
    return getattr(function, "py_func", function)


@pytest.mark.parametrize(
    ("delay", "junk", "ends"),
    [
        (lambda _: TRIP, NEVER, State.MOVING),
        (lambda _: NEVER, NEVER, State.FAULT),
        (lambda _: 7 * PERIOD // 10, NEVER, State.FAULT),
        (frozen, NEVER, State.FAULT),
        (lossy, NEVER, State.MOVING),
        (lambda _: TRIP, CALL // 2, State.FAULT),
    ],
    ids=["answers", "no answer", "late answers", "frozen", "5 % loss", "a flood of packets"],
)
def test_no_cycle_waits_past_its_deadline(
    monkeypatch: pytest.MonkeyPatch, delay: Callable[[int], int], junk: int, ends: State
) -> None:
    loop = Lockstep()
    loop.moving()
    network = Network(loop, delay, junk)
    for module in (bus, cycle):
        monkeypatch.setattr(module, "now", network.now)
    for name in ("send", "receive", "wait_readable"):
        monkeypatch.setattr(bus, name, getattr(network, name))
    monkeypatch.setattr(cycle, "sleep_until", network.sleep_until)
    for name in ("read_inputs", "write_outputs", "machine_time", "_next_period"):
        monkeypatch.setattr(cycle, name, plain(getattr(cycle, name)))
    polling = loop.bus._replace(spin=bus.SPIN)
    assert plain(cycle.run)(polling, loop.layout, loop.shared, loop.memory) == cycle.QUITTING

    status = loop.shared.status
    assert network.cycles == CYCLES
    assert status[Status.LATE] == 0  # no cycle ended after the next should have begun
    longest = np.flatnonzero(loop.shared.waits).max() * 1000
    assert longest <= cycle.ANSWER + 10 * CALL
    assert loop.state == ends
    if ends == State.FAULT:
        assert loop.fault == (faults.LINK_LOST, 0)
        assert loop.shared.figures[Figure.FAULT_VALUE] == pytest.approx(0.010)
        assert loop.without_torque()
    else:
        assert (status[Status.MISSED] > 0) == (delay is lossy)
