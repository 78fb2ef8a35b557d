"""A packet dissector that is not ours reads frames of master and drives as they are meant."""

from __future__ import annotations

import socket
from collections.abc import Callable
from pathlib import Path

import pytest

from motionlab.drive import process_data as pd
from motionlab.drive.ethercat import APWR, ARMW, BRD, BWR, FPRD, FPWR, LRD, LRW, LWR
from motionlab.drive.libc import new_clock
from motionlab.drive.link import bring_up
from motionlab.drive.link.bus import cyclic_bus
from motionlab.drive.link.carrier import Carrier
from motionlab.drive.virtual.segment import Segment, default_drive
from tests.drive.virtual.bus import PERIOD, Bus
from tests.drive.virtual.captures import (
    ETHERNET_HEADER,
    UDP_HEADERS,
    datagrams_of,
    dissect,
    in_udp,
    on_ethernet,
    write_capture,
)

SDO_REQUEST, SDO_RESPONSE = 2, 3
CARRIERS = pytest.mark.parametrize(
    ("carried", "header", "around"),
    [
        (on_ethernet, ETHERNET_HEADER, "eth:ethertype"),
        (in_udp, UDP_HEADERS, "eth:ethertype:ip:udp"),
    ],
    ids=["ethernet", "udp"],
)


class Wire:
    """A socket of the link with a segment at its other end; it keeps all that passes."""

    def __init__(self, segment: Segment) -> None:
        self.passed: list[bytes] = []
        self._segment = segment
        self._now = 0
        self._link, self._drives = socket.socketpair(socket.AF_UNIX, socket.SOCK_DGRAM)

    def send(self, payload: bytes) -> int:
        self._now += PERIOD
        answer = self._segment.exchange(payload, self._now)
        assert answer is not None
        self.passed += [payload, answer]
        return self._drives.send(answer)

    def recv(self, size: int) -> bytes:
        return self._link.recv(size)

    def fileno(self) -> int:
        return self._link.fileno()

    def close(self) -> None:
        self._link.close()
        self._drives.close()


def exchange_of_the_link(segment: Segment) -> list[bytes]:
    """Return what passes when our master brings drives up and exchanges process data."""
    wire, config = Wire(segment), default_drive()
    carrier = Carrier(config.link)
    carrier.close()
    carrier.socket = wire  # pyright: ignore[reportAttributeAccessIssue]
    bring_up.BringUp(carrier, config).bring_up()
    cyclic = cyclic_bus(wire.fileno(), b"", new_clock(), clocks=True)
    for _ in range(10):
        wire.send(cyclic.read.tobytes())
        wire.send(cyclic.write.tobytes())
    wire.close()
    return wire.passed


def exchange_of_a_test(segment: Segment) -> list[bytes]:
    """Return what passes with every drive enabled, through faults, in one frame a period."""
    passed: list[bytes] = []

    def exchange(payload: bytes, now: int) -> bytes | None:
        answer = segment.exchange(payload, now)
        passed.extend([payload] if answer is None else [payload, answer])
        return answer

    bus = Bus(exchange)
    bus.to_op()
    bus.enable()
    segment.switch(fault={"node": 2, "code": 0x2310}, link=5)
    bus.one(LRW, 0, 0, bytes(132))
    segment.switch(clear=True)
    bus.control(pd.FAULT_RESET)
    assert bus.upload(1, 0x1008)
    with pytest.raises(Exception, match="0x06020000"):
        bus.upload(1, 0x5FFF)
    return passed


@CARRIERS
@pytest.mark.parametrize("exchange", [exchange_of_the_link, exchange_of_a_test])
def test_every_frame_is_read_as_meant(
    exchange: Callable[[Segment], list[bytes]],
    carried: Callable[[bytes], bytes],
    header: int,
    around: str,
    segment: Segment,
    tmp_path: Path,
) -> None:
    frames = [carried(payload) for payload in exchange(segment)]
    path = tmp_path / "frames.pcap"
    write_capture(path, frames)
    dissected = dissect(path)
    ours = datagrams_of(frames, header)
    assert len(dissected) == len(ours)
    for frame, meant in zip(dissected, ours, strict=True):
        assert frame.complaints == ""
        assert frame.protocols.removesuffix(":ecat_mailbox") == f"{around}:ecatf:ecat"
        assert frame.commands == [datagram.command for datagram in meant]
        assert frame.counters == [datagram.working_counter for datagram in meant]

    commands = {command for frame in dissected for command in frame.commands}
    cyclic = {ARMW, BRD, LRD, LWR} if exchange is exchange_of_the_link else {LRW}
    assert commands >= {BWR, APWR, FPRD, FPWR} | cyclic
    mail = [(kind, index) for frame in dissected for kind in frame.coe for index in frame.objects]
    assert {SDO_REQUEST, SDO_RESPONSE} <= {kind for frame in dissected for kind in frame.coe}
    assert (SDO_REQUEST, 0x1C32) in mail
    assert (SDO_REQUEST, 0x1008) in mail


def test_it_complains_about_what_is_wrong(segment: Segment, tmp_path: Path) -> None:
    """What the other tests rely on: a frame cut short, or of a length that is not its own."""
    frames = [on_ethernet(payload) for payload in exchange_of_a_test(segment)[:2]]
    path = tmp_path / "frames.pcap"
    write_capture(path, [frames[0], frames[1][:-3]])
    whole, cut = dissect(path)
    assert whole.complaints == ""
    assert cut.complaints != ""
