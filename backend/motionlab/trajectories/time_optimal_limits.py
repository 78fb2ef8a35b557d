"""Limits at places along a path, and the forward and backward pass that keep them all but jerk."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from motionlab.lanes import cached
from motionlab.trajectories.path import Array

_LEAST = 1e-3  # share of the acceleration limit that is assumed to be left at least
_FINE = 4  # distances between nodes at the start and the end that are quartered
_CLOSE_BY = 16  # places between each end and the even place next to it, the latter counted
_SLOWEST = 1e-12  # (m/s)^2


class Motor(NamedTuple):
    """Limits of both axes."""

    numbers: Array  # v_max, a_max, M, F_c, F_s, v_s, sigma_2, pole pitch; shape (2, 8), SI
    thrust: Array  # available over a pole pitch, N; axis, direction (backward first), position


class Along(NamedTuple):
    """Limits along the path."""

    v_max: float  # m/s
    a_max: float  # m/s^2
    j_max: float  # m/s^3


class Nodes(NamedTuple):
    """Places along a path."""

    way: Array  # arc length from the start, m, shape (n,)
    place: Array  # m, shape (n, 2)
    slope: Array  # unit tangent, shape (n, 2)
    bend: Array  # curvature, 1/m, shape (n, 2)


@cached
def available(motor: Motor, axis: int, direction: int, place: float) -> float:
    """Return the thrust available at a place, N; direction 0 is backward, 1 forward."""
    table = motor.thrust[axis, direction]
    turns = place / motor.numbers[axis, 7]
    u = (turns - math.floor(turns)) * len(table)
    low = int(u)
    share = u - low
    first, second = table[low % len(table)], table[(low + 1) % len(table)]
    return first + (second - first) * share


@cached
def friction(motor: Motor, axis: int, v: float) -> float:
    """Return the steady friction at a velocity, N, with its sign."""
    _, _, _, coulomb, static, stribeck, viscous, _ = motor.numbers[axis]
    level = coulomb + (static - coulomb) * math.exp(-((v / stribeck) ** 2))
    return np.sign(v) * level + viscous * v


@cached
def acceleration_range(motor: Motor, axis: int, place: float, v: float) -> tuple[float, float]:
    """Return the largest deceleration, as a positive number, and acceleration of an axis."""
    a_max, mass = motor.numbers[axis, 1], motor.numbers[axis, 2]
    against = friction(motor, axis, v)
    down = min(a_max, (available(motor, axis, 0, place) + against) / mass)
    up = min(a_max, (available(motor, axis, 1, place) - against) / mass)
    return max(down, _LEAST * a_max), max(up, _LEAST * a_max)


@cached
def _gains(motor: Motor, nodes: Nodes, k: int, x: float, a_max: float) -> tuple[float, float]:
    """Return the least and the largest acceleration along the path at squared speed x."""
    low, high = -a_max, a_max
    speed = math.sqrt(x)
    for axis in range(2):
        slope, bend = nodes.slope[k, axis], nodes.bend[k, axis]
        down, up = acceleration_range(motor, axis, nodes.place[k, axis], slope * speed)
        if abs(slope) < 1e-9:
            if bend * x > up or -bend * x > down:
                return 1.0, -1.0
            continue
        first, second = (-down - bend * x) / slope, (up - bend * x) / slope
        low, high = max(low, min(first, second)), min(high, max(first, second))
    return low, high


@cached
def squared_speed_ceiling(motor: Motor, nodes: Nodes, along: Along) -> Array:
    """Return the largest squared speed at each node, by itself; (m/s)^2.

    Besides velocity and centripetal acceleration, constant jerk from rest at either end bounds it.
    """
    n = len(nodes.way)
    length = nodes.way[n - 1] - nodes.way[0]
    squares = np.empty(n)
    for k in range(n):
        x = along.v_max**2
        for axis in range(2):
            slope = abs(nodes.slope[k, axis])
            if slope > 0.0:
                x = min(x, (motor.numbers[axis, 0] / slope) ** 2)
        near = min(nodes.way[k] - nodes.way[0], length - (nodes.way[k] - nodes.way[0]))
        near = max(near, 0.0)
        x = min(x, (0.5 * along.j_max * (6.0 * near / along.j_max) ** (2.0 / 3.0)) ** 2)
        low, high = 0.0, 0.0
        if nodes.bend[k, 0] != 0.0 or nodes.bend[k, 1] != 0.0:
            low, high = _gains(motor, nodes, k, x, along.a_max)
        if low > high:
            least = 0.0
            for _ in range(40):
                middle = 0.5 * (least + x)
                low, high = _gains(motor, nodes, k, middle, along.a_max)
                if low > high:
                    x = middle
                else:
                    least = middle
            x = least
        squares[k] = max(x, _SLOWEST)
    return squares


@cached
def lowest(ways: Array, values: Array, places: Array, limits: Array) -> Array:
    """Return values at nodes, no larger than the limits at the places around each."""
    minima = np.minimum(values, np.interp(ways, places, limits))
    k, last = 0, len(ways) - 1
    for i in range(len(places)):
        while k < last and 0.5 * (ways[k] + ways[k + 1]) < places[i]:
            k += 1
        if 0 < k < last:
            minima[k] = min(minima[k], limits[i])
    return minima


@cached
def both_passes(motor: Motor, nodes: Nodes, along: Along, most: Array) -> Array:
    """Return the largest squared speed within all limits but jerk, from rest to rest."""
    n = len(nodes.way)
    x = most.copy()
    x[0] = x[n - 1] = 0.0
    for k in range(n - 1):
        _, high = _gains(motor, nodes, k, x[k], along.a_max)
        gained = 2.0 * (nodes.way[k + 1] - nodes.way[k]) * high
        x[k + 1] = min(x[k + 1], max(x[k] + gained, _SLOWEST))
    for k in range(n - 1, 0, -1):
        low, _ = _gains(motor, nodes, k, x[k], along.a_max)
        gained = -2.0 * (nodes.way[k] - nodes.way[k - 1]) * low
        x[k - 1] = min(x[k - 1], max(x[k] + gained, _SLOWEST))
    x[0] = x[n - 1] = 0.0
    return x


@cached
def places_between(ends: tuple[float, float], count: int) -> Array:
    """Return places evenly spaced, but close to each other at the ends, where motion is slow."""
    first, last = ends
    step = (last - first) / (count - 1)
    places = np.empty(count + 2 * (_CLOSE_BY - 1))
    for k in range(len(places)):
        left, right = k, len(places) - 1 - k
        if left < _CLOSE_BY:
            places[k] = first + step * (left / _CLOSE_BY) ** 3
        elif right < _CLOSE_BY:
            places[k] = last - step * (right / _CLOSE_BY) ** 3
        else:
            places[k] = first + step * (left - _CLOSE_BY + 1)
    return places


@cached
def spaced(way: Array, x: Array, every: float, fewest: int, most: int) -> tuple[Array, Array]:
    """Return where nodes lie, evenly spaced in time, and the squared speeds there.

    In between `way` the acceleration is constant. The first and the last distances are quartered,
    since the jerk there is held to the largest speed of each.
    """
    n = len(way)
    time, speed = np.zeros(n), np.sqrt(x)
    for k in range(1, n):
        time[k] = time[k - 1] + 2.0 * (way[k] - way[k - 1]) / (speed[k - 1] + speed[k])
    count = min(max(math.ceil(time[n - 1] / every), fewest), most)
    ways, free = np.empty(count + 6 * _FINE + 1), np.empty(count + 6 * _FINE + 1)
    i = 0
    for k in range(len(ways)):
        if k < 4 * _FINE:
            u = 0.25 * k
        elif k < len(ways) - 4 * _FINE:
            u = k - 3.0 * _FINE
        else:
            u = count - 0.25 * (len(ways) - 1 - k)
        at = time[n - 1] * u / count
        while i < n - 2 and time[i + 1] <= at:
            i += 1
        passed = min(at - time[i], time[i + 1] - time[i])
        velocity = speed[i] + (speed[i + 1] - speed[i]) * passed / (time[i + 1] - time[i])
        ways[k] = way[i] + 0.5 * (speed[i] + velocity) * passed
        free[k] = max(velocity * velocity, _SLOWEST)
    ways[len(ways) - 1] = way[n - 1]
    return ways, free


@cached
def reach_at(motor: Motor, knots: Nodes, along: Along, x: Array, straight: bool) -> Array:
    """Return the largest deceleration and acceleration of x, y and along the path, (n + 1, 3, 2).

    Friction is that of the squared speeds x: were it to change with what the solver tries, the
    problem would not be convex. On a straight line the axes limit the acceleration along it.
    """
    reach = np.empty((len(x), 3, 2))
    for k in range(len(x)):
        speed = math.sqrt(x[k])
        reach[k, 2] = along.a_max
        for axis in range(2):
            slope = knots.slope[k, axis]
            down, up = acceleration_range(motor, axis, knots.place[k, axis], slope * speed)
            reach[k, axis, 0], reach[k, axis, 1] = down, up
            if straight and abs(slope) > 1e-9:
                first, second = (down, up) if slope > 0.0 else (up, down)
                reach[k, 2, 0] = min(reach[k, 2, 0], first / abs(slope))
                reach[k, 2, 1] = min(reach[k, 2, 1], second / abs(slope))
    return reach
