"""What a motion asks of the motor, as data to draw, and everywhere it asks too much."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.config.drawn import DrawnPath
from motionlab.config.figures import Circle, Polygon, Star
from motionlab.config.planar import AXES
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.trajectory.feasibility import ALWAYS, Demand, MotionLimits, Span, demands, place_at
from motionlab.trajectory.path import Array
from motionlab.trajectory.reference import Reference, sample

QUANTITIES = ("position", "step", "velocity", "acceleration", "thrust")
VIOLATIONS_MAX = 50
"""Violations that are listed; the worst ones."""

LimitSets = Sequence[tuple[Span, MotionLimits]]
"""When which limits hold; of several variants all hold at once."""


@dataclass(frozen=True)
class Violation:
    """An interval in which one quantity of one axis is outside its limit.

    Attributes
    ----------
    quantity, axis : str
        What is too large, and on which axis.
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
    """The largest magnitude of one quantity of one axis, and how much of its limit that is."""

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
        Time that profiles and violations are of: one lap of what repeats, s.
    length : float
        Way along the path in that time, m.
    step : float
        Time that a bin of the profiles stands for, s.
    profiles : list of Profile
        Position, speed, velocity, acceleration, jerk, thrust and available thrust, and the sum of
        2**k of every violated quantity, numbered as in `QUANTITIES`.
    peaks : list of Peak
        Largest magnitude of each quantity of each axis.
    violations : list of Violation
        Worst first, `VIOLATIONS_MAX` at most.
    violation_count : int
        How many there are.
    """

    duration: float
    examined: float
    length: float
    step: float
    profiles: list[Profile]
    peaks: list[Peak]
    violations: list[Violation]
    violation_count: int

    @property
    def feasible(self) -> bool:
        """Whether the motor can follow."""
        return self.violation_count == 0


def examine(trajectory: TrajectoryConfig, limits: LimitSets, *, bins: int) -> Examination:
    """Hold a motion against the limits and decimate what it asks for.

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
    found = [(demand, span) for span, each in limits for demand in demands(reference, each)]
    outside = [demand.outside(span) for demand, span in found]
    violations: list[Violation] = []
    for (demand, _), beyond in zip(found, outside, strict=True):
        if beyond is not None:
            violations += _violations(reference, demand, beyond)
    violations.sort(key=lambda each: -each.share)
    first = [demand for demand, _ in found[: len(AXES) * len(QUANTITIES)]]
    size = max(1, -(-reference.ticks // bins))
    return Examination(
        duration=(reference.ticks + laps_left * reference.period) * CONTROL_PERIOD,
        examined=reference.ticks * CONTROL_PERIOD,
        length=_way(reference.position),
        step=size * CONTROL_PERIOD,
        profiles=[
            *_profiles(reference, first, limits[0][1], size),
            _flags(found, outside, reference.ticks, size),
        ],
        peaks=_peaks(first),
        violations=violations[:VIOLATIONS_MAX],
        violation_count=len(violations),
    )


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _way(position: Array) -> float:
    way = 0.0
    for k in range(1, len(position)):
        way += np.hypot(position[k, 0] - position[k - 1, 0], position[k, 1] - position[k - 1, 1])
    return way


def _one_lap(trajectory: TrajectoryConfig) -> TrajectoryConfig:
    repeats = isinstance(trajectory, Circle | Polygon | Star) or (
        isinstance(trajectory, DrawnPath) and trajectory.law != "constant_speed"
    )
    if not repeats or _laps(trajectory) == 1:
        return trajectory
    return trajectory.model_copy(update={"laps": 1})


def _laps(trajectory: TrajectoryConfig) -> int:
    return getattr(trajectory, "laps", 1)


def _violations(
    reference: Reference, demand: Demand, beyond: NDArray[np.bool_]
) -> Iterable[Violation]:
    """Yield each interval outside the limit with its worst tick."""
    edges = np.flatnonzero(np.diff(beyond, prepend=False, append=False))
    for start, stop in edges.reshape(-1, 2).tolist():
        size = np.abs(demand.value[start:stop])
        limit = demand.limit[start:stop] if isinstance(demand.limit, np.ndarray) else demand.limit
        worst = start + int(np.argmax(size - limit))
        yield Violation(
            quantity=demand.quantity,
            axis=AXES[demand.axis],
            start=start * CONTROL_PERIOD,
            end=(stop - 1) * CONTROL_PERIOD,
            time=worst * CONTROL_PERIOD,
            place=place_at(reference, worst),
            value=float(demand.value[worst]),
            limit=demand.limit_at(worst),
            unit=demand.unit,
        )


def _profiles(
    reference: Reference, found: list[Demand], limits: MotionLimits, size: int
) -> Iterable[Profile]:
    """Yield the curves of position, speed and, for each axis, of what is asked and available."""
    for axis, name in enumerate(AXES):
        first = reference.position[::size, axis].astype(np.float32)
        yield Profile(f"{name}.position", "m", first, first)
    yield _profile("speed", "m/s", np.hypot(*reference.velocity.T), size)
    for axis, name in enumerate(AXES):
        jerk = np.diff(reference.acceleration[:, axis], prepend=0.0) / CONTROL_PERIOD
        yield _profile(f"{name}.jerk", "m/s^3", jerk, size)
        for demand in found:
            if demand.axis == axis and demand.quantity in {"velocity", "acceleration", "thrust"}:
                yield _profile(f"{name}.{demand.quantity}", demand.unit, demand.value, size)
        place = reference.position[::size, axis]
        backward, forward = (
            limits.available_thrust(axis, place, np.full_like(place, sign)).astype(np.float32)
            for sign in (-1.0, 1.0)
        )
        yield Profile(f"{name}.available_thrust", "N", -backward, forward)


def _profile(name: str, unit: str, values: Array, size: int) -> Profile:
    return Profile(name, unit, *_min_max(values, size))


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _min_max(values: Array, size: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    count = -(-len(values) // size)
    low, high = np.empty(count, dtype=np.float32), np.empty(count, dtype=np.float32)
    for i in range(count):
        least = most = values[i * size]
        for k in range(i * size + 1, min((i + 1) * size, len(values))):
            least, most = min(least, values[k]), max(most, values[k])
        low[i], high[i] = least, most
    return low, high


def _flags(
    found: list[tuple[Demand, Span]],
    outside: list[NDArray[np.bool_] | None],
    ticks: int,
    size: int,
) -> Profile:
    """Return which quantities are outside their limits somewhere in each bin."""
    starts = np.arange(0, ticks, size)
    flags = np.zeros(len(starts), dtype=np.int64)
    for (demand, _), beyond in zip(found, outside, strict=True):
        if beyond is not None:
            within = beyond[:ticks]
            within[-1] |= beyond[-1]  # the end of the motion belongs to its last bin
            some = np.logical_or.reduceat(within, starts)
            flags |= some.astype(np.int64) << QUANTITIES.index(demand.quantity)
    shown = flags.astype(np.float32)
    return Profile("violated", "1", shown, shown)


def _peaks(found: list[Demand]) -> list[Peak]:
    """Return the peak of each quantity; of thrust where it takes most of what there is."""
    peaks = []
    for demand in found:
        size = np.abs(demand.value)
        varies = isinstance(demand.limit, np.ndarray)
        worst = int(np.argmax(size / demand.limit if varies else size))
        value, limit = float(size[worst]), demand.limit_at(worst)
        share = value / limit if limit else None
        peaks.append(Peak(demand.quantity, AXES[demand.axis], value, limit, share, demand.unit))
    return peaks
