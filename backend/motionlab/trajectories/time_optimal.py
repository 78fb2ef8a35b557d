r"""Time-optimal motion profiles: as fast along a path as motor and limits of the path allow.

Along the path, with arc length s, tangent q' and curvature q'' of each axis,

.. math:: \dot q = q' \dot s, \qquad \ddot q = q' \ddot s + q'' \dot s^2

so that with :math:`x(s) = \dot s^2`, :math:`\ddot s = x'/2` and :math:`\dddot s = x'' \sqrt x / 2`
limits of velocity, acceleration and thrust are linear in x, and the time
:math:`T = \int ds / \sqrt x` is convex. Three steps find x:

1. A forward and a backward pass over a fine grid, without jerk: where the nodes of step 2 lie, and
   how fast the path can be followed at all.
2. A primal-dual interior-point method over some thousand nodes, evenly spaced in the time of
   step 1, with jerk: each of its steps solves a band of five diagonals.
3. A check of every control tick. Where one is beyond a limit, the limits of the nodes around it are
   tightened and step 2 is repeated; what little is left after that is stretched in time.

On a straight line the axes limit the acceleration along it alone: step 2 has five constraints a
node there, not nine.

References
----------
Verscheure et al., "Time-optimal path tracking for robots: a convex optimization approach", IEEE
Trans. Automatic Control 2009. Debrouwere et al., "Time-optimal path following for robots with
convex-concave constraints using sequential convex programming", IEEE Trans. Robotics 2013.
"""

from __future__ import annotations

import math

import numpy as np

from motionlab.config.planned_motor import PlannedAxis, PlannedMotor
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_profile import (
    jerk_limited,
    jerk_limited_times,
)
from motionlab.trajectories.path import Array, Path
from motionlab.trajectories.time_optimal_check import Cells, on_cells, shares, tighten
from motionlab.trajectories.time_optimal_limits import (
    Along,
    Motor,
    Nodes,
    both_passes,
    ceiling,
    places_between,
    reach_at,
    spaced,
)
from motionlab.trajectories.time_optimal_solver import solve, tied, timed

_PLACES = (64, 60_000)
_PLACES_PER_EDGE = 16
_NODES = (40, 20_000)
_NODE_TIME = 0.002  # s
_START = 0.25
"""Squared speed from which the solver starts, as a share of that without limit of jerk."""
_SHARE = 0.998
"""Share of the limits that nodes use at first, so that little lies beyond them in between."""
_TIGHTER = 0.002
"""Margin with which limits are tightened; it grows with every attempt."""
_SOLUTIONS = 5
_STRETCHES = 40
_ROUNDING = 1e-9


def motor_of(config: PlannedMotor) -> Motor:
    """Return the limits of both axes as arrays."""
    axes = (config.x, config.y)
    size = max(len(axis.forward) for axis in axes)
    thrust = [
        [_resampled(values, size) for values in (axis.backward, axis.forward)] for axis in axes
    ]
    return Motor(np.array([_numbers(axis) for axis in axes]), np.array(thrust))


def plan_leg(
    path: Path, ends: tuple[float, float], edges: int, motor: Motor, along: Along
) -> Cells:
    """Plan a stretch of a path from rest to rest.

    Parameters
    ----------
    path : Path
        Arc length to position, unit tangent and curvature.
    ends : tuple of float
        Arc length at its start and its end, m.
    edges : int
        Edges of a smooth curve in it; 0 for a straight one.
    motor : Motor
        Limits of the axes.
    along : Along
        Limits along the path.

    Returns
    -------
    Cells
        The profile over time in control periods, a whole number of them long.
    """
    if not edges:
        cells = _straight(path, ends, motor, along)
        if cells is not None:
            return _whole(cells, CONTROL_PERIOD)
    return _solved(path, ends, edges, motor, along)


def _straight(path: Path, ends: tuple[float, float], motor: Motor, along: Along) -> Cells | None:
    """Return the seven phases of a straight stretch; None where the thrust bounds it."""
    slope = np.abs(path(np.array([ends[0]]))[1][0])
    v_max, a_max, mass, _, static, _, viscous, _ = motor.numbers.T
    with np.errstate(divide="ignore"):
        v = min(along.v_max, float((v_max / slope).min()))
        a = min(along.a_max, float((a_max / slope).min()))
    left = motor.thrust.min(axis=(1, 2)) - np.where(slope > 0, static + viscous * v * slope, 0.0)
    if (mass * a * slope > left).any():
        return None
    length = ends[1] - ends[0]
    jerk, ramp, travel = jerk_limited_times(length, v_max=v, a_max=a, j_max=along.j_max)
    whole = travel + ramp + jerk
    time = np.sort([0.0, jerk, ramp, ramp + jerk, travel, travel + jerk, travel + ramp])
    time = np.append(time[np.diff(time, append=whole) > _ROUNDING], whole)
    time[0] = 0.0
    way, rate, second = jerk_limited(time, jerk, ramp, travel)
    return Cells(time, ends[0] + length * way, length * rate, length * second)


def _solved(path: Path, ends: tuple[float, float], edges: int, motor: Motor, along: Along) -> Cells:
    count = min(max(_PLACES_PER_EDGE * edges, _PLACES[0]), _PLACES[1])
    places = _nodes(path, places_between(ends, count))
    most = ceiling(motor, places, along)
    free = both_passes(motor, places, along, most)
    ways, free = spaced(places.way, free, _NODE_TIME, *_NODES)
    nodes = _nodes(path, ways)
    most = np.minimum(ceiling(motor, nodes, along), np.interp(ways, places.way, most))
    middles = 0.5 * (ways[1:] + ways[:-1])
    share, c = np.full(len(ways), _SHARE), _START * np.interp(middles, ways, free)
    tied(ways, c)
    cells, straight = None, edges == 0
    for attempt in range(_SOLUTIONS):
        reach = reach_at(motor, nodes, along, free, straight)
        found, done = solve(nodes, along, reach, most, share, c, straight)
        if not done:
            break
        cells = _cells(ways, found)
        free = (cells.speed / CONTROL_PERIOD) ** 2
        excess = _excess(path, cells, motor, along)
        if not tighten(cells.time, excess, share, 1.0, 1.0 - _TIGHTER * (1 + attempt)):
            return cells
        c = 0.5 * found
    return _stretched(path, _cells(ways, c) if cells is None else cells, motor, along)


def _cells(ways: Array, c: Array) -> Cells:
    time, speed, gain = timed(ways, c)
    return _whole(Cells(time, ways, speed, gain), CONTROL_PERIOD)


def _excess(path: Path, cells: Cells, motor: Motor, along: Along) -> Array:
    """Return `shares` of every tick."""
    way, rate, second = on_cells(cells, np.arange(round(cells.time[-1]), dtype=np.float64))
    speed, gain = rate / CONTROL_PERIOD, second / CONTROL_PERIOD**2
    return shares(motor, along, _nodes(path, way), speed, gain)


def _stretched(path: Path, cells: Cells, motor: Motor, along: Along) -> Cells:
    """Stretch a profile in time, no further than needed, until no tick is beyond a limit."""
    for _ in range(_STRETCHES):
        worst = float(_excess(path, cells, motor, along).max())
        if worst <= 1.0:
            break
        cells = _whole(cells, 1.0 / max(math.sqrt(worst), 1.0 + 1.0 / cells.time[-1]))
    return cells


def _whole(cells: Cells, unit: float) -> Cells:
    """Return a profile in another unit of time, a whole number of which it then lasts."""
    ticks = max(2, math.ceil(cells.time[-1] / unit * (1.0 - _ROUNDING)))
    unit = cells.time[-1] / ticks
    return Cells(
        np.append(cells.time[:-1] / unit, float(ticks)),
        cells.way,
        cells.speed * unit,
        cells.gain * unit**2,
    )


def _nodes(path: Path, way: Array) -> Nodes:
    return Nodes(way, *path(way))


def _numbers(axis: PlannedAxis) -> tuple[float, ...]:
    friction = (axis.F_c, axis.F_s, axis.v_s, axis.sigma_2)
    return axis.velocity_max, axis.acceleration_max, axis.mass, *friction, axis.pitch


def _resampled(values: tuple[float, ...], size: int) -> Array:
    given = len(values)
    return np.interp(np.arange(size) * given / size, np.arange(given), values, period=given)
