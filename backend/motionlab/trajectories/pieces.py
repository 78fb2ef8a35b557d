"""Pieces of a motion from its config."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import assert_never

import numpy as np

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.moves import (
    Dwell,
    Line,
    Parabola,
    PointTarget,
    RampMove,
    Staircase,
    Step,
    Trapezoid,
    Waypoints,
)
from motionlab.config.multisine import Multisine
from motionlab.config.planar import (
    PlanarAcceleration,
    PlanarAngle,
    PlanarLength,
    PlanarVelocity,
)
from motionlab.config.samples import Samples
from motionlab.config.shapes import Circle, Polygon, Sine, Star
from motionlab.config.trajectory import Sequence, TrajectoryConfig
from motionlab.errors import ConfigError, FieldError
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories import path
from motionlab.trajectories.corners import corners
from motionlab.trajectories.drawn_motion import at_constant_speed, stop_and_go
from motionlab.trajectories.motion import (
    EdgeRule,
    Piece,
    chain,
    ease_out,
    fast_minimum_jerk_edge,
    hold,
    minimum_jerk_edge,
    point_to_point,
    refuse_too_long,
    run,
    trapezoidal_edge,
    whole_ticks,
)
from motionlab.trajectories.multisine import multisine_motion
from motionlab.trajectories.path import Vector
from motionlab.trajectories.sampled_motion import sampled_motion

_MOVES_MAX = 1_000_000
_SAME_PLACE = 1e-12  # m


@dataclass(frozen=True)
class MotionPlan:
    """Pieces of a motion, the ticks of one lap, and how many laps at its end metrics use.

    Attributes
    ----------
    pieces : list of Piece
        At least one, in order of time.
    period : int
        Ticks of one lap, 0 if the motion does not repeat.
    measured_laps : int
        Laps at the end that metrics use, 0 for the whole motion.
    window : tuple of int, optional
        Ticks that metrics use where they are not the last ones.
    """

    pieces: list[Piece]
    period: int = 0
    measured_laps: int = 0
    window: tuple[int, int] | None = None


def plan_motion(config: TrajectoryConfig) -> MotionPlan:  # noqa: PLR0911, PLR0912 - one for each kind
    """Turn any kind of motion into pieces.

    Parameters
    ----------
    config : TrajectoryConfig
        The motion.
    """
    match config:
        case PointTarget():
            return MotionPlan(hold(_xy(config.position), config.duration))
        case Dwell():
            return MotionPlan(hold((0.0, 0.0), config.duration))
        case Step():
            start, height = _xy(config.start), _xy(config.height)
            top = (start[0] + height[0], start[1] + height[1])
            return MotionPlan([*hold(start, config.delay), *hold(top, config.dwell)])
        case RampMove():
            ray = path.ray(_xy(config.start), _xy(config.velocity))
            return MotionPlan([_timed(ray, config.duration, lead_in=config.lead_in)])
        case Parabola():
            curve = path.parabola(_xy(config.start), _xy(config.coefficient))
            return MotionPlan([_timed(curve, config.duration, lead_in=0.0)])
        case Sine():
            return _sine(config)
        case Circle():
            return _circle(config)
        case Line():
            return MotionPlan(
                point_to_point(corners(config), dwell=config.dwell, edge=_edge_rule(config))
            )
        case Waypoints():
            edge = _edge_rule(config)
            once = point_to_point(corners(config), dwell=config.dwell, edge=edge)
            return _repeated(once, laps=config.laps, dwell=config.dwell)
        case Trapezoid():
            edge = partial(trapezoidal_edge, v_max=config.v_max, a_max=config.a_max)
            return MotionPlan(point_to_point(corners(config), dwell=config.dwell, edge=edge))
        case Staircase():
            return _staircase(config)
        case Polygon() | Star():
            return _closed(config)
        case DrawnPath():
            return _drawn(config)
        case Samples():
            return MotionPlan([sampled_motion(config)])
        case Multisine():
            return MotionPlan([multisine_motion(config)])
        case Sequence():
            once = chain(plan_motion(part).pieces for part in config.parts)
            return _repeated(once, laps=config.laps)
        case _:
            assert_never(config)


def _sine(config: Sine) -> MotionPlan:
    lead_in = _lead_in_ticks(config.lead_in, frequency=config.frequency)
    wave = path.sinusoid(_xy(config.center), _xy(config.amplitude), _xy(config.phase))
    cycles = whole_ticks(config.cycles / config.frequency)
    rate = 2 * math.pi * config.frequency * CONTROL_PERIOD
    turning = run(wave, rate=rate, lead_in=lead_in, ticks=lead_in + cycles)
    lap, laps = whole_ticks(1 / config.frequency), config.cycles
    if config.for_ever:
        return MotionPlan([turning], period=lap, measured_laps=_last_two(laps))
    return _ending(turning, rate=rate, lead_in=lead_in, lap=lap, laps=laps)


def _circle(config: Circle) -> MotionPlan:
    period = whole_ticks(1 / config.frequency)
    lead_in = _lead_in_ticks(config.lead_in, frequency=config.frequency)
    ring = path.circle(_xy(config.center), config.radius, config.start_angle)
    rate = (2 * math.pi if config.direction == "ccw" else -2 * math.pi) / period
    turning = run(ring, rate=rate, lead_in=lead_in, ticks=lead_in + config.laps * period)
    if config.for_ever:
        return MotionPlan([turning], period=period, measured_laps=_last_two(config.laps))
    return _ending(turning, rate=rate, lead_in=lead_in, lap=period, laps=config.laps)


def _staircase(config: Staircase) -> MotionPlan:
    edge = None
    if config.v_max is not None and config.a_max is not None:
        edge = partial(trapezoidal_edge, v_max=config.v_max, a_max=config.a_max)
    once = point_to_point(corners(config), dwell=config.dwell, edge=edge)
    return _repeated(once, laps=config.laps, dwell=config.dwell)


def _ending(turning: Piece, *, rate: float, lead_in: int, lap: int, laps: int) -> MotionPlan:
    """Return laps between a lead-in and, of the same length, the way back to rest."""
    measured = min(_last_two(laps) * lap, turning.ticks)
    last = turning.ticks
    pieces = [turning, ease_out(turning, rate=rate, ticks=lead_in)] if lead_in else [turning]
    return MotionPlan(pieces, period=lap, window=(last - measured, last))


def _closed(config: Polygon | Star) -> MotionPlan:
    vertices = corners(config)
    ticks = whole_ticks(1 / (config.frequency * len(vertices)))
    ends = (*vertices[1:], vertices[0])
    lap: list[Piece] = []
    for start, end in zip(vertices, ends, strict=True):
        lap += [minimum_jerk_edge(start, end, ticks=ticks), *hold(end, config.dwell)]
    period = sum(piece.ticks for piece in lap)
    pieces = [*hold(vertices[0], config.dwell), *lap * config.laps]
    return MotionPlan(pieces, period=period, measured_laps=max(1, config.laps - 1))


def _repeated(once: list[Piece], *, laps: int, dwell: float = 0.0) -> MotionPlan:
    """Repeat a motion that ends where it starts; it stands once only between two laps."""
    if laps == 1:
        return MotionPlan(once)
    before = 1 if dwell else 0
    lap = once[before:]
    ticks = sum(piece.ticks for piece in lap)
    gap = float(np.abs(once[-1].place_at(once[-1].ticks) - once[0].place_at(0)).max())
    if gap > _SAME_PLACE:
        message = "more than one lap needs an end where the motion starts; it ends elsewhere"
        raise ConfigError(FieldError("trajectory.laps", message, laps))
    refuse_too_long(ticks * laps)
    if len(lap) * laps > _MOVES_MAX:
        message = f"has more than {_MOVES_MAX} moves and stops over all laps"
        raise ConfigError(FieldError("trajectory.laps", message, laps))
    pieces = [*once[:before], *lap * laps]
    return MotionPlan(pieces, period=ticks, measured_laps=laps - 1)


def _drawn(config: DrawnPath) -> MotionPlan:
    if config.law == "constant_speed":
        pieces, window = at_constant_speed(config)
        return MotionPlan(pieces, window=window)
    pieces, lap = stop_and_go(config)
    if not config.closed:
        return MotionPlan(pieces)
    return MotionPlan(pieces, period=lap, measured_laps=max(1, config.laps - 1))


def _edge_rule(config: Line | Waypoints) -> EdgeRule:
    if config.edge_time is not None:
        return partial(minimum_jerk_edge, ticks=whole_ticks(config.edge_time))
    assert config.v_max is not None and config.a_max is not None  # the model has made sure
    return partial(fast_minimum_jerk_edge, v_max=config.v_max, a_max=config.a_max)


def _timed(curve: path.Path, seconds: float, *, lead_in: float) -> Piece:
    """Run along a path whose parameter is time in seconds."""
    ticks = whole_ticks(seconds)
    return run(curve, rate=CONTROL_PERIOD, lead_in=whole_ticks(lead_in), ticks=ticks)


def _lead_in_ticks(seconds: float | None, *, frequency: float) -> int:
    return whole_ticks(0.5 / frequency if seconds is None else seconds)


def _last_two(laps: int) -> int:
    """Use the last two laps, but not the very first one unless it is the only one."""
    return max(1, min(2, laps - 1))


def _xy(pair: PlanarLength | PlanarVelocity | PlanarAcceleration | PlanarAngle) -> Vector:
    return pair.x, pair.y
