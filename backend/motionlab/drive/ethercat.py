"""EtherCAT as the link uses it: numbers of the protocol, frames, datagrams.

From ETG.1000 (services and protocols of the data link and application layers), ETG.1020 (protocol
enhancements) and ETG.2010 (slave information). Everything is little-endian but the Ethernet and
UDP headers.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from typing import NamedTuple

ETHERTYPE = 0x88A4
UDP_PORT = 34980  # 0x88A4, ETG.1000.4 section 5.2

FRAME_HEADER = 2  # length (11 bits), reserved (1), type (4) = 1: datagrams
DATAGRAM_HEADER = 10
WORKING_COUNTER = 2

# Commands
NOP, APRD, APWR, APRW, FPRD, FPWR, FPRW, BRD, BWR, BRW, LRD, LWR, LRW, ARMW, FRMW = range(15)

# Registers of an EtherCAT slave controller
REGISTER_TYPE = 0x0000
REGISTER_FEATURES = 0x0008
REGISTER_STATION_ADDRESS = 0x0010
REGISTER_STATION_ALIAS = 0x0012
REGISTER_DL_CONTROL = 0x0100
REGISTER_DL_STATUS = 0x0110
REGISTER_AL_CONTROL = 0x0120
REGISTER_AL_STATUS = 0x0130
REGISTER_AL_STATUS_CODE = 0x0134
REGISTER_EVENT_MASK = 0x0200
REGISTER_WATCHDOG_DIVIDER = 0x0400
REGISTER_WATCHDOG_PDI = 0x0410
REGISTER_WATCHDOG_PROCESS_DATA = 0x0420
REGISTER_WATCHDOG_STATUS = 0x0440
REGISTER_SII_CONFIGURATION = 0x0500
REGISTER_SII_CONTROL = 0x0502
REGISTER_SII_ADDRESS = 0x0504
REGISTER_SII_DATA = 0x0508
REGISTER_FMMU = 0x0600  # 16 bytes each
REGISTER_SYNC_MANAGER = 0x0800  # 8 bytes each
REGISTER_DC_RECEIVE_TIME = 0x0900
REGISTER_DC_SYSTEM_TIME = 0x0910
REGISTER_DC_RECEIVE_TIME_UNIT = 0x0918
REGISTER_DC_SYSTEM_TIME_OFFSET = 0x0920
REGISTER_DC_SYSTEM_TIME_DELAY = 0x0928
REGISTER_DC_SYSTEM_TIME_DIFFERENCE = 0x092C
REGISTER_DC_SPEED_START = 0x0930
REGISTER_DC_CUC = 0x0980
REGISTER_DC_ACTIVATION = 0x0981
REGISTER_DC_START_TIME = 0x0990
REGISTER_DC_SYNC0_CYCLE = 0x09A0

WATCHDOG_TICK = 100e-6
"""s; one count of a watchdog at the divider's reset value, (2498 + 2) x 40 ns."""

# States of the application layer
INIT, PREOP, BOOT, SAFEOP, OP = 1, 2, 3, 4, 8
AL_ERROR = 0x10  # error indication in the status, acknowledgement in the control
AL_STATES = {INIT: "INIT", PREOP: "PREOP", BOOT: "BOOT", SAFEOP: "SAFEOP", OP: "OP"}
AL_CODES = {
    0x0000: "no error",
    0x0001: "unspecified error",
    0x0011: "invalid requested state change",
    0x0012: "unknown requested state",
    0x0016: "invalid mailbox configuration",
    0x001A: "synchronization error",
    0x001B: "sync manager watchdog",
    0x001D: "invalid output configuration",
    0x001E: "invalid input configuration",
    0x001F: "invalid watchdog configuration",
    0x0024: "invalid input mapping",
    0x0025: "invalid output mapping",
    0x0030: "invalid DC SYNC configuration",
    0x0032: "PLL error",
}


class Datagram(NamedTuple):
    """One datagram of a frame.

    For the position-addressed commands `position` counts down from 0 and is incremented by every
    node; for the configured-address ones it is the station address. Logical commands take
    `position` as the low and `offset` as the high 16 bits of the address.
    """

    command: int
    position: int
    offset: int
    data: bytes
    index: int = 0  # pyright: ignore[reportIncompatibleMethodOverride]
    working_counter: int = 0


def frame(datagrams: Sequence[Datagram]) -> bytes:
    """Return the payload of an Ethernet frame or UDP packet that holds some datagrams."""
    parts = []
    for i, d in enumerate(datagrams):
        more = 0x8000 if i < len(datagrams) - 1 else 0
        parts.append(
            struct.pack(
                "<BBHHHH", d.command, d.index, d.position & 0xFFFF, d.offset, len(d.data) | more, 0
            )
        )
        parts.append(d.data)
        parts.append(struct.pack("<H", d.working_counter))
    body = b"".join(parts)
    return struct.pack("<H", len(body) | 0x1000) + body


def datagrams(payload: bytes) -> Iterator[Datagram]:
    """Yield the datagrams of a frame.

    Raises
    ------
    ValueError
        If it is no EtherCAT frame, or shorter than it says.
    """
    if len(payload) < FRAME_HEADER:
        raise ValueError("shorter than a frame header")
    (header,) = struct.unpack_from("<H", payload)
    if header >> 12 != 1:
        raise ValueError(f"type {header >> 12} of the frame, not 1")
    at, end = FRAME_HEADER, FRAME_HEADER + (header & 0x07FF)
    more = True
    while more:
        if min(end, len(payload)) < at + DATAGRAM_HEADER + WORKING_COUNTER:
            raise ValueError("a datagram is cut off")
        command, index, position, offset, length, _ = struct.unpack_from("<BBHHHH", payload, at)
        more = bool(length & 0x8000)
        length &= 0x07FF
        at += DATAGRAM_HEADER
        if min(end, len(payload)) < at + length + WORKING_COUNTER:
            raise ValueError("a datagram is cut off")
        (counter,) = struct.unpack_from("<H", payload, at + length)
        yield Datagram(command, position, offset, payload[at : at + length], index, counter)
        at += length + WORKING_COUNTER


def ethernet_header(source: bytes) -> bytes:
    """Return the header of a broadcast EtherCAT frame from a network card's address."""
    return b"\xff" * 6 + source + struct.pack(">H", ETHERTYPE)
