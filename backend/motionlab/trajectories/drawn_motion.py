"""Pieces of motion from a drawn path and its motion profile."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.errors import ConfigError, FieldError
from motionlab.lanes import cached
from motionlab.timing import to_ticks
from motionlab.trajectories.motion import Piece, hold, refuse_too_long, whole_ticks
from motionlab.trajectories.motion_profile import (
    Law,
    cruise_ticks,
    jerk_limited_at,
    jerk_limited_ticks,
    minimum_jerk_at,
    minimum_jerk_ticks,
    smooth_start,
    trapezoidal_at,
    trapezoidal_ticks,
)
from motionlab.trajectories.path import Array
from motionlab.trajectories.spline import ArcLengthCurve, locate, polyline, spline
from motionlab.trajectories.time_optimal import motor_of, plan_leg
from motionlab.trajectories.time_optimal_check import Cells, at_rest, joined, on_cells
from motionlab.trajectories.time_optimal_limits import Along

Interval = tuple[int, int]

TIME_OPTIMAL_POINTS_MAX = 2000
"""Most points of a time-optimal path: planning it takes seconds."""
TIME_OPTIMAL_CORNERS_MAX = 200
"""Most corners of a time-optimal spline."""

STOPPING = ("minimum_jerk", "trapezoid", "jerk_limited")
_MINIMUM_JERK, _TRAPEZOID, _ = range(len(STOPPING))


@dataclass(frozen=True)
class _Timing:
    """How one leg from rest to rest is timed: numbers of its law, and their sum in ticks."""

    numbers: tuple[int, ...]
    ticks: int


def curve_of(config: DrawnPath) -> ArcLengthCurve:
    """Return the geometry of a drawn path."""
    if config.geometry == "polyline":
        return polyline(config.points, closed=config.closed)
    return spline(config.points, closed=config.closed, corners=config.corners)


def stop_and_go(config: DrawnPath) -> tuple[list[Piece], int]:
    """Return the pieces of a path that rests at its stops, and the ticks of one lap.

    Parameters
    ----------
    config : DrawnPath
        With any law but `constant_speed`.
    """
    curve = curve_of(config)
    if config.law == "time_optimal":
        return _laps(config, _time_optimal(config, curve))
    stops = curve.marks[_stops(config, curve)]
    ways = np.diff(stops)
    shares = np.sqrt(ways) / np.sqrt(ways).sum()
    timings = _TIMINGS[config.law]
    dwell = whole_ticks(config.dwell)
    legs: list[tuple[float, float, _Timing, bool]] = []
    for start, way, share in zip(stops, ways, shares, strict=False):
        timing = timings(config, float(way), float(share))
        legs.append((start, way, timing, False))
        if dwell:
            legs.append((start + way, 0.0, _Timing(_AT_REST[config.law], dwell), True))
    law = _run_through(legs, config.law)
    stretches = tuple((timing.ticks, still) for _, _, timing, still in legs)
    ticks = sum(ticks for ticks, _ in stretches)
    return _laps(config, Piece(curve.path, law, ticks, stretches=stretches))


def _laps(config: DrawnPath, lap: Piece) -> tuple[list[Piece], int]:
    return [*hold(config.points[0], config.dwell), *[lap] * config.laps], lap.ticks


def _stops(config: DrawnPath, curve: ArcLengthCurve) -> list[int]:
    """Return the numbers of the marks at which a path stops."""
    last = len(curve.marks) - 1
    if config.geometry == "polyline":
        return list(range(last + 1))
    return sorted({0, *config.corners, last})


def _time_optimal(config: DrawnPath, curve: ArcLengthCurve) -> Piece:
    """Return one lap as fast as the limits allow.

    Raises
    ------
    ConfigError
        If no motor's limits have been filled in, there are too many points or corners to plan, or
        the motion lasts longer than an hour.
    """
    if config.planned_for is None:
        message = "law = 'time_optimal' needs planned_for; a scenario that is prepared has it"
        raise ConfigError(FieldError("trajectory.planned_for", message))
    assert config.v_max is not None and config.a_max is not None  # the model has made sure
    assert config.j_max is not None
    stops = _stops(config, curve)
    _refuse_too_many("trajectory.points", len(config.points), TIME_OPTIMAL_POINTS_MAX)
    if config.geometry == "spline":
        _refuse_too_many("trajectory.corners", len(config.corners), TIME_OPTIMAL_CORNERS_MAX)
    motor, along = motor_of(config.planned_for), Along(config.v_max, config.a_max, config.j_max)
    dwell = whole_ticks(config.dwell)
    legs: list[Cells] = []
    stretches: list[tuple[int, bool]] = []
    slower: list[tuple[float, float]] = []
    ticks = 0
    for first, last in itertools.pairwise(stops):
        ends = float(curve.marks[first]), float(curve.marks[last])
        # A spline of one edge is a straight line.
        edges = 0 if config.geometry == "polyline" or last == first + 1 else last - first
        leg, converged = plan_leg(curve.path, ends, edges, motor, along)
        slower += [] if converged else [ends]
        legs.append(leg)
        stretches.append((round(leg.time[-1]), False))
        if dwell:
            legs.append(at_rest(ends[1], dwell))
            stretches.append((dwell, True))
        ticks += sum(each for each, _ in stretches[-2 if dwell else -1 :])
        refuse_too_long(ticks)
    cells = joined(legs)
    ticks = round(cells.time[-1])
    piece = Piece(curve.path, partial(on_cells, cells), ticks, stretches=tuple(stretches))
    return replace(piece, notes=_not_optimal(slower))


def _refuse_too_many(loc: str, count: int, most: int) -> None:
    if count > most:
        message = "too many for law = 'time_optimal', which plans each stretch by itself"
        raise ConfigError(FieldError(loc, message, count, bounds={"maximum": most}))


def _not_optimal(slower: list[tuple[float, float]]) -> tuple[str, ...]:
    """Return the note on stretches, of a start and an end each, for which no optimum is known."""
    if not slower:
        return ()
    start, end = slower[0]
    more = f" and {len(slower) - 1} more stretches" if slower[1:] else ""
    return (
        f"time_optimal: the solver has not converged from {start:.6g} to {end:.6g} m along the "
        f"path{more}; the motion keeps all limits there, but a faster one may exist. Other limits, "
        "or more points in narrow bends, may help",
    )


def at_constant_speed(config: DrawnPath) -> tuple[list[Piece], Interval | None]:
    """Return the pieces of a path run at constant speed, and the ticks of its whole laps at speed.

    Start and stop lie on the path, so a run of n laps has n - 1 or fewer at full speed.

    Parameters
    ----------
    config : DrawnPath
        With the law `constant_speed`.
    """
    curve = curve_of(config)
    whole = curve.length * config.laps
    if config.lap_time is not None:
        lap = whole_ticks(config.lap_time)
        ramp = max(1, lap // 2)
    else:
        assert config.v_max is not None and config.a_max is not None  # the model has made sure
        ramp, travel = cruise_ticks(whole, v_max=config.v_max, a_max=config.a_max)
        lap = math.ceil(travel / config.laps)
    rate = curve.length / lap
    rest = hold(config.points[0], config.dwell)
    before = sum(piece.ticks for piece in rest) + ramp
    laps, remainder = divmod(lap * config.laps - ramp, lap)

    def speeding_up(u: Array) -> Law:
        clock, speed, gain = smooth_start(u, ramp)
        return rate * clock, rate * speed, rate * gain

    def cruising(u: Array) -> Law:
        return rate * (u + ramp / 2), np.full(u.shape, rate), np.zeros(u.shape)

    def slowing_down(u: Array) -> Law:
        clock, speed, gain = smooth_start(ramp - u, ramp)
        return whole - rate * clock, rate * speed, -rate * gain

    at_speed = [Piece(curve.path, cruising, lap)] * laps
    at_speed += [Piece(curve.path, cruising, remainder)] if remainder else []
    there = config.points[0] if config.closed else config.points[-1]
    pieces = [
        *rest,
        Piece(curve.path, speeding_up, ramp),
        *at_speed,
        Piece(curve.path, slowing_down, ramp),
        *hold(there, config.dwell),
    ]
    measured = config.closed and laps > 0
    return pieces, (before, before + laps * lap) if measured else None


def _run_through(
    legs: list[tuple[float, float, _Timing, bool]], law: str
) -> Callable[[Array], Law]:
    """Return the law that takes one leg after another; a leg of no length is a rest."""
    origins, ways = (np.array([leg[k] for leg in legs]) for k in (0, 1))
    begins = np.concatenate(([0.0], np.cumsum([timing.ticks for _, _, timing, _ in legs])))
    numbers = np.array([timing.numbers for _, _, timing, _ in legs], dtype=np.float64)
    return partial(_on_legs, STOPPING.index(law), begins, origins, ways, numbers)


@cached
def _on_legs(  # noqa: PLR0913, PLR0917 - the tables of the legs
    law: int, begins: Array, origins: Array, ways: Array, numbers: Array, u: Array
) -> Law:
    """Return the arc length and its derivatives; `law` numbers one of `STOPPING`."""
    leg = locate(begins, u)
    way, rate, second = np.empty(len(u)), np.empty(len(u)), np.empty(len(u))
    for k in range(len(u)):
        i = leg[k]
        t, n = u[k] - begins[i], numbers[i]
        if law == _MINIMUM_JERK:
            share = minimum_jerk_at(t, n[0])
        elif law == _TRAPEZOID:
            share = trapezoidal_at(t, n[0], n[1])
        else:
            share = jerk_limited_at(t, n[0], n[1], n[2])
        way[k] = origins[i] + ways[i] * share[0]
        rate[k], second[k] = ways[i] * share[1], ways[i] * share[2]
    return way, rate, second


def _minimum_jerk(config: DrawnPath, way: float, share: float) -> _Timing:
    if config.lap_time is not None:
        ticks = _share_of(config.lap_time, share, least=2)  # one would sample its start alone
    else:
        assert config.v_max is not None and config.a_max is not None  # the model has made sure
        ticks = minimum_jerk_ticks(way, v_max=config.v_max, a_max=config.a_max)
    return _Timing((ticks,), ticks)


def _trapezoid(config: DrawnPath, way: float, share: float) -> _Timing:
    if config.lap_time is not None:
        ticks = _share_of(config.lap_time, share, least=2)
        ramp = max(1, round(ticks / 3))
        cruise = ticks - 2 * ramp
    else:
        assert config.v_max is not None and config.a_max is not None  # the model has made sure
        ramp, cruise = trapezoidal_ticks(way, v_max=config.v_max, a_max=config.a_max)
    return _Timing((ramp, cruise), 2 * ramp + cruise)


def _jerk_limited(config: DrawnPath, way: float, share: float) -> _Timing:
    if config.lap_time is not None:
        ticks = _share_of(config.lap_time, share, least=4)
        jerk = ramp = max(1, round(ticks / 6))
        travel = ticks - jerk - ramp
    else:
        assert config.v_max is not None and config.a_max is not None  # the model has made sure
        assert config.j_max is not None
        jerk, ramp, travel = jerk_limited_ticks(
            way, v_max=config.v_max, a_max=config.a_max, j_max=config.j_max
        )
    return _Timing((jerk, ramp, travel), jerk + ramp + travel)


def _share_of(lap_time: float, share: float, *, least: int) -> int:
    return max(least, to_ticks(lap_time * share))


_TIMINGS: dict[str, Callable[[DrawnPath, float, float], _Timing]] = {
    "minimum_jerk": _minimum_jerk,
    "trapezoid": _trapezoid,
    "jerk_limited": _jerk_limited,
}
_AT_REST = {"minimum_jerk": (1,), "trapezoid": (1, 0), "jerk_limited": (1, 1, 2)}
"""Numbers that a law can take for a leg of no length; what it returns is multiplied by zero."""
