"""Captured frames: files that packet dissectors read, and what tshark says of them."""

from __future__ import annotations

import shutil
import struct
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import pytest

from motionlab.drive.ethercat import UDP_PORT, Datagram, datagrams, ethernet_header

MASTER, DRIVES = b"\x02\0\0\0\0\x01", b"\x02\0\0\0\0\x02"
ETHERNET_HEADER, UDP_HEADERS = 14, 14 + 20 + 8
FIELDS = (
    "frame.protocols",
    "ecat.cmd",
    "ecat.cnt",
    "ecat_mailbox.coe.type",
    "ecat_mailbox.coe.sdoidx",
    "_ws.malformed",
    "_ws.expert.message",
)


@dataclass
class Dissected:
    """One frame as tshark understands it.

    Attributes
    ----------
    protocols : str
        From the outermost, with colons.
    commands, counters : list of int
        Of its datagrams.
    coe, objects : list of int
        Kinds of CoE mail, and indices of objects that are read or written.
    complaints : str
        Malformed parts and remarks of the dissector.
    """

    protocols: str
    commands: list[int]
    counters: list[int]
    coe: list[int]
    objects: list[int]
    complaints: str


def on_ethernet(payload: bytes) -> bytes:
    """Return an Ethernet frame of EtherType 0x88A4."""
    return ethernet_header(MASTER) + payload


def in_udp(payload: bytes) -> bytes:
    """Return an Ethernet frame with an EtherCAT frame in a UDP packet between two hosts."""
    udp = struct.pack(">4H", UDP_PORT, UDP_PORT, 8 + len(payload), 0) + payload
    hosts = b"\x0a\0\0\x01", b"\x0a\0\0\x02"
    head = struct.pack(">BBHHHBBH4s4s", 0x45, 0, 20 + len(udp), 0, 0, 64, 17, 0, *hosts)
    total = sum(struct.unpack(">10H", head))
    checksum = ~((total & 0xFFFF) + (total >> 16)) & 0xFFFF
    return DRIVES + MASTER + b"\x08\0" + head[:10] + struct.pack(">H", checksum) + head[12:] + udp


def datagrams_of(frames: Iterable[bytes], header: int) -> list[list[Datagram]]:
    """Return the datagrams of each captured frame as our own codec reads them."""
    return [list(datagrams(frame[header:])) for frame in frames]


def write_capture(path: Path, frames: Iterable[bytes]) -> None:
    """Write Ethernet frames as a capture file, 100 us apart."""
    with path.open("wb") as file:
        file.write(struct.pack("<IHHiIII", 0xA1B2C3D4, 2, 4, 0, 0, 65535, 1))
        for i, frame in enumerate(frames):
            time = i // 10_000, 100 * (i % 10_000)
            file.write(struct.pack("<IIII", *time, len(frame), len(frame)) + frame)


def dissect(path: Path) -> list[Dissected]:
    """Return the frames of a capture file as tshark understands them."""
    program = shutil.which("tshark")
    if program is None:
        pytest.skip("no tshark: apt-get install tshark")
    fields = [part for field in FIELDS for part in ("-e", field)]
    told = subprocess.run(
        [program, "-n", "-r", str(path), "-T", "fields", "-E", "occurrence=a", *fields],
        capture_output=True,
        text=True,
        check=True,
        timeout=60.0,
    )
    return [_dissected(*line.split("\t")) for line in told.stdout.splitlines()]


def _dissected(protocols: str, *columns: str) -> Dissected:
    numbers = [[int(text, 0) for text in column.split(",") if text] for column in columns[:4]]
    return Dissected(protocols, *numbers, complaints=" ".join(columns[4:]).strip())
