"""Compiled parts of time-optimal motion profiles: limits at a place, both passes, the solver."""

from __future__ import annotations

import math
from typing import NamedTuple

import numba
import numpy as np

from motionlab.trajectory.path import Array

_ROWS = 9  # constraints of a node
_ITERATIONS = 120
_GAP = 1e-5  # of the time, at which the solver is done
_BEYOND = 1e-6  # share of a limit by which it may be missed then
_CLOSE = 0.02  # of both, at which a result is used where it gets no further
_BOUNDARY = 0.99  # share of the step to the nearest boundary that is taken
_LEAST = 1e-3  # share of the acceleration limit that is assumed to be left at least
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


@numba.njit(error_model="numpy", nogil=True, cache=True)
def available(motor: Motor, axis: int, direction: int, place: float) -> float:
    """Return the thrust available at a place, N; direction 0 is backward, 1 forward."""
    table = motor.thrust[axis, direction]
    turns = place / motor.numbers[axis, 7]
    u = (turns - math.floor(turns)) * len(table)
    low = int(u)
    share = u - low
    first, second = table[low % len(table)], table[(low + 1) % len(table)]
    return first + (second - first) * share


@numba.njit(error_model="numpy", nogil=True, cache=True)
def friction(motor: Motor, axis: int, v: float) -> float:
    """Return the steady friction at a velocity, N, with its sign."""
    _, _, _, coulomb, static, stribeck, viscous, _ = motor.numbers[axis]
    level = coulomb + (static - coulomb) * math.exp(-((v / stribeck) ** 2))
    return np.sign(v) * level + viscous * v


@numba.njit(error_model="numpy", nogil=True, cache=True)
def acceleration_range(motor: Motor, axis: int, place: float, v: float) -> tuple[float, float]:
    """Return the largest deceleration, as a positive number, and acceleration of an axis."""
    a_max, mass = motor.numbers[axis, 1], motor.numbers[axis, 2]
    against = friction(motor, axis, v)
    down = min(a_max, (available(motor, axis, 0, place) + against) / mass)
    up = min(a_max, (available(motor, axis, 1, place) - against) / mass)
    return max(down, _LEAST * a_max), max(up, _LEAST * a_max)


@numba.njit(error_model="numpy", nogil=True, cache=True)
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


@numba.njit(error_model="numpy", nogil=True, cache=True)
def ceiling(motor: Motor, nodes: Nodes, along: Along) -> Array:
    """Return the largest squared speed at each node, by itself; (m/s)^2.

    Besides velocity and centripetal acceleration, constant jerk from rest at either end bounds it.
    """
    n = len(nodes.way)
    length = nodes.way[n - 1] - nodes.way[0]
    found = np.empty(n)
    for k in range(n):
        x = along.v_max**2
        for axis in range(2):
            slope = abs(nodes.slope[k, axis])
            if slope > 0.0:
                x = min(x, (motor.numbers[axis, 0] / slope) ** 2)
        near = min(nodes.way[k] - nodes.way[0], length - (nodes.way[k] - nodes.way[0]))
        near = max(near, 0.0)
        x = min(x, (0.5 * along.j_max * (6.0 * near / along.j_max) ** (2.0 / 3.0)) ** 2)
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
        found[k] = max(x, _SLOWEST)
    return found


@numba.njit(error_model="numpy", nogil=True, cache=True)
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


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _constraints(  # noqa: PLR0913, PLR0917 - one knot with its neighbours
    knots: Nodes,
    along: Along,
    reach: Array,
    share: float,
    most: float,
    k: int,
    c: Array,
    g: Array,
    jacobian: Array,
) -> None:
    """Set the constraints g <= 0 of a knot, as shares of their limits, and of the jerk after it.

    Their derivatives are those by c of the intervals before, after, and after that. The jerk after
    the last knot before the end is that of its `tie`.
    """
    way, count = knots.way, len(c)
    width = way[k + 1] - way[k]
    apart = 0.5 * (way[k + 1] - way[k - 1])
    right = 0.5 * (way[k] - way[k - 1]) / apart
    left = 1.0 - right
    x = left * c[k - 1] + right * c[k]
    gain = 0.5 * (c[k] - c[k - 1]) / apart
    jacobian[:, :] = 0.0
    jacobian[0, 0], jacobian[0, 1] = left / (share * most), right / (share * most)
    g[0] = x / (share * most) - 1.0
    for sign in range(2):
        unit = (1.0 - 2.0 * sign) / (share * along.a_max)
        jacobian[1 + sign, 0], jacobian[1 + sign, 1] = -0.5 / apart * unit, 0.5 / apart * unit
        g[1 + sign] = gain * unit - 1.0
    for axis in range(2):
        slope, bend = knots.slope[k, axis], knots.bend[k, axis]
        down, up = reach[axis]
        row = 3 + 2 * axis
        value = slope * gain + bend * x
        before, after = bend * left - 0.5 * slope / apart, bend * right + 0.5 * slope / apart
        jacobian[row, 0], jacobian[row, 1] = before / (share * up), after / (share * up)
        jacobian[row + 1, 0], jacobian[row + 1, 1] = (
            -before / (share * down),
            -after / (share * down),
        )
        g[row] = value / (share * up) - 1.0
        g[row + 1] = -value / (share * down) - 1.0
    if k == count - 1:
        g[7:] = -1.0
        jacobian[:, 0] += tie(way[count], way[k], way[k - 1]) * jacobian[:, 1]
        jacobian[:, 1] = 0.0
        return
    further = 0.5 * (way[k + 2] - way[k])
    limit = 2.0 * share * along.j_max / math.sqrt(c[k] * _faster(way, k))
    first, last = 1.0 / (apart * width), 1.0 / (further * width)
    second = first * c[k - 1] - (first + last) * c[k] + last * c[k + 1]
    for sign in range(2):
        unit = (1.0 - 2.0 * sign) / limit
        jacobian[7 + sign, 0] = first * unit
        jacobian[7 + sign, 1] = (0.5 * second / c[k] - first - last) * unit
        jacobian[7 + sign, 2] = last * unit
        g[7 + sign] = second * unit - 1.0
    if k == 1:
        jacobian[:, 1] += tie(way[0], way[1], way[2]) * jacobian[:, 0]
        jacobian[:, 0] = 0.0
    if k == count - 2:
        jacobian[:, 1] += tie(way[count], way[count - 1], way[count - 2]) * jacobian[:, 2]
        jacobian[:, 2] = 0.0


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _faster(way: Array, k: int) -> float:
    """Return the largest squared speed between knots k and k + 1 over that in the middle.

    It counts near the ends, where the squared speed is the arc length from there to the power of
    4/3 at constant jerk.
    """
    left, right = way[k] - way[0], way[len(way) - 1] - way[k + 1]
    near, half = min(left, right), 0.5 * (way[k + 1] - way[k])
    return ((near + 2.0 * half) / (near + half)) ** (4.0 / 3.0)


@numba.njit(error_model="numpy", nogil=True, cache=True)
def reach_at(motor: Motor, knots: Nodes, x: Array) -> Array:
    """Return the largest deceleration and acceleration of each axis, shape (n + 1, 2, 2).

    Friction is that of the squared speeds x: were it to change with what the solver tries, the
    problem would not be convex.
    """
    reach = np.empty((len(x), 2, 2))
    for k in range(len(x)):
        speed = math.sqrt(x[k])
        for axis in range(2):
            v = knots.slope[k, axis] * speed
            reach[k, axis] = acceleration_range(motor, axis, knots.place[k, axis], v)
    return reach


@numba.njit(error_model="numpy", nogil=True, cache=True)
def tie(end: float, first: float, second: float) -> float:
    """Return c of the interval at an end over c of the one beside it.

    Then the acceleration at the knot between them is that of constant jerk from rest.
    """
    width, apart = abs(first - end), 0.5 * abs(second - end)
    right = 0.5 * width / apart
    above = 1.0 / apart - 4.0 / 3.0 * right / width
    return max(above, 0.01 / apart) / (4.0 / 3.0 * (1.0 - right) / width + 1.0 / apart)


@numba.njit(error_model="numpy", nogil=True, cache=True)
def tied(way: Array, c: Array) -> None:
    """Set c of the first and the last interval."""
    n = len(c)
    c[0] = tie(way[0], way[1], way[2]) * c[1]
    c[n - 1] = tie(way[n], way[n - 1], way[n - 2]) * c[n - 2]


@numba.njit(error_model="numpy", nogil=True, cache=True)
def _solve_band(diagonal: Array, first: Array, second: Array, right: Array) -> None:
    """Solve a symmetric system of bandwidth two in place; `right` becomes the solution."""
    n = len(diagonal)
    for k in range(n):
        pivot = diagonal[k]
        if k + 1 < n:
            a = first[k] / pivot
            diagonal[k + 1] -= a * first[k]
            right[k + 1] -= a * right[k]
            if k + 2 < n:
                b = second[k] / pivot
                first[k + 1] -= a * second[k]
                diagonal[k + 2] -= b * second[k]
                right[k + 2] -= b * right[k]
    for k in range(n - 1, -1, -1):
        value = right[k]
        if k + 1 < n:
            value -= first[k] * right[k + 1]
        if k + 2 < n:
            value -= second[k] * right[k + 2]
        right[k] = value / diagonal[k]


@numba.njit(error_model="numpy", nogil=True, cache=True)
def solve(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917 - one compiled loop
    knots: Nodes, along: Along, reach: Array, most: Array, share: Array, c: Array
) -> tuple[Array, bool]:
    r"""Return the squared speeds of least time, and whether the solver got there.

    .. math:: \min_c \sum_k \frac{\Delta s_k}{\sqrt{c_k}} \quad \text{with} \quad g(c) \le 0

    The squared speed is a quadratic B-spline over arc length, whose coefficients c belong to the
    middles of the intervals between knots: the jerk is the same throughout an interval but for the
    speed, and the acceleration continuous.

    Parameters
    ----------
    knots : Nodes
        The n + 1 knots, from rest to rest.
    along : Along
        Limits along the path.
    reach : ndarray, shape (n + 1, 2, 2)
        From `reach_at`.
    most : ndarray, shape (n + 1,)
        Largest squared speed of each knot by itself.
    share : ndarray, shape (n + 1,)
        Share of all limits that may be used at each knot.
    c : ndarray, shape (n,)
        Where to start, > 0.
    """
    last = len(c) - 1
    c = c.copy()
    tied(knots.way, c)
    weight = np.empty(len(c))
    whole = 0.0
    for k in range(1, last):
        weight[k] = knots.way[k + 1] - knots.way[k]
        whole += weight[k] / math.sqrt(c[k])
    g, slack = np.empty((len(c), _ROWS)), np.empty((len(c), _ROWS))
    price = np.empty((len(c), _ROWS))
    slack_step, price_step = np.empty((len(c), _ROWS)), np.empty((len(c), _ROWS))
    jacobian = np.empty((len(c), _ROWS, 3))
    count = last * _ROWS
    target = 0.1 / count
    worst = gap = math.inf
    for k in range(1, last + 1):
        _constraints(knots, along, reach[k], share[k], most[k], k, c, g[k], jacobian[k])
        for row in range(_ROWS):
            slack[k, row] = max(-g[k, row], 0.1)
            price[k, row] = target / slack[k, row]
    for _ in range(_ITERATIONS):
        diagonal, right = np.zeros(last - 1), np.zeros(last - 1)
        first, second = np.zeros(last - 1), np.zeros(last - 1)
        worst, gap = 0.0, 0.0
        for k in range(1, last + 1):
            _constraints(knots, along, reach[k], share[k], most[k], k, c, g[k], jacobian[k])
            i = k - 1
            if k < last:
                root = math.sqrt(c[k])
                scaled = weight[k] / (whole * c[k] * root)
                right[i] += 0.5 * scaled
                diagonal[i] += 0.75 * scaled / c[k]
            for row in range(_ROWS):
                slack[k, row] = max(slack[k, row], -g[k, row])
                s, z = slack[k, row], price[k, row]
                missing = g[k, row] + s
                worst, gap = max(worst, abs(missing)), gap + s * z
                push = z + (z * missing - (s * z - target)) / s
                ratio = z / s
                low, own, high = jacobian[k, row]
                if i > 0:
                    diagonal[i - 1] += ratio * low * low
                    right[i - 1] -= low * push
                if k == last:
                    continue
                diagonal[i] += ratio * own * own
                right[i] -= own * push
                if i > 0:
                    first[i - 1] += ratio * low * own
                if i + 1 < last - 1:
                    diagonal[i + 1] += ratio * high * high
                    first[i] += ratio * own * high
                    right[i + 1] -= high * push
                    if i > 0:
                        second[i - 1] += ratio * low * high
        if gap < _GAP and worst < _BEYOND:
            return c, True
        _solve_band(diagonal, first, second, right)
        primal, dual = 1.0, 1.0
        for k in range(1, last + 1):
            step = right[k - 1] if k < last else 0.0
            if step < -0.9 * c[k]:
                primal = min(primal, -0.9 * c[k] / step)
            before = right[k - 2] if k > 1 else 0.0
            after = right[k] if k < last - 1 else 0.0
            for row in range(_ROWS):
                s, z = slack[k, row], price[k, row]
                low, own, high = jacobian[k, row]
                ds = -(g[k, row] + s) - (low * before + own * step + high * after)
                dz = -(s * z - target + z * ds) / s
                if ds < -_BOUNDARY * s:
                    primal = min(primal, -_BOUNDARY * s / ds)
                if dz < -_BOUNDARY * z:
                    dual = min(dual, -_BOUNDARY * z / dz)
                slack_step[k, row], price_step[k, row] = ds, dz
        gap = 0.0
        for k in range(1, last + 1):
            if k < last:
                c[k] += primal * right[k - 1]
            for row in range(_ROWS):
                slack[k, row] += primal * slack_step[k, row]
                price[k, row] += dual * price_step[k, row]
                gap += slack[k, row] * price[k, row]
            if not c[k] > 0.0:
                return c, False
        tied(knots.way, c)
        least = min(primal, dual)
        target = (0.1 if least > 0.7 else 0.5 if least > 0.2 else 0.9) * gap / count
    return c, gap < _CLOSE and worst < _CLOSE


@numba.njit(error_model="numpy", nogil=True, cache=True)
def timed(way: Array, c: Array) -> tuple[Array, Array, Array]:
    """Return time, speed and acceleration along the path at each knot.

    In between the speed is a cubic over time, and the interval as long as it is.
    """
    last = len(c)
    time, speed, gain = np.zeros(last + 1), np.zeros(last + 1), np.zeros(last + 1)
    for k in range(1, last):
        apart = 0.5 * (way[k + 1] - way[k - 1])
        right = 0.5 * (way[k] - way[k - 1]) / apart
        speed[k] = math.sqrt((1.0 - right) * c[k - 1] + right * c[k])
        gain[k] = 0.5 * (c[k] - c[k - 1]) / apart
    for k in range(last):
        length = way[k + 1] - way[k]
        mean = 0.5 * (speed[k] + speed[k + 1])
        rest = (gain[k] - gain[k + 1]) / 3.0 * length
        time[k + 1] = time[k] + 2.0 * length / (mean + math.sqrt(max(mean * mean + rest, 0.0)))
    return time, speed, gain
