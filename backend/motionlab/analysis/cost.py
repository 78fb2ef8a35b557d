"""Cost of a motion: energy, currents, forces, and the balance of the mechanical energy.

Samples are T apart; within a period the currents, and so the thrust, go to their new values as the
amplifier's first-order loop does, ``F(t) = F_1 + (F_0 - F_1) exp(-t/tau)``, and the velocity in a
straight line. Then, with r = tau/T::

    int F v dt = T (F_1 (v_0 + v_1)/2 + (F_0 - F_1) (w v_0 + u (v_1 - v_0)))
    int i^2 dt = T (i_1^2 + 2 i_1 (i_0 - i_1) w + (i_0 - i_1)^2 r/2 (1 - exp(-2/r)))
    w = r (1 - exp(-1/r));   u = r (r - exp(-1/r) (1 + r))

The thrust does work on friction, on the load and on the kinetic energy; what a sum over samples
leaves of that balance is its residual.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Within(NamedTuple):
    """Course of a quantity between two samples, as shares of their difference.

    Attributes
    ----------
    mean : float
        Mean of what is left of the difference, w.
    moment : float
        Mean of that times t/T, u.
    square : float
        Mean of its square.
    """

    mean: float
    moment: float
    square: float


LINEAR = Within(1 / 2, 1 / 6, 1 / 3)
"""In a straight line, where the amplifier is not known."""
HELD = Within(1.0, 1 / 2, 1.0)
"""Held at the earlier sample: a force that is commanded directly."""


def settling(tau: float, period: float) -> Within:
    """Return the course between samples of a first-order loop of time constant `tau`, s."""
    if tau <= 0.0:
        return Within(0.0, 0.0, 0.0)
    r = tau / period
    left = math.exp(-1 / r)
    return Within(r * (1 - left), r * (r - left * (1 + r)), r / 2 * (1 - left * left))


class Moved(NamedTuple):
    """Forces on one axis and its velocity, each of shape (n,), N and m/s."""

    thrust: Array
    friction: Array
    load: Array
    velocity: Array


@dataclass(frozen=True)
class Balance:
    """Mechanical energy of one axis, J: thrust = friction + load + kinetic + residual.

    Attributes
    ----------
    thrust, friction, load : float
        Work of the thrust, work against friction and against the external load.
    kinetic : float
        Kinetic energy at the end less that at the beginning.
    residual : float
        What the sums over samples leave, and the work of an end stop, which is not recorded.
    """

    thrust: float
    friction: float
    load: float
    kinetic: float
    residual: float


def work(force: Array, velocity: Array, period: float, within: Within = LINEAR) -> float:
    """Return the work of a force, J; both of shape (n,), N and m/s."""
    later, earlier = force[1:], force[:-1]
    v, change = velocity[:-1], np.diff(velocity)
    along = later * (v + change / 2) + (earlier - later) * (
        within.mean * v + within.moment * change
    )
    return float(period * along.sum())


def square_integral(values: Array, period: float, within: Within = LINEAR) -> float:
    """Return the integral of a squared quantity, its unit squared times s."""
    later, change = values[1:], values[:-1] - values[1:]
    squares = later**2 + 2 * within.mean * later * change + within.square * change**2
    return float(period * squares.sum())


def balance(moved: Moved, *, mass: float, period: float, within: Within) -> Balance:
    """Return the energy balance of one axis of a `mass`, kg, whose thrust settles as `within`."""
    velocity = moved.velocity
    done = work(moved.thrust, velocity, period, within)
    lost = work(moved.friction, velocity, period)
    pushed = work(moved.load, velocity, period, HELD)
    kinetic = mass / 2 * float(velocity[-1] ** 2 - velocity[0] ** 2)
    return Balance(done, lost, pushed, kinetic, done - lost - pushed - kinetic)


def rms(values: Array) -> float:
    """Return the root mean square."""
    return float(np.sqrt(np.mean(values**2)))


def rate(values: Array, period: float) -> float:
    """Return the root mean square of a rate of change, per s."""
    return rms(np.diff(values)) / period
