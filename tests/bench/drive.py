"""How a drive link keeps its time: 2 kHz against the virtual drive, beside timer and echo."""

from __future__ import annotations

import contextlib
import os
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.drive.libc import (
    Clock,
    new_clock,
    now,
    part,
    receive,
    send,
    sleep_until,
    wait_readable,
)
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.memory import PERIOD
from motionlab.drive.link.shared import Order, State, Status
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.drive.virtual.process import VirtualDrive
from motionlab.drive.virtual.segment import default_drive
from tests.bench.table import Row

_SECONDS = 60.0
_REFERENCE_SECONDS = 30.0
_PATIENCE = 300.0  # s; the loop may have to be compiled first
_LATE, _RUN, _TRIP, _CONTROL = 0.001, 10, 250.0, 5.0  # targets; us
_PACKET = 150  # bytes, as frames of inputs are long


@dataclass
class Timing:
    """Cycles, how many were late, the longest run of these, and times of each, us."""

    cycles: int
    late: int
    run: int
    p50: float
    p99: float
    p999: float

    @property
    def share(self) -> str:
        """Of late cycles."""
        return f"{self.late / self.cycles:.3%}"

    @property
    def times(self) -> str:
        """In the order of their names."""
        return f"{self.p50:.0f}/{self.p99:.0f}/{self.p999:.0f}"


def drive() -> Iterator[Row]:
    """Measure at rest, then beside a process that keeps a core busy."""
    yield from _rows("")
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield from _rows(", beside a busy process")
    finally:
        busy.kill()
        busy.wait()


def _rows(beside: str) -> Iterator[Row]:
    timer, echo = _timer(), _echo()
    link, control, longest, priority = _link()
    how = "SCHED_FIFO" if priority else "SCHED_OTHER"
    yield Row(
        f"late cycles, {how}{beside}",
        f"<= {_LATE:.1%}",
        link.share,
        f"bare timer {timer.share}",
        met=link.late <= _LATE * link.cycles,
    )
    yield Row(
        "  longest run of them",
        f"< {_RUN}",
        str(link.run),
        f"bare timer {timer.run}",
        met=link.run < _RUN,
    )
    yield Row(
        "  round trip p50/p99/p99.9",
        f"< {_TRIP:.0f} us",
        f"{link.times} us",
        f"bare echo {echo.times}",
        f"{link.p50 / max(echo.p50, 1.0):.2f}",
        met=link.p999 < _TRIP,
    )
    yield Row(
        "  control of both axes, p50/longest",
        f"< {_CONTROL:.0f} us",
        f"{control:.1f}/{longest:.0f} us",
        met=control < _CONTROL,
    )
    yield Row("  timer wakes late p50/p99/p99.9", "", f"{timer.times} us")


@part
def _wake(cycles: int, clock: Clock, late: NDArray[np.int64]) -> None:
    """Sleep until each period begins; note how late it was, ns."""
    following = now(clock) + PERIOD
    for k in range(cycles):
        sleep_until(following, clock)
        late[k] = now(clock) - following
        following += PERIOD * (1 + max(late[k], 0) // PERIOD)


@part
def _ask(
    descriptor: int, cycles: int, packet: NDArray[np.uint8], clock: Clock, took: NDArray[np.int64]
) -> None:
    """Send a packet each period and wait for its echo; note how long that took, ns."""
    following = now(clock) + PERIOD
    for k in range(cycles):
        sleep_until(following, clock)
        begun = now(clock)
        send(descriptor, packet, packet.size)
        while receive(descriptor, packet) < 0:
            if not wait_readable(descriptor, PERIOD, clock):
                break
        took[k] = now(clock) - begun
        following += PERIOD * (1 + max(now(clock) - following, 0) // PERIOD)


@part
def _answer(descriptor: int, packet: NDArray[np.uint8], clock: Clock) -> None:
    """Echo packets until none comes for a second."""
    while wait_readable(descriptor, 1_000_000_000, clock):
        if receive(descriptor, packet) == packet.size:
            send(descriptor, packet, packet.size)


def _in_real_time(priority: int, task: Callable[[], Any]) -> threading.Thread:
    """Start a thread under SCHED_FIFO where that is permitted."""

    def run() -> None:
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
        task()

    thread = threading.Thread(target=run)
    thread.start()
    return thread


def _timer() -> Timing:
    cycles = round(_REFERENCE_SECONDS * 1e9 / PERIOD)
    late = np.zeros(cycles, np.int64)
    _wake(1, new_clock(), late)
    _in_real_time(80, lambda: _wake(cycles, new_clock(), late)).join()
    over = late > PERIOD
    edges = np.flatnonzero(np.diff(np.concatenate(([0], over, [0]))))
    run = int(np.max(edges[1::2] - edges[::2], initial=0))
    skipped = int((late[over] // PERIOD).sum())
    return Timing(cycles + skipped, skipped, run, *_quantiles(late))


def _echo() -> Timing:
    cycles = round(_REFERENCE_SECONDS * 1e9 / PERIOD)
    took = np.zeros(cycles, np.int64)
    near, far = (socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2))
    with near, far:
        for end in (near, far):
            end.bind(("127.0.0.1", 0))
        near.connect(far.getsockname())
        far.connect(near.getsockname())
        packets = np.zeros((2, _PACKET), np.uint8)
        _ask(near.fileno(), 0, packets[0], new_clock(), took)
        _answer(-1, packets[1], new_clock(1))
        answering = _in_real_time(79, lambda: _answer(far.fileno(), packets[1], new_clock()))
        _in_real_time(80, lambda: _ask(near.fileno(), cycles, packets[0], new_clock(), took)).join()
        answering.join()
    return Timing(cycles, 0, 0, *_quantiles(took))


def _quantiles(times: NDArray[np.int64]) -> tuple[float, float, float]:
    p50, p99, p999 = (np.quantile(times, (0.5, 0.99, 0.999)) * 1e-3).tolist()
    return p50, p99, p999


def _link() -> tuple[Timing, float, float, int]:
    """Return timing of the loop while it holds a position, and its control half's times, us."""
    with VirtualDrive(priority=79) as virtual:
        config = default_drive()
        at = config.link.model_copy(update={"port": virtual.port})
        link = DriveLink(config.model_copy(update={"link": at}))
        try:
            _await(lambda: link.state == State.READY and link.status(Status.PHASE_LOCKED) == 1)
            link.load(held_parameters(on_drives(load_scenario("circle"), "B")))
            link.order(Order.ARM)
            _await(lambda: link.state in {State.HOLDING, State.FAULT})
            cycles, late = link.status(Status.CYCLES), link.status(Status.LATE)
            trips = link.round_trips
            control = []
            end = time.monotonic() + _SECONDS
            while time.monotonic() < end:
                control.append(link.status(Status.CONTROL_LAST))
                time.sleep(0.01)
            cycles = link.status(Status.CYCLES) - cycles
            late = link.status(Status.LATE) - late
            trips = np.cumsum(link.round_trips - trips)
            if link.state != State.HOLDING:
                told = link.fault() or link.problem
                raise RuntimeError(f"the link came to {link.state.name}: {told}")
            p50, p99, p999 = (
                float(np.searchsorted(trips, q * trips[-1])) for q in (0.5, 0.99, 0.999)
            )
            timing = Timing(cycles, late, link.status(Status.LATE_RUN), p50, p99, p999)
            longest = link.status(Status.CONTROL_TIME) * 1e-3
            return timing, float(np.median(control)) * 1e-3, longest, link.status(Status.PRIORITY)
        finally:
            link.close()


def _await(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + _PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError("the drives did not come to hold a position")
        time.sleep(0.01)
