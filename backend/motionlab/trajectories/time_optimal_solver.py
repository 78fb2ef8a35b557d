"""Interior-point solver of time-optimal motion profiles with limited jerk."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from motionlab.lanes import cached
from motionlab.trajectories.path import Array
from motionlab.trajectories.time_optimal_limits import Along, Nodes

_ROWS = 9  # constraints of a node
_STRAIGHT_ROWS = 5  # of one on a straight line: the axes limit the acceleration along it
_ITERATIONS = 120
_GAP = 1e-4  # of the time, at which the solver is done
_BEYOND = 1e-6  # share of a limit by which it may be missed then
_CLOSE = 0.02  # of both, at which a result is used where it gets no further
FAILED, CLOSE, DONE = range(3)
_BOUNDARY = 0.99  # share of the step to the nearest boundary that is taken


class _Spacing(NamedTuple):
    """What the constraints of each knot need of the places of the knots, shape (n + 1,)."""

    apart: Array  # between the middles of the intervals before and after, m
    left: Array  # weights of the squared speeds before and after
    right: Array
    before: Array  # weights of c before and after the interval after it in the second derivative
    after: Array
    faster: Array  # from `_faster`


@cached
def _spacing(way: Array) -> _Spacing:
    n = len(way)
    spacing = _Spacing(np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))
    for k in range(1, n - 1):
        width = way[k + 1] - way[k]
        apart = 0.5 * (way[k + 1] - way[k - 1])
        spacing.apart[k] = apart
        spacing.right[k] = 0.5 * (way[k] - way[k - 1]) / apart
        spacing.left[k] = 1.0 - spacing.right[k]
        if k < n - 2:
            further = 0.5 * (way[k + 2] - way[k])
            spacing.before[k], spacing.after[k] = 1.0 / (apart * width), 1.0 / (further * width)
            spacing.faster[k] = _faster(way, k)
    return spacing


@cached
def _linear(  # noqa: PLR0913, PLR0917 - one knot with its neighbours
    knots: Nodes,
    spacing: _Spacing,
    reach: Array,
    share: float,
    most: float,
    k: int,
    jacobian: Array,
) -> None:
    """Set the derivatives of a knot's constraints but that of jerk: they do not depend on c.

    They are those by c of the intervals before, after, and after that.
    """
    apart, left, right = spacing.apart[k], spacing.left[k], spacing.right[k]
    jacobian[:, :] = 0.0
    jacobian[0, 0], jacobian[0, 1] = left / (share * most), right / (share * most)
    for sign in range(2):
        unit = (1.0 - 2.0 * sign) / (share * reach[2, 1 - sign])
        jacobian[1 + sign, 0], jacobian[1 + sign, 1] = -0.5 / apart * unit, 0.5 / apart * unit
    for axis in range(2 if len(jacobian) > _STRAIGHT_ROWS else 0):
        slope, bend = knots.slope[k, axis], knots.bend[k, axis]
        down, up = reach[axis]
        row = 5 + 2 * axis
        before, after = bend * left - 0.5 * slope / apart, bend * right + 0.5 * slope / apart
        jacobian[row, 0], jacobian[row, 1] = before / (share * up), after / (share * up)
        jacobian[row + 1, 0], jacobian[row + 1, 1] = (
            -before / (share * down),
            -after / (share * down),
        )
    _tie_in(knots.way, k, jacobian)


@cached
def _tie_in(way: Array, k: int, jacobian: Array) -> None:
    """Let derivatives by c of the first and the last interval count as those by their neighbours'.

    Only knots next to an end have any.
    """
    last = len(way) - 2
    if k == last:
        jacobian[:, 0] += tie(way[last + 1], way[last], way[last - 1]) * jacobian[:, 1]
        jacobian[:, 1] = 0.0
        return
    if k == 1:
        jacobian[:, 1] += tie(way[0], way[1], way[2]) * jacobian[:, 0]
        jacobian[:, 0] = 0.0
    if k == last - 1:
        jacobian[:, 1] += tie(way[last + 1], way[last], way[last - 1]) * jacobian[:, 2]
        jacobian[:, 2] = 0.0


@cached
def _constraints(  # noqa: PLR0913, PLR0917 - what is known of all knots
    knots: Nodes,
    spacing: _Spacing,
    along: Along,
    reach: Array,
    share: Array,
    most: Array,
    start: Array,
    c: Array,
    g: Array,
    jacobian: Array,
) -> None:
    """Set the constraints g <= 0 of all knots, as shares of their limits, and of the jerk after.

    Of the derivatives those of the jerk depend on c. The jerk after the last knot before the end is
    that of its `tie`.
    """
    last = len(c) - 1
    axes = 2 if g.shape[1] > _STRAIGHT_ROWS else 0
    for k in range(1, last + 1):
        x = spacing.left[k] * c[k - 1] + spacing.right[k] * c[k]
        gain = 0.5 * (c[k] - c[k - 1]) / spacing.apart[k]
        g[k, 0] = x / (share[k] * most[k]) - 1.0
        g[k, 1] = gain * (1.0 / (share[k] * reach[k, 2, 1])) - 1.0
        g[k, 2] = gain * (-1.0 / (share[k] * reach[k, 2, 0])) - 1.0
        for axis in range(axes):
            value = knots.slope[k, axis] * gain + knots.bend[k, axis] * x
            g[k, 5 + 2 * axis] = value / (share[k] * reach[k, axis, 1]) - 1.0
            g[k, 6 + 2 * axis] = -value / (share[k] * reach[k, axis, 0]) - 1.0
    for k in range(1, last):
        # With the speed at the right, |x''| / 2 <= j / sqrt(x), the constraint is concave in c: the
        # linear one is stricter, and no step of the solver leads beyond the limit.
        scale = math.sqrt(start[k] * spacing.faster[k])
        unit = scale / (2.0 * share[k] * along.j_max)
        room = math.sqrt(start[k] / c[k])
        before, after = spacing.before[k], spacing.after[k]
        second = before * c[k - 1] - (before + after) * c[k] + after * c[k + 1]
        for sign in range(2):
            signed = (1.0 - 2.0 * sign) * unit
            jacobian[k, 3 + sign, 0] = before * signed
            jacobian[k, 3 + sign, 1] = -(before + after) * signed + 0.5 * room / c[k]
            jacobian[k, 3 + sign, 2] = after * signed
            g[k, 3 + sign] = second * signed - room
    _tie_in(knots.way, 1, jacobian[1, 3:5])
    _tie_in(knots.way, last - 1, jacobian[last - 1, 3:5])
    g[last, 3:5] = -1.0


@cached
def _faster(way: Array, k: int) -> float:
    """Return the largest squared speed between knots k and k + 1 over that in the middle.

    It counts near the ends, where the squared speed is the arc length from there to the power of
    4/3 at constant jerk.
    """
    left, right = way[k] - way[0], way[len(way) - 1] - way[k + 1]
    near, half = min(left, right), 0.5 * (way[k + 1] - way[k])
    return ((near + 2.0 * half) / (near + half)) ** (4.0 / 3.0)


@cached
def tie(end: float, first: float, second: float) -> float:
    """Return c of the interval at an end over c of the one beside it.

    Then the acceleration at the knot between them is that of constant jerk from rest.
    """
    width, apart = abs(first - end), 0.5 * abs(second - end)
    right = 0.5 * width / apart
    above = 1.0 / apart - 4.0 / 3.0 * right / width
    return max(above, 0.01 / apart) / (4.0 / 3.0 * (1.0 - right) / width + 1.0 / apart)


@cached
def tied(way: Array, c: Array) -> None:
    """Set c of the first and the last interval."""
    n = len(c)
    c[0] = tie(way[0], way[1], way[2]) * c[1]
    c[n - 1] = tie(way[n], way[n - 1], way[n - 2]) * c[n - 2]


@cached
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


@cached
def solve(  # noqa: PLR0912, PLR0913, PLR0915, PLR0917 - one compiled loop
    knots: Nodes,
    along: Along,
    reach: Array,
    most: Array,
    share: Array,
    c: Array,
    straight: bool,
) -> tuple[Array, int]:
    r"""Return the squared speeds of least time, and one of DONE, CLOSE and FAILED.

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
    reach : ndarray, shape (n + 1, 3, 2)
        From `reach_at`.
    most : ndarray, shape (n + 1,)
        Largest squared speed of each knot by itself.
    share : ndarray, shape (n + 1,)
        Share of all limits that may be used at each knot.
    c : ndarray, shape (n,)
        Where to start, > 0.
    straight : bool
        Whether it is a straight line.
    """
    rows = _STRAIGHT_ROWS if straight else _ROWS
    last = len(c) - 1
    c = c.copy()
    tied(knots.way, c)
    start = c.copy()
    weight = np.empty(len(c))
    whole = 0.0
    for k in range(1, last):
        weight[k] = knots.way[k + 1] - knots.way[k]
        whole += weight[k] / math.sqrt(c[k])
    g, slack = np.empty((len(c), rows)), np.empty((len(c), rows))
    price = np.empty((len(c), rows))
    slack_step, price_step = np.empty((len(c), rows)), np.empty((len(c), rows))
    jacobian = np.empty((len(c), rows, 3))
    count = last * rows
    target = 0.1 / count
    worst = gap = math.inf
    spacing = _spacing(knots.way)
    for k in range(1, last + 1):
        _linear(knots, spacing, reach[k], share[k], most[k], k, jacobian[k])
    _constraints(knots, spacing, along, reach, share, most, start, c, g, jacobian)
    for k in range(1, last + 1):
        for row in range(rows):
            slack[k, row] = max(-g[k, row], 0.1)
            price[k, row] = target / slack[k, row]
    for _ in range(_ITERATIONS):
        diagonal, right = np.zeros(last - 1), np.zeros(last - 1)
        first, second = np.zeros(last - 1), np.zeros(last - 1)
        worst, gap = 0.0, 0.0
        _constraints(knots, spacing, along, reach, share, most, start, c, g, jacobian)
        for k in range(1, last + 1):
            i = k - 1
            if k < last:
                root = math.sqrt(c[k])
                scaled = weight[k] / (whole * c[k] * root)
                right[i] += 0.5 * scaled
                diagonal[i] += 0.75 * scaled / c[k]
            for row in range(rows):
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
            return c, DONE
        _solve_band(diagonal, first, second, right)
        primal, dual = 1.0, 1.0
        for k in range(1, last + 1):
            step = right[k - 1] if k < last else 0.0
            if step < -0.9 * c[k]:
                primal = min(primal, -0.9 * c[k] / step)
            before = right[k - 2] if k > 1 else 0.0
            after = right[k] if k < last - 1 else 0.0
            for row in range(rows):
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
            for row in range(rows):
                slack[k, row] += primal * slack_step[k, row]
                price[k, row] += dual * price_step[k, row]
                gap += slack[k, row] * price[k, row]
            if not c[k] > 0.0:
                return c, FAILED
        tied(knots.way, c)
        least = min(primal, dual)
        target = (0.1 if least > 0.7 else 0.5 if least > 0.2 else 0.9) * gap / count
    return c, CLOSE if gap < _CLOSE and worst < _CLOSE else FAILED


@cached
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
