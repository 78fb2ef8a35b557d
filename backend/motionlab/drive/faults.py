"""What can go wrong on a drive link, in words, and what a person does about it."""

from __future__ import annotations

from typing import NamedTuple

LINK_LOST = 0x8700
FOLLOWING_ERROR = 0x8611
POSITION_LIMIT = 0x8612
SPEED_LIMIT = 0x8400
ENCODER = 0x7305
STO = 0x5440
NOT_A_NUMBER = 0x6320
LEFT_OPERATION = 0x8701
DRIVE_FAULT = 0x1000
NOT_ENABLED = 0x8702
WRONG_MODE = 0x8703
PHASE = 0x8704
DIVERGED = 0x8613
TRAVEL = 0x8614


class Fault(NamedTuple):
    """Name, unit of its figures and remedy of a fault."""

    name: str
    remedy: str
    unit: str = ""
    factor: float = 1.0


FAULTS = {
    LINK_LOST: Fault(
        "link lost",
        "Check cable and power of the drives and other masters on the bus; "
        "a busy machine that lets the loop sleep is a lost link, too.",
        "ms",
        1e3,
    ),
    FOLLOWING_ERROR: Fault(
        "following error beyond its window",
        "Look for a mechanical obstacle and a wrong commutation offset (commissioning); "
        "lower the speed or widen the window.",
        "\u00b5m",
        1e6,
    ),
    POSITION_LIMIT: Fault(
        "position beyond its limit", "Move the mover back by hand, then reset.", "mm", 1e3
    ),
    SPEED_LIMIT: Fault("speed beyond its limit", "Lower the speed of the trajectory.", "mm/s", 1e3),
    ENCODER: Fault(
        "encoder signal lost or implausible", "Check the encoder's cable and its reading head."
    ),
    STO: Fault(
        "safe torque off is active", "Release the emergency stop, then reset. STO is hard-wired."
    ),
    NOT_A_NUMBER: Fault("a command was not a number", "The controller diverged: lower its gains."),
    LEFT_OPERATION: Fault(
        "the drives left OP", "Their watchdog has de-energised them. Reset brings them up again."
    ),
    DRIVE_FAULT: Fault("fault of a drive", "See the drive's manual for its error code."),
    NOT_ENABLED: Fault(
        "a drive did not enable", "Check its supply voltage and its STO input, then reset."
    ),
    WRONG_MODE: Fault(
        "a drive is not in cyclic synchronous torque mode",
        "Look for another master, or a setting of the drive, that changes its mode (6060).",
    ),
    PHASE: Fault(
        "the exchange is not in phase with SYNC0",
        "Wait until the phase error is below 10 % of a cycle; check the load of this machine.",
        "\u00b5s",
        1e6,
    ),
    TRAVEL: Fault(
        "further from its beginning than a test may go",
        "Look for what else moves this axis; check its encoder and its phases.",
        "mm",
        1e3,
    ),
    DIVERGED: Fault("the controller diverged", "Lower its gains.", "\u00b5m", 1e6),
}

OF_AN_AXIS = frozenset(
    {FOLLOWING_ERROR, POSITION_LIMIT, SPEED_LIMIT, ENCODER, DIVERGED, TRAVEL},
)
"""Faults whose place is an axis; other places are drives."""

DRIVE_ERRORS = {
    0x2310: Fault(
        "continuous overcurrent",
        "Check the coil of this phase for a short to the frame, and its resistance.",
    ),
    0x2320: Fault("short circuit", "Check the coil of this phase and its cable for a short."),
    0x3210: Fault("supply voltage too high", "Check the supply, and what takes up braking energy."),
    0x3220: Fault("supply voltage too low", "Check the supply of the drive and its fuses."),
    0x4210: Fault("drive too hot", "Let it cool down; check its fan and the load."),
    0x5440: Fault("safe torque off", "Release the emergency stop. STO is hard-wired."),
    0x7305: Fault("encoder signal lost", "Check the encoder's cable and its reading head."),
    0x8130: Fault("heartbeat lost", "Check cable and load of this machine."),
    0x8700: Fault("synchronisation lost", "Check cable and load of this machine."),
}
"""Error codes 603F of CiA 402 that drives report most."""
