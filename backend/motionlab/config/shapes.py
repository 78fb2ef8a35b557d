"""Figures that repeat: sine, circle, polygon and star.

Lengths are in m from mid-stroke, times in s. A lap of circle, polygon and star takes a whole number
of control periods, so that laps repeat sample for sample; the sine keeps its exact frequency, which
enters eqs (41) and (42).
"""

from __future__ import annotations

import math
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.moves import OURS, REQUIRED, dwell_field, for_ever_field
from motionlab.config.planar import PlanarAngle, PlanarLength, Point, refuse_repeats
from motionlab.config.quantity import Config, quantity


def _center() -> PlanarLength:
    return quantity(
        "Centre of the figure",
        label="centre",
        shown="mm",
        unit="m",
        source=OURS,
        default=PlanarLength(),
    )


def _lead_in() -> float | None:
    return quantity(
        "Time in which the phase rate is eased from rest to its full value, and, unless it is "
        "repeated for ever, back to rest after the last lap; half a period when left out, 0 starts "
        "at full speed",
        label="lead-in",
        unit="s",
        source=OURS,
        default=None,
        ge=0.0,
        le=60.0,
    )


def _frequency(description: str) -> float:
    return quantity(description, unit="Hz", source=REQUIRED, ge=1e-4, le=100.0)


class Sine(Config):
    """Oscillate, p = center + B sin(2 pi f t + phase), eqs (41) and (42)."""

    kind: Literal["sine"] = "sine"
    center: PlanarLength = _center()
    amplitude: PlanarLength = quantity("B per axis", shown="mm", unit="m", source=REQUIRED)
    frequency: float = quantity(
        "Cycles per second; 20 control periods a cycle at the limit",
        unit="Hz",
        source=REQUIRED,
        ge=1e-4,
        le=100.0,
    )
    phase: PlanarAngle = quantity(
        "Phase per axis at the start", shown="°", unit="rad", source=OURS, default=PlanarAngle()
    )
    cycles: int = quantity(
        "Cycles after the lead-in", unit="1", source=OURS, default=3, ge=1, le=100_000
    )
    for_ever: bool = for_ever_field()
    lead_in: float | None = _lead_in()


class Circle(Config):
    """Go round a circle at constant speed after a smooth start."""

    kind: Literal["circle"] = "circle"
    center: PlanarLength = _center()
    radius: float = quantity("Radius", shown="mm", unit="m", source=REQUIRED, gt=0.0, le=1.0)
    frequency: float = _frequency("Laps per second; one lap is rounded to whole control periods")
    direction: Literal["ccw", "cw"] = quantity(
        "Sense of rotation seen from above", unit="", source=OURS, default="ccw"
    )
    start_angle: float = quantity(
        "Angle of the start from the x axis",
        shown="°",
        unit="rad",
        source=OURS,
        default=0.0,
        ge=-2 * math.pi,
        le=2 * math.pi,
    )
    laps: int = quantity(
        "Laps after the lead-in; metrics use the last two",
        unit="1",
        source=OURS,
        default=3,
        ge=1,
        le=100_000,
    )
    for_ever: bool = for_ever_field()
    lead_in: float | None = _lead_in()


class Polygon(Config):
    """Draw a closed polygon, a minimum-jerk edge of equal time at a time, stopping at corners."""

    kind: Literal["polygon"] = "polygon"
    vertices: Annotated[tuple[Point, ...], Field(strict=False, min_length=3, max_length=256)] = (
        quantity(
            "Corners (x, y); the last is joined to the first", shown="mm", unit="m", source=REQUIRED
        )
    )
    frequency: float = _frequency("Laps per second; one edge is rounded to whole control periods")
    laps: int = quantity(
        "Laps; metrics leave out the first", unit="1", source=OURS, default=3, ge=1, le=1000
    )
    dwell: float = dwell_field("Time at each corner, besides that of the edges", default=0.0)
    for_ever: bool = for_ever_field()

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        refuse_repeats((*self.vertices, self.vertices[0]))
        return self


class Star(Config):
    """Draw the star polygon {points/density} with long chords; {5/2} is the pentagram.

    Timed like a polygon.
    """

    kind: Literal["star"] = "star"
    center: PlanarLength = _center()
    circumradius: float = quantity(
        "Distance of the points from the centre",
        shown="mm",
        unit="m",
        source="30 mm inferred from Huang et al. 2019, Table 1: 57.06 mm = 2 R sin 72 deg; "
        "otherwise the scenario's",
        gt=0.0,
        le=1.0,
    )
    points: int = quantity(
        "Number of points",
        unit="1",
        source="5: the pentagram of Huang et al. 2019, Table 1",
        default=5,
        ge=5,
        le=99,
    )
    density: int = quantity(
        "Each chord leads this many points further round",
        unit="1",
        source="2: the pentagram of Huang et al. 2019, Table 1",
        default=2,
        ge=2,
        le=49,
    )
    start_angle: float = quantity(
        "Angle of the first point from the x axis",
        shown="°",
        unit="rad",
        source=f"pi/2, a point straight up: {OURS}",
        default=math.pi / 2,
        ge=-2 * math.pi,
        le=2 * math.pi,
    )
    frequency: float = _frequency("Laps per second; one chord is rounded to whole control periods")
    laps: int = quantity(
        "Laps; metrics leave out the first", unit="1", source=OURS, default=3, ge=1, le=1000
    )
    dwell: float = dwell_field("Time at each corner, besides that of the edges", default=0.0)
    for_ever: bool = for_ever_field()

    @model_validator(mode="after")
    def _is_one_stroke(self) -> Self:
        if 2 * self.density >= self.points or math.gcd(self.points, self.density) != 1:
            raise ValueError(
                f"{{{self.points}/{self.density}}} cannot be drawn in one stroke: density must be "
                "below points/2 and share no factor with points"
            )
        return self
