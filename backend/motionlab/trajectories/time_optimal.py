r"""Time-optimal motion profiles: as fast along a path as motor and limits of the path allow.

Along the path, with arc length s, tangent q' and curvature q'' of each axis,

.. math:: \dot q = q' \dot s, \qquad \ddot q = q' \ddot s + q'' \dot s^2

so that with :math:`x(s) = \dot s^2`, :math:`\ddot s = x'/2` and :math:`\dddot s = x'' \sqrt x / 2`
limits of velocity, acceleration and thrust are linear in x, and the time
:math:`T = \int ds / \sqrt x` is convex. Three steps find x:

1. A forward and a backward pass over a fine grid, without jerk: where the nodes of step 2 lie, and
   how fast the path can be followed at all.
2. A primal-dual interior-point method over some thousand nodes, evenly spaced in the time of
   step 1, with jerk: each of its steps solves a band of five diagonals. It starts from the solution
   on a coarse grid, and again from what it reached where it has not converged.
3. A check of every control tick. Where one is beyond a limit, the limits of the nodes around it are
   tightened and step 2 is repeated; what little is left after that is stretched in time.

On a straight line the axes limit the acceleration along it alone: step 2 has five constraints a
node there, not nine. The seven phases along the stretch are kept where they are faster, as on
nearly straight curves.

References
----------
Verscheure et al., "Time-optimal path tracking for robots: a convex optimization approach", IEEE
Trans. Automatic Control 2009. Debrouwere et al., "Time-optimal path following for robots with
convex-concave constraints using sequential convex programming", IEEE Trans. Robotics 2013.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from motionlab.config.planned_motor import PlannedAxis, PlannedMotor
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion import refuse_too_long
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
    lowest,
    places_between,
    reach_at,
    spaced,
    squared_speed_ceiling,
)
from motionlab.trajectories.time_optimal_solver import DONE, FAILED, solve, tied, timed

_PLACES = (64, 60_000)
_PLACES_PER_EDGE = 16
_NODES = (40, 20_000)
_NODE_TIME = 0.001  # s
_COARSE = 4
"""Times as far apart are the nodes of the grid whose solution the solver starts from."""
_START = 0.25
"""Squared speed from which the solver starts, as a share of that without limit of jerk."""
_SHARE = 0.998
"""Share of the limits that nodes use at first, so that little lies beyond them in between."""
_TIGHTER = 0.002
"""Margin with which limits are tightened; it grows with every attempt."""
_SOLUTIONS = 12
_STARTS = 4
_AGAIN = 0.5
"""Share of the squared speed of a solution from which the solver starts again."""
_STRETCHES = 40
_LONGEST_STRETCH = 64.0
_LONGEST_STRETCHED = 600.0 / CONTROL_PERIOD
"""Ticks of the longest profile that is stretched: each attempt looks at all of them."""
_CLOSE = 1.03
"""Times as long as the solver's motion is what still counts as converged, once stretched."""
_TURN = 0.2  # rad
_SPLITS = 24
_ROUNDING = 1e-9


def motor_of(config: PlannedMotor) -> Motor:
    """Return the limits of both axes as arrays."""
    axes = (config.x, config.y)
    size = max(len(axis.forward) for axis in axes)
    thrust = [
        [_resampled(values, size) for values in (axis.backward, axis.forward)] for axis in axes
    ]
    return Motor(np.array([_numbers(axis) for axis in axes]), np.array(thrust))


class Leg(NamedTuple):
    """A stretch of a path from rest to rest."""

    cells: Cells  # its profile over time in control periods, a whole number of them long
    converged: bool  # whether it is time-optimal, not only within the limits


def plan_leg(path: Path, ends: tuple[float, float], edges: int, motor: Motor, along: Along) -> Leg:
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

    Raises
    ------
    ConfigError
        If the limits along the path alone make it longer than an hour.
    """
    if not edges:
        cells = _straight(path, ends, motor, along)
        if cells is not None:
            return Leg(cells, converged=True)
    phases = _seven_phases(ends, along.v_max, along.a_max, along.j_max)
    refuse_too_long(round(phases.time[-1]))
    if _excess(path, phases, motor, along).max() <= 1.0 + _ROUNDING:
        return Leg(phases, converged=True)  # nothing is faster within the limits along the path
    solved, converged = _solved(path, ends, edges, motor, along)
    if solved is None:
        return Leg(_stretched(path, phases, motor, along), converged=False)
    # A stretched profile is never shorter: most are longer without it.
    if phases.time[-1] < solved.time[-1]:
        phases = _stretched(path, phases, motor, along, shorter_than=float(solved.time[-1]))
        if phases.time[-1] < solved.time[-1]:
            return Leg(phases, converged)
    return Leg(solved, converged)


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
    return _seven_phases(ends, v, a, along.j_max)


def _seven_phases(ends: tuple[float, float], v: float, a: float, j: float) -> Cells:
    length = ends[1] - ends[0]
    jerk, ramp, travel = jerk_limited_times(length, v_max=v, a_max=a, j_max=j)
    whole = travel + ramp + jerk
    time = np.sort([0.0, jerk, ramp, ramp + jerk, travel, travel + jerk, travel + ramp])
    time = np.append(time[np.diff(time, append=whole) > _ROUNDING], whole)
    time[0] = 0.0
    way, rate, second = jerk_limited(time, jerk, ramp, travel)
    cells = Cells(time, ends[0] + length * way, length * rate, length * second)
    return _whole(cells, CONTROL_PERIOD)


class _Grid(NamedTuple):
    """Nodes of the solver, and the squared speeds there without limit of jerk."""

    nodes: Nodes
    most: Array
    free: Array


def _solved(
    path: Path, ends: tuple[float, float], edges: int, motor: Motor, along: Along
) -> tuple[Cells | None, bool]:
    """Return the fastest profile within all limits, and whether the solver has converged.

    The profile is None where the solver has failed altogether.
    """
    straight = edges == 0
    count = min(max(_PLACES_PER_EDGE * edges, _PLACES[0]), _PLACES[1])
    evenly = places_between(ends, count)
    places = _nodes(path, evenly) if straight else _turning_little(path, evenly)
    most = squared_speed_ceiling(motor, places, along)
    passes = both_passes(motor, places, along, most)

    def grid(every: float) -> _Grid:
        ways, free = spaced(places.way, passes, every, *_NODES)
        nodes = _nodes(path, ways)
        return _Grid(
            nodes, lowest(ways, squared_speed_ceiling(motor, nodes, along), places.way, most), free
        )

    fine = grid(_NODE_TIME)
    ways, free = fine.nodes.way, fine.free
    c = _START * np.interp(_middles(ways), ways, free)
    if len(ways) > _COARSE * _NODES[0]:
        coarse = grid(_COARSE * _NODE_TIME)
        there = coarse.nodes.way
        start = _START * np.interp(_middles(there), there, coarse.free)
        share = np.full(len(there), _SHARE)
        reach = reach_at(motor, coarse.nodes, along, coarse.free, straight)
        rough, state = solve(coarse.nodes, along, reach, coarse.most, share, start, straight)
        if state != FAILED:
            c = _AGAIN * np.interp(_middles(ways), _middles(there), rough)
            _, speed, _ = timed(there, rough)
            free = np.interp(ways, there, speed**2)
    share = np.full(len(ways), _SHARE)
    cells, state = None, FAILED
    for attempt in range(_SOLUTIONS):
        tied(ways, c)
        reach = reach_at(motor, fine.nodes, along, free, straight)
        c, state = _restarted(fine, along, reach, share, c, straight)
        if state == FAILED:
            break
        time, speed, gain = timed(ways, c)
        cells = _whole(Cells(time, ways, speed, gain), CONTROL_PERIOD)
        excess = _excess(path, cells, motor, along)
        if not tighten(cells.time, excess, share, 1.0, 1.0 - _TIGHTER * (1 + attempt)):
            return cells, state == DONE
        c, free = _AGAIN * c, speed**2
    if cells is None:
        return None, False
    longer = _stretched(path, cells, motor, along)
    return longer, state == DONE and longer.time[-1] < _CLOSE * cells.time[-1]


def _restarted(  # noqa: PLR0913, PLR0917 - what the solver takes
    grid: _Grid, along: Along, reach: Array, share: Array, start: Array, straight: bool
) -> tuple[Array, int]:
    """Return the result of `solve`, started again from what it has reached until it is done."""
    best, reached = start, FAILED
    for _ in range(_STARTS):
        c, state = solve(grid.nodes, along, reach, grid.most, share, start, straight)
        if state == FAILED:
            start = 0.25 * start
            continue
        best, reached = c, state
        if state == DONE:
            break
        start = _AGAIN * c
    return best, reached


def _turning_little(path: Path, ways: Array) -> Nodes:
    """Return places, more of them where the path turns much from one to the next, as at a cusp."""
    places = _nodes(path, ways)
    for _ in range(_SPLITS):
        # At its end the path has turned already where it has a corner there.
        between = np.sum(places.slope[1:-1] * places.slope[:-2], axis=1)
        turning = np.flatnonzero(between < math.cos(_TURN))
        if not len(turning) or len(places.way) + len(turning) > _PLACES[1]:
            break
        middles = _middles(places.way)[turning]
        places = _nodes(path, np.insert(places.way, turning + 1, middles))
    return places


def _middles(ways: Array) -> Array:
    return 0.5 * (ways[1:] + ways[:-1])


def _excess(path: Path, cells: Cells, motor: Motor, along: Along) -> Array:
    """Return `shares` of every tick."""
    way, rate, second = on_cells(cells, np.arange(round(cells.time[-1]), dtype=np.float64))
    speed, gain = rate / CONTROL_PERIOD, second / CONTROL_PERIOD**2
    return shares(motor, along, _nodes(path, way), speed, gain)


def _stretched(
    path: Path,
    cells: Cells,
    motor: Motor,
    along: Along,
    *,
    shorter_than: float = math.inf,
) -> Cells:
    """Stretch a profile in time, no further than needed, until no tick is beyond a limit.

    It is left beyond a limit once it takes `shorter_than` ticks, or where being slower is no help.
    """
    longest = min(shorter_than, _LONGEST_STRETCH * cells.time[-1], _LONGEST_STRETCHED)
    for _ in range(_STRETCHES):
        if cells.time[-1] >= longest:
            break
        worst = float(_excess(path, cells, motor, along).max())
        if worst <= 1.0 + _ROUNDING:
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
    count = len(values)
    return np.interp(np.arange(size) * count / size, np.arange(count), values, period=count)
