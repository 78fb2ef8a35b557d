"""A virtual drive in a process of its own, over UDP."""

from __future__ import annotations

import socket
import struct
import time
from collections.abc import Iterator

import pytest

from motionlab.drive.ethercat import OP, REGISTER_WATCHDOG_PROCESS_DATA, SAFEOP
from motionlab.drive.virtual.process import VirtualDrive
from motionlab.errors import ConfigError
from tests.drive.virtual.bus import NODES, Bus, NoAnswer

PATIENCE = 5.0  # s
WATCHDOG = 0.1  # s, the longest that the drives take: this master is slow


@pytest.fixture(scope="module")
def running() -> Iterator[VirtualDrive]:
    with VirtualDrive() as drive:
        yield drive


@pytest.fixture
def drive(running: VirtualDrive) -> VirtualDrive:
    running.switch(clear=True)
    return running


@pytest.fixture
def line(drive: VirtualDrive) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.settimeout(PATIENCE)
        line.connect((drive.address, drive.port))
        yield line


@pytest.fixture
def bus(line: socket.socket) -> Bus:
    """Return a master in real time."""

    def exchange(payload: bytes, _: int) -> bytes:
        line.send(payload)
        try:
            return line.recv(2048)
        except TimeoutError:
            raise NoAnswer from None

    bus = Bus(exchange)
    bus.address()
    for node in range(NODES):
        ticks = round(WATCHDOG / 100e-6)
        bus.write(node, REGISTER_WATCHDOG_PROCESS_DATA, struct.pack("<H", ticks))
    return bus


def test_it_comes_to_op_and_answers_its_mail(drive: VirtualDrive, bus: Bus) -> None:
    assert bus.count() == NODES
    bus.to_preop()
    assert bus.upload(3, 0x1008) == b"Virtual current drive"
    bus.to_op()
    bus.exchange_all()
    assert drive.status()["counters"]["malformed"] == 0


def test_it_falls_to_safeop_without_a_master(bus: Bus) -> None:
    bus.to_op()
    assert bus.state(0) == (OP, 0)
    time.sleep(1.5 * WATCHDOG)
    assert bus.state(0) == (SAFEOP | 0x10, 0x1B)


def test_a_link_that_is_out_hides_the_drives_behind_it(drive: VirtualDrive, bus: Bus) -> None:
    assert drive.switch(link=2)["switches"] == {"link": 2.0}
    assert bus.count() == 2
    drive.switch(clear=True)
    assert bus.count() == NODES


def test_frames_are_lost_in_a_black_hole(
    drive: VirtualDrive, bus: Bus, line: socket.socket
) -> None:
    drive.switch(black_hole=True)
    line.settimeout(0.2)
    with pytest.raises(NoAnswer):
        bus.count()
    assert drive.switch(clear=True)["counters"]["lost"] >= 1
    line.settimeout(PATIENCE)
    assert bus.count() == NODES


def test_answers_are_delayed(drive: VirtualDrive, bus: Bus) -> None:
    drive.switch(delay=0.05)
    begin = time.monotonic()
    assert bus.count() == NODES
    assert time.monotonic() - begin >= 0.05


@pytest.mark.parametrize(
    "wrong", [{"drop": 1.5}, {"nothing": 1}, {"fault": {"node": 7, "code": 1}}, {"delay": "a"}]
)
def test_switches_are_validated(drive: VirtualDrive, wrong: dict[str, object]) -> None:
    with pytest.raises(ConfigError, match=next(iter(wrong))):
        drive.switch(**wrong)


def test_frames_that_waited_are_answered_after_a_freeze(
    drive: VirtualDrive, bus: Bus, line: socket.socket
) -> None:
    drive.switch(freeze=True)
    time.sleep(0.01)  # the answering thread looks at its switches every millisecond
    line.settimeout(0.2)
    with pytest.raises(NoAnswer):
        bus.count()
    drive.switch(clear=True)
    line.settimeout(PATIENCE)
    assert bus.count() == NODES
