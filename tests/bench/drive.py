"""How a drive link keeps its time: 2 kHz against the virtual drive, beside timer and echo."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Generator, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import config_root
from motionlab.drive.faults import LINK_LOST
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
from motionlab.scripting.http_client import HeldLease, LabServer
from tests.bench.serving import API, Serving
from tests.bench.stream import watching
from tests.bench.table import Row

_SECONDS = 60.0
_SHORT_SECONDS = 20.0
_LOSS_SECONDS = 5.0
_WINDOWS = "18"  # of 4 s and a bit, of the clients
_WHAT_IF = {"scenario": "circle", "columns": ["A.x.following_error", "B.x.following_error"]}
_STALLS = 3  # rows that a machine which stood still may end
_PATIENCE = 300.0  # s; the loop may have to be compiled first
_LATE, _RUN, _TRIP, _CONTROL = 0.001, 10, 250.0, 5.0  # targets; us
_TABLES = {
    "variants.B.controller.model.x.force_map": "new-design",
    "variants.B.controller.model.y.force_map": "previous-design",
    "variants.B.controller.sharing.law": "force-per-ampere",
}
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


class _Held(NamedTuple):
    """What holding a position took; times of the control half, us."""

    timing: Timing
    control: float
    tabled: float
    longest: float
    how: str


def drive() -> Iterator[Row]:
    """Measure at rest, beside a busy process, under a server with clients, and without answers."""
    rest = yield from _rows("", _SECONDS)
    busy = subprocess.Popen([sys.executable, "-c", "while True: pass"])
    try:
        yield from _rows(", beside a busy process", _SHORT_SECONDS)
    finally:
        busy.kill()
        busy.wait()
    yield from _served(rest)
    for loss in _LOSSES:
        yield _lost(loss)


def _rows(beside: str, seconds: float) -> Generator[Row, None, Timing]:
    timer, echo = _timer(seconds / 3), _echo(seconds / 3)
    stalls = 0
    while (found := _held(seconds)) is None:
        stalls += 1
        if stalls == _STALLS:
            raise RuntimeError(f"the machine stood still for 10 ms in each of {stalls} rows")
    timing, control, tabled, longest, how = found
    if stalls:
        yield Row(
            "  rows ended by a machine that stood still for 10 ms", "0", str(stalls), met=False
        )
    yield from _timing_rows(
        f"{how}{beside}",
        timing,
        (f"bare timer {timer.share}", f"bare timer {timer.run}", f"bare echo {echo.times}"),
        timing.p50 / max(echo.p50, 1.0),
    )
    yield Row(
        "  control of both axes, p50/longest",
        f"< {_CONTROL:.0f} us",
        f"{control:.1f}/{longest:.0f} us",
        met=control < _CONTROL,
    )
    yield Row(
        "  with force maps and shares as tables, p50",
        f"< {_CONTROL:.0f} us",
        f"{tabled:.1f} us",
        met=tabled < _CONTROL,
    )
    yield Row("  timer wakes late p50/p99/p99.9", "", f"{timer.times} us")
    return timing


def _held(seconds: float) -> _Held | None:
    """Hold a position; None where the link was lost, since the machine slept."""
    with _holding() as (link, _):
        before, trips = _counters(link), link.round_trips
        control = _control_time(link, seconds)
        fault = link.fault()
        if fault is not None and fault.code == LINK_LOST:
            return None
        if link.state != State.HOLDING:
            raise RuntimeError(f"the link came to {link.state.name}: {fault}")
        cycles, late = _counters(link) - before
        run = link.status(Status.LATE_RUN)
        timing = Timing(int(cycles), int(late), run, *_of_histogram(link.round_trips - trips))
        longest = link.status(Status.CONTROL_TIME) * 1e-3
        how = "SCHED_FIFO" if link.status(Status.PRIORITY) else "SCHED_OTHER"
        link.load(held_parameters(on_drives(load_scenario("circle", _TABLES), "B")))
        tabled = _control_time(link, seconds / 6)
    return _Held(timing, control, tabled, longest, how)


def _control_time(link: DriveLink, seconds: float) -> float:
    """Return the median time of the control half, us."""
    times: list[int] = []
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        times.append(link.status(Status.CONTROL_LAST))
        time.sleep(0.01)
    return float(np.median(times)) * 1e-3


def _timing_rows(
    how: str, link: Timing, references: tuple[str, str, str], ratio: float
) -> Iterator[Row]:
    late, run, trip = references
    met = link.late <= _LATE * link.cycles
    yield Row(f"late cycles, {how}", f"<= {_LATE:.1%}", link.share, late, met=met)
    yield Row("  longest run of them", f"< {_RUN}", str(link.run), run, met=link.run < _RUN)
    yield Row(
        "  round trip p50/p99/p99.9",
        f"< {_TRIP:.0f} us",
        f"{link.times} us",
        trip,
        f"{ratio:.2f}",
        met=link.p999 < _TRIP,
    )


def _served(rest: Timing) -> Iterator[Row]:
    """Hold a position by a server that streams to 20 clients and answers one what-if on another."""
    with VirtualDrive(priority=79) as virtual, tempfile.TemporaryDirectory() as folder:
        shipped = (config_root() / "drives" / "virtual.toml").read_text(encoding="utf-8")
        file = Path(folder, "drive.toml")
        file.write_text(shipped.replace("port = 34980", f"port = {virtual.port}"), encoding="utf-8")
        with (
            Serving(MOTIONLAB_DRIVE=str(file), MOTIONLAB_DATA=folder) as server,
            HeldLease(LabServer(server.url), "bench") as lease,
        ):

            def status() -> dict[str, Any]:
                return server.client.get(f"{API}/drive").json()

            _await(lambda: status()["state"] == "ready" and status()["loop"]["phase_locked"])
            arm = {"scenario": "circle", "variant": "B", "confirm": True}
            server.client.post(f"{API}/drive/arm", json=arm, headers=lease.headers)
            _await(lambda: status()["state"] == "holding")
            session = server.post("/sessions", scenario="circle")["id"]
            asked = 0
            with watching(server, session, "--clients", "20", "--windows", _WINDOWS) as clients:
                end = time.monotonic() + _SECONDS + 1.0
                while time.monotonic() < end:
                    server.client.post(f"{API}/whatif", json=_WHAT_IF).raise_for_status()
                    asked += 1
                now = status()
                clients.terminate()
        if now["state"] != "holding":
            raise RuntimeError(f"the link came to {now['state']}: {now['fault']}")
    loop = now["loop"]
    recent = loop["recent"]  # the last minute
    times = (recent[name] * 1e6 if recent[name] else np.inf for name in ("p50", "p99", "p999"))
    timing = Timing(recent["cycles"], recent["late"], loop["late_run"], *times)
    yield from _timing_rows(
        f"20 clients, {asked / _SECONDS:.0f} what-ifs a second",
        timing,
        (f"at rest {rest.share}", f"at rest {rest.run}", f"at rest {rest.times}"),
        timing.p50 / max(rest.p50, 1.0),
    )


_LOSSES: dict[str, dict[str, Any]] = {
    "5 % of the frames lost": {"drop": 0.05},
    "a black hole": {"black_hole": True},
    "link down": {"link": 0},
    "frames wait unread": {"freeze": True},
    "a stopped peer": {},
}


def _lost(loss: str) -> Row:
    """Hold a position, then lose answers."""
    with _holding() as (link, virtual):
        before = link._shared.waits.copy()
        if switches := _LOSSES[loss]:
            virtual.switch(**switches)
        else:
            os.kill(virtual.pid, signal.SIGSTOP)
        time.sleep(_LOSS_SECONDS)
        fault = link.fault()
        waits = link._shared.waits - before
        os.kill(virtual.pid, signal.SIGCONT)
        virtual.switch(clear=True)
    p50, p99, p999 = _of_histogram(waits)
    after = f"{fault.name}, {fault.value:g} ms" if fault and fault.value else "holds on"
    return Row(
        f"bus time p50/p99/p99.9, {loss}",
        f"< {PERIOD / 1000:.0f} us",
        f"{p50:.0f}/{p99:.0f}/{p999:.0f} us",
        fault.name if fault and not fault.value else after,
        met=p999 < PERIOD / 1000,
    )


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


def _timer(seconds: float) -> Timing:
    cycles = round(seconds * 1e9 / PERIOD)
    late = np.zeros(cycles, np.int64)
    _wake(1, new_clock(), late)
    _in_real_time(80, lambda: _wake(cycles, new_clock(), late)).join()
    over = late > PERIOD
    edges = np.flatnonzero(np.diff(np.concatenate(([0], over, [0]))))
    run = int(np.max(edges[1::2] - edges[::2], initial=0))
    skipped = int((late[over] // PERIOD).sum())
    return Timing(cycles + skipped, skipped, run, *_quantiles(late))


def _echo(seconds: float) -> Timing:
    cycles = round(seconds * 1e9 / PERIOD)
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


def _of_histogram(counts: NDArray[np.int64]) -> tuple[float, float, float]:
    """Return p50, p99 and p99.9 of a histogram in us."""
    reached = np.cumsum(counts)
    p50, p99, p999 = (float(np.searchsorted(reached, q * reached[-1])) for q in (0.5, 0.99, 0.999))
    return p50, p99, p999


def _counters(link: DriveLink) -> NDArray[np.int64]:
    """Return how many cycles there have been, and how many were late."""
    return np.array([link.status(Status.CYCLES), link.status(Status.LATE)])


@contextlib.contextmanager
def _holding() -> Iterator[tuple[DriveLink, VirtualDrive]]:
    """Provide a link to a virtual drive that holds its position."""
    with VirtualDrive(priority=79) as virtual:
        config = default_drive()
        at = config.link.model_copy(update={"port": virtual.port})
        link = DriveLink(config.model_copy(update={"link": at}))
        try:
            _await(lambda: link.state == State.READY and link.status(Status.PHASE_LOCKED) == 1)
            link.load(held_parameters(on_drives(load_scenario("circle"), "B")))
            link.order(Order.ARM)
            _await(lambda: link.state in {State.HOLDING, State.FAULT})
            yield link, virtual
        finally:
            link.close()


def _await(condition: Callable[[], bool]) -> None:
    deadline = time.monotonic() + _PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            raise TimeoutError("the drives did not come to hold a position")
        time.sleep(0.01)
