"""Check of a motion as data to draw, with all its violations."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.planar import AXES
from motionlab.config.shapes import Circle, Polygon, Star
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.lanes import cached
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.cusps import cusp_note
from motionlab.trajectories.motion_limits import (
    ALWAYS,
    QUANTITIES,
    UNITS,
    Demand,
    Flags,
    Intervals,
    MotionLimits,
    Span,
    demands,
    place_at,
)
from motionlab.trajectories.motion_profile import mean_acceleration
from motionlab.trajectories.path import Array
from motionlab.trajectories.reference import Reference, sample

VIOLATIONS_MAX = 50
"""Violations that are listed; the worst ones."""

Bins = NDArray[np.float32]

LimitSets = Sequence[tuple[Span, MotionLimits]]
"""When which limits hold; of several variants all hold at once."""


@dataclass(frozen=True)
class LimitViolation:
    """An interval in which one quantity of one axis is outside its limit.

    Attributes
    ----------
    quantity, axis : str
        Quantity outside its limit, and its axis.
    start, end : float
        First and last instant outside the limit, s.
    time : float
        Instant of the worst value, s.
    place : tuple of float
        Reference position (x, y) then, m.
    value, limit : float
        Worst value, with its sign, and the magnitude allowed there, in `unit`.
    unit : str
        Unit of value and limit.
    """

    quantity: str
    axis: str
    start: float
    end: float
    time: float
    place: tuple[float, float]
    value: float
    limit: float
    unit: str

    @property
    def share(self) -> float:
        """Worst value over its limit."""
        return abs(self.value) / self.limit if self.limit else float("inf")


@dataclass(frozen=True)
class Peak:
    """The largest magnitude of one quantity of one axis, and its share of the limit."""

    quantity: str
    axis: str
    value: float
    limit: float | None
    share: float | None
    unit: str


@dataclass(frozen=True)
class Profile:
    """One curve: the smallest and the largest value in each bin, both of shape (bins,)."""

    name: str
    unit: str
    minimum: NDArray[np.float32]
    maximum: NDArray[np.float32]


@dataclass(frozen=True)
class Examination:
    """A motion against its limits.

    Attributes
    ----------
    duration : float
        Time of the whole motion, s.
    examined : float
        Time covered by profiles and violations: one lap of a motion that repeats, s.
    length : float
        Arc length in that time, m.
    extent : dict of str to (float, float)
        Least and largest position of each axis in that time, m.
    step : float
        Time that a bin of the profiles stands for, s.
    profiles : list of Profile
        Position, speed, velocity, acceleration, jerk, thrust and available thrust, and the sum of
        2**k of every violated quantity, numbered as in `QUANTITIES`.
    peaks : list of Peak
        Largest magnitude of each quantity of each axis.
    violations : list of LimitViolation
        Worst first, `VIOLATIONS_MAX` at most.
    violation_count : int
        How many there are.
    notes : list of str
        What a user must know of the motion: that a faster one may exist, or where it turns back.
    reserve : float
        Share of the thrust that the limits leave to feedback.
    """

    duration: float
    examined: float
    length: float
    extent: dict[str, tuple[float, float]]
    step: float
    profiles: list[Profile]
    peaks: list[Peak]
    violations: list[LimitViolation]
    violation_count: int
    notes: list[str]
    reserve: float

    @property
    def feasible(self) -> bool:
        """Whether the motor can follow."""
        return self.violation_count == 0


def examine(trajectory: TrajectoryConfig, limits: LimitSets, *, bins: int) -> Examination:
    """Check a motion against the limits and decimate its profiles.

    Parameters
    ----------
    trajectory : TrajectoryConfig
        The motion; of laps that repeat sample for sample one is examined.
    limits : sequence of (Span, MotionLimits)
        When which limits hold, at least one; the profiles show the first.
    bins : int
        Points of each profile at most.

    Raises
    ------
    ConfigError
        If the motion lasts longer than an hour.
    """
    one = _one_lap(trajectory) if all(span == ALWAYS for span, _ in limits) else trajectory
    reference = sample(one)
    laps_left = 0 if one is trajectory else _laps(trajectory) - 1
    all_demands = [each for span, most in limits for each in demands(reference, most, span=span)]
    violations, count = _worst(reference, all_demands)
    first = all_demands[: len(AXES)]
    size = max(1, -(-reference.ticks // bins))
    return Examination(
        duration=(reference.ticks + laps_left * reference.period) * CONTROL_PERIOD,
        examined=reference.ticks * CONTROL_PERIOD,
        length=_way(reference.position),
        extent={
            name: (
                float(reference.position[:, axis].min()),
                float(reference.position[:, axis].max()),
            )
            for axis, name in enumerate(AXES)
        },
        step=size * CONTROL_PERIOD,
        profiles=[
            *_profiles(reference, first, limits[0][1], size),
            _flags(all_demands, size),
        ],
        peaks=_peaks(first),
        violations=violations,
        violation_count=count,
        notes=_notes(trajectory, reference, feasible=count == 0),
        reserve=limits[0][1].reserve,
    )


def _notes(trajectory: TrajectoryConfig, reference: Reference, *, feasible: bool) -> list[str]:
    if feasible:
        return list(reference.notes)
    note = cusp_note(trajectory)
    return [note] if note else []


def _one_lap(trajectory: TrajectoryConfig) -> TrajectoryConfig:
    repeats = isinstance(trajectory, Circle | Polygon | Star) or (
        isinstance(trajectory, DrawnPath) and trajectory.law != "constant_speed"
    )
    if not repeats or _laps(trajectory) == 1:
        return trajectory
    return trajectory.model_copy(update={"laps": 1})


def _laps(trajectory: TrajectoryConfig) -> int:
    return getattr(trajectory, "laps", 1)


def _worst(reference: Reference, demands: list[Demand]) -> tuple[list[LimitViolation], int]:
    """Return the worst intervals outside a limit, and how many there are."""
    outside = [
        each
        for demand in demands
        for quantity in range(len(QUANTITIES))
        if (each := demand.outside(quantity)) is not None
    ]
    if not outside:
        return [], 0
    with np.errstate(divide="ignore"):
        shares = np.concatenate([np.abs(each.value) / each.limit for each in outside])
    owners = [(each, i) for each in outside for i in range(len(each.start))]
    order = np.argsort(-shares, kind="stable")[:VIOLATIONS_MAX]
    return [_violation(reference, *owners[index]) for index in order], len(owners)


def _violation(reference: Reference, outside: Intervals, index: int) -> LimitViolation:
    worst = int(outside.worst[index])
    return LimitViolation(
        quantity=QUANTITIES[outside.quantity],
        axis=AXES[outside.axis],
        start=int(outside.start[index]) * CONTROL_PERIOD,
        end=(int(outside.stop[index]) - 1) * CONTROL_PERIOD,
        time=worst * CONTROL_PERIOD,
        place=place_at(reference, worst),
        value=float(outside.value[index]),
        limit=float(outside.limit[index]),
        unit=UNITS[outside.quantity],
    )


def _profiles(
    reference: Reference, demands: list[Demand], limits: MotionLimits, size: int
) -> Iterable[Profile]:
    """Yield position, speed and, per axis, required and available quantities."""
    for axis, name in enumerate(AXES):
        first = reference.position[::size, axis].astype(np.float32)
        yield Profile(f"{name}.position", "m", first, first)
    yield Profile("speed", "m/s", *_speed(reference.velocity, size))
    for axis, name in enumerate(AXES):
        samples = demands[axis].samples
        curves = _decimated(samples.velocity, samples.acceleration, samples.thrust, size)
        for (quantity, unit), (low, high) in zip(_CURVES.items(), curves, strict=True):
            yield Profile(f"{name}.{quantity}", unit, low, high)
        place = reference.position[::size, axis]
        backward, forward = (
            limits.available_thrust(axis, place, np.full_like(place, sign)).astype(np.float32)
            for sign in (-1.0, 1.0)
        )
        yield Profile(f"{name}.available_thrust", "N", -backward, forward)


_CURVES = {"jerk": "m/s^3", "velocity": "m/s", "acceleration": "m/s^2", "thrust": "N"}
"""Unit of each curve that `_decimated` returns."""


@cached
def _decimated(velocity: Array, acceleration: Array, thrust: Array, size: int) -> Bins:
    """Return the extremes of jerk, velocity, acceleration and thrust, shape (4, 2, bins)."""
    n = len(velocity)
    bins = np.empty((4, 2, -(-n // size)), dtype=np.float32)
    before, gained = 0.0, 0.0
    for i in range(bins.shape[2]):
        low, high = np.full(4, np.inf), np.full(4, -np.inf)
        for k in range(i * size, min((i + 1) * size, n)):
            v, a = velocity[k], acceleration[k]
            now = ((a - gained) / CONTROL_PERIOD, v, mean_acceleration(a, v, before), thrust[k])
            for j in range(4):
                low[j], high[j] = min(low[j], now[j]), max(high[j], now[j])
            before, gained = v, a
        for j in range(4):
            bins[j, 0, i], bins[j, 1, i] = low[j], high[j]
    return bins


@cached
def _speed(velocity: Array, size: int) -> Bins:
    """Return the extremes of the speed along the path, shape (2, bins)."""
    n = len(velocity)
    bins = np.empty((2, -(-n // size)), dtype=np.float32)
    for i in range(bins.shape[1]):
        low, high = np.inf, 0.0
        for k in range(i * size, min((i + 1) * size, n)):
            square = velocity[k, 0] ** 2 + velocity[k, 1] ** 2
            low, high = min(low, square), max(high, square)
        bins[0, i], bins[1, i] = np.sqrt(low), np.sqrt(high)
    return bins


@cached
def _way(position: Array) -> float:
    way = 0.0
    for k in range(1, len(position)):
        x, y = position[k, 0] - position[k - 1, 0], position[k, 1] - position[k - 1, 1]
        way += np.sqrt(x * x + y * y)
    return way


def _flags(demands: list[Demand], size: int) -> Profile:
    """Return which quantities are outside their limits somewhere in each bin."""
    shown = np.zeros(-(-(len(demands[0].beyond) - 1) // size), dtype=np.uint8)
    for demand in demands:
        if demand.violations:
            _collect(demand.beyond, size, shown)
    flags = shown.astype(np.float32)
    return Profile("violated", "1", flags, flags)


@cached
def _collect(beyond: Flags, size: int, shown: Flags) -> None:
    for k in range(len(beyond)):
        # The end of the motion belongs to its last bin.
        shown[min(k // size, len(shown) - 1)] |= beyond[k]


def _peaks(demands: list[Demand]) -> list[Peak]:
    """Return the peak of each quantity; of thrust, the largest share of the available one."""
    peaks = []
    for demand in demands:
        for quantity, tick in enumerate(demand.peaks.tolist()):
            value = abs(demand.value_at(quantity, tick))
            limit = demand.limit_at(quantity, tick)
            share = value / limit if limit else None
            name, unit = QUANTITIES[quantity], UNITS[quantity]
            peaks.append(Peak(name, AXES[demand.axis], value, limit, share, unit))
    return peaks
