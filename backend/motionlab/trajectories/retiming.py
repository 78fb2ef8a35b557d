"""The same path, slower, until the motor can follow it."""

from __future__ import annotations

import math
from typing import Any

from pydantic import ValidationError

from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError, Infeasible
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.feasibility import check, refusal
from motionlab.trajectories.motion_limits import QUANTITIES, demands
from motionlab.trajectories.reference import Reference, sample
from motionlab.trajectories.trajectory_check import LimitSets

_POWERS = {
    "duration": 1,
    "lead_in": 1,
    "edge_time": 1,
    "lap_time": 1,
    "frequency": -1,
    "v_max": -1,
    "velocity": -1,
    "a_max": -2,
    "coefficient": -2,
    "j_max": -3,
}
"""Exponents by which the numbers of a motion profile scale with time; dwells are unchanged."""

_RESTS = frozenset({"point", "dwell", "step"})
_LARGEST = 1e4
_PRECISION = 1e-3
_POSITION = QUANTITIES.index("position")
LONGEST = 300.0
"""Longest motion that is slowed down, before or after, s: each trial samples all of it."""


def stretched(trajectory: TrajectoryConfig, factor: float) -> TrajectoryConfig:
    """Return a motion whose moves take `factor` times as long.

    Parameters
    ----------
    trajectory : TrajectoryConfig
        The motion.
    factor : float
        Stretch of time, > 0.

    Raises
    ------
    ConfigError
        If a number of its motion profile would leave its range.
    """
    try:
        return type(trajectory).model_validate(_scaled(trajectory.model_dump(), factor))
    except ValidationError:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="cannot be slowed down so far: its numbers leave their ranges",
                value=factor,
                unit="times",
            )
        ) from None


def slow_down(trajectory: TrajectoryConfig, limits: LimitSets) -> tuple[TrajectoryConfig, float]:
    """Find the smallest uniform stretch of time with which a motion is feasible.

    The stretch is found by bisection, to a thousandth; whole control periods round it a little.

    Parameters
    ----------
    trajectory : TrajectoryConfig
        The motion.
    limits : sequence of (Span, MotionLimits)
        When which limits hold.

    Returns
    -------
    TrajectoryConfig, float
        The slower motion and the stretch; the motion itself and 1 if it is feasible as it is.

    Raises
    ------
    Infeasible
        If it leaves the stroke, or jumps: no stretch helps.
    ConfigError
        If no stretch is found within the ranges of its numbers, or the motion gets too long.
    """
    _refuse_what_time_does_not_cure(trajectory, limits)
    if _feasible(trajectory, limits):
        return trajectory, 1.0
    low, high = 1.0, 2.0
    while not _feasible(stretched(trajectory, high), limits):
        low, high = high, 2.0 * high
        if high > _LARGEST:
            raise ConfigError(
                FieldError(
                    loc="trajectory",
                    message="stays infeasible however slow it is",
                    value=low,
                    unit="times slower",
                )
            )
    while high / low > 1.0 + _PRECISION:
        middle = math.sqrt(low * high)
        if _feasible(stretched(trajectory, middle), limits):
            high = middle
        else:
            low = middle
    return stretched(trajectory, high), high


def _scaled(table: dict[str, Any], factor: float) -> dict[str, Any]:
    if table["kind"] in _RESTS:
        return table
    if table["kind"] == "sequence":
        return table | {"parts": [_scaled(part, factor) for part in table["parts"]]}
    if table["kind"] == "samples":
        first = table["time"][0]
        times = tuple(first + (time - first) * factor for time in table["time"])
        return table | {"time": times}
    scaled = dict(table)
    for name, power in _POWERS.items():
        value = table.get(name)
        if isinstance(value, float):
            scaled[name] = value * factor**power
        elif isinstance(value, dict):
            scaled[name] = {axis: each * factor**power for axis, each in value.items()}
    return scaled


def _refuse_what_time_does_not_cure(trajectory: TrajectoryConfig, limits: LimitSets) -> None:
    reference = _sampled(trajectory)
    for span, each in limits:
        for demand in demands(reference, each, span=span):
            outside = demand.outside(_POSITION)
            if outside is not None:
                raise refusal(demand, _POSITION, int(outside.start[0]))


def _sampled(trajectory: TrajectoryConfig) -> Reference:
    reference = sample(trajectory)
    duration = reference.ticks * CONTROL_PERIOD
    if duration > LONGEST:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="lasts too long to be slowed down",
                value=duration,
                bounds={"maximum": LONGEST},
                unit="s",
            )
        )
    return reference


def _feasible(trajectory: TrajectoryConfig, limits: LimitSets) -> bool:
    reference = _sampled(trajectory)
    try:
        for span, each in limits:
            check(reference, each, span=span)
    except Infeasible:
        return False
    return True
