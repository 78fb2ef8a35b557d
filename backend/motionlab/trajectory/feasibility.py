"""Whether the motor can follow a reference, decided before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import Infeasible
from motionlab.trajectory.path import Array
from motionlab.trajectory.reference import Reference

STEP_MAX = 10e-6
"""Largest jump between two control periods, m (this project's limit for true steps)."""

_POSITION_ROUNDING = 1e-12
_RELATIVE_ROUNDING = 1e-9
_QUADRATURE = 4
"""Counts per cycle of an encoder with two tracks in quadrature."""


class Span(NamedTuple):
    """Ticks from `start` to before `end`; to the end of the motion, which counts, without one."""

    start: int = 0
    end: int | None = None


ALWAYS = Span()


@dataclass(frozen=True)
class MotionLimits:
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
    sure_thrust : tuple of float
        Thrust that can be had everywhere and in both directions, N; below it nothing is asked of
        `available_thrust`.
    """

    stroke: tuple[float, float]
    v_max: tuple[float, float]
    a_max: tuple[float, float]
    mass: tuple[float, float]
    friction: Callable[[int, Array], Array]
    available_thrust: Callable[[int, Array, Array], Array]
    sure_thrust: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True)
class Demand:
    """One quantity of one axis against its limit, tick by tick.

    Attributes
    ----------
    quantity : str
        ``position``, ``step``, ``velocity``, ``acceleration`` or ``thrust``.
    axis : int
        Index of the axis.
    value : ndarray, shape (ticks,)
        What the motion asks for, in `unit`; a position has the end of the motion too.
    limit : float or ndarray, shape (ticks,)
        Largest magnitude allowed; of a thrust below the sure one just that one.
    unit : str
        Unit of value and limit.
    """

    quantity: str
    axis: int
    value: Array
    limit: float | Array
    unit: str

    def outside(self, span: Span = ALWAYS) -> NDArray[np.bool_] | None:
        """Return at which ticks of a span the limit is exceeded, None for nowhere."""
        most = float(np.max(self.limit))
        rounding = _POSITION_ROUNDING if self.unit == "m" else _RELATIVE_ROUNDING * most
        size = np.abs(self.value)
        beyond = size > self.limit + rounding
        beyond[: span.start] = False
        if span.end is not None:
            beyond[span.end :] = False
        return beyond if beyond.any() else None

    def limit_at(self, tick: int) -> float:
        """Return the limit that holds at one tick."""
        return float(self.limit[tick] if isinstance(self.limit, np.ndarray) else self.limit)


def check(reference: Reference, limits: MotionLimits, *, span: Span = ALWAYS) -> None:
    """Refuse a motion that leaves the stroke or asks for more than the motor can do.

    The thrust that the motion requires is M a + f_f(v), eq (16). Velocity that jumps between two
    ticks counts as the acceleration it takes, the start from rest included. A position that jumps
    by more than the velocity explains is a true step: up to `STEP_MAX` it is allowed and
    counts neither as velocity nor as acceleration.

    Parameters
    ----------
    reference : Reference
        The motion.
    limits : MotionLimits
        What the motor can do.
    span : Span
        Ticks at which these limits hold.

    Raises
    ------
    Infeasible
        With the first time and place at which anything is exceeded.
    """
    first: tuple[int, Demand] | None = None
    for demand in demands(reference, limits):
        outside = demand.outside(span)
        tick = None if outside is None else int(np.argmax(outside))
        if tick is not None and (first is None or tick < first[0]):
            first = tick, demand
    if first is not None:
        raise refusal(reference, first[1], first[0])


def refusal(reference: Reference, demand: Demand, tick: int) -> Infeasible:
    """Return the error that tells of one tick at which a demand is outside its limit."""
    limit = demand.limit_at(tick)
    return Infeasible(
        quantity=demand.quantity,
        axis=AXES[demand.axis],
        time=tick * CONTROL_PERIOD,
        place=place_at(reference, tick),
        value=float(demand.value[tick]),
        limit=(-limit, limit),
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


def demands(reference: Reference, limits: MotionLimits) -> Iterator[Demand]:
    """Yield every quantity to check; the order decides between equals in time."""
    for axis in range(len(AXES)):
        velocity, acceleration, inertia, jumps = _asked(
            reference.position[:, axis],
            reference.velocity[:, axis],
            reference.acceleration[:, axis],
            limits.mass[axis],
        )
        thrust = inertia + limits.friction(axis, velocity)
        yield Demand("position", axis, _with_end(reference, axis), limits.stroke[axis], "m")
        yield Demand("step", axis, jumps, STEP_MAX, "m")
        yield Demand("velocity", axis, velocity, limits.v_max[axis], "m/s")
        yield Demand("acceleration", axis, acceleration, limits.a_max[axis], "m/s^2")
        yield Demand("thrust", axis, thrust, _available(reference, limits, axis, thrust), "N")


def _available(reference: Reference, limits: MotionLimits, axis: int, thrust: Array) -> Array:
    """Return the thrust that can be had, computed only where the sure one does not do."""
    sure = limits.sure_thrust[axis]
    available = np.full(thrust.shape, sure)
    hard = np.flatnonzero(np.abs(thrust) > sure) if sure > 0.0 else slice(None)
    asked = thrust[hard]
    if asked.size:
        available[hard] = limits.available_thrust(
            axis, reference.position[hard, axis], np.where(asked < 0, -1.0, 1.0)
        )
    return available


def _with_end(reference: Reference, axis: int) -> Array:
    return np.append(reference.position[:, axis], reference.end[axis])


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _asked(
    position: Array, velocity: Array, acceleration: Array, mass: float
) -> tuple[Array, Array, Array, Array]:
    """Return velocity, largest acceleration, inertia force, and jumps, tick by tick.

    The largest acceleration is the analytic one or that which takes the velocity from the tick
    before; a jump is what no velocity between those of two ticks explains of the way.
    """
    n = len(position)
    speed, largest, inertia, jumps = np.empty(n), np.empty(n), np.empty(n), np.empty(n)
    for k in range(n):
        now, before = velocity[k], velocity[k - 1] if k > 0 else 0.0
        mean = (now - before) / CONTROL_PERIOD
        speed[k] = now
        largest[k] = acceleration[k] if abs(acceleration[k]) >= abs(mean) else mean
        inertia[k] = mass * acceleration[k]
        jumps[k] = 0.0
        if k > 0:
            way = position[k] - position[k - 1]
            slow, fast = CONTROL_PERIOD * min(now, before), CONTROL_PERIOD * max(now, before)
            jumps[k] = way - min(max(way, slow), fast)
    return speed, largest, inertia, jumps


def place_at(reference: Reference, tick: int) -> tuple[float, float]:
    """Return the position at a tick, the end of the motion included, m."""
    place = reference.position[tick] if tick < reference.ticks else reference.end
    return float(place[0]), float(place[1])
