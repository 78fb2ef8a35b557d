"""A motion given by its positions over time."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import Field, field_validator, model_validator

from motionlab.config.moves import REQUIRED
from motionlab.config.planar import Coordinate
from motionlab.config.quantity import Config, quantity
from motionlab.declarations import OURS

SAMPLES_MAX = 100_000
"""Most samples of a motion: 50 s at 2 kHz."""

_PLACE_MAX = 1.0  # m
_TIME_MAX = 1e9  # s
_LONGEST = 3600.0  # s
_REST = 1e-3  # m/s

Instant = Annotated[float, Field(ge=-_TIME_MAX, le=_TIME_MAX)]
"""Time of a sample, s."""


class Samples(Config):
    """Follow given positions over time, as recorded or planned by another program.

    The motion starts with the first sample, at rest. Between samples it is a cubic spline with
    continuous velocity and acceleration, which goes through every one of them.
    """

    kind: Literal["samples"] = "samples"
    time: Annotated[
        tuple[Instant, ...], Field(strict=False, min_length=2, max_length=SAMPLES_MAX)
    ] = quantity("Time of each sample, rising", unit="s", source=REQUIRED)
    x: Annotated[
        tuple[Coordinate, ...], Field(strict=False, min_length=2, max_length=SAMPLES_MAX)
    ] = quantity("Position x at each sample", shown="mm", unit="m", source=REQUIRED)
    y: Annotated[
        tuple[Coordinate, ...], Field(strict=False, min_length=2, max_length=SAMPLES_MAX)
    ] = quantity("Position y at each sample", shown="mm", unit="m", source=REQUIRED)
    for_ever: bool = quantity(
        "Whether a live session repeats it for ever where it ends where it starts",
        label="for ever",
        unit="",
        source=OURS,
        default=False,
    )

    @field_validator("time", "x", "y", mode="before")
    @classmethod
    def _is_finite(cls, values: Any, info: Any) -> Any:
        """Name the first row that is wrong: a file may have as many as it has rows."""
        if not isinstance(values, list | tuple) or len(values) > SAMPLES_MAX:
            return values
        limit = _TIME_MAX if info.field_name == "time" else _PLACE_MAX
        unit = "s" if info.field_name == "time" else "m"
        numbers = [type(value) in {int, float} for value in values]
        if not all(numbers):
            row = numbers.index(False)
            raise ValueError(f"row {row} is no number: {str(values[row])[:40]!r}")
        try:
            array = np.array(values, dtype=np.float64)
        except OverflowError:
            return values
        wrong = np.flatnonzero(~(np.abs(array) <= limit))
        if wrong.size:
            row = int(wrong[0])
            raise ValueError(f"row {row} is {array[row]:g} {unit}; allowed +-{limit:g} {unit}")
        return values

    @model_validator(mode="after")
    def _is_a_motion(self) -> Self:
        if not len(self.time) == len(self.x) == len(self.y):
            counts = f"{len(self.time)}, {len(self.x)} and {len(self.y)}"
            raise ValueError(f"time, x and y need equally many values, not {counts}")
        time = np.array(self.time)
        back = np.flatnonzero(np.diff(time) <= 0.0)
        if back.size:
            row = int(back[0]) + 1
            raise ValueError(
                f"time must rise: row {row} is {time[row]:.9g} s after {time[row - 1]:.9g} s"
            )
        if time[-1] - time[0] > _LONGEST:
            raise ValueError(
                f"lasts {time[-1] - time[0]:.6g} s from row 0 to row {len(time) - 1}; "
                f"allowed up to {_LONGEST:g} s"
            )
        for axis in ("x", "y"):
            self._check_rest(axis, time, np.array(getattr(self, axis)[:3]))
        return self

    @staticmethod
    def _check_rest(axis: str, time: Any, place: Any) -> None:
        """Compare the speed at the first of three samples, of a parabola, with the mean one."""
        if len(place) < 3:
            return
        first, both = time[1] - time[0], time[2] - time[0]
        mean = (place[2] - place[0]) / both
        speed = (place[1] - place[0]) / first
        speed += (speed - mean) * first / (both - first)
        if abs(mean) > _REST and speed * np.sign(mean) > 0.5 * abs(mean):
            raise ValueError(
                f"must start at rest: {axis} moves at {speed:.4g} m/s at row 0, "
                f"{time[0]:.6g} s; allowed +-{_REST:g} m/s"
            )
