"""A force that was learnt of a motion, one number for each control period of its lap."""

from __future__ import annotations

import base64
import binascii
import functools
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from motionlab.config.planar import Coordinate
from motionlab.config.quantity import Config, quantity
from motionlab.declarations import OURS
from motionlab.timing import CONTROL_PERIOD

TICKS_MIN, TICKS_MAX = 400, 90_000
"""Shortest and longest lap, control periods: 0.2 and 45 s, which a request of 1 MB holds."""
FORCE_MAX = 100.0
"""Largest force, N."""
PLACES = 64
"""Positions by which a motion is known again, evenly over its lap."""

_LETTERS = 4 * (-(-4 * TICKS_MAX // 3))
_Encoded = Annotated[str, Field(max_length=_LETTERS)]
_Place = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]


class LearntForce(Config):
    """A force that was learnt of a motion: added at each control period of a lap, lap after lap.

    `motionlab learn` makes it: docs/learning.md. Numbers are 4-byte floats, N, as base64.
    """

    laps: int = quantity(
        "Laps that it was learnt in", unit="1", source=OURS, default=0, ge=0, le=1_000_000
    )
    places: Annotated[
        tuple[_Place, ...], Field(strict=False, min_length=PLACES, max_length=PLACES)
    ] = quantity(
        f"Position at {PLACES} instants of the lap: it is of this motion only",
        unit="m",
        source="the motion that it was learnt of",
    )
    x: _Encoded = Field(description="Force on x in each control period of the lap")
    y: _Encoded = Field(description="Force on y in each control period of the lap")

    @model_validator(mode="after")
    def _is_a_force(self) -> Self:
        sizes = {}
        for axis in ("x", "y"):
            force = _decoded(getattr(self, axis))
            if force is None or not TICKS_MIN <= len(force) <= TICKS_MAX:
                raise ValueError(
                    f"{axis} holds no {TICKS_MIN} to {TICKS_MAX} 4-byte floats as base64, "
                    f"one for each {1e3 * CONTROL_PERIOD:g} ms of the lap"
                )
            wrong = np.flatnonzero(~(np.abs(force) <= FORCE_MAX))
            if wrong.size:
                row = int(wrong[0])
                raise ValueError(
                    f"{axis} is {force[row]:g} N in period {row}; allowed +-{FORCE_MAX:g} N"
                )
            sizes[axis] = len(force)
        if sizes["x"] != sizes["y"]:
            raise ValueError(f"x and y need equally many values, not {sizes['x']} and {sizes['y']}")
        return self

    @property
    def force(self) -> NDArray[np.float32]:
        """The force in each control period of the lap, N, (ticks, 2); read-only."""
        return _both(self.x, self.y)


def encoded(force: NDArray[np.floating]) -> str:
    """Return a force, N, (ticks,), as `LearntForce` has it."""
    return base64.b64encode(np.asarray(force, dtype="<f4").tobytes()).decode("ascii")


def _decoded(text: str) -> NDArray[np.float32] | None:
    try:
        data = base64.b64decode(text, validate=True)
    except (binascii.Error, ValueError):
        return None
    return np.frombuffer(data, dtype="<f4") if len(data) % 4 == 0 else None


@functools.lru_cache(maxsize=8)
def _both(x: str, y: str) -> NDArray[np.float32]:
    on_x, on_y = _decoded(x), _decoded(y)
    assert on_x is not None  # as validated
    assert on_y is not None
    force = np.stack((on_x, on_y), axis=1)
    force.setflags(write=False)
    return force
