"""Service data objects."""

from __future__ import annotations

import struct

import pytest

from motionlab.drive import process_data as pd
from motionlab.drive.ethercat import INIT
from motionlab.drive.virtual.segment import Segment
from tests.drive.virtual.bus import NODES, PERIOD, Bus, Refused


def u16(value: int) -> bytes:
    return struct.pack("<H", value)


def test_identity_and_names(bus: Bus) -> None:
    bus.to_preop()
    for node in range(NODES):
        assert struct.unpack("<I", bus.upload(node, 0x1018, 1))[0] == 0xE000_0001
        assert struct.unpack("<I", bus.upload(node, 0x1018, 4))[0] == node + 1
        assert bus.upload(node, 0x1008) == b"Virtual current drive"  # longer than four bytes
    assert bus.upload(0, 0x1000) == struct.pack("<I", 0x0002_0192)
    assert bus.upload(0, 0x6075) == struct.pack("<I", 10_000)
    assert bus.upload(0, 0x6502) == struct.pack("<I", 1 << 9)


def test_mapping_is_the_process_data(bus: Bus) -> None:
    bus.to_preop()
    for index, entries in ((pd.RX_PDO, pd.OUTPUTS), (pd.TX_PDO, pd.INPUTS)):
        assert bus.upload(0, index) == bytes([len(entries)])
        for i, entry in enumerate(entries):
            assert bus.upload(0, index, i + 1) == struct.pack("<I", entry.mapped)
    assert bus.upload(0, 0x1C12, 1) == u16(pd.RX_PDO)
    # As masters do: empty the list, fill it, set its length; with nothing else.
    bus.download(0, 0x1C12, 0, b"\0")
    assert bus.upload(0, 0x1C12) == b"\0"
    bus.download(0, 0x1C12, 1, u16(pd.RX_PDO))
    with pytest.raises(Refused, match="0x06090030"):
        bus.download(0, 0x1C12, 1, u16(0x1601))
    bus.download(0, 0x1C12, 0, b"\1")
    with pytest.raises(Refused, match="0x06010000"):
        bus.download(0, 0x1C12, 1, u16(pd.RX_PDO))


@pytest.mark.parametrize(
    ("index", "subindex", "data", "code"),
    [
        (0x5FFF, 0, None, 0x0602_0000),
        (0x1018, 9, None, 0x0609_0011),
        (0x6041, 0, u16(0), 0x0601_0002),
        (0x6073, 0, b"\1", 0x0607_0010),
        (0x6073, 0, u16(2001), 0x0609_0030),
        (0x6060, 0, b"\x08", 0x0609_0030),
    ],
)
def test_refusals(bus: Bus, index: int, subindex: int, data: bytes | None, code: int) -> None:
    bus.to_preop()
    with pytest.raises(Refused) as refused:
        if data is None:
            bus.upload(0, index, subindex)
        else:
            bus.download(0, index, subindex, data)
    assert refused.value.code == code


@pytest.mark.parametrize(
    ("command", "code"), [(0x60, 0x0504_0001), (0x00, 0x0504_0001), (0x50, 0x0601_0004)]
)
def test_commands_that_are_not_offered(bus: Bus, command: int, code: int) -> None:
    bus.to_preop()
    answer = bus.mail(0, struct.pack("<HBHB4x", 2 << 12, command, 0x1018, 0))
    assert answer[2] == 0x80
    assert struct.unpack("<I", answer[6:10])[0] == code


@pytest.mark.parametrize(
    ("body", "kind", "detail"),
    [(bytes(10), 2, 2), (bytes(4), 3, 6), (struct.pack("<HBHB4x", 8 << 12, 1, 0, 0), 3, 2)],
)
def test_other_mail_is_answered_with_an_error(
    bus: Bus, body: bytes, kind: int, detail: int
) -> None:
    bus.to_preop()
    assert bus.mail(0, body, kind) == struct.pack("<HH", 1, detail)


def test_normal_and_unsized_downloads(bus: Bus) -> None:
    bus.to_preop()
    head = struct.pack("<HBHB", 2 << 12, 0x21, 0x6065, 0)
    assert bus.mail(0, head + struct.pack("<II", 4, 12_345))[2] == 0x60
    assert bus.upload(0, 0x6065) == struct.pack("<I", 12_345)
    head = struct.pack("<HBHB", 2 << 12, 0x22, 0x6073, 0)
    assert bus.mail(0, head + struct.pack("<I", 800))[2] == 0x60
    assert bus.upload(0, 0x6073) == u16(800)


def test_the_same_mail_twice_is_answered_once(segment: Segment, bus: Bus) -> None:
    bus.to_preop()
    body = struct.pack("<HBHB4x", 2 << 12, 0x40, 0x1000, 0)
    mail = (struct.pack("<HHBB", len(body), 0, 0, 0x53) + body).ljust(128, b"\0")
    bus.write(0, 0x1000, mail)
    bus.read(0, 0x1080, 128)
    bus.write(0, 0x1000, mail)
    assert not bus.number(0, 0x080D, 1) & 8


def test_live_objects(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    bus.outputs["torque"] = 250
    bus.control(pd.ENABLED)
    assert bus.upload(3, 0x6077) == u16(250) or bus.upload(3, 0x6077) == u16(249)
    assert bus.upload(3, 0x6040) == u16(pd.ENABLED)
    assert bus.upload(3, 0x6071) == u16(250)
    assert pd.drive_state(struct.unpack("<H", bus.upload(3, 0x6041))[0]) == "operation enabled"
    assert bus.upload(0, 0x608F, 1) == struct.pack("<I", 20_000)  # counts in a millimetre
    with pytest.raises(Refused):
        bus.upload(1, 0x608F, 1)  # it has no encoder
    segment.switch(sto=True)
    assert bus.upload(3, 0x60FD) == struct.pack("<I", 1 << 16)


def test_an_emergency_tells_of_an_error_and_of_its_end(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    assert bus.emergencies(1) == []
    segment.switch(fault={"node": 2, "code": 0x2310})
    bus.periods(3)
    assert bus.emergencies(0) == []
    assert bus.emergencies(1) == [(0x2310, 1)]
    bus.periods(3)
    assert bus.emergencies(1) == []  # once
    segment.switch(fault={"node": 2, "code": 0x3220})
    bus.periods(3)
    assert bus.emergencies(1) == []  # it has failed already
    bus.control(0)
    bus.control(pd.FAULT_RESET)
    assert bus.emergencies(1) == [(0, 0)]


def test_an_emergency_stands_in_front_of_no_answer(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    bus.enable()
    segment.switch(fault={"node": 1, "code": 0x2310})
    bus.periods(3)
    assert bus.has_mail(0)
    assert bus.upload(0, 0x603F) == u16(0x2310)


def test_no_emergency_before_preop(segment: Segment, bus: Bus) -> None:
    bus.to_op()
    segment.switch(encoder_loss="x")
    bus.periods(3)
    bus.request_all(INIT)
    bus.to_preop()
    assert bus.emergencies(0) == []  # what INIT threw away does not come again
    assert bus.upload(0, 0x603F) == u16(0x7305)


def test_synchronisation(bus: Bus) -> None:
    bus.to_preop()
    for index in (0x1C32, 0x1C33):
        assert bus.upload(0, index, 2) == struct.pack("<I", PERIOD)
        assert bus.upload(0, index, 4) == u16(0b111)
        assert bus.upload(0, index, 5) == struct.pack("<I", 100_000)
        bus.download(0, index, 2, struct.pack("<I", 1_000_000))
        assert bus.upload(0, index, 2) == struct.pack("<I", 1_000_000)
        bus.download(0, index, 2, struct.pack("<I", PERIOD))
    assert bus.upload(0, 0x1C33, 1) == u16(34)
    bus.download(0, 0x1C32, 1, u16(2))
    bus.download(0, 0x1C33, 1, u16(2))
    assert bus.upload(0, 0x1C33, 1) == u16(2)
    with pytest.raises(Refused, match="0x06090030"):
        bus.download(0, 0x1C33, 1, u16(3))  # there is no SYNC1
    assert bus.upload(0, 0x60C2, 1) + bus.upload(0, 0x60C2, 2) == b"\x05\xfc"  # 5e-4 s
    bus.download(0, 0x60C2, 1, b"\x0a")
    assert bus.upload(0, 0x60C2, 1) == b"\x0a"
