"""Process data of one current drive: what goes in and out of it every period.

Outputs (RxPDO 0x1600) and inputs (TxPDO 0x1A00) of all nodes follow one another in the logical
address space, all outputs first: 6 + 16 bytes a node, 132 for six, working counter 18 in one LRW.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

NODES = 6


class Entry(NamedTuple):
    """An object mapped into process data; index 0 is padding."""

    index: int  # pyright: ignore[reportIncompatibleMethodOverride]
    subindex: int
    bits: int
    name: str

    @property
    def mapped(self) -> int:
        """The entry as 0x1600 and 0x1A00 hold it."""
        return self.index << 16 | self.subindex << 8 | self.bits


RX_PDO = 0x1600
TX_PDO = 0x1A00

OUTPUTS = (
    Entry(0x6040, 0, 16, "control word"),
    Entry(0x6071, 0, 16, "target torque"),
    Entry(0x6060, 0, 8, "mode of operation"),
    Entry(0x0000, 0, 8, "padding"),
)
INPUTS = (
    Entry(0x6041, 0, 16, "status word"),
    Entry(0x6064, 0, 32, "position actual value"),
    Entry(0x606C, 0, 32, "velocity actual value"),
    Entry(0x6077, 0, 16, "torque actual value"),
    Entry(0x6061, 0, 8, "mode of operation display"),
    Entry(0x0000, 0, 8, "padding"),
    Entry(0x603F, 0, 16, "error code"),
)

OUTPUT = np.dtype([("control", "<u2"), ("torque", "<i2"), ("mode", "i1"), ("padding", "u1")])
INPUT = np.dtype(
    [
        ("status", "<u2"),
        ("position", "<i4"),
        ("velocity", "<i4"),
        ("torque", "<i2"),
        ("mode", "i1"),
        ("padding", "u1"),
        ("error", "<u2"),
    ]
)
"""Target and actual torque are per mille of the rated current (6075): a drive in torque mode whose
motor is a coil. Position is in counts of the encoder, velocity in counts per second."""

OUTPUT_BYTES = OUTPUT.itemsize
INPUT_BYTES = INPUT.itemsize
CYCLIC_TORQUE = 10
"""Mode of operation 6060: cyclic synchronous torque."""

# Control word 6040 (CiA 402-2, table 24)
SWITCH_ON, ENABLE_VOLTAGE, NO_QUICK_STOP, ENABLE_OPERATION = 1, 2, 4, 8
FAULT_RESET = 0x80
DISABLE_VOLTAGE = 0x00
SHUTDOWN = ENABLE_VOLTAGE | NO_QUICK_STOP  # to ready to switch on
SWITCHED_ON = SHUTDOWN | SWITCH_ON
ENABLED = SWITCHED_ON | ENABLE_OPERATION
QUICK_STOP = ENABLE_VOLTAGE  # bit 2 is low when a quick stop is asked for

# Status word 6041: state under a mask (CiA 402-2, table 25)
STATES = {
    "not ready to switch on": (0x4F, 0x00),
    "switch on disabled": (0x4F, 0x40),
    "ready to switch on": (0x6F, 0x21),
    "switched on": (0x6F, 0x23),
    "operation enabled": (0x6F, 0x27),
    "quick stop active": (0x6F, 0x07),
    "fault reaction active": (0x4F, 0x0F),
    "fault": (0x4F, 0x08),
}
STO_ACTIVE = 0x4000
"""Bit 14 of the status word, which CiA 402 leaves to the maker: the torque path is open by STO."""


def drive_state(status: int) -> str:
    """Return the state of a drive in the words of CiA 402."""
    for name, (mask, value) in STATES.items():
        if status & mask == value:
            return name
    return "unknown"
