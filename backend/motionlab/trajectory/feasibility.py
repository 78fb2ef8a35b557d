"""Whether the motor can follow a reference, decided before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import Infeasible
from motionlab.trajectory.path import Array
from motionlab.trajectory.reference import AXES, Reference

STEP_MAX = 10e-6
"""Largest jump between two control periods, m (this project's limit for true steps)."""

_POSITION_ROUNDING = 1e-12
_RELATIVE_ROUNDING = 1e-9
_QUADRATURE = 4
"""Counts per cycle of an encoder with two tracks in quadrature."""


@dataclass(frozen=True)
class Limits:
    """What the motor can do; pairs are (x, y).

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
    """

    stroke: tuple[float, float]
    v_max: tuple[float, float]
    a_max: tuple[float, float]
    mass: tuple[float, float]
    friction: Callable[[int, Array], Array]
    available_thrust: Callable[[int, Array, Array], Array]


@dataclass(frozen=True)
class _Demand:
    """One quantity of one axis against its limits, tick by tick."""

    quantity: str
    axis: int
    value: Array
    lower: Array
    upper: Array
    unit: str
    rounding: float

    def first_violation(self, start: int) -> int | None:
        """Return the first tick from `start` on outside the limits."""
        outside = (self.value < self.lower - self.rounding) | (
            self.value > self.upper + self.rounding
        )
        outside[:start] = False
        return int(np.argmax(outside)) if outside.any() else None


def check(reference: Reference, limits: Limits, *, start: int = 0) -> None:
    """Refuse a motion that leaves the stroke or asks for more than the motor can do.

    The thrust that the motion requires is M a + f_f(v), eq (16). Velocity that jumps between two
    ticks counts as the acceleration it takes, the start from rest included. A position that jumps
    by more than the velocity explains is a true step: up to `STEP_MAX` it is allowed and
    counts neither as velocity nor as acceleration.

    Parameters
    ----------
    reference : Reference
        The motion.
    limits : Limits
        What the motor can do.
    start : int
        First tick at which these limits hold.

    Raises
    ------
    Infeasible
        With the first time and place at which anything is exceeded.
    """
    first: tuple[int, _Demand] | None = None
    for demand in _demands(reference, limits):
        tick = demand.first_violation(start)
        if tick is not None and (first is None or tick < first[0]):
            first = tick, demand
    if first is None:
        return
    tick, demand = first
    raise Infeasible(
        quantity=demand.quantity,
        axis=AXES[demand.axis],
        time=tick * CONTROL_PERIOD,
        place=_place(reference, tick),
        value=float(demand.value[tick]),
        limit=(float(demand.lower[tick]), float(demand.upper[tick])),
        unit=demand.unit,
    )


def count_rate_warning(
    reference: Reference, axis: str, *, resolution: float, rate: float
) -> str | None:
    """Say where the encoder interface of an axis would lose counts.

    The interface follows up to 4 `rate` `resolution`: 0.25 m/s at 1.25 MHz and 50 nm.

    Parameters
    ----------
    reference : Reference
        The motion.
    axis : str
        ``x`` or ``y``.
    resolution : float
        One encoder count, m.
    rate : float
        Largest frequency of the interface, Hz.

    Returns
    -------
    str or None
        A note for the user, or None if no count is lost.
    """
    v_max = _QUADRATURE * rate * resolution
    speed = np.abs(reference.velocity[:, AXES.index(axis)])
    too_fast = speed > v_max * (1 + _RELATIVE_ROUNDING)
    if not too_fast.any():
        return None
    tick = int(np.argmax(too_fast))
    peak = float(speed.max())
    return (
        f"encoder: velocity on {axis} exceeds {v_max:.6g} m/s from t = "
        f"{tick * CONTROL_PERIOD:.4f} s on, peak {peak:.6g} m/s; "
        f"a real {rate / 1e6:g} MHz interface would lose counts"
    )


def _demands(reference: Reference, limits: Limits) -> Iterator[_Demand]:
    """Yield every quantity to check; the order decides between equals in time."""
    for axis in range(len(AXES)):
        position = _with_end(reference, axis)
        velocity = reference.velocity[:, axis]
        acceleration = _largest(reference.acceleration[:, axis], _mean_acceleration(velocity))
        force = limits.mass[axis] * reference.acceleration[:, axis] + limits.friction(
            axis, velocity
        )
        available = limits.available_thrust(
            axis, reference.position[:, axis], np.where(force < 0, -1.0, 1.0)
        )
        yield _within("position", axis, position, limits.stroke[axis], "m")
        yield _within("step", axis, _jumps(reference, axis), STEP_MAX, "m")
        yield _within("velocity", axis, velocity, limits.v_max[axis], "m/s")
        yield _within("acceleration", axis, acceleration, limits.a_max[axis], "m/s^2")
        yield _within("thrust", axis, force, available, "N")


def _within(quantity: str, axis: int, value: Array, limit: float | Array, unit: str) -> _Demand:
    upper = np.broadcast_to(np.asarray(limit, dtype=np.float64), value.shape)
    rounding = _POSITION_ROUNDING if unit == "m" else _RELATIVE_ROUNDING * float(upper.max())
    return _Demand(quantity, axis, value, -upper, upper, unit, rounding)


def _with_end(reference: Reference, axis: int) -> Array:
    return np.append(reference.position[:, axis], reference.end[axis])


def _jumps(reference: Reference, axis: int) -> Array:
    """Return what no velocity between those of two ticks explains of the way to each tick."""
    way = np.diff(reference.position[:, axis])
    ways = CONTROL_PERIOD * reference.velocity[:, axis]
    slow, fast = np.minimum(ways[1:], ways[:-1]), np.maximum(ways[1:], ways[:-1])
    return np.concatenate(([0.0], way - np.clip(way, slow, fast)))


def _mean_acceleration(velocity: Array) -> Array:
    """Return the acceleration that takes the velocity from the tick before to each tick."""
    return np.diff(velocity, prepend=0.0) / CONTROL_PERIOD


def _largest(first: Array, second: Array) -> Array:
    return np.where(np.abs(first) >= np.abs(second), first, second)


def _place(reference: Reference, tick: int) -> tuple[float, float]:
    place = reference.position[tick] if tick < reference.ticks else reference.end
    return float(place[0]), float(place[1])
