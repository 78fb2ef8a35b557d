"""Addressing, working counters, registers and slave information."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from motionlab.drive.ethercat import (
    APRD,
    APRW,
    APWR,
    ARMW,
    BRD,
    BRW,
    FPRW,
    FRMW,
    LRD,
    LRW,
    LWR,
    NOP,
    REGISTER_DC_RECEIVE_TIME,
    REGISTER_DC_SYSTEM_TIME,
    REGISTER_DC_SYSTEM_TIME_DIFFERENCE,
    REGISTER_DL_STATUS,
    REGISTER_FMMU,
    REGISTER_SII_CONTROL,
    REGISTER_SII_DATA,
    REGISTER_STATION_ADDRESS,
    SAFEOP,
    Datagram,
    datagrams,
    frame,
)
from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import INPUTS, NODES, OUTPUTS, Bus, fmmu

RAM = 0x1800


def test_every_node_counts_once_on_a_broadcast(bus: Bus) -> None:
    found = bus.one(BRD, 0, 0x0004, bytes(2))
    assert (found.working_counter, found.data) == (NODES, b"\x04\x04")
    assert found.position == NODES  # every node adds one
    assert bus.one(BRW, 0, RAM, b"\x01").working_counter == 3 * NODES
    assert bus.one(NOP, 0, 0, bytes(1)).working_counter == 0


def test_position_and_station_address_find_one_node(bus: Bus) -> None:
    bus.address()
    for node in range(NODES):
        found = bus.one(APRD, -node, REGISTER_STATION_ADDRESS, bytes(2))
        assert (found.working_counter, found.data) == (1, struct.pack("<H", 0x1001 + node))
    assert bus.one(APRD, 1, REGISTER_STATION_ADDRESS, bytes(2)).working_counter == 0
    old = bus.one(APRW, -2, RAM, b"\x55")
    assert (old.working_counter, old.data) == (3, b"\0")  # read before it was written
    assert bus.one(FPRW, 0x1003, RAM, b"\xaa").data == b"\x55"
    bus.write(2, 0x0012, struct.pack("<H", 0x0777))
    assert bus.one(APRD, -2, 0x0012, bytes(2)).data == b"\0\0"  # the alias is the EEPROM's


def test_what_lies_outside_the_memory_is_not_answered(bus: Bus) -> None:
    assert bus.one(BRD, 0, 0x1FFE, bytes(2)).working_counter == NODES
    assert bus.one(BRD, 0, 0x1FFF, bytes(2)).working_counter == 0
    assert bus.one(APWR, 0, 0xFFFF, bytes(1)).working_counter == 0


def test_registers_of_the_chip_cannot_be_written(bus: Bus) -> None:
    before = bus.one(APRD, 0, 0, bytes(16)).data
    bus.one(APWR, 0, 0, b"\xff" * 16)
    after = bus.one(APRD, 0, 0, bytes(16)).data
    assert after == before


def test_multiple_write_reads_one_node_and_writes_the_others(bus: Bus) -> None:
    bus.address()
    bus.one(APWR, -1, RAM, b"\x42")
    assert bus.one(ARMW, -1, RAM, bytes(1)).working_counter == NODES
    assert bus.one(BRD, 0, RAM, bytes(1)).data == b"\x42"
    bus.one(APWR, -4, RAM, b"\x24")
    bus.one(FRMW, 0x1005, RAM, bytes(1))
    # Nodes before the one that is read were written before it was: with what the master sent.
    values = [bus.read(n, RAM, 1) for n in range(NODES)]
    assert values == [b"\0"] * 4 + [b"\x24"] * 2


def test_one_frame_holds_many_datagrams(bus: Bus) -> None:
    found = bus.send(*(Datagram(APRD, -n, 0x0004, bytes(1)) for n in range(NODES)))
    assert [d.working_counter for d in found] == [1] * NODES


def test_last_link_is_the_last_nodes(segment: Segment, bus: Bus) -> None:
    bus.address()
    assert bus.number(0, REGISTER_DL_STATUS) & 0x0C30 == 0x0830
    assert bus.number(5, REGISTER_DL_STATUS) & 0x0C30 == 0x0410
    segment.switch(link=3)
    assert bus.count() == 3
    assert bus.number(2, REGISTER_DL_STATUS) & 0x0C30 == 0x0410


def test_slave_information_names_node_and_layout(bus: Bus) -> None:
    bus.address()

    def words(at: int) -> bytes:
        bus.write(3, REGISTER_SII_CONTROL, struct.pack("<HI", 0x0100, at))
        assert not bus.number(3, REGISTER_SII_CONTROL) & 0x8000
        return bus.read(3, REGISTER_SII_DATA, 8)

    assert struct.unpack("<II", words(8)) == (0xE000_0001, 0x5001)
    assert struct.unpack("<II", words(12)) == (1, 4)  # revision, serial
    assert struct.unpack("<4H", words(0x18)) == (0x1000, 128, 0x1080, 128)
    image = b"".join(words(at) for at in range(0, 512, 4))
    found, at = {}, 0x80
    while (kind := struct.unpack_from("<H", image, at)[0]) != 0xFFFF:
        size = 2 * struct.unpack_from("<H", image, at + 2)[0]
        found[kind] = image[at + 4 : at + 4 + size]
        at += 4 + size
    assert list(found) == [10, 30, 40, 41, 50, 51]
    assert struct.unpack_from("<HHB", found[41], 16) == (0x1100, 6, 0x64)
    assert struct.unpack_from("<HHB", found[41], 24) == (0x1180, 16, 0x20)
    assert struct.unpack_from("<HB", found[50]) == (0x1A00, 7)
    bus.write(3, REGISTER_SII_CONTROL, struct.pack("<HI", 0x0201, 0))
    assert bus.number(3, REGISTER_SII_CONTROL) & 0x2000  # it cannot be written


def test_process_data_by_read_and_write_apart(bus: Bus) -> None:
    bus.to_op()
    assert bus.one(LRW, 0, 0, bytes(OUTPUTS + INPUTS)).working_counter == 18
    assert bus.one(LWR, 0, 0, bytes(OUTPUTS)).working_counter == 6
    assert bus.one(LRD, OUTPUTS, 0, bytes(INPUTS)).working_counter == 6
    assert bus.one(LRD, OUTPUTS + 16, 0, bytes(32)).working_counter == 2
    assert bus.one(LRW, 0x1_0000 - 1, 1, bytes(OUTPUTS)).working_counter == 0


def test_process_data_does_not_count_before_safeop(bus: Bus) -> None:
    bus.to_preop()
    for node in range(NODES):
        bus.process_data(node)
    assert bus.one(LRW, 0, 0, bytes(OUTPUTS + INPUTS)).working_counter == 0
    bus.request_all(SAFEOP)
    assert bus.one(LRW, 0, 0, bytes(OUTPUTS + INPUTS)).working_counter == 18


def test_an_fmmu_of_bits_maps_the_state_of_a_mailbox(bus: Bus) -> None:
    bus.to_preop()
    # Bit 3 of 0x080D, mail for the master, at bit 5 of logical byte 0x2000.
    bus.write(1, REGISTER_FMMU, struct.pack("<IHBBHBBB3x", 0x2000, 1, 5, 5, 0x080D, 3, 1, 1))
    assert bus.one(LRD, 0x2000, 0, b"\x01").data == b"\x01"
    body = struct.pack("<HBHB4x", 2 << 12, 0x40, 0x1000, 0)
    mail = struct.pack("<HHBB", len(body), 0, 0, 0x13) + body
    bus.write(1, 0x1000, mail.ljust(128, b"\0"))
    found = bus.one(LRD, 0x2000, 0, b"\x01")
    assert (found.data, found.working_counter) == (b"\x21", 1)


def test_a_datagram_may_cut_an_fmmu(bus: Bus) -> None:
    bus.to_op()
    bus.write(0, REGISTER_FMMU, fmmu(0x8000, 6, 0x1100, 2))
    assert bus.one(LWR, 0x8002, 0, b"\x11\x22").working_counter == 1
    assert bus.one(LWR, 0x8006, 0, b"\x11").working_counter == 0


def test_clocks_agree_after_offsets_and_delays(bus: Bus) -> None:
    bus.address()
    bus.now = 5_000_000
    local = [bus.number(n, REGISTER_DC_SYSTEM_TIME, 8) for n in range(NODES)]
    assert len(set(local)) == NODES
    bus.clocks()
    bus.now += 1_000_000
    assert [bus.system_time(n) - bus.system_time(0) for n in range(NODES)] == [
        300 * n
        for n in range(NODES)  # as the frame reaches them
    ]
    bus.one(ARMW, 0, REGISTER_DC_SYSTEM_TIME, bytes(8))
    assert [bus.number(n, REGISTER_DC_SYSTEM_TIME_DIFFERENCE, 4) for n in range(1, NODES)] == [
        0
    ] * 5
    ports = struct.unpack("<II", bus.read(0, REGISTER_DC_RECEIVE_TIME, 8))
    assert ports[1] - ports[0] == 2 * 300 * (NODES - 1)


def test_a_clock_that_is_off_moves_towards_the_reference(segment: Segment, bus: Bus) -> None:
    bus.address()
    bus.clocks()
    segment.arrays.nodes[3, 15] += 5000  # CLOCK
    away = []
    for _ in range(8):
        bus.now += 500_000
        bus.one(ARMW, 0, REGISTER_DC_SYSTEM_TIME, bytes(8))
        away.append(bus.system_time(3) - bus.system_time(0) - 900)
    assert away == [4000, 3000, 2000, 1000, 0, 0, 0, 0]


@pytest.mark.parametrize("seed", range(3))
def test_malformed_frames_are_ignored_and_counted(segment: Segment, bus: Bus, seed: int) -> None:
    bus.to_op()
    random = np.random.default_rng(seed)
    sample = frame([Datagram(LRW, 0, 0, bytes(132)), Datagram(BRD, 0, 0x0130, bytes(2))])
    for _ in range(1500):
        bus.now += int(random.integers(0, 3000))
        if random.random() < 0.5:
            packet = random.bytes(int(random.integers(0, 1600)))
        else:
            damaged = bytearray(sample[: int(random.integers(0, len(sample) + 1))])
            for _ in range(int(random.integers(0, 4))):
                damaged[int(random.integers(0, max(len(damaged), 1))) :][:1] = random.bytes(1)
            packet = bytes(damaged)
        before = segment.arrays.counters[:2].sum()
        answer = segment.exchange(packet, bus.now)
        assert segment.arrays.counters[:2].sum() == before + 1  # FRAMES or MALFORMED
        if answer is not None:
            list(datagrams(answer))
    assert segment.arrays.counters[1] > 500


@pytest.mark.parametrize(
    "packet",
    [
        b"",
        b"\x0c",
        b"\x0c\x10",
        b"\x0c\x20" + bytes(12),  # another type
        b"\x0d\x10" + bytes(13),  # bytes after the last datagram
        b"\x0c\x10" + bytes(6) + b"\x00\x80" + bytes(4),  # another one is promised
        b"\x0c\x10" + bytes(6) + b"\xff\x07" + bytes(4),  # longer than the frame
        b"\x0c\x10" + bytes(11),  # cut off
    ],
)
def test_frames_that_contradict_themselves(segment: Segment, packet: bytes) -> None:
    assert segment.exchange(packet, 0) is None
    assert segment.status()["counters"]["malformed"] == 1
