"""Time-optimal motion profiles over time, and the check of their every control tick."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from motionlab.lanes import cached
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_profile import Law, mean_acceleration
from motionlab.trajectories.path import Array
from motionlab.trajectories.spline import locate
from motionlab.trajectories.time_optimal_limits import Along, Motor, Nodes, available, friction

_FAR_BEYOND = 4.0


class Cells(NamedTuple):
    """A profile: at each of n + 1 nodes time, arc length, speed and acceleration along the path.

    Between nodes the speed is a cubic over time. Its unit of time is up to the caller.
    """

    time: Array
    way: Array
    speed: Array
    gain: Array


def at_rest(way: float, ticks: int) -> Cells:
    """Return a rest at an arc length."""
    return Cells(np.array([0.0, ticks]), np.array([way, way]), np.zeros(2), np.zeros(2))


def joined(legs: Sequence[Cells]) -> Cells:
    """Return profiles from rest to rest one after another."""
    ends = np.cumsum([0.0, *(leg.time[-1] for leg in legs)])
    time = [end + leg.time[:-1] for end, leg in zip(ends, legs, strict=False)]
    inner = [np.concatenate([each[k][:-1] for each in legs]) for k in range(1, 4)]
    last = legs[-1]
    way, speed, gain = (np.append(values, last[k][-1]) for k, values in enumerate(inner, start=1))
    return Cells(np.append(np.concatenate(time), ends[-1]), way, speed, gain)


@cached
def on_cells(cells: Cells, u: Array) -> Law:
    """Return the arc length and its derivatives at each time."""
    cell_numbers = locate(cells.time, u)
    way, rate, second = np.empty(len(u)), np.empty(len(u)), np.empty(len(u))
    for k in range(len(u)):
        i = cell_numbers[k]
        width = cells.time[i + 1] - cells.time[i]
        r = min(max((u[k] - cells.time[i]) / width, 0.0), 1.0)
        v_0, v_1 = cells.speed[i], cells.speed[i + 1]
        a_0, a_1 = width * cells.gain[i], width * cells.gain[i + 1]
        b = 3.0 * (v_1 - v_0) - 2.0 * a_0 - a_1
        c = 2.0 * (v_0 - v_1) + a_0 + a_1
        way[k] = cells.way[i] + width * r * (v_0 + r * (a_0 / 2.0 + r * (b / 3.0 + r * c / 4.0)))
        rate[k] = v_0 + r * (a_0 + r * (b + r * c))
        second[k] = (a_0 + r * (2.0 * b + r * 3.0 * c)) / width
    return way, rate, second


@cached
def shares(motor: Motor, along: Along, seen: Nodes, speed: Array, gain: Array) -> Array:
    """Return, tick by tick, by what factor squared speeds exceed what the limits allow.

    The quantities are those of `motionlab.trajectories.feasibility.check`, which counts velocity
    that changes between two ticks as acceleration; and the limits along the path.

    Parameters
    ----------
    motor, along
        Limits.
    seen : Nodes
        The path at each tick.
    speed, gain : ndarray, shape (ticks,)
        Speed and acceleration along the path, m/s and m/s^2.
    """
    ratios = np.empty(len(speed))
    before = np.zeros(2)
    gained = 0.0
    for k in range(len(speed)):
        v, a = speed[k], gain[k]
        most = max((v / along.v_max) ** 2, abs(a) / along.a_max)
        jerk = abs(a - gained) / (CONTROL_PERIOD * along.j_max)
        most = max(most, jerk ** (2.0 / 3.0))
        gained = a
        for axis in range(2):
            v_axis = seen.slope[k, axis] * v
            a_axis = seen.slope[k, axis] * a + seen.bend[k, axis] * v * v
            v_max, a_max, mass = (
                motor.numbers[axis, 0],
                motor.numbers[axis, 1],
                motor.numbers[axis, 2],
            )
            mean = mean_acceleration(a_axis, v_axis, before[axis])
            before[axis] = v_axis
            most = max(most, (v_axis / v_max) ** 2, abs(mean) / a_max)
            against = friction(motor, axis, v_axis)
            force = mass * a_axis + against
            sign = 1.0 if force > 0.0 else -1.0
            reach = available(motor, axis, 1 if force > 0.0 else 0, seen.place[k, axis])
            left = reach - sign * against
            thrust = sign * mass * a_axis
            if thrust > 0.0:
                most = max(most, thrust / left if left > 0.0 else _FAR_BEYOND)
            elif sign * force > reach:
                most = _FAR_BEYOND
        ratios[k] = min(most, _FAR_BEYOND)
    return ratios


@cached
def tighten(time: Array, ratios: Array, share: Array, step: float, tighter: float) -> bool:
    """Reduce the share of the limits used around ticks that exceed them; tell whether any did.

    Parameters
    ----------
    time : ndarray, shape (n,)
        When each node is reached, s.
    ratios : ndarray, shape (ticks,)
        From `shares`.
    share : ndarray, shape (n,)
        Reduced in place.
    step : float
        Time between ticks, s.
    tighter : float
        Factor beyond what the excess asks for.
    """
    worst = np.ones(len(time))
    i, last = 0, len(time) - 1
    beyond = False
    for k in range(len(ratios)):
        while i < last - 1 and time[i + 1] <= k * step:
            i += 1
        if ratios[k] > 1.0:
            beyond = True
            for near in range(max(i - 2, 0), min(i + 4, last + 1)):
                worst[near] = max(worst[near], ratios[k])
    for k in range(len(time)):
        if worst[k] > 1.0:
            share[k] *= tighter / worst[k]
    return beyond
