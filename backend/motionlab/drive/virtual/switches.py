"""Fault switches: what can be made to go wrong while a segment runs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError

from motionlab.config.quantity import Config, Whole
from motionlab.config.validation_errors import field_errors
from motionlab.drive.virtual import layout
from motionlab.drive.virtual.layout import NODES, Arrays
from motionlab.errors import ConfigError
from motionlab.timing import PLANT_STEP

_JUMP = 2**24
Axes = Literal["", "x", "y", "xy"]
Node = Annotated[Whole, Field(ge=1, le=NODES)]
Code = Annotated[Whole, Field(ge=1, le=0xFFFF)]


class Push(Config):
    """A push of the mover by hand."""

    axis: Literal["x", "y"]
    force: float = Field(ge=-100.0, le=100.0, description="N, towards positive positions")
    time: float = Field(gt=0.0, le=60.0, description="s")


class Failing(Config):
    """A drive and the error it fails with."""

    node: Node = Field(description="Drive, from 1")
    code: Code = Field(description="Error code 603F, or AL status code")


class Switches(Config):
    """What goes wrong from now on. Fields that are left out stay as they are."""

    drop: float | None = Field(
        default=None, ge=0.0, le=1.0, description="Share of frames lost, half of them unprocessed"
    )
    duplicate: float | None = Field(
        default=None, ge=0.0, le=1.0, description="Share of answers sent twice"
    )
    reorder: float | None = Field(
        default=None, ge=0.0, le=1.0, description="Share of answers that the next one overtakes"
    )
    delay: float | None = Field(
        default=None, ge=0.0, le=0.1, description="Time by which answers are late, s"
    )
    black_hole: bool | None = Field(default=None, description="Every frame is lost")
    freeze: bool | None = Field(
        default=None, description="Frames wait unread; when it ends, all are answered"
    )
    link: Whole | None = Field(
        default=None,
        ge=0,
        le=NODES,
        description="Drives that are reached: the cable behind the last one is out",
    )
    counter: Whole | None = Field(
        default=None, ge=-100, le=100, description="Added to the working counter of process data"
    )
    jump_x: Whole | None = Field(
        default=None, ge=-_JUMP, le=_JUMP, description="Added to the position of x, counts"
    )
    jump_y: Whole | None = Field(
        default=None, ge=-_JUMP, le=_JUMP, description="Added to the position of y, counts"
    )
    stuck: Axes | None = Field(default=None, description="Axes whose encoder stays where it is")
    encoder_loss: Axes | None = Field(
        default=None, description="Axes whose encoder is lost: error 0x7305"
    )
    sto: bool | None = Field(default=None, description="Safe torque off, all drives")
    fault: Failing | None = Field(default=None, description="A drive fails, once")
    safeop: Failing | None = Field(default=None, description="A drive falls to SAFEOP, once")
    push: Push | None = Field(default=None, description="The mover is pushed, once")
    clear: bool = Field(default=False, description="Whether to switch everything else off first")


_NUMBERS = {
    "drop": layout.DROP,
    "duplicate": layout.DUPLICATE,
    "reorder": layout.REORDER,
    "delay": layout.DELAY,
    "black_hole": layout.BLACK_HOLE,
    "freeze": layout.FREEZE,
    "link": layout.REACHED,
    "counter": layout.WRONG_COUNTER,
    "jump_x": layout.JUMP_X,
    "jump_y": layout.JUMP_Y,
    "sto": layout.STO,
}
_BY_AXIS = {"stuck": layout.STUCK_X, "encoder_loss": layout.ENCODER_LOST_X}


def parse_switches(document: Mapping[str, Any]) -> Switches:
    """Return switches as validated.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value and range.
    """
    try:
        return Switches.model_validate(dict(document))
    except ValidationError as error:
        raise ConfigError(*field_errors(error, Switches)) from None


def set_switches(s: Arrays, switches: Switches) -> None:
    """Put switches into effect."""
    if switches.clear:
        clear_switches(s)
    for name, row in _NUMBERS.items():
        value = getattr(switches, name)
        if value is not None:
            s.switches[row] = float(value)
    for name, row in _BY_AXIS.items():
        axes = getattr(switches, name)
        if axes is not None:
            for i, axis in enumerate("xy"):
                s.switches[row + i] = float(axis in axes)
    if switches.fault is not None:
        s.nodes[switches.fault.node - 1, layout.FAULT_REQUEST] = switches.fault.code
    if switches.safeop is not None:
        s.nodes[switches.safeop.node - 1, layout.DROP_REQUEST] = switches.safeop.code
    if switches.push is not None:
        axis = "xy".index(switches.push.axis)
        s.switches[layout.PUSH_X + axis] = switches.push.force
        steps = max(round(switches.push.time / PLANT_STEP), 1)
        s.switches[layout.PUSH_STEPS_X + axis] = float(steps)


def clear_switches(s: Arrays) -> None:
    """Let nothing go wrong from now on. Faults of drives stay until a master resets them."""
    s.switches[:] = 0.0
    s.switches[layout.REACHED] = NODES


def switched(s: Arrays) -> dict[str, Any]:
    """Return the switches in effect, those that are off left out."""
    switches: dict[str, Any] = {
        name: s.switches[row].item()
        for name, row in _NUMBERS.items()
        if s.switches[row] != (NODES if row == layout.REACHED else 0.0)
    }
    for name, row in _BY_AXIS.items():
        axes = "".join(axis for i, axis in enumerate("xy") if s.switches[row + i] > 0.0)
        switches |= {name: axes} if axes else {}
    return switches
