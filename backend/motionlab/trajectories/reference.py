"""The reference that the controllers follow, sampled once per control period."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motionlab.config.planar import AXES
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.trajectories.motion import Piece
from motionlab.trajectories.path import Array, Vector
from motionlab.trajectories.pieces import MotionPlan, plan_motion, refuse_too_long

_BLOCK = 4096
"""Ticks that are sampled at once: intermediate results stay in the processor's cache."""

_SAME_PLACE = 1e-12
"""Below a picometre two positions differ by rounding only, m."""

Interval = tuple[int, int]
"""Half-open interval of ticks [start, end)."""


@dataclass(frozen=True)
class Reference:
    """Sampled motion; sample k is valid at t = k T_s, for k = 0 .. ticks - 1.

    A motion of n control periods has n samples, so its last sample lies one period before its end.
    `end` is the position at tick n, where another motion may start. Nothing is promised
    beyond: a circle ends at full speed, a move with a final dwell at rest.

    Attributes
    ----------
    position, velocity, acceleration : ndarray of float64, shape (ticks, 2), read-only
        Reference and its analytic derivatives per axis, m, m/s, m/s^2. At a discontinuity the
        value is the one that holds from then on; a true step has neither velocity nor acceleration.
    end : tuple of float
        Position at tick n, m.
    moving : tuple of str
        Axes that move at all.
    window : tuple of int
        Ticks that metrics use by default: the last two periods of circle and sine, all laps but the
        first of polygon, star and closed path, the laps at speed of a path at constant speed,
        otherwise everything.
    holds : tuple of intervals
        Where the reference is at rest after a commanded move.
    edges : tuple of intervals
        The moves themselves, in order; a true step has none.
    period : int
        Ticks of one lap, 0 if the motion does not repeat. Laps of circle, polygon, star and path
        repeat sample for sample; a sine keeps its exact frequency and does so only if its period is
        whole.
    for_ever : bool
        Whether a live session repeats it for ever where it can.
    notes : tuple of str
        What a user must know of the motion.
    """

    position: Array
    velocity: Array
    acceleration: Array
    end: Vector
    moving: tuple[str, ...]
    window: Interval
    holds: tuple[Interval, ...]
    edges: tuple[Interval, ...]
    period: int
    for_ever: bool = True
    notes: tuple[str, ...] = ()

    @property
    def ticks(self) -> int:
        """Number of samples."""
        return len(self.position)


def sample(config: TrajectoryConfig) -> Reference:
    """Sample a motion at every control period.

    Parameters
    ----------
    config : TrajectoryConfig
        The motion.

    Returns
    -------
    Reference
        Read-only samples, with the intervals that metrics use.

    Raises
    ------
    ConfigError
        If the motion lasts longer than an hour.
    """
    motion = plan_motion(config)
    total = _ticks(motion)
    position, velocity, acceleration = _samples(motion.pieces, total)
    for samples in (position, velocity, acceleration):
        samples.setflags(write=False)

    last = motion.pieces[-1]
    end = last.place_at(last.ticks)
    travel = [
        float(max(p.max(), e) - min(p.min(), e)) for p, e in zip(position.T, end, strict=True)
    ]
    measured = motion.period * motion.measured_laps
    window = motion.window or (max(total - measured, 0) if measured else 0, total)
    return Reference(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        end=(float(end[0]), float(end[1])),
        moving=tuple(axis for axis, way in zip(AXES, travel, strict=True) if way > _SAME_PLACE),
        window=window,
        holds=_holds(motion.pieces, position),
        edges=_edges(motion.pieces),
        period=motion.period,
        for_ever=getattr(config, "for_ever", True),
        notes=tuple(dict.fromkeys(note for piece in motion.pieces for note in piece.notes)),
    )


def ticks_of(config: TrajectoryConfig) -> int:
    """Return the number of samples of a motion, without sampling it.

    Raises
    ------
    ConfigError
        If the motion lasts longer than an hour.
    """
    return _ticks(plan_motion(config))


def _ticks(motion: MotionPlan) -> int:
    ticks = sum(piece.ticks for piece in motion.pieces)
    refuse_too_long(ticks)
    return ticks


def _samples(pieces: list[Piece], total: int) -> tuple[Array, Array, Array]:
    """Return position, velocity and acceleration of all pieces, one after another."""
    position, velocity, acceleration = (np.empty((total, 2)) for _ in range(3))
    start = 0
    sampled: dict[int, slice] = {}
    for piece in pieces:
        here = slice(start, start + piece.ticks)
        there = sampled.setdefault(id(piece), here)
        if there is not here:  # a lap like the one before
            for samples in (position, velocity, acceleration):
                samples[here] = samples[there]
        else:
            for begin in range(0, piece.ticks, _BLOCK):
                ticks = np.arange(begin, min(begin + _BLOCK, piece.ticks), dtype=np.float64)
                block = slice(start + begin, start + begin + len(ticks))
                position[block], velocity[block], acceleration[block] = piece.at(ticks)
        start += piece.ticks
    return position, velocity, acceleration


def _holds(pieces: list[Piece], position: Array) -> tuple[Interval, ...]:
    """Find the standstills after moves, joining neighbours at the same position."""
    holds: list[Interval] = []
    stands_at = None
    for start, stop, still in _stretches(pieces):
        place = position[start] if still else None
        if place is not None:
            waits_on = (
                stands_at is not None and float(np.abs(place - stands_at).max()) <= _SAME_PLACE
            )
            if not waits_on and start > 0:
                holds.append((start, stop))
            elif holds and holds[-1][1] == start:
                holds[-1] = (holds[-1][0], stop)
        stands_at = place
    return tuple(holds)


def _edges(pieces: list[Piece]) -> tuple[Interval, ...]:
    """Find the moves."""
    return tuple((start, stop) for start, stop, still in _stretches(pieces) if not still)


def _stretches(pieces: list[Piece]) -> Iterator[tuple[int, int, bool]]:
    """Yield first tick, tick after the last, and whether the reference is at rest, in order."""
    start = 0
    for piece in pieces:
        for ticks, still in piece.parts:
            yield start, start + ticks, still
            start += ticks
