"""A virtual drive in a process of its own, over UDP."""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator

import pytest

from motionlab.drive.virtual.process import VirtualDrive
from motionlab.errors import ConfigError
from tests.drive.virtual.bus import NODES, Bus, NoAnswer

PATIENCE = 5.0  # s


@pytest.fixture(scope="module")
def drive() -> Iterator[VirtualDrive]:
    if not os.environ.get("REALTIME_TESTS"):
        pytest.skip("runs in real time, which a loaded machine does not give: REALTIME_TESTS=1")
    with VirtualDrive() as running:
        yield running


def exchanging(drive: VirtualDrive, patience: float = PATIENCE) -> Callable[[bytes, int], bytes]:
    """Return a function that exchanges frames with a virtual drive in real time."""
    sending = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    sending.settimeout(patience)
    sending.connect((drive.address, drive.port))

    def exchange(payload: bytes, _: int) -> bytes:
        sending.send(payload)
        try:
            return sending.recv(2048)
        except TimeoutError:
            raise NoAnswer from None

    return exchange


def test_it_comes_to_op_and_answers_its_mail(drive: VirtualDrive) -> None:
    drive.switch(clear=True)
    bus = Bus(exchanging(drive))
    assert bus.count() == NODES
    bus.to_preop()
    assert bus.upload(3, 0x1008) == b"Virtual current drive"
    bus.to_op()
    bus.exchange_all()
    assert drive.status()["counters"]["malformed"] == 0


def test_it_falls_to_safeop_without_a_master(drive: VirtualDrive) -> None:
    bus = Bus(exchanging(drive))
    bus.to_op()
    time.sleep(0.1)
    assert bus.state(0) == (0x14, 0x1B)


def test_switches_act_while_it_runs(drive: VirtualDrive) -> None:
    bus = Bus(exchanging(drive, 0.2))
    assert drive.switch(link=2)["switches"] == {"link": 2.0}
    assert bus.count() == 2
    drive.switch(clear=True, black_hole=True)
    with pytest.raises(NoAnswer):
        bus.count()
    lost = drive.switch(clear=True)["counters"]["lost"]
    assert lost >= 1
    assert bus.count() == NODES
    drive.switch(delay=0.05)
    begin = time.monotonic()
    assert bus.count() == NODES
    assert time.monotonic() - begin >= 0.05
    drive.switch(clear=True)


@pytest.mark.parametrize(
    "wrong", [{"drop": 1.5}, {"nothing": 1}, {"fault": {"node": 7, "code": 1}}, {"delay": "a"}]
)
def test_switches_are_validated(drive: VirtualDrive, wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        drive.switch(**wrong)


def test_frames_that_waited_are_answered_after_a_freeze(drive: VirtualDrive) -> None:
    drive.switch(clear=True, freeze=True)
    waiting = Bus(exchanging(drive, 0.2))
    with pytest.raises(NoAnswer):
        waiting.count()
    drive.switch(clear=True)
    assert waiting.count() == NODES
