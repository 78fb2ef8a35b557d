"""Point-to-point moves and dwells.

Lengths are in m from mid-stroke, times in s. Every duration is rounded to whole control periods
when the motion is sampled, phase by phase, so that time never drifts.
"""

from __future__ import annotations

from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.planar import (
    PlanarAcceleration,
    PlanarLength,
    PlanarVelocity,
    Point,
    refuse_repeats,
)
from motionlab.config.quantity import Config, quantity

OURS = "this project's choice; the paper prints none"
REQUIRED = "chosen by the scenario; range chosen by this project"

_HOUR = 3600.0


def _start() -> PlanarLength:
    return quantity(
        "Where the motion starts", shown="mm", unit="m", source=OURS, default=PlanarLength()
    )


def dwell_field(description: str, *, gt: float | None = None, default: float = 1.0) -> float:
    """Declare a dwell time; zero is allowed unless `gt` is given."""
    ge = 0.0 if gt is None else None
    return quantity(description, unit="s", source=OURS, default=default, ge=ge, gt=gt, le=_HOUR)


def v_max_field(*, default: float | None = None) -> float:
    """Declare the largest speed along a path; optional without a default."""
    return quantity(
        "Largest speed along the path",
        label="max speed",
        shown="mm/s",
        unit="m/s",
        source=f"{REQUIRED}; the paper's y motions stay below 0.15 m/s",
        default=default,
        ge=1e-6,
        le=10.0,
    )


def a_max_field(*, default: float | None = None) -> float:
    """Declare the largest acceleration along a path; optional without a default."""
    return quantity(
        "Largest acceleration along the path; in bends those of the axes, which the motor limits, "
        "are larger",
        label="max path accel.",
        unit="m/s^2",
        source=f"{REQUIRED}; the thrust map reaches 28.1 N / 13.9 kg = 2.0 m/s^2 less friction "
        "on y",
        default=default,
        ge=1e-6,
        le=100.0,
    )


def for_ever_field() -> bool:
    """Declare whether a live session repeats a motion for ever."""
    return quantity(
        "Whether a live session repeats it for ever; else it ends there after its laps too, as it "
        "does in runs, what-ifs and files",
        label="for ever",
        unit="",
        source=OURS,
        default=True,
    )


def laps_field() -> int:
    """Declare how often a motion is done that ends where it starts."""
    return quantity(
        "Times that all of it is done; more than once needs an end where it starts, and leaves the "
        "first out of metrics",
        unit="1",
        source=OURS,
        default=1,
        ge=1,
        le=1000,
    )


class PointTarget(Config):
    """Stand still at one place."""

    kind: Literal["point"] = "point"
    position: PlanarLength = quantity(
        "Where to stand", shown="mm", unit="m", source=OURS, default=PlanarLength()
    )
    duration: float = quantity("How long", unit="s", source=OURS, default=1.0, gt=0.0, le=_HOUR)


class Dwell(Config):
    """Stand still where the previous part of a sequence ended; alone, at mid-stroke."""

    kind: Literal["dwell"] = "dwell"
    duration: float = quantity("How long", unit="s", source=OURS, default=1.0, gt=0.0, le=_HOUR)


class Step(Config):
    """Jump from one control period to the next; at most 10 um, or the motion is infeasible."""

    kind: Literal["step"] = "step"
    start: PlanarLength = _start()
    height: PlanarLength = quantity("Height of the step", shown="µm", unit="m", source=REQUIRED)
    delay: float = quantity(
        "Time at the start before the step", unit="s", source=OURS, default=0.1, gt=0.0, le=_HOUR
    )
    dwell: float = dwell_field("Time after the step", gt=0.0)


class RampMove(Config):
    """Move at constant velocity, eq (40)."""

    kind: Literal["ramp"] = "ramp"
    start: PlanarLength = _start()
    velocity: PlanarVelocity = quantity(
        "Velocity per axis", shown="mm/s", unit="m/s", source=REQUIRED
    )
    lead_in: float = quantity(
        "Time in which the velocity is eased from rest, part of the duration; 0 jumps to it, which "
        "is feasible for slow ramps only",
        label="lead-in",
        unit="s",
        source=OURS,
        default=0.1,
        ge=0.0,
        le=60.0,
    )
    duration: float = quantity("How long", unit="s", source=OURS, default=1.0, gt=0.0, le=_HOUR)


class Parabola(Config):
    """Move from rest at constant acceleration, p = start + R t^2, eq (40)."""

    kind: Literal["parabola"] = "parabola"
    start: PlanarLength = _start()
    coefficient: PlanarAcceleration = quantity(
        "R per axis, half the acceleration", unit="m/s^2", source=REQUIRED
    )
    duration: float = quantity("How long", unit="s", source=OURS, default=0.5, gt=0.0, le=_HOUR)


class Trapezoid(Config):
    """Move along a line with trapezoidal velocity, dwelling at both ends."""

    kind: Literal["trapezoid"] = "trapezoid"
    start: PlanarLength = _start()
    end: PlanarLength = quantity("Where the line ends", shown="mm", unit="m", source=REQUIRED)
    v_max: float = v_max_field(default=0.15)
    a_max: float = a_max_field(default=1.6)
    dwell: float = dwell_field("Time at each end, before the first move too")
    there_and_back: bool = quantity("Return to the start", unit="", source=OURS, default=True)
    cycles: int = quantity("Repetitions", unit="1", source=OURS, default=1, ge=1, le=1000)
    for_ever: bool = for_ever_field()
    thrust_reserve: float | None = quantity(
        "Share of the force sharing's linear range that it leaves to feedback to be feasible; left "
        "out: the scenario's",
        label="thrust reserve",
        shown="%",
        unit="1",
        source=OURS,
        default=None,
        ge=0,
        le=0.9,
    )

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        if self.start == self.end:
            raise ValueError("start and end must differ")
        if self.cycles > 1 and not self.there_and_back:
            raise ValueError("more than one cycle needs there_and_back")
        return self


class Staircase(Config):
    """Climb `count` equal steps and, if wanted, come down again, dwelling on every level.

    True steps (at most 10 um) when neither `v_max` nor `a_max` is given, moves with trapezoidal
    velocity when both are.
    """

    kind: Literal["staircase"] = "staircase"
    start: PlanarLength = _start()
    step: PlanarLength = quantity(
        "Displacement of one step",
        shown="µm",
        unit="m",
        source="Huang et al. 2019, Table 1, has 0.5 um and 50 mm; otherwise the scenario's",
    )
    count: int = quantity(
        "Steps up", label="steps", unit="1", source=OURS, default=5, ge=1, le=1000
    )
    there_and_back: bool = quantity("Come down again", unit="", source=OURS, default=True)
    dwell: float = dwell_field("Time on each level, the first included", gt=0.0)
    laps: int = laps_field()
    for_ever: bool = for_ever_field()
    v_max: float | None = v_max_field()
    a_max: float | None = a_max_field()

    @model_validator(mode="after")
    def _climbs(self) -> Self:
        if self.step == PlanarLength():
            raise ValueError("step must not be zero on both axes")
        if (self.v_max is None) != (self.a_max is None):
            raise ValueError("give v_max and a_max together, or neither for true steps")
        if self.laps > 1 and not self.there_and_back:
            raise ValueError("more than one lap needs there_and_back")
        return self


class _Edges(Config):
    """Timing shared by the motions made of single minimum-jerk edges."""

    dwell: float = dwell_field("Time at each point, the first and the last included")
    v_max: float | None = v_max_field()
    a_max: float | None = a_max_field()
    edge_time: float | None = quantity(
        "Time of every edge, instead of v_max and a_max",
        label="time of an edge",
        unit="s",
        source=REQUIRED,
        default=None,
        gt=0.0,
        le=_HOUR,
    )

    @model_validator(mode="after")
    def _is_timed_once(self) -> Self:
        by_limits = self.v_max is not None and self.a_max is not None
        half_given = (self.v_max is None) != (self.a_max is None)
        if half_given or by_limits == (self.edge_time is not None):
            raise ValueError("give either edge_time, or both v_max and a_max")
        return self


class Line(_Edges):
    """Move once along a line with minimum jerk."""

    kind: Literal["line"] = "line"
    start: PlanarLength = _start()
    end: PlanarLength = quantity("Where the line ends", shown="mm", unit="m", source=REQUIRED)

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        if self.start == self.end:
            raise ValueError("start and end must differ")
        return self


class Waypoints(_Edges):
    """Visit a list of points with one minimum-jerk edge between neighbours, stopping at each."""

    kind: Literal["waypoints"] = "waypoints"
    points: Annotated[tuple[Point, ...], Field(strict=False, min_length=2, max_length=10_000)] = (
        quantity("Points (x, y) in the order of the visit", shown="mm", unit="m", source=REQUIRED)
    )

    laps: int = laps_field()
    for_ever: bool = for_ever_field()

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        refuse_repeats(self.points)
        if self.laps > 1 and self.points[0] != self.points[-1]:
            raise ValueError("more than one lap needs a last point equal to the first")
        return self
