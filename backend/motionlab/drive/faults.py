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
COMMANDER_GONE = 0x8703
PHASE = 0x8704
DIVERGED = 0x8613


class Fault(NamedTuple):
    """Name, unit of its figures and remedy of a fault."""

    name: str
    remedy: str
    unit: str = ""
    factor: float = 1.0


FAULTS = {
    LINK_LOST: Fault(
        "link lost", "Check cable, power of the drives and the other masters on the bus.", "ms", 1e3
    ),
    FOLLOWING_ERROR: Fault(
        "following error beyond its window",
        "Look for a mechanical obstacle; lower the speed or widen the window.",
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
    COMMANDER_GONE: Fault(
        "the server stopped answering", "The motion was stopped. Reset, then arm again."
    ),
    PHASE: Fault(
        "the exchange is not in phase with SYNC0",
        "Wait until the phase error is below 10 % of a cycle; check the load of this machine.",
        "\u00b5s",
        1e6,
    ),
    DIVERGED: Fault("the controller diverged", "Lower its gains.", "\u00b5m", 1e6),
}

DRIVE_ERRORS = {
    0x2310: "continuous overcurrent",
    0x2320: "short circuit",
    0x3210: "supply voltage too high",
    0x3220: "supply voltage too low",
    0x4210: "drive too hot",
    0x5440: "safe torque off",
    0x7305: "encoder signal lost",
    0x8130: "heartbeat lost",
    0x8700: "synchronisation lost",
}
"""Error codes 603F of CiA 402 that drives report most."""
