"""Commanded motions: one model per ``kind``."""

from __future__ import annotations

import tomllib
from typing import Annotated, Literal, Self

from pydantic import Field, TypeAdapter, model_validator

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
from motionlab.config.multisine import Multisine
from motionlab.config.quantity import Config, quantity
from motionlab.config.samples import Samples
from motionlab.config.shapes import Circle, Polygon, Sine, Star
from motionlab.config.validation_errors import members

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
    | DrawnPath
    | Samples
    | Multisine,
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
            field = type(part).model_fields.get("for_ever")
            if field is not None and vars(part)["for_ever"] != field.default:
                raise ValueError("for_ever belongs to the sequence as a whole, not to its parts")
            if isinstance(part, DrawnPath) and part.law == "time_optimal":
                raise ValueError(
                    "a path with law = 'time_optimal' is planned for the thrust where it lies, "
                    "and a part of a sequence is moved"
                )
        return self


TrajectoryConfig = Annotated[Part | Sequence, Field(discriminator="kind")]
"""Any motion."""

KINDS: dict[str, type[Config]] = {
    model.model_fields["kind"].default: model for model in members(TrajectoryConfig)
}
"""The model of each kind of motion."""

EXAMPLES: dict[str, str] = {
    "point": "position = { x = 0.01 }, duration = 1.0",
    "dwell": "duration = 0.5",
    "step": "height = { x = 5e-6 }",
    "ramp": "velocity = { x = 0.02 }",
    "parabola": "coefficient = { y = 0.05 }",
    "sine": "amplitude = { x = 0.01 }, frequency = 0.5",
    "circle": "radius = 0.015, frequency = 0.333",
    "line": "end = { x = 0.03, y = 0.01 }, v_max = 0.1, a_max = 2.0",
    "trapezoid": "end = { y = 0.1 }, v_max = 0.1, a_max = 1.0",
    "staircase": "step = { x = 5e-7 }",
    "polygon": "vertices = [[0.01, 0], [0, 0.01], [-0.01, 0]], frequency = 0.1",
    "star": "circumradius = 0.03, frequency = 0.05",
    "waypoints": "points = [[0, 0], [0.02, 0], [0.02, 0.03]], v_max = 0.1, a_max = 2.0",
    "samples": "time = [0, 0.5, 1, 1.5], x = [0, 0.001, 0.004, 0.009], y = [0, 0, 0, 0]",
    "multisine": "axis = 'y'",
    "path": "points = [[0, 0], [0.02, 0.02], [0.04, 0]], geometry = 'spline', lap_time = 2.0",
    "sequence": "parts = [{ kind = 'step', height = { x = 5e-6 } }, { kind = 'dwell' }]",
}
"""A motion of each kind, in TOML, as `{ kind = "line", ... }` of a scenario has it."""


def example(kind: str) -> TrajectoryConfig:
    """Return the example of a kind."""
    tables = tomllib.loads(f"motion = {{ kind = '{kind}', {EXAMPLES[kind]} }}")
    return TypeAdapter(TrajectoryConfig).validate_python(tables["motion"])
