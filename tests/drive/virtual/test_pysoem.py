"""An independent master, pysoem, takes the virtual drive for the drives that it stands for.

It is unmodified, on one end of a pair of virtual network cards, and the virtual drive on the other.
"""

from __future__ import annotations

import socket
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.drive import process_data as pd
from motionlab.drive.ethercat import APRD, BRD, ETHERTYPE, FPRD, FPWR, LRD, LRW, LWR
from motionlab.drive.virtual.process import VirtualDrive
from tests.drive.virtual.bus import NODES
from tests.drive.virtual.captures import dissect, write_capture

pysoem: Any = pytest.importorskip("pysoem", reason="no pysoem: pip install pysoem==1.1.13")

SLOW = 5
"""The drives are slower than real time, so that a busy machine keeps their watchdog fed."""

PERIOD = 1e-3  # s
MAX_CURRENT = 0x6073
SOURCE_OF_SOEM = "Source MAC must not be a group address: IEEE 802.3-2002, Section 3.2.3(b)"
"""Of its frames, which come from 01:01:01:01:01:01 and not from its card."""


@pytest.fixture(scope="module")
def drive(cards: tuple[str, str]) -> Iterator[VirtualDrive]:
    with VirtualDrive(interface=cards[0], slow=SLOW) as drive:
        yield drive


@pytest.fixture
def master(drive: VirtualDrive, cards: tuple[str, str]) -> Iterator[Any]:
    """Return a master that has found six drives and brought them to PREOP."""
    pysoem.settings.always_release_gil = True
    pysoem.settings.timeouts.ret = 200_000  # us until it sends a frame again: the machine is busy
    drive.switch(clear=True)
    master = pysoem.Master()
    master.open(cards[1])
    try:
        assert master.config_init() == NODES
        yield master
        master.state = pysoem.INIT_STATE
        master.write_state()
    finally:
        master.close()


def start_up(master: Any) -> None:
    """Bring drives to OP, with a start-up list that the master sends at PREOP to SAFEOP."""

    def start_up_list(position: int) -> None:
        slave = master.slaves[position]
        slave.sdo_write(0x1C32, 1, struct.pack("<H", 1))
        slave.sdo_write(MAX_CURRENT, 0, struct.pack("<H", 800))

    for slave in master.slaves:
        slave.config_func = start_up_list
    assert master.config_map() == NODES * (pd.OUTPUT_BYTES + pd.INPUT_BYTES)
    assert master.state_check(pysoem.SAFEOP_STATE, 500_000) == pysoem.SAFEOP_STATE
    exchange(master)
    master.state = pysoem.OP_STATE
    master.write_state()
    for _ in range(200):
        exchange(master)
        if master.state_check(pysoem.OP_STATE, 1000) == pysoem.OP_STATE:
            return
    master.read_state()
    pytest.fail(f"no OP: {[(slave.state, slave.al_status) for slave in master.slaves]}")


def exchange(master: Any) -> int:
    master.send_processdata()
    return master.receive_processdata(100_000)


def outputs(master: Any, control: int, torque: int = 0) -> None:
    for slave in master.slaves:
        slave.output = struct.pack("<HhbB", control, torque, pd.CYCLIC_TORQUE, 0)


def inputs(master: Any) -> np.ndarray:
    return np.frombuffer(b"".join(slave.input for slave in master.slaves), pd.INPUT)


def states(master: Any) -> set[str]:
    return {pd.drive_state(int(status)) for status in inputs(master)["status"]}


def test_it_reads_who_they_are(master: Any) -> None:
    for position, slave in enumerate(master.slaves):
        assert (slave.man, slave.id, slave.rev) == (0xE000_0001, 0x5001, 1)
        assert slave.name == "Virtual current drive"
        identity = [slave.sdo_read(0x1018, i) for i in range(1, 5)]
        assert identity == [
            struct.pack("<I", value) for value in (0xE000_0001, 0x5001, 1, position + 1)
        ]
        assert slave.sdo_read(0x1008, 0) == b"Virtual current drive"
        assert slave.sdo_read(0x6502, 0) == struct.pack("<I", 1 << 9)
        assert slave.sdo_read(0x60C2, 1) + slave.sdo_read(0x60C2, 2) == b"\x05\xfc"  # 5e-4 s
        for index in (0x1C32, 0x1C33):
            assert slave.sdo_read(index, 4) == struct.pack("<H", 0b111)


def test_it_is_refused_what_there_is_not(master: Any) -> None:
    with pytest.raises(pysoem.SdoError) as refused:
        master.slaves[0].sdo_read(0x5FFF, 0)
    assert refused.value.abort_code == 0x0602_0000
    with pytest.raises(pysoem.SdoError) as refused:
        master.slaves[0].sdo_read(0x1018, 0, ca=True)
    assert refused.value.abort_code == 0x0601_0004  # no complete access
    with pytest.raises(pysoem.SdoError) as refused:
        master.slaves[0].sdo_write(0x1C33, 1, b"\3\0")
    assert refused.value.abort_code == 0x0609_0030  # no SYNC1


def test_it_enables_them_and_exchanges_process_data(master: Any) -> None:
    start_up(master)
    assert master.slaves[0].sdo_read(MAX_CURRENT, 0) == struct.pack("<H", 800)
    for word, state in (
        (pd.FAULT_RESET, "switch on disabled"),
        (pd.SHUTDOWN, "ready to switch on"),
        (pd.SWITCHED_ON, "switched on"),
        (pd.ENABLED, "operation enabled"),
    ):
        outputs(master, word)
        for _ in range(200):
            assert exchange(master) == master.expected_wkc == 3 * NODES
            if states(master) == {state}:
                break
        assert states(master) == {state}

    counters: Counter[int] = Counter()
    outputs(master, pd.ENABLED, 300)
    master.slaves[1].output = struct.pack("<HhbB", pd.ENABLED, 900, pd.CYCLIC_TORQUE, 0)
    begin = time.monotonic()
    while time.monotonic() < begin + 2.0:
        counters[exchange(master)] += 1
        time.sleep(PERIOD)
    assert set(counters) == {3 * NODES}
    assert sum(counters.values()) > 100
    found = inputs(master)
    assert found["torque"].tolist() == [300, 800, 300, 300, 300, 300]  # within 6073
    assert abs(int(found["position"][0])) > 1000  # the mover went to where phase b pulls it
    assert master.slaves[1].sdo_read(0x6071, 0) == struct.pack("<h", 900)  # mail beside it


def test_it_is_told_of_an_error(master: Any, drive: VirtualDrive) -> None:
    start_up(master)
    told: list[Any] = []
    master.slaves[2].add_emergency_callback(told.append)
    drive.switch(fault={"node": 3, "code": 0x2310})
    begin = time.monotonic()
    while not told and time.monotonic() < begin + 10.0:
        exchange(master)
        master.slaves[2].mbx_receive()
    assert (told[0].error_code, told[0].error_reg) == (0x2310, 1)
    found = inputs(master)
    assert found["error"].tolist() == [0, 0, 0x2310, 0, 0, 0]


def test_it_sees_their_watchdog(master: Any, drive: VirtualDrive) -> None:
    start_up(master)
    time.sleep(2 * SLOW * 0.02)
    assert master.read_state() == pysoem.SAFEOP_STATE
    for slave in master.slaves:
        assert slave.state == pysoem.SAFEOP_STATE | pysoem.STATE_ERROR
        assert pysoem.al_status_code_to_string(slave.al_status) == "Sync manager watchdog"
    assert drive.status()["counters"]["watchdogs"] >= NODES


def test_a_dissector_reads_what_passed(master: Any, cards: tuple[str, str], tmp_path: Path) -> None:
    frames: list[bytes] = []
    with socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3)) as ear:
        ear.bind((cards[0], 3))  # ETH_P_ALL, with what is sent
        ear.settimeout(0.2)

        def listen() -> None:
            while True:
                try:
                    frame = ear.recv(2048)
                except TimeoutError:
                    return
                if frame[12:14] == ETHERTYPE.to_bytes(2, "big"):
                    frames.append(frame)

        listening = threading.Thread(target=listen)
        listening.start()
        assert master.config_init() == NODES
        start_up(master)
        for _ in range(20):
            exchange(master)
        listening.join()
    write_capture(tmp_path / "frames.pcap", frames)
    dissected = dissect(tmp_path / "frames.pcap")
    assert len(dissected) == len(frames) > 100
    assert {frame.complaints for frame in dissected} <= {"", SOURCE_OF_SOEM}
    commands = {command for frame in dissected for command in frame.commands}
    assert commands >= {APRD, BRD, FPRD, FPWR, LRW} or commands >= {LRD, LWR}
    kinds = {kind for frame in dissected for kind in frame.coe}
    assert kinds >= {2, 3}  # requests and responses of service data objects
