"""A path through points, drawn or listed in a file, and its motion profile.

Lengths are in m from mid-stroke, times in s. Phases are rounded up to whole control periods, so the
realised motion stays within its limits and every lap takes a whole number of them.
"""

from __future__ import annotations

import itertools
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from motionlab.config.moves import (
    OURS,
    REQUIRED,
    a_max_field,
    dwell_field,
    for_ever_field,
    v_max_field,
)
from motionlab.config.planar import Point, refuse_repeats
from motionlab.config.planned_motor import PlannedMotor
from motionlab.config.quantity import Config, quantity

POINTS_MAX = 6000
"""Most points of a path."""

TimeLaw = Literal["minimum_jerk", "trapezoid", "jerk_limited", "time_optimal", "constant_speed"]
_WITH_JERK = ("jerk_limited", "time_optimal")


class DrawnPath(Config):
    """Follow a polyline or a smooth curve through points with a motion profile.

    With every law but `constant_speed` a polyline stops at each of its points, a spline at its
    corners and ends; a closed one ends, and stops, where it starts.
    """

    kind: Literal["path"] = "path"
    points: Annotated[
        tuple[Point, ...], Field(strict=False, min_length=2, max_length=POINTS_MAX)
    ] = quantity("Points (x, y) in the order of the visit", shown="mm", unit="m", source=REQUIRED)
    closed: bool = quantity(
        "Whether the last point is joined to the first", unit="", source=OURS, default=False
    )
    geometry: Literal["polyline", "spline"] = quantity(
        "Straight edges, or the cubic spline through the points with continuous curvature",
        unit="",
        source=OURS,
        default="polyline",
    )
    corners: Annotated[
        tuple[Annotated[int, Field(ge=0, lt=POINTS_MAX)], ...],
        Field(strict=False, max_length=POINTS_MAX),
    ] = quantity(
        "Points, counted from 0 in rising order, at which a spline has a corner and the motion "
        "stops; any makes one of a closed path's start too",
        unit="1",
        source=OURS,
        default=(),
    )
    law: TimeLaw = quantity(
        "Motion profile along the path; constant_speed eases in and out at its two ends only",
        unit="",
        source=OURS,
        default="minimum_jerk",
    )
    v_max: float | None = v_max_field()
    a_max: float | None = a_max_field()
    j_max: float | None = quantity(
        "Largest jerk along the path, of jerk_limited and time_optimal only; in bends those of the "
        "axes are larger",
        label="max path jerk",
        unit="m/s^3",
        source=REQUIRED,
        default=None,
        ge=1e-6,
        le=1e6,
    )
    lap_time: float | None = quantity(
        "Time along the path once, dwells left out, instead of v_max, a_max and j_max; the edges "
        "of a polyline share it so that all have the same peak acceleration, ramps take a third "
        "of each, and those of constant_speed half a lap each",
        unit="s",
        source=REQUIRED,
        default=None,
        gt=0.0,
        le=3600.0,
    )
    laps: int = quantity(
        "Times along a closed path; metrics leave out the first",
        unit="1",
        source=OURS,
        default=1,
        ge=1,
        le=1000,
    )
    for_ever: bool = for_ever_field()
    dwell: float = dwell_field("Time at each stop, the first and the last included", default=0.0)
    planned_for: PlannedMotor | None = quantity(
        "Limits of the motor that a time_optimal profile keeps; left out, those of the motor and "
        "the controllers that it is prepared for, which are then filled in",
        unit="",
        source=OURS,
        default=None,
    )

    @model_validator(mode="after")
    def _goes_somewhere(self) -> Self:
        if self.closed and len(self.points) < 3:
            raise ValueError("a closed path needs three points or more")
        refuse_repeats((*self.points, self.points[0]) if self.closed else self.points)
        if self.laps > 1 and not self.closed:
            raise ValueError("more than one lap needs a closed path")
        return self

    @model_validator(mode="after")
    def _corners_are_points(self) -> Self:
        if self.corners and self.geometry == "polyline":
            raise ValueError("corners belong to geometry = 'spline' only")
        if any(after <= before for before, after in itertools.pairwise(self.corners)):
            raise ValueError("corners must be in rising order, each once")
        if self.corners and self.corners[-1] >= len(self.points):
            raise ValueError(
                f"corner {self.corners[-1]} is no point; points are counted from 0 to "
                f"{len(self.points) - 1}"
            )
        return self

    @model_validator(mode="after")
    def _is_timed_once(self) -> Self:
        limits = {"v_max": self.v_max, "a_max": self.a_max}
        if self.law in _WITH_JERK:
            limits["j_max"] = self.j_max
        elif self.j_max is not None:
            raise ValueError("j_max belongs to law = 'jerk_limited' and 'time_optimal' only")
        if self.law != "time_optimal":
            if self.planned_for is not None:
                raise ValueError("planned_for belongs to law = 'time_optimal' only")
        elif self.lap_time is not None:
            raise ValueError("law = 'time_optimal' takes v_max, a_max and j_max, no lap_time")
        names = [name for name, value in limits.items() if value is not None]
        timed = self.lap_time is not None
        if (timed and (names or self.j_max is not None)) or (
            not timed and len(names) < len(limits)
        ):
            *others, last = limits
            raise ValueError(f"give either lap_time, or {', '.join(others)} and {last} together")
        return self
