"""Friction anatomy of a recording: true, estimated and compensated friction; docs/views.md."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field

from motionlab.analysis import friction_anatomy as numbers
from motionlab.analysis.views.recorded import Recorded
from motionlab.config.planar import AXES
from motionlab.config.plant import FrictionConfig
from motionlab.config.quantity import si
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]

REVERSALS_DRAWN = 8
"""Latest reversals that are drawn; figures are of all."""
SAMPLES_DRAWN = 20_000
"""Most samples that are drawn: 10 s."""
POINTS = 3000
"""Most points of an axis, shared by its variants, each of which has `POINTS_LEAST` at least."""
POINTS_LEAST = 300

_DIGITS = 7  # of the largest number of a column
_CHANNELS = ("position", "velocity", "friction", "friction_estimate", "bristle", "bristle_estimate")
_NEWTON = Field(description="N")
_METRES = Field(description="m")


class FrictionParameters(BaseModel):
    """LuGre friction, eqs (20) to (22)."""

    sigma_0: float = Field(description="Bristle stiffness, N/m")
    sigma_1: float = Field(description="Bristle damping, N s/m")
    sigma_2: float = Field(description="Viscous friction, N s/m")
    F_c: float = Field(description="Coulomb friction, N")
    F_s: float = Field(description="Stiction, N")
    v_s: float = Field(description="Stribeck velocity, m/s")


class FrictionFigures(BaseModel):
    """Figures of one axis under one variant, over the whole stretch."""

    mismatch_rms: float = Field(description="RMS of estimated less true friction, N")
    mismatch_max: float = Field(description="Largest size of it, N")
    compensated: float | None = si(
        "1 - RMS(friction less compensation)/RMS(friction); null without friction, or "
        "where the controller in effect is not known",
        "1",
        "%",
    )
    breakaway: float | None = Field(
        description="Largest friction in the new direction within presliding after a reversal, "
        "median, N"
    )
    breakaway_estimate: float | None = Field(description="The same of the estimate, N")
    stiffness: float | None = Field(
        description="Slope of friction over displacement where friction crosses zero after a "
        "reversal, median, N/m"
    )
    stiffness_estimate: float | None = Field(description="The same of the estimate, N/m")


class FrictionCurves(BaseModel):
    """Samples at the times of the axis."""

    position: list[float] = _METRES
    displacement: list[float | None] = Field(
        description="Way from the last turn, in the direction of motion, m; null before the first"
    )
    velocity: list[float] = Field(description="m/s")
    friction: list[float] = _NEWTON
    estimate: list[float] = _NEWTON
    compensation: list[float] | None = Field(
        description="Estimate that is added to the force command, N; null where the controller in "
        "effect is not known"
    )
    bristle: list[float] = _METRES
    bristle_estimate: list[float] = _METRES


class FrictionVariant(BaseModel):
    """One variant; without figures and curves where it diverged."""

    model: FrictionParameters | None = Field(
        description="Friction that the controller assumes; null where it is off or not known"
    )
    stribeck: list[float] | None = Field(description="Its Stribeck curve, N")
    figures: FrictionFigures | None = Field(
        description="null where it diverged, or was not recorded throughout"
    )
    curves: FrictionCurves | None


class FrictionAxis(BaseModel):
    """One axis that moves."""

    motor: FrictionParameters | None = Field(
        description="Friction of the motor; null where it is off or not known"
    )
    velocities: list[float] = Field(description="Of the Stribeck curves, m/s")
    stribeck: list[float] | None = Field(description="Stribeck curve of the motor, N")
    reached: float = Field(description="Largest true speed in the stretch, m/s")
    presliding: float = Field(description="Displacement that presliding takes, m")
    reversals: int = Field(description="Of the reference, in the stretch")
    time: list[float] = Field(description="Of the drawn samples, s")
    direction: list[int] = Field(description="Since the last reversal; 0 before the first")
    variants: dict[str, FrictionVariant]


class FrictionAnatomy(BaseModel):
    """Friction of each axis that moves."""

    start: float = Field(description="Of the stretch, s")
    end: float = Field(description="Of the stretch, s")
    axes: dict[str, FrictionAxis]
    note: str = Field(description="What is not known, and why; empty where all is")


class _Measured(NamedTuple):
    """One variant on one axis: figures, and the drawn part of its channels."""

    reached: float
    figures: FrictionFigures
    drawn: dict[str, Array]


def friction(recorded: Recorded) -> FrictionAnatomy:
    """Return the friction anatomy of a recording.

    Raises
    ------
    ConfigError
        If no axis moves, or friction was not recorded.
    """
    axes = {
        axis: _axis(recorded, axis)
        for axis in AXES
        if np.ptp(recorded.needed(f"{axis}.position_reference")) > 0.0
    }
    if not axes:
        raise ConfigError(FieldError("trajectory", "no axis moves, so there is no friction to see"))
    return FrictionAnatomy(
        start=recorded.start,
        end=recorded.end,
        axes=axes,
        note=""
        if _known(recorded)
        else f"Parameters and compensation are not known for all of it: {recorded.scenario}",
    )


def _known(recorded: Recorded) -> Scenario | None:
    return recorded.scenario if isinstance(recorded.scenario, Scenario) else None


def _motion(recorded: Recorded, axis: str) -> Array:
    """Return the velocity of a reference at each sample, or that of its steps."""
    velocity = recorded.column(f"{axis}.velocity_reference")
    if velocity is not None and np.any(velocity):
        return velocity
    position = recorded.needed(f"{axis}.position_reference")
    return np.diff(position, prepend=position[0])


def _axis(recorded: Recorded, axis: str) -> FrictionAxis:
    known = _known(recorded)
    motion = _motion(recorded, axis)
    turns = numbers.reversals(motion)
    motor = getattr(known.plant, axis).friction if known else None
    length = _presliding(motor)
    count = len(motion)
    first = turns[-REVERSALS_DRAWN - 1].tick if len(turns) > REVERSALS_DRAWN else 0
    drawn = slice(max(first, count - SAMPLES_DRAWN), count)
    columns = {
        name: _measure(recorded, (name, axis), motion, length=length, drawn=drawn)
        for name in recorded.variants
    }
    measured = {name: one for name, one in columns.items() if one is not None}
    reached = max((one.reached for one in measured.values()), default=0.0)
    models = {
        name: getattr(known.variants[name].controller.model, axis).friction if known else None
        for name in recorded.variants
    }
    curves = [one for one in (motor, *models.values()) if one is not None and one.enabled]
    velocities = numbers.stribeck_velocities(reached, [one.v_s for one in curves])
    picked = _picked(measured, length, drawn.stop - drawn.start)
    direction = np.zeros(count, dtype=np.int64)
    for turn in turns:
        direction[turn.tick : turn.end] = turn.direction
    return FrictionAxis(
        motor=_parameters(motor),
        velocities=_rounded(velocities),
        stribeck=_stribeck(motor, velocities),
        reached=reached,
        presliding=length,
        reversals=len(turns),
        time=np.round((recorded.first + drawn.start + picked) * recorded.period, 7).tolist(),
        direction=direction[drawn][picked].tolist(),
        variants={
            name: FrictionVariant(
                model=_parameters(models[name]),
                stribeck=_stribeck(models[name], velocities),
                figures=None if one is None else one.figures,
                curves=None if one is None else _curves(one.drawn, picked),
            )
            for name, one in columns.items()
        },
    )


def _presliding(motor: FrictionConfig | None) -> float:
    if motor is None or not motor.enabled:
        return numbers.PRESLIDING_UNKNOWN
    return numbers.PRESLIDING * motor.F_s / motor.sigma_0


def _measure(
    recorded: Recorded,
    lane: tuple[str, str],
    motion: Array,
    *,
    length: float,
    drawn: slice,
) -> _Measured | None:
    names = [".".join((*lane, channel)) for channel in _CHANNELS]
    columns = recorded.whole(names)
    if columns is None:
        for name in names:
            recorded.needed(name)
        return None
    position, velocity, friction, estimate, bristle, bristle_estimate = columns
    added = _added(_known(recorded), *lane)
    motion_parts = numbers.branches(motion, position)
    true = numbers.presliding(motion_parts, position, friction, length)
    believed = numbers.presliding(motion_parts, position, estimate, length)
    rms, largest = numbers.mismatch(friction, estimate)
    figures = FrictionFigures(
        mismatch_rms=rms,
        mismatch_max=largest,
        compensated=None if added is None else numbers.compensated(friction, added * estimate),
        breakaway=true.breakaway,
        breakaway_estimate=believed.breakaway,
        stiffness=true.stiffness,
        stiffness_estimate=believed.stiffness,
    )
    channels = {
        "position": position,
        "displacement": numbers.displacement(motion_parts, position),
        "velocity": velocity,
        "friction": friction,
        "estimate": estimate,
        "bristle": bristle,
        "bristle_estimate": bristle_estimate,
    }
    if added is not None:
        channels["compensation"] = added * estimate
    part = {key: values[drawn].copy() for key, values in channels.items()}
    return _Measured(float(np.abs(velocity).max()), figures, part)


def _added(known: Scenario | None, name: str, axis: str) -> float | None:
    """Return 1 where a controller adds its estimate to the command, 0 where it does not."""
    if known is None:
        return None
    controller = known.variants[name].controller
    law = controller.compensation
    model = getattr(controller.model, axis).friction
    return float(law.enabled and law.law != "off" and model.enabled)


def _picked(measured: dict[str, _Measured], length: float, count: int) -> NDArray[np.int64]:
    """Return the samples drawn as points, the same for all variants of an axis."""
    curves: list[Array] = [np.zeros(count)]
    for one in measured.values():
        away = np.nan_to_num(one.drawn["displacement"])
        curves += [one.drawn[key] for key in ("velocity", "friction", "estimate", "bristle")]
        curves.append(np.clip(away, 0.0, length))
    most = max(POINTS_LEAST, POINTS // max(1, len(measured)))
    return numbers.spread_evenly(curves, most)


def _parameters(friction: FrictionConfig | None) -> FrictionParameters | None:
    if friction is None or not friction.enabled:
        return None
    return FrictionParameters(**friction.model_dump(exclude={"enabled"}))


def _stribeck(friction: FrictionConfig | None, velocities: Array) -> list[float] | None:
    if friction is None or not friction.enabled:
        return None
    return _rounded(numbers.stribeck_curve(friction.parameters(), velocities))


def _curves(drawn: dict[str, Array], picked: NDArray[np.int64]) -> FrictionCurves:
    away = drawn["displacement"][picked]
    columns: dict[str, Any] = {key: _rounded(values[picked]) for key, values in drawn.items()}
    columns.setdefault("compensation", None)
    columns["displacement"] = [
        None if math.isnan(each) else round(each, 10) for each in away.tolist()
    ]
    return FrictionCurves(**columns)


def _rounded(values: Array) -> list[float]:
    """Return numbers to `_DIGITS` digits of the largest."""
    most = float(np.nanmax(np.abs(values), initial=0.0))
    if most == 0.0:
        return np.zeros(len(values)).tolist()
    return np.round(values, _DIGITS - 1 - math.floor(math.log10(most))).tolist()
