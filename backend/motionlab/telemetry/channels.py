"""The recorded channels: meaning, unit and instant of each.

A sample at tick k holds the state at t = k T_s and everything the controller computed from it;
thrust and acceleration are those just after the new command acts.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum

from motionlab.config.planar import AXES


class Owner(StrEnum):
    """Whose quantity a channel holds."""

    MACHINE = "machine"
    """Of the simulated machine; on a drive nothing measures it."""
    SENSED = "machine, measured"
    """Of the machine, and measured on a drive too."""
    CONTROLLER = "controller"
    REFERENCE = "reference"


@dataclass(frozen=True)
class Channel:
    """Name, unit, meaning and owner of a recorded column."""

    name: str
    unit: str
    meaning: str
    owner: Owner | None = None  # of a column that is none of ours


MACHINE, SENSED, CONTROLLER, REFERENCE = Owner

CHANNELS: tuple[Channel, ...] = (
    Channel("position", "m", "true position", MACHINE),
    Channel("position_measured", "m", "position read from the encoder", CONTROLLER),
    Channel("following_error", "m", "reference less measured position", CONTROLLER),
    Channel("velocity", "m/s", "true velocity", MACHINE),
    Channel("velocity_measured", "m/s", "difference of the measured position", CONTROLLER),
    Channel("acceleration", "m/s^2", "true acceleration", MACHINE),
    Channel("pd_force", "N", "PD force u, eq. (15), after its limit", CONTROLLER),
    Channel("friction", "N", "true friction f_f, eq. (20)", MACHINE),
    Channel("friction_estimate", "N", "estimated friction f_f*, eq. (23)", CONTROLLER),
    Channel("bristle", "m", "true bristle state z, eq. (21)", MACHINE),
    Channel("bristle_estimate", "m", "estimated bristle state z*, eq. (24)", CONTROLLER),
    Channel("K", "m/s", "adaptation term K of eq. (24)", CONTROLLER),
    Channel("disturbance_estimate", "N", "force of the disturbance observer", CONTROLLER),
    Channel("force_command", "N", "force command f*, eq. (17), after its limit", CONTROLLER),
    Channel(
        "force_realised",
        "N",
        "force in effect by the controller's map, after all limits",
        CONTROLLER,
    ),
    Channel("thrust", "N", "true thrust", MACHINE),
    Channel("normal_force", "N", "true normal force of the three phases", MACHINE),
    Channel("current_a", "A", "current of phase a", SENSED),
    Channel("current_b", "A", "current of phase b", SENSED),
    Channel("current_c", "A", "current of phase c", SENSED),
    Channel("current_command_a", "A", "current command of phase a", CONTROLLER),
    Channel("current_command_b", "A", "current command of phase b", CONTROLLER),
    Channel("current_command_c", "A", "current command of phase c", CONTROLLER),
    Channel("force_saturated", "1", "1 while the force command is at its limit", CONTROLLER),
    Channel("current_saturated", "1", "1 while a current command is at its limit", CONTROLLER),
)
"""Every channel of a lane: the only table of them."""

Sample = namedtuple("Sample", [channel.name for channel in CHANNELS])
"""One tick of one lane, a field for each channel."""

REFERENCES: tuple[Channel, ...] = (
    Channel("position_reference", "m", "commanded position", REFERENCE),
    Channel("velocity_reference", "m/s", "commanded velocity", REFERENCE),
    Channel("acceleration_reference", "m/s^2", "commanded acceleration", REFERENCE),
    Channel("load_force", "N", "external load force f_d", REFERENCE),
)
"""Channels of an axis that all variants share."""


def stream_columns(variants: Iterable[str]) -> list[tuple[str, Channel]]:
    """Return name and channel of every column of variants side by side, in the order of a ring.

    References come first, as ``x.position_reference``; then every channel of every variant, as
    ``A.x.following_error``.
    """
    shared = [(f"{axis}.{channel.name}", channel) for axis in AXES for channel in REFERENCES]
    return shared + [
        (f"{name}.{axis}.{channel.name}", channel)
        for name in variants
        for axis in AXES
        for channel in CHANNELS
    ]
