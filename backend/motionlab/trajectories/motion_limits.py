"""Check of a motion against the limits of one axis.

Only what tells of a refused motion is compiled: on a fresh machine the first curves wait for the
check of theirs.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.lanes import cached, compiled
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_profile import mean_acceleration
from motionlab.trajectories.path import Array, Vector
from motionlab.trajectories.reference import Reference

QUANTITIES = ("position", "step", "velocity", "acceleration", "thrust")
UNITS = ("m", "m", "m/s", "m/s^2", "N")

STEP_MAX = 10e-6
"""Largest jump between two control periods, m (this project's limit for true steps)."""

RELATIVE_ROUNDING = 1e-9
_AT_REST = 1e-9
"""Below this a velocity is rounding, m/s."""

_POSITION_ROUNDING = 1e-12
_BLOCK = 8192
"""Ticks that are looked at together: what is computed of them stays in the processor's cache."""
_POSITION, _STEP, _VELOCITY, _ACCELERATION, _THRUST = range(len(QUANTITIES))


class Span(NamedTuple):
    """Ticks from `start` to before `end`; to the end of the motion, which counts, without one."""

    start: int = 0
    end: int | None = None


ALWAYS = Span()

Ticks = NDArray[np.int64]
Flags = NDArray[np.uint8]


@dataclass(frozen=True)
class MotionLimits:
    """Limits of the motor; pairs are (x, y).

    Attributes
    ----------
    stroke : tuple of float
        Largest distance from mid-stroke, inclusive, m.
    v_max : tuple of float
        Largest velocity, m/s.
    a_max : tuple of float
        Largest acceleration, m/s^2.
    mass : tuple of float
        Moving mass M, kg.
    friction : callable
        (axis index, velocities (n,)) to friction force (n,), N, with the sign of the velocity.
    available_thrust : callable
        (axis index, positions (n,), signs (n,), each -1 or 1) to the largest thrust in that
        direction (n,), N, >= 0.
    sure_thrust : tuple of float
        Thrust available everywhere and in both directions, N; below it `available_thrust` is not
        called.
    reserve : float
        Share of the thrust that has been left to feedback already.
    """

    stroke: tuple[float, float]
    v_max: tuple[float, float]
    a_max: tuple[float, float]
    mass: tuple[float, float]
    friction: Callable[[int, Array], Array]
    available_thrust: Callable[[int, Array, Array], Array]
    sure_thrust: tuple[float, float] = (0.0, 0.0)
    reserve: float = 0.0


@dataclass(frozen=True)
class Intervals:
    """Where one quantity of one axis is outside its limit, in order of time.

    Attributes
    ----------
    quantity, axis : int
        Indices in `QUANTITIES` and `AXES`.
    start, stop, worst : ndarray of int64, shape (n,)
        First tick outside, the one after the last, and the one furthest outside.
    value, limit : ndarray, shape (n,)
        Value at the worst tick, and the magnitude allowed there, in the quantity's unit.
    """

    quantity: int
    axis: int
    start: Ticks
    stop: Ticks
    worst: Ticks
    value: Array
    limit: Array


class Samples(NamedTuple):
    """Quantities required of one axis at each of n ticks."""

    position: Array  # m
    velocity: Array  # m/s
    acceleration: Array  # m/s^2
    thrust: Array  # M a + f_f(v), eq. (16), N
    end: float  # where the motion ends, m


class Reach(NamedTuple):
    """Ticks that require more than the sure thrust, and the thrust available there, N."""

    hard: Ticks
    available: Array


@dataclass(frozen=True)
class Demand:
    """Quantities that a motion requires of one axis.

    Attributes
    ----------
    reference : Reference
        The motion, of n ticks.
    axis : int
        Index of the axis.
    samples : Samples
        Required quantities.
    limits : tuple of float
        Magnitude allowed of each of `QUANTITIES`; of the thrust the sure one.
    reserve : float
        Share of the thrust that has been left to feedback already.
    reach : Reach
        Available thrust.
    beyond : ndarray of uint8, shape (n + 1,)
        Sum of 2**k of the quantities outside their limits at each tick; the end of the motion has
        a position only.
    found : int
        The same of all ticks together.
    peaks : ndarray of int64, shape (5,)
        Tick at which each quantity is largest, the thrust as a share of the available one.
    """

    reference: Reference
    axis: int
    samples: Samples
    limits: tuple[float, ...]
    reserve: float
    reach: Reach
    beyond: Flags
    violations: int
    peaks: Ticks

    def value_at(self, quantity: int, tick: int) -> float:
        """Return the required value at one tick, in the quantity's unit."""
        return float(_value(quantity, tick, self.samples))

    def limit_at(self, quantity: int, tick: int) -> float:
        """Return the magnitude that is allowed at one tick."""
        hard, available = self.reach
        if quantity == _THRUST and hard.size:
            index = int(np.searchsorted(hard, tick))
            if index < hard.size and hard[index] == tick:
                return float(available[index])
        return self.limits[quantity]

    def outside(self, quantity: int) -> Intervals | None:
        """Return where a quantity is outside its limit, None for nowhere."""
        if not self.violations >> quantity & 1:
            return None
        ticks, amounts = _intervals(
            quantity, self.beyond, self.samples, self.limits[quantity], self.reach
        )
        return Intervals(quantity, self.axis, *ticks, *amounts)


def demands(reference: Reference, limits: MotionLimits, *, span: Span = ALWAYS) -> list[Demand]:
    """Check a motion against limits, axis by axis.

    Velocity that jumps between two ticks counts as the acceleration it takes, the start from rest
    included. A position that jumps by more than the velocity explains is a true step, which counts
    neither as velocity nor as acceleration.

    Parameters
    ----------
    reference : Reference
        The motion.
    limits : MotionLimits
        Limits of the motor.
    span : Span
        Ticks at which these limits hold.
    """
    return [_demand(reference, limits, axis, span) for axis in range(len(AXES))]


def place_at(reference: Reference, tick: int) -> Vector:
    """Return the position at a tick, the end of the motion included, m."""
    place = reference.position[tick] if tick < reference.ticks else reference.end
    return float(place[0]), float(place[1])


def _demand(reference: Reference, limits: MotionLimits, axis: int, span: Span) -> Demand:
    position, velocity = reference.position[:, axis], reference.velocity[:, axis]
    acceleration = reference.acceleration[:, axis]
    sure = limits.sure_thrust[axis]
    # The rounding of a straight edge has a sign too, with which friction would change at random.
    moving = np.where(np.abs(velocity) < _AT_REST, 0.0, velocity)
    thrust = limits.mass[axis] * acceleration + limits.friction(axis, moving)
    hard = np.flatnonzero(np.abs(thrust) > (sure if sure > 0 else -1.0))
    available = np.empty(0)
    if hard.size:
        sign = np.where(thrust[hard] < 0.0, -1.0, 1.0)
        available = limits.available_thrust(axis, position[hard], sign)
    allowed = (limits.stroke[axis], STEP_MAX, limits.v_max[axis], limits.a_max[axis], sure)
    most = (*allowed[:_THRUST], max(sure, float(available.max(initial=0.0))))
    slack = [
        _POSITION_ROUNDING if unit == "m" else RELATIVE_ROUNDING * value
        for unit, value in zip(UNITS, most, strict=True)
    ]
    samples = Samples(position, velocity, acceleration, thrust, reference.end[axis])
    reach = Reach(hard, available)
    during = (span.start, reference.ticks + 1 if span.end is None else span.end)
    survey = _survey(samples, np.array(allowed), np.array(slack), reach, during)
    return Demand(reference, axis, samples, allowed, limits.reserve, reach, *survey)


@compiled
def _jump(way: Any, now: Any, before: Any) -> Any:
    """Return the part of a displacement that the velocities at both ticks do not explain."""
    slow = CONTROL_PERIOD * np.minimum(now, before)
    fast = CONTROL_PERIOD * np.maximum(now, before)
    return way - np.minimum(np.maximum(way, slow), fast)


@cached
def _value(quantity: int, tick: int, samples: Samples) -> float:
    position, velocity, acceleration, thrust, end = samples
    if quantity == _POSITION:
        return position[tick] if tick < len(position) else end
    before = velocity[tick - 1] if tick > 0 else 0.0
    if quantity == _STEP:
        way = position[tick] - position[tick - 1] if tick > 0 else 0.0
        return _jump(way, velocity[tick], before) if tick > 0 else 0.0
    if quantity == _VELOCITY:
        return velocity[tick]
    if quantity == _ACCELERATION:
        return mean_acceleration(acceleration[tick], velocity[tick], before)
    return thrust[tick]


def _survey(
    samples: Samples, allowed: Array, slack: Array, reach: Reach, during: tuple[int, int]
) -> tuple[Flags, int, Ticks]:
    """Return which quantities are outside at each tick and at any, and where each is largest."""
    n = len(samples.position)
    beyond = np.zeros(n + 1, dtype=np.uint8)
    largest, peaks = np.full(len(allowed), -1.0), np.zeros(len(allowed), dtype=np.int64)
    for first in range(0, n, _BLOCK):
        stop = min(first + _BLOCK, n)
        limit = np.full(stop - first, allowed[_THRUST])
        begin, end = np.searchsorted(reach.hard, (first, stop))
        limit[reach.hard[begin:end] - first] = reach.available[begin:end]
        sizes = _sizes(samples, slice(first, stop))
        force = sizes[_THRUST]
        with np.errstate(divide="ignore"):
            shares = np.divide(force, limit, out=np.zeros_like(force), where=force > 0.0)
        bounds = [*(allowed + slack)[:_THRUST], limit + slack[_THRUST]]
        for quantity, size in enumerate((*sizes[:_THRUST], shares)):
            place = int(size.argmax())
            if size[place] > largest[quantity]:
                largest[quantity], peaks[quantity] = size[place], first + place
            outside = sizes[quantity] > bounds[quantity]
            if outside.any():
                beyond[first:stop] |= outside.astype(np.uint8) << quantity
    if abs(samples.end) > largest[_POSITION]:
        peaks[_POSITION] = n
    beyond[n] = (abs(samples.end) > allowed[_POSITION] + slack[_POSITION]) << _POSITION
    beyond[: during[0]] = beyond[during[1] :] = 0
    return beyond, int(np.bitwise_or.reduce(beyond)), peaks


def _sizes(samples: Samples, here: slice) -> tuple[Array, ...]:
    """Return the magnitude of each of `QUANTITIES` at some ticks."""
    position, now = samples.position[here], samples.velocity[here]
    last = max(here.start - 1, 0)
    place, before = np.empty_like(position), np.empty_like(now)
    place[0], place[1:] = samples.position[last], position[:-1]
    before[0], before[1:] = samples.velocity[last] if here.start else 0.0, now[:-1]
    step = np.abs(_jump(position - place, now, before))
    if here.start == 0:
        step[0] = 0.0
    mean = (now - before) / CONTROL_PERIOD
    return (
        np.abs(position),
        step,
        np.abs(now),
        np.maximum(np.abs(samples.acceleration[here]), np.abs(mean)),
        np.abs(samples.thrust[here]),
    )


@cached
def _intervals(
    quantity: int, beyond: Flags, samples: Samples, allowed: float, reach: Reach
) -> tuple[Ticks, Array]:
    """Return start, stop and worst tick, (3, n), and value and limit there, (2, n)."""
    hard, available = reach
    bit = 1 << quantity
    count = 0
    for k in range(len(beyond)):
        if beyond[k] & bit and (k == 0 or not beyond[k - 1] & bit):
            count += 1
    ticks, amounts = np.empty((3, count), dtype=np.int64), np.empty((2, count))
    i = -1
    furthest = 0.0
    h = 0
    for k in range(len(beyond)):
        if not beyond[k] & bit:
            continue
        value = _value(quantity, k, samples)
        limit = allowed
        if quantity == _THRUST:
            while h < len(hard) and hard[h] < k:
                h += 1
            if h < len(hard) and hard[h] == k:
                limit = available[h]
        begins = k == 0 or not beyond[k - 1] & bit
        if begins:
            i += 1
            ticks[0, i] = k
        ticks[1, i] = k + 1
        if begins or abs(value) - limit > furthest:
            furthest = abs(value) - limit
            ticks[2, i] = k
            amounts[0, i], amounts[1, i] = value, limit
    return ticks, amounts
