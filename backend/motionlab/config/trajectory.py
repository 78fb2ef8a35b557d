"""Commanded motions: one model per ``kind``."""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.moves import (
    REQUIRED,
    Dwell,
    Line,
    Parabola,
    PointTarget,
    RampMove,
    Staircase,
    Step,
    Trapezoid,
    Waypoints,
    for_ever_field,
    laps_field,
)
from motionlab.config.quantity import Config, quantity
from motionlab.config.shapes import Circle, Polygon, Sine, Star

Part = Annotated[
    PointTarget
    | Dwell
    | Step
    | RampMove
    | Parabola
    | Sine
    | Circle
    | Line
    | Trapezoid
    | Staircase
    | Polygon
    | Star
    | Waypoints
    | DrawnPath,
    Field(discriminator="kind"),
]
"""Any motion but a sequence."""


class Sequence(Config):
    """Do several motions one after another; each is moved to start where the one before ended."""

    kind: Literal["sequence"] = "sequence"
    parts: Annotated[tuple[Part, ...], Field(strict=False, min_length=1, max_length=100)] = (
        quantity("The motions in their order", unit="", source=REQUIRED)
    )
    laps: int = laps_field()
    for_ever: bool = for_ever_field()

    @model_validator(mode="after")
    def _keeps_its_places(self) -> Self:
        for part in self.parts:
            if not getattr(part, "for_ever", True):
                raise ValueError("for_ever belongs to the sequence as a whole, not to its parts")
            if isinstance(part, DrawnPath) and part.law == "time_optimal":
                raise ValueError(
                    "a path with law = 'time_optimal' is planned for the thrust where it lies, "
                    "and a part of a sequence is moved"
                )
        return self


TrajectoryConfig = Annotated[Part | Sequence, Field(discriminator="kind")]
"""Any motion."""
