"""The process of the loop: ``python -m motionlab.drive.link.process MEMORY REPORT``.

It brings the drives up, runs the compiled loop, and brings them up again when a person resets a
lost link. What it does is written to the pipe REPORT, a line of JSON each; MEMORY is the shared
memory. Both are descriptors that it inherits.
"""

from __future__ import annotations

import contextlib
import ctypes
import gc
import json
import os
import select
import signal
import sys
import time
from typing import Any

import numpy as np

from motionlab.config.drive import PHASES, DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.libc import new_clock
from motionlab.drive.link.bring_up import BringUp
from motionlab.drive.link.bus import SPIN, Bus, cyclic_bus
from motionlab.drive.link.carrier import Carrier, LinkError
from motionlab.drive.link.cycle import BRING_UP, GONE, HEARTBEAT, QUITTING, RESETTING, run
from motionlab.drive.link.memory import Count, Layout, new_memory
from motionlab.drive.link.shared import (
    TEST_BEYOND,
    TEST_CURRENT,
    TEST_SPEED,
    Command,
    Order,
    Shared,
    State,
    Status,
    attach,
)
from motionlab.timing import CONTROL_PERIOD

_LOCK_ALL = 1 | 2  # MCL_CURRENT, MCL_FUTURE
_POLL = 0.05  # s, while there is no link
_SECOND = 1_000_000_000
_PR_SET_TIMERSLACK = 29


def main(memory: int, report: int, config: DriveConfig) -> None:
    """Serve one link until an order to quit, or until its server is silent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # a terminal's Ctrl-C is for the server
    shared = attach(memory)
    loop = Loop(config, shared, report)
    compile_loop(config)  # before drives wait for it
    loop.serve()


class Loop:
    """Bring-up and loop of one link, which reports on a pipe, a descriptor, what it does."""

    def __init__(self, config: DriveConfig, shared: Shared, report: int) -> None:
        self._config = config
        self._shared = shared
        self._report = report
        self._memory = new_memory()
        self._carrier: Carrier | None = None
        self._server = select.poll()
        self._server.register(report, 0)  # POLLERR comes unasked, once the pipe has no reader

    def serve(self) -> None:
        """Keep the link up until an order or a silent commander ends it."""
        _prepare_real_time(self._config.link.priority, self._shared)
        gc.collect()  # later, between OP and the first period, it would outlast the watchdog
        gc.freeze()
        gc.disable()
        try:
            while True:
                drives = self._brought_up()
                if drives is None:
                    return
                reason = self._cycle(drives)
                if reason in {QUITTING, GONE}:
                    if reason == GONE:
                        self._tell(
                            problem=f"the server was silent for {HEARTBEAT / _SECOND:g} s: the "
                            "drives were stopped and the drive loop has ended; reset begins it anew"
                        )
                    drives.shut_down()
                    return
        finally:
            if self._carrier is not None:
                self._carrier.close()

    def _brought_up(self) -> BringUp | None:
        """Return a bus in OP; None after an order to quit."""
        while True:
            drives: BringUp | None = None
            try:
                if self._carrier is None:
                    self._carrier = Carrier(self._config.link)
                drives = BringUp(self._carrier, self._config)
                self._tell(step="finding drives")
                drives.bring_up()
            except LinkError as error:
                # The next try has a new socket: without an answer the card may have gone.
                if self._carrier is not None:
                    self._carrier.close()
                    self._carrier = None
                answers = [one._asdict() for one in drives.answers] if drives else []
                self._tell(problem=str(error), answers=answers)
                if not self._wait_for_reset():
                    return None
                continue
            identities = [
                drive._asdict() | {"limits": [limit._asdict() for limit in drive.limits]}
                for drive in drives.identities
            ]
            self._tell(step="operational", identities=identities, steps=drives.steps)
            return drives

    def _cycle(self, drives: BringUp) -> int:
        """Run the compiled loop on drives in OP, and return why it ended.

        It is ready with its first inputs: until then nothing is known of the positions.
        """
        assert self._carrier is not None
        shared, status = self._shared, self._shared.status
        link = self._config.link
        bus = cyclic_bus(
            self._carrier.socket.fileno(),
            self._carrier.header,
            new_clock(link.slow),
            clocks=link.distributed_clocks,
            spin=SPIN if len(os.sched_getaffinity(0)) > 1 else 0,
        )
        layout = layout_of(self._config, drives.sync_start)
        status[Status.FAULT] = 0
        status[Status.PHASE_LOCKED] = 0
        reason = run(bus, layout, shared, self._memory)
        if reason == BRING_UP:
            status[Status.STATE] = State.OFFLINE
        return reason

    def _wait_for_reset(self) -> bool:
        """Wait for an order to try again; false when it is to end.

        Without drives a server that is silent for long does no harm; one that is gone ends it.
        """
        command, status = self._shared.command, self._shared.status
        status[Status.STATE] = State.OFFLINE
        while True:
            if self._server.poll(0):
                return False
            if command[Command.SEQUENCE] != status[Status.DONE]:
                order = command[Command.ORDER]
                status[Status.REFUSED] = order not in {Order.RESET, Order.QUIT}
                status[Status.DONE] = command[Command.SEQUENCE]
                if order in {Order.RESET, Order.QUIT}:
                    self._memory.count[Count.RESETTING] = RESETTING
                    return order == Order.RESET
            time.sleep(_POLL)

    def _tell(self, **facts: Any) -> None:
        line = json.dumps({"time": time.time(), **facts}) + "\n"
        with contextlib.suppress(OSError):
            os.write(self._report, line.encode())


def layout_of(config: DriveConfig, sync_start: int) -> Layout:
    """Return what the compiled loop needs of a configuration."""
    axes = [getattr(config, axis) for axis in AXES]
    link = config.link

    def both(name: str, kind: Any = np.float64) -> Any:
        return np.array([getattr(axis, name) for axis in axes], kind)

    return Layout(
        axis=np.array([AXES.index(node.axis) for node in config.nodes]),
        phase=np.array([PHASES.index(node.phase) for node in config.nodes]),
        rated=np.array([node.rated_current for node in config.nodes]),
        encoder=both("encoder", np.int64) - 1,  # counted from 1 in the file
        resolution=both("resolution") * both("direction"),
        offset=both("offset"),
        position_min=both("position_min"),
        position_max=both("position_max"),
        velocity_max=both("velocity_max"),
        deceleration=both("deceleration"),
        window=both("following_error"),
        window_cycles=np.rint(both("following_error_time") / CONTROL_PERIOD).astype(np.int64),
        current_max=both("current_max"),
        test_current=TEST_CURRENT * both("current_max"),
        test_velocity=TEST_SPEED * both("velocity_max"),
        test_travel=both("position_max") - both("position_min") + TEST_BEYOND,
        loss_cycles=round(link.loss / CONTROL_PERIOD),
        clocks=int(link.distributed_clocks),
        sync_start=sync_start,
        sync_shift=round(link.sync_shift * 1e9),
    )


def compile_loop(config: DriveConfig) -> None:
    """Compile the loop, or load it from the cache, by leaving it at once, over a silent socket."""
    import socket  # noqa: PLC0415 - for this alone

    from motionlab.drive.link import shared as memory  # noqa: PLC0415

    descriptor = memory.create()
    arrays = attach(descriptor)
    os.close(descriptor)
    arrays.command[Command.ORDER] = Order.QUIT
    arrays.command[Command.SEQUENCE] = 1
    arrays.command[Command.HEARTBEAT] = time.monotonic_ns() + _SECOND
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)
    with near, far:
        bus: Bus = cyclic_bus(near.fileno(), b"", new_clock(), clocks=True)
        run(bus, layout_of(config, 0), arrays, new_memory())


def _prepare_real_time(priority: int, shared: Shared) -> None:
    """Ask for SCHED_FIFO and locked memory; what was granted is in the status."""
    libc = ctypes.CDLL(None, use_errno=True)
    shared.status[Status.MEMORY_LOCKED] = libc.mlockall(_LOCK_ALL) == 0
    libc.prctl(_PR_SET_TIMERSLACK, 1, 0, 0, 0)
    if priority:
        with contextlib.suppress(PermissionError):
            os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(priority))
            shared.status[Status.PRIORITY] = priority


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]), DriveConfig.model_validate_json(sys.stdin.read()))
