"""Accuracy and repeatability of an axis, in the style of ISO 230-2; docs/views.md."""

from __future__ import annotations

from dataclasses import asdict
from typing import Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from motionlab.analysis import positioning as numbers
from motionlab.analysis.views.recorded import Recorded
from motionlab.config.drawn_path import DrawnPath
from motionlab.config.planar import AXES
from motionlab.config.plant import AxisConfig
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]
Axis = Literal["x", "y"]
Instrument = Literal["true", "encoder"]
Group = tuple[float, list[numbers.Rest], list[numbers.Rest]]

OVERRUN = 2e-3
"""How far beyond the outer targets the axis turns, m."""
SPEED, ACCELERATION, JERK = 0.15, 0.5, 20.0
"""Limits of the moves, m/s, m/s^2 and m/s^3, the former two unless those of the axis are lower; an
axis comes to rest the same way at all targets, also after the overrun."""
SHARE = 0.5
"""Of the largest speed and acceleration of the axis."""

_DIGITS = 12  # of a length in m: a picometre
_METRES = Field(description="m")


class PositioningCycle(BaseModel):
    """A test cycle."""

    model_config = ConfigDict(
        json_schema_extra={
            "examples": [
                {"scenario": "circle-matched", "axis": "y", "targets": 3, "runs": 2}
                | {"dwell": 0.2, "low": -0.01, "high": 0.01}
            ]
        }
    )

    axis: Axis | None = Field(
        default=None,
        description="Which axis; left out: x, or of a run the one with more targets",
    )
    targets: int = Field(default=5, ge=2, le=50, strict=True, description="Targets of the cycle")
    runs: int = Field(
        default=5, ge=2, le=50, strict=True, description="Approaches of each in each direction"
    )
    dwell: float = Field(
        default=0.5,
        ge=numbers.REST,
        le=10.0,
        allow_inf_nan=False,
        description="Rest at each target, s; a position is the mean over its last 0.1 s, or half",
    )
    low: float | None = Field(
        default=None,
        ge=-1.0,
        le=1.0,
        allow_inf_nan=False,
        description="First target, m; left out: the end of the stroke less the overrun of 2 mm",
    )
    high: float | None = Field(
        default=None, ge=-1.0, le=1.0, allow_inf_nan=False, description="Last target, m; likewise"
    )
    instrument: Instrument = Field(
        default="true", description="What measures: the true position, or the encoder"
    )


class PositioningTarget(BaseModel):
    """Deviations at one target, actual less target position."""

    place: float = Field(description="Target position P_i, m")
    up: list[float] = Field(description="x_ij of approaches in the positive direction, m")
    down: list[float] = Field(description="x_ij of approaches in the negative direction, m")
    mean_up: float = _METRES
    mean_down: float = _METRES
    s_up: float = Field(description="Standard deviation, positive direction, m")
    s_down: float = Field(description="Standard deviation, negative direction, m")
    reversal: float = Field(description="B_i, m")
    repeatability: float = Field(description="Bidirectional repeatability R_i, m")


class PositioningFigures(BaseModel):
    """Figures of the axis, k = 2."""

    A: float = Field(description="Bidirectional accuracy, m")
    A_up: float = Field(description="Unidirectional accuracy, positive direction, m")
    A_down: float = Field(description="Unidirectional accuracy, negative direction, m")
    E: float = Field(description="Bidirectional systematic deviation, m")
    E_up: float = Field(description="Unidirectional systematic deviation, positive direction, m")
    E_down: float = Field(description="Unidirectional systematic deviation, negative direction, m")
    M: float = Field(description="Range of the mean bidirectional deviation, m")
    R: float = Field(description="Bidirectional repeatability, m")
    R_up: float = Field(description="Unidirectional repeatability, positive direction, m")
    R_down: float = Field(description="Unidirectional repeatability, negative direction, m")
    B: float = Field(description="Reversal value: largest size of B_i, m")
    B_mean: float = Field(description="Mean of B_i, m")


class PositioningVariant(BaseModel):
    """One variant; empty where it diverged."""

    targets: list[PositioningTarget]
    figures: PositioningFigures | None = Field(
        description="null where it diverged, or was not measured"
    )


class Positioning(BaseModel):
    """Accuracy and repeatability, ISO 230-2 style."""

    axis: Axis
    simulated: bool = Field(description="A test cycle that was simulated, not a kept run")
    duration: float = Field(description="Of what was looked at, s")
    instrument: Instrument
    resolution: float = Field(
        description="Of the instrument, m: true positions are recorded in single precision; 0 "
        "where it is not known"
    )
    variants: dict[str, PositioningVariant]
    note: str = Field(description="What is different from what was asked for; empty if nothing")


def measured_scenario(scenario: Scenario, cycle: PositioningCycle) -> Scenario:
    """Return a scenario that goes through a test cycle, without schedule and load steps.

    Raises
    ------
    ConfigError
        If the targets do not lie within the stroke, or the last not beyond the first.
    """
    axis = cycle.axis or AXES[0]
    own: AxisConfig = getattr(scenario.plant, axis)
    end = own.stroke - OVERRUN
    low = -end if cycle.low is None else cycle.low
    high = end if cycle.high is None else cycle.high
    limits = {"minimum": -end, "maximum": end}
    for name, place in (("low", low), ("high", high)):
        if not -end <= place <= end:
            message = f"leaves no room of {1e3 * OVERRUN:g} mm to turn within the stroke"
            raise ConfigError(FieldError(name, message, place, "", "m", limits))
    least = low + numbers.SAME * 10 * (cycle.targets - 1)
    if high < least:
        message = "has to lie beyond the first target"
        raise ConfigError(FieldError("high", message, high, "", "m", {"minimum": least}))
    stops = numbers.cycle(numbers.targets_in(low, high, cycle.targets), OVERRUN, cycle.runs)
    points = tuple((place, 0.0) if axis == AXES[0] else (0.0, place) for place in stops)
    trajectory = DrawnPath(
        points=points,
        law="jerk_limited",
        dwell=cycle.dwell,
        v_max=min(SPEED, SHARE * own.velocity_max),
        a_max=min(ACCELERATION, SHARE * own.acceleration_max),
        j_max=JERK,
    )
    load = scenario.load.model_copy(update={"steps": ()})
    without = {"schedule": (), "window": None, "learnt": None}
    update = without | {"trajectory": trajectory, "load": load}
    return scenario.model_copy(update=update)


def positioning(recorded: Recorded, cycle: PositioningCycle) -> Positioning:
    """Return accuracy and repeatability of an axis.

    Parameters
    ----------
    recorded : Recorded
        A recording that rests at targets.
    cycle : PositioningCycle
        Axis and instrument; the rest of it is what `measured_scenario` made of it.

    Raises
    ------
    ConfigError
        If it rests at no target approached twice or more in each direction.
    """
    period = recorded.period
    axes: tuple[Axis, ...] = (cycle.axis,) if cycle.axis else ("x", "y")
    groups_of: dict[Axis, list[Group]] = {
        axis: numbers.grouped(numbers.rests(recorded.needed(f"{axis}.position_reference"), period))
        for axis in axes
    }
    axis = max(groups_of, key=lambda each: len(groups_of[each]))
    groups = groups_of[axis]
    if not groups:
        message = (
            f"rests at no target of {' or '.join(axes)} that is approached twice or more in each "
            "direction; of a scenario a test cycle is simulated, as in the Lab"
        )
        raise ConfigError(FieldError("run", message))
    instrument, note = _instrument(recorded, axis, cycle.instrument)
    return Positioning(
        axis=axis,
        simulated=recorded.simulated,
        duration=recorded.end - recorded.start,
        instrument=instrument,
        resolution=_resolution(recorded, axis, instrument, [place for place, _, _ in groups]),
        variants={
            name: _variant(recorded, f"{name}.{axis}", instrument, groups)
            for name in recorded.variants
        },
        note=note,
    )


def _instrument(recorded: Recorded, axis: str, instrument: Instrument) -> tuple[Instrument, str]:
    if instrument == "true" and all(
        recorded.column(f"{name}.{axis}.position") is None for name in recorded.variants
    ):
        return "encoder", "true positions were not recorded, so the encoder measures"
    return instrument, ""


def _resolution(
    recorded: Recorded, axis: str, instrument: Instrument, places: list[float]
) -> float:
    if instrument == "encoder":
        return recorded.count(axis)
    return float(np.spacing(np.float32(max(abs(place) for place in places))))


def _variant(
    recorded: Recorded,
    lane: str,
    instrument: Instrument,
    groups: list[Group],
) -> PositioningVariant:
    channel = "position" if instrument == "true" else "following_error"
    values = recorded.column(f"{lane}.{channel}")
    if values is None:
        return PositioningVariant(targets=[], figures=None)

    def deviations(place: float, rests: list[numbers.Rest]) -> Array:
        shown = np.array([numbers.read(rest, values, recorded.period) for rest in rests])
        return shown - place if instrument == "true" else -shown

    targets = [
        numbers.Target(place, deviations(place, up), deviations(place, down))
        for place, up, down in groups
    ]
    if not all(np.isfinite([*target.up, *target.down]).all() for target in targets):
        return PositioningVariant(targets=[], figures=None)
    figures = PositioningFigures(**asdict(numbers.figures_of(targets)))
    return PositioningVariant(targets=[_target(each) for each in targets], figures=figures)


def _target(target: numbers.Target) -> PositioningTarget:
    return PositioningTarget(
        place=target.place,
        up=np.round(target.up, _DIGITS).tolist(),
        down=np.round(target.down, _DIGITS).tolist(),
        mean_up=target.mean_up,
        mean_down=target.mean_down,
        s_up=target.s_up,
        s_down=target.s_down,
        reversal=target.reversal,
        repeatability=target.repeatability,
    )
