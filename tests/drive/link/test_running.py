"""Loop and drives in processes of their own: what must hold while they run."""

from __future__ import annotations

import contextlib
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator

import pytest

from motionlab.drive import faults
from motionlab.drive.link import link
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Order, State, Status
from motionlab.drive.virtual.process import VirtualDrive
from tests.drive.link.rig import PATIENCE, SLOW, Rig, linked, pid_of
from tests.processes import runs

pytestmark = pytest.mark.realtime

SERVER = """
import sys
from tests.drive.link.rig import Rig
rig = Rig()
rig.drive.port, rig.drive.control_port = int(sys.argv[1]), int(sys.argv[2])
rig.attach()
rig.moving()
print(rig.link._process.pid, flush=True)
sys.stdin.read()
"""


@pytest.fixture
def fresh() -> Iterator[Rig]:
    with Rig() as running:
        yield running


def de_energised(drive: VirtualDrive) -> bool:
    """Return whether every drive has let go, and its current is zero."""
    nodes = drive.status()["nodes"]
    return all(n["status_word"] & 0x6F != 0x27 and n["current"] == 0.0 for n in nodes)


def waited(condition: Callable[[], bool]) -> bool:
    """Return whether something holds before patience ends."""
    deadline = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.01)
    return True


@pytest.mark.parametrize("loss", ["drop", "black_hole", "freeze", "link", "stopped"])
def test_the_loop_never_waits_for_its_peer(rig: Rig, loss: str) -> None:
    rig.ready()
    if loss == "stopped":
        os.kill(rig.drive.pid, signal.SIGSTOP)
    else:
        rig.drive.switch(**{loss: {"drop": 0.05, "link": 0}.get(loss, True)})
    try:
        cycles, begun = rig.link.status(Status.CYCLES), time.monotonic()
        time.sleep(1.0)
        passed = rig.link.status(Status.CYCLES) - cycles
        expected = (time.monotonic() - begun) / (0.5e-3 * SLOW)
    finally:
        os.kill(rig.drive.pid, signal.SIGCONT)
        rig.drive.switch(clear=True)
    # A loop that waited for answers would do a few cycles a second; periods that the machine
    # did not give are not made up as cycles.
    assert 0.8 * expected < passed < 1.02 * expected
    assert (rig.link.state == State.FAULT) == (loss != "drop") or loss == "drop"


def test_unplugged_in_motion_it_stops_and_moves_only_after_reset_and_arm(rig: Rig) -> None:
    motion = rig.moving()
    rig.drive.switch(black_hole=True)
    rig.until(State.FAULT)
    fault = rig.link.fault()
    assert fault is not None
    assert fault.code in {faults.LINK_LOST, faults.LEFT_OPERATION}
    assert fault.remedy
    assert waited(lambda: de_energised(rig.drive))
    rig.take(motion)
    assert motion.stopped
    assert motion.fault == fault
    assert 1500 < motion.tick < motion.prepared.reference.ticks

    rig.drive.switch(clear=True)
    time.sleep(0.2 * SLOW)
    assert rig.link.state == State.FAULT
    assert de_energised(rig.drive)
    with pytest.raises(LinkError, match="while the link is fault"):
        rig.link.order(Order.ARM)
    with pytest.raises(LinkError, match="while the link is fault"):
        rig.motion()
    rig.link.order(Order.RESET)
    rig.until(State.READY)
    assert motion.fault == fault  # a reset does not make it well
    assert de_energised(rig.drive)
    rig.ready()
    rig.arm()


def test_while_the_link_is_down_a_reset_says_why_it_fails(rig: Rig) -> None:
    rig.ready()
    rig.drive.switch(black_hole=True)
    rig.until(State.FAULT)
    rig.link.order(Order.RESET)
    rig.wait(lambda: "no answer" in rig.link.problem, "told")
    rig.until(State.OFFLINE)
    with pytest.raises(LinkError, match="while the link is offline"):
        rig.link.order(Order.ARM)
    rig.ready()
    assert rig.link.problem == ""


def test_stop_brakes_a_motion_and_ends_it(rig: Rig) -> None:
    motion = rig.moving()
    rig.link.stop()
    rig.until(State.READY)
    assert rig.link.fault() is None
    samples = rig.take(motion)
    assert motion.stopped
    assert motion.fault is None
    assert len(samples) == motion.tick < motion.prepared.reference.ticks
    assert waited(lambda: de_energised(rig.drive))


def test_the_loop_killed_in_motion_leaves_the_drives_to_their_watchdog(fresh: Rig) -> None:
    motion = fresh.moving()
    os.kill(pid_of(fresh.link), signal.SIGKILL)
    assert waited(lambda: de_energised(fresh.drive))
    fresh.take(motion)
    assert motion.stopped
    assert fresh.link.state == State.OFFLINE
    with pytest.raises(LinkError, match="has ended"):
        fresh.link.order(Order.RESET)
    fresh.wait(lambda: "has ended" in fresh.link.problem, "told")
    assert all(node["al_state"] & 0x0F == 4 for node in fresh.drive.status()["nodes"])


def test_closed_in_motion_it_stops_first_and_leaves_the_drives_in_init(fresh: Rig) -> None:
    fresh.moving()
    loop = pid_of(fresh.link)
    fresh.link.close()
    assert not runs(loop)
    assert de_energised(fresh.drive)
    assert all(node["al_state"] == 1 for node in fresh.drive.status()["nodes"])


def test_a_loop_that_hangs_is_ended_by_close(fresh: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link, "_END_TIMEOUT", 1.0)
    fresh.moving()
    loop = pid_of(fresh.link)
    os.kill(loop, signal.SIGSTOP)
    assert waited(lambda: de_energised(fresh.drive))
    with pytest.raises(LinkError, match="does not answer"):
        fresh.link.order(Order.DISARM)
    fresh.link.close()
    assert not runs(loop)


def test_a_server_killed_in_motion_leaves_drives_that_stop_by_themselves() -> None:
    with VirtualDrive(priority=70, slow=SLOW) as drive:
        command = [sys.executable, "-c", SERVER, str(drive.port), str(drive.control_port)]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as server:
            assert server.stdout is not None
            loop = int(server.stdout.readline())
            assert not de_energised(drive)
            server.kill()
        try:
            assert waited(lambda: de_energised(drive))
            assert waited(lambda: not runs(loop))
        finally:
            with contextlib.suppress(ProcessLookupError):
                os.kill(loop, signal.SIGKILL)
        nodes = drive.status()["nodes"]
        assert all(node["al_state"] == 1 and not node["error_code"] for node in nodes)


def test_a_wrong_identity_enables_nothing() -> None:
    with VirtualDrive(slow=SLOW) as drive:
        config = linked(drive)
        nodes = list(config.nodes)
        nodes[3] = nodes[3].model_copy(update={"product": 0x5002})
        link = DriveLink(config.model_copy(update={"nodes": tuple(nodes)}))
        try:
            assert waited(lambda: bool(link.problem))
            assert "nodes.3.product: drive 4 is 0x5001, 0x5002 expected" in link.problem
            assert link.state == State.OFFLINE
            assert all(node["al_state"] == 1 for node in drive.status()["nodes"])
        finally:
            link.close()
