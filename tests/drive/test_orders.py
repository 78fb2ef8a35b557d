"""Orders that are overtaken: by a stop, by the end of control, by other orders."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.drive.faults import LINK_LOST
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.memory import latch
from motionlab.drive.link.shared import Figure, Order, State, Status
from motionlab.drive.motion import DriveMotion, on_drives
from motionlab.drive.plug import drives as service
from motionlab.drive.plug.drives import Drives
from motionlab.drive.virtual.segment import default_drive
from motionlab.server.live import sessions
from motionlab.simulation.prepare import prepare
from tests.drive.link.lockstep import Lockstep
from tests.drive.link.step_rig import LockstepLink

Test = Callable[[Drives, Lockstep], Coroutine[Any, Any, None]]
SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.5}


@pytest.fixture
def loop() -> Lockstep:
    return Lockstep()


@pytest.fixture
def run(loop: Lockstep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[Test], None]:
    """Return what runs a test with drives in lockstep."""
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    monkeypatch.setattr(service, "DriveLink", lambda _config: LockstepLink(loop))
    monkeypatch.setattr(service, "_WATCH", 0.01)

    async def go(test: Test) -> None:
        drives = Drives(default_drive())
        await test(drives, loop)
        drives._watching.cancel()

    return lambda test: asyncio.run(go(test))


async def _stop(drives: Drives, _: str) -> None:
    drives.stop()


async def _give_up(drives: Drives, token: str) -> None:
    drives.give_up(token)


async def _fall_silent(drives: Drives, _: str) -> None:
    drives.lease.end()
    while drives.lease.holder:
        await asyncio.sleep(0.01)


async def _disarm(drives: Drives, token: str) -> None:
    await drives.order(Order.DISARM, token)


@pytest.mark.parametrize("overtake", [_stop, _give_up, _fall_silent, _disarm])
def test_arming_is_overtaken(
    run: Callable[[Test], None], overtake: Callable[[Drives, str], Coroutine[Any, Any, None]]
) -> None:
    async def test(drives: Drives, loop: Lockstep) -> None:
        token = drives.lease.take("me")
        here = asyncio.get_running_loop()

        def load() -> Scenario:  # while it takes its time
            asyncio.run_coroutine_threadsafe(overtake(drives, token), here).result()
            return load_scenario("circle")

        with pytest.raises(LinkError, match="there was a STOP"):
            await drives.arm(load, "A", token)
        loop.cycle(50)
        assert loop.state == State.READY

    run(test)


def test_one_order_with_torque_at_a_time(run: Callable[[Test], None]) -> None:
    async def test(drives: Drives, _: Lockstep) -> None:
        token = drives.lease.take("me")
        here = asyncio.get_running_loop()

        async def others() -> None:
            for other in (
                drives.arm(lambda: load_scenario("circle"), "B", token),
                drives.do_step("drives"),
                drives.reset(token),
            ):
                with pytest.raises(LinkError, match="not possible while torque is switched on"):
                    await other

        def load() -> Scenario:
            asyncio.run_coroutine_threadsafe(others(), here).result()
            return load_scenario("circle")

        await drives.arm(load, "A", token)
        drives.check_free()

    run(test)


def test_torque_without_a_lease_is_stopped(run: Callable[[Test], None]) -> None:
    async def test(drives: Drives, loop: Lockstep) -> None:
        loop.arm()
        await asyncio.sleep(0.05)
        loop.cycle(200)
        assert loop.state == State.READY
        stopped = drives._history.stopped
        assert stopped is not None
        assert stopped.cause == "no one in control"

    run(test)


def test_a_watch_that_fails_goes_on(
    run: Callable[[Test], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    async def test(drives: Drives, loop: Lockstep) -> None:
        def fail() -> None:
            raise KeyError(0)

        monkeypatch.setattr(drives._history, "note", fail)
        drives.lease.take("me")
        await asyncio.sleep(0.05)
        loop.arm()
        drives.lease.end()
        await asyncio.sleep(0.05)
        loop.cycle(200)
        assert loop.state == State.READY

    run(test)


def _motion(link: LockstepLink, number: int = 1) -> DriveMotion:
    return DriveMotion(prepare(on_drives(load_scenario("circle", SHORT), "B")), link, number)


def test_a_motion_does_not_begin_after_a_stop(loop: Lockstep) -> None:
    link = LockstepLink(loop)
    loop.arm()
    stops, motion = link.stops, _motion(link)
    link.stop()
    loop.cycle(200)
    loop.arm()  # somebody else
    with pytest.raises(LinkError, match="there was a STOP"):
        motion.begin(stops)
    loop.cycle(10)
    assert loop.state == State.HOLDING
    motion.begin(link.stops)
    assert loop.state == State.MOVING


def test_a_motion_begins_where_the_drives_hold(loop: Lockstep) -> None:
    link = LockstepLink(loop)
    loop.arm()
    reference = np.zeros((100, 3, 2))
    reference[:, 0] = link.figure(Figure.REFERENCE)
    reference[:, 0, 1] += 1e-4
    with pytest.raises(LinkError, match=r"begins 0\.100 mm from where the drives hold"):
        link.start(reference, 0, 1)
    assert loop.state == State.HOLDING


def test_a_fault_that_is_reset_while_it_is_read(loop: Lockstep) -> None:
    latch(loop.shared, LINK_LOST, 0, 0.0, 0.0)
    loop.shared.status[Status.FAULT] = 0
    assert LockstepLink(loop).fault() is None


def test_a_motion_that_no_one_watches_makes_room_for_no_other_session() -> None:
    running = Mock(listeners=0, touched=0.0, drive="Virtual drive", runs=True)
    ended = Mock(listeners=0, touched=0.0, drive="Virtual drive", runs=False)
    simulated = Mock(listeners=0, touched=0.0, drive="", runs=True)
    assert [sessions._idle(each, 90.0) for each in (running, ended, simulated)] == [0.0, 90.0, 90.0]
