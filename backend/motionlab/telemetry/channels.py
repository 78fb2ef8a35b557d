"""The recorded channels: meaning, unit and instant of each.

A sample at tick k holds the state at t = k T_s and everything the controller computed from it;
thrust and acceleration are those just after the new command acts.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

from motionlab.config.planar import AXES
from motionlab.lanes import Lanes


class Sample(NamedTuple):
    """One tick of one lane; the order of the fields is the order of the recorded channels."""

    position: Lanes
    position_measured: Lanes
    following_error: Lanes
    velocity: Lanes
    velocity_measured: Lanes
    acceleration: Lanes
    pd_force: Lanes
    friction: Lanes
    friction_estimate: Lanes
    bristle: Lanes
    bristle_estimate: Lanes
    K: Lanes
    disturbance_estimate: Lanes
    force_command: Lanes
    force_realised: Lanes
    thrust: Lanes
    normal_force: Lanes
    current_a: Lanes
    current_b: Lanes
    current_c: Lanes
    current_command_a: Lanes
    current_command_b: Lanes
    current_command_c: Lanes
    force_saturated: Lanes
    current_saturated: Lanes


@dataclass(frozen=True)
class Channel:
    """Name, unit and meaning of a recorded column."""

    name: str
    unit: str
    meaning: str


CHANNELS: tuple[Channel, ...] = (
    Channel("position", "m", "true position"),
    Channel("position_measured", "m", "position read from the encoder"),
    Channel("following_error", "m", "reference less measured position"),
    Channel("velocity", "m/s", "true velocity"),
    Channel("velocity_measured", "m/s", "difference of the measured position"),
    Channel("acceleration", "m/s^2", "true acceleration"),
    Channel("pd_force", "N", "PD force u, eq. (15), after its limit"),
    Channel("friction", "N", "true friction f_f, eq. (20)"),
    Channel("friction_estimate", "N", "estimated friction f_f*, eq. (23)"),
    Channel("bristle", "m", "true bristle state z, eq. (21)"),
    Channel("bristle_estimate", "m", "estimated bristle state z*, eq. (24)"),
    Channel("K", "m/s", "adaptation term K of eq. (24)"),
    Channel("disturbance_estimate", "N", "force of the disturbance observer"),
    Channel("force_command", "N", "force command f*, eq. (17), after its limit"),
    Channel("force_realised", "N", "force in effect by the controller's map, after all limits"),
    Channel("thrust", "N", "true thrust"),
    Channel("normal_force", "N", "true normal force of the three phases"),
    Channel("current_a", "A", "current of phase a"),
    Channel("current_b", "A", "current of phase b"),
    Channel("current_c", "A", "current of phase c"),
    Channel("current_command_a", "A", "current command of phase a"),
    Channel("current_command_b", "A", "current command of phase b"),
    Channel("current_command_c", "A", "current command of phase c"),
    Channel("force_saturated", "1", "1 while the force command is at its limit"),
    Channel("current_saturated", "1", "1 while a current command is at its limit"),
)
"""Every channel of a lane, in the order of Sample."""

REFERENCES: tuple[Channel, ...] = (
    Channel("position_reference", "m", "commanded position"),
    Channel("velocity_reference", "m/s", "commanded velocity"),
    Channel("acceleration_reference", "m/s^2", "commanded acceleration"),
    Channel("load_force", "N", "external load force f_d"),
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
