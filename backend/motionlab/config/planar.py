"""Pairs of an x and a y component; ``--set trajectory.amplitude.x=0.01`` reaches one of them.

The bounds only catch slips of unit (millimetres given as metres, degrees as radians); whether the
motor can follow is decided later, with time and place, by `motionlab.trajectories.feasibility`.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Annotated

from pydantic import Field

from motionlab.config.quantity import Config, quantity

AXES = ("x", "y")
"""The axes of the plane, in the order of every array that has a row or a column for each."""

_CATCHES_SLIPS = "range chosen by this project to catch slips of unit; zero leaves the axis at rest"

Coordinate = Annotated[float, Field(ge=-1.0, le=1.0)]
"""One coordinate of a listed point, m."""

Point = Annotated[tuple[Coordinate, Coordinate], Field(strict=False)]
"""A listed point (x, y), m; a TOML array is accepted, text and switches are not."""


class PlanarLength(Config):
    """A place or a distance in the plane, m; the origin is at mid-stroke."""

    x: float = quantity(
        "x component", unit="m", source=_CATCHES_SLIPS, default=0.0, ge=-1.0, le=1.0
    )
    y: float = quantity(
        "y component", unit="m", source=_CATCHES_SLIPS, default=0.0, ge=-1.0, le=1.0
    )


class PlanarVelocity(Config):
    """A velocity in the plane, m/s."""

    x: float = quantity(
        "x component", unit="m/s", source=_CATCHES_SLIPS, default=0.0, ge=-10.0, le=10.0
    )
    y: float = quantity(
        "y component", unit="m/s", source=_CATCHES_SLIPS, default=0.0, ge=-10.0, le=10.0
    )


class PlanarAcceleration(Config):
    """An acceleration, or half of one, in the plane, m/s^2."""

    x: float = quantity(
        "x component", unit="m/s^2", source=_CATCHES_SLIPS, default=0.0, ge=-100.0, le=100.0
    )
    y: float = quantity(
        "y component", unit="m/s^2", source=_CATCHES_SLIPS, default=0.0, ge=-100.0, le=100.0
    )


class PlanarAngle(Config):
    """A phase angle for each axis, rad."""

    x: float = quantity(
        "x component",
        unit="rad",
        source=_CATCHES_SLIPS,
        default=0.0,
        ge=-2 * math.pi,
        le=2 * math.pi,
    )
    y: float = quantity(
        "y component",
        unit="rad",
        source=_CATCHES_SLIPS,
        default=0.0,
        ge=-2 * math.pi,
        le=2 * math.pi,
    )


PAIRS = (PlanarLength, PlanarVelocity, PlanarAcceleration, PlanarAngle)
"""Pairs whose components are called and shown as the field that has them."""


def refuse_repeats(points: Sequence[Point]) -> None:
    """Refuse equal neighbouring points: an edge needs a length; ``dwell`` makes a pause.

    Raises
    ------
    ValueError
        With the index of the first repeated point.
    """
    for index, (here, there) in enumerate(itertools.pairwise(points)):
        if here == there:
            raise ValueError(
                f"point {index} is repeated by the next one in the order of the visit; "
                "neighbours must differ"
            )
