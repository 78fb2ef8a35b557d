"""Circular test of a recording, the direction that it lacks simulated; docs/views.md."""

from __future__ import annotations

import math
from dataclasses import asdict
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis import ballbar as numbers
from motionlab.analysis.views.recorded import Recorded
from motionlab.config.planar import AXES
from motionlab.config.quantity import si
from motionlab.config.shapes import Circle as CircleConfig
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]

_LAPS = 2  # of a direction that is simulated: the last one counts
_DIGITS = 12  # of a length in m: a picometre
_METRES = Field(description="m")


class Harmonics(BaseModel):
    """F = mean + offset_x cos + offset_y sin + cos_2 cos 2 theta + sin_2 sin 2 theta, m."""

    mean: float
    offset_x: float
    offset_y: float
    cos_2: float
    sin_2: float


class BallbarDirection(BaseModel):
    """One lap in one direction."""

    labels: ClassVar[dict[str, str]] = {"quadrants": "at 0, 90, 180, 270 deg"}

    simulated: bool = Field(description="Not in the recording, so simulated for this answer")
    F_max: float = Field(description="Largest radial deviation about the reference's centre, m")
    F_min: float = Field(description="Least radial deviation, m")
    G: float = Field(description="Circular deviation about the least-squares centre, m")
    quadrants: list[float | None] = Field(
        description="Change of F where an axis reverses, at 0, 90, 180 and 270 degrees, outwards "
        "positive, m"
    )
    harmonics: Harmonics = Field(repr=False)
    deviation: list[float] = Field(description="F, mean of each half degree from 0, m")


class BallbarBoth(BaseModel):
    """Both directions together."""

    G: float = Field(description="Bi-directional circular deviation G(b), m")
    H: float = Field(description="Circular hysteresis, m")
    radius_error: float = Field(description="Mean radius less that of the reference, m")
    offset_x: float = _METRES
    offset_y: float = _METRES
    squareness: float = Field(description="A right angle less that between the axes, rad")
    scale_mismatch: float = si("Scale of x less that of y", "1", "ppm")
    servo_mismatch: float = Field(description="By how much x lags more than y, s")


class BallbarVariant(BaseModel):
    """One variant; empty where it diverged or was not measured over a lap."""

    directions: dict[str, BallbarDirection] = Field(description="ccw and cw")
    both: BallbarBoth | None = Field(description="null where a direction is missing")


class Ballbar(BaseModel):
    """Circular test, ISO 230-4 style, on the encoders."""

    radius: float = Field(description="Of the reference, m")
    center: list[float] = Field(description="Of the reference, x and y, m")
    feed: float = Field(description="Speed along the circle, m/s")
    step: float = Field(
        description="Between the points of a lap, rad; the first is at half of it", repr=False
    )
    variants: dict[str, BallbarVariant]
    note: str = Field(description="Why a direction is missing; empty where none is")


class _Measured(NamedTuple):
    theta: Array
    F: Array
    lap: numbers.Lap
    simulated: bool
    figures: numbers.DirectionFigures


def ballbar(recorded: Recorded) -> Ballbar:
    """Return the circular test of a recording.

    Raises
    ------
    ConfigError
        If its reference is no circle, or goes round it less than once.
    """
    x, y = recorded.reference()
    circle = numbers.circle_of(x, y)
    laps = numbers.last_laps(circle, x, y)
    if not laps:
        raise ConfigError(
            FieldError(
                "trajectory.laps",
                "the recording has no whole lap",
                recorded.end - recorded.start,
                unit="s",
            )
        )
    rate = max(_rate(lap, circle, x, y, recorded.period) for lap in laps.values())
    measured = _measure(recorded, circle, laps, simulated=False)
    note = ""
    if len(laps) == 1:
        (there,) = laps
        note, other = _other(recorded, "cw" if there == "ccw" else "ccw")
        if other is not None:
            own = other.reference()
            same = numbers.circle_of(*own)
            simulation = _measure(other, same, numbers.last_laps(same, *own), simulated=True)
            for name, each in simulation.items():
                measured[name] = each | measured.get(name, {})
    return Ballbar(
        radius=circle.radius,
        center=[circle.x, circle.y],
        feed=rate * circle.radius,
        step=2 * math.pi / numbers.GRID,
        variants={
            name: _variant(measured.get(name, {}), circle.radius, rate)
            for name in recorded.variants
        },
        note=note,
    )


def _rate(lap: numbers.Lap, circle: numbers.Circle, x: Array, y: Array, period: float) -> float:
    angle = np.unwrap(
        np.arctan2(y[lap.start : lap.stop] - circle.y, x[lap.start : lap.stop] - circle.x)
    )
    return abs(float(angle[-1] - angle[0])) / ((len(angle) - 1) * period)


def _measure(
    recorded: Recorded,
    circle: numbers.Circle,
    laps: dict[numbers.Direction, numbers.Lap],
    *,
    simulated: bool,
) -> dict[str, dict[numbers.Direction, _Measured]]:
    x, y = recorded.reference()
    counts = recorded.count(AXES[0]), recorded.count(AXES[1])
    measured: dict[str, dict[numbers.Direction, _Measured]] = {}
    for name in recorded.variants:
        errors = [recorded.column(f"{name}.{axis}.following_error") for axis in AXES]
        if errors[0] is None or errors[1] is None:
            continue
        theta, F = numbers.deviation(circle, x, y, errors[0], errors[1])
        for direction, lap in laps.items():
            own = slice(lap.start, lap.stop)
            if not np.isfinite(F[own]).all():
                continue
            heights = numbers.quadrant_heights(
                lap, (x, y), F, counts=counts, period=recorded.period
            )
            figures = numbers.figures_of(theta[own], F[own], heights)
            each = _Measured(theta[own], F[own], lap, simulated, figures)
            measured.setdefault(name, {})[direction] = each
    return measured


def _other(recorded: Recorded, direction: numbers.Direction) -> tuple[str, Recorded | None]:
    """Simulate a scenario in the other direction, or return why not."""
    scenario = recorded.scenario
    if recorded.simulate is None:
        return "the other direction was not recorded, and a real machine cannot be simulated", None
    if isinstance(scenario, str):
        return f"the other direction cannot be simulated: {scenario}", None
    if not isinstance(scenario.trajectory, CircleConfig):
        return (
            "the other direction cannot be simulated: its trajectory is not kind = 'circle'",
            None,
        )
    trajectory = scenario.trajectory.model_copy(update={"direction": direction, "laps": _LAPS})
    update = {"trajectory": trajectory, "learnt": None, "window": None, "schedule": ()}
    try:
        return "", recorded.simulate(scenario.model_copy(update=update))
    except ConfigError as problem:
        return f"the other direction cannot be simulated: {problem}", None


def _variant(
    measured: dict[numbers.Direction, _Measured], radius: float, rate: float
) -> BallbarVariant:
    both = None
    if len(measured) == 2:
        ccw, cw = ((measured[way].theta, measured[way].F) for way in ("ccw", "cw"))
        both = BallbarBoth(**asdict(numbers.both_figures(radius, rate, ccw, cw)))
    return BallbarVariant(
        directions={
            way: BallbarDirection(
                simulated=each.simulated,
                F_max=each.figures.F_max,
                F_min=each.figures.F_min,
                G=each.figures.G,
                quadrants=list(each.figures.quadrants),
                harmonics=Harmonics(**asdict(each.figures.harmonics)),
                deviation=np.round(numbers.on_grid(each.theta, each.F), _DIGITS).tolist(),
            )
            for way, each in sorted(measured.items())
        },
        both=both,
    )
