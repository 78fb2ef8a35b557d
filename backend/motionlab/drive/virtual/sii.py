"""Slave information: what the EEPROM of a node holds, ETG.2010."""

from __future__ import annotations

import struct
from typing import Any

import numpy as np

from motionlab.drive.process_data import INPUT, INPUTS, OUTPUT, OUTPUTS, RX_PDO, TX_PDO, Entry
from motionlab.drive.virtual.al import MAILBOX_BYTES, MAILBOX_IN, MAILBOX_OUT
from motionlab.drive.virtual.layout import EEPROM, INPUT_ADDRESS, OUTPUT_ADDRESS

TYPES = {"u1": 0x05, "i1": 0x02, "u2": 0x06, "i2": 0x03, "u4": 0x07, "i4": 0x04}
"""Numbers of data types, ETG.1000.6, by those of numpy."""

_STRINGS, _GENERAL, _FMMU, _SYNC_MANAGERS, _TX_PDO, _RX_PDO, _END = 10, 30, 40, 41, 50, 51, 0xFFFF
_COE = 0x04  # of the mailbox protocols
_SDO = 0x01  # of CoE: service data objects, without information about them
_NAMES = ("Virtual current drive", "Drives", "Outputs", "Inputs")
"""Texts; the first is that of the device, which some masters read without looking it up."""


def slave_information(vendor: int, product: int, revision: int, serial: int) -> bytes:
    """Return the EEPROM of a node, `EEPROM` bytes."""
    head = struct.pack("<7H", 0x0080, 0, 0, 0, 0, 0, 0)
    head += struct.pack("<H", _checksum(head))
    head += struct.pack("<4I", vendor, product, revision, serial)
    head += bytes(16)  # no delays, no mailbox of a bootstrap
    head += struct.pack("<5H", MAILBOX_OUT, MAILBOX_BYTES, MAILBOX_IN, MAILBOX_BYTES, _COE)
    head += bytes(2 * 0x3E - len(head))
    head += struct.pack("<2H", EEPROM // 128 - 1, 1)

    names = [*_NAMES, *(entry.name for entry in (*OUTPUTS, *INPUTS) if entry.index)]
    strings = bytes([len(names)]) + b"".join(bytes([len(n)]) + n.encode() for n in names)
    # Indices of group, picture, order and name; CoE, FoE, EoE, SoE, profile channels; ports.
    general = struct.pack("<4Bx5B", 2, 0, 1, 1, _SDO, 0, 0, 0, 1).ljust(16, b"\0")
    general = (general + struct.pack("<H", 0x0011)).ljust(32, b"\0")
    managers = b"".join(
        struct.pack("<HHBBBB", start, length, control, 0, 1, kind)
        for start, length, control, kind in (
            (MAILBOX_OUT, MAILBOX_BYTES, 0x26, 1),
            (MAILBOX_IN, MAILBOX_BYTES, 0x22, 2),
            (OUTPUT_ADDRESS, OUTPUT.itemsize, 0x64, 3),
            (INPUT_ADDRESS, INPUT.itemsize, 0x20, 4),
        )
    )
    image = head
    for kind, content in (
        (_STRINGS, strings),
        (_GENERAL, general),
        (_FMMU, bytes([1, 2, 3, 0])),  # outputs, inputs, state of the mailbox, unused
        (_SYNC_MANAGERS, managers),
        (_TX_PDO, _pdo(TX_PDO, 3, 4, INPUTS, INPUT, names)),
        (_RX_PDO, _pdo(RX_PDO, 2, 3, OUTPUTS, OUTPUT, names)),
    ):
        even = content + bytes(len(content) % 2)
        image += struct.pack("<HH", kind, len(even) // 2) + even
    image += struct.pack("<H", _END)
    return image.ljust(EEPROM, b"\xff")


def _pdo(  # noqa: PLR0913, PLR0917 - as many as its head has fields
    index: int,
    manager: int,
    name: int,
    entries: tuple[Entry, ...],
    kinds: np.dtype[Any],
    names: list[str],
) -> bytes:
    content = struct.pack("<HBBBBH", index, len(entries), manager, 0, name, 0x0011)
    for i, entry in enumerate(entries):
        number = names.index(entry.name) + 1 if entry.index else 0
        kind = TYPES[kinds[i].str[1:]] if entry.index else 0
        content += struct.pack("<HBBBBH", entry.index, entry.subindex, number, kind, entry.bits, 0)
    return content


def _checksum(words: bytes) -> int:
    """Return the CRC-8 of the first seven words: x^8 + x^2 + x + 1, starting from 0xFF."""
    crc = 0xFF
    for byte in words:
        crc ^= byte
        for _ in range(8):
            crc = (crc << 1 ^ 0x07 if crc & 0x80 else crc << 1) & 0xFF
    return crc
