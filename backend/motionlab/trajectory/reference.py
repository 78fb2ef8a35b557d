"""The reference that the controllers follow, sampled once per control period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, FieldError
from motionlab.trajectory.motion import Piece
from motionlab.trajectory.path import Array, Vector
from motionlab.trajectory.plan import plan

AXES = ("x", "y")
LONGEST = 3600.0
"""Longest reference, s; its arrays take 350 MB."""

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
        first of polygon and star, otherwise everything.
    holds : tuple of intervals
        Where the reference stands still after a commanded move.
    edges : tuple of intervals
        The moves themselves, in order; a true step has none.
    period : int
        Ticks of one lap, 0 if the motion does not repeat. Laps of circle, polygon and star repeat
        sample for sample; a sine keeps its exact frequency and does so only if its period is whole.
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
        Read-only samples and what metrics need to know about them.

    Raises
    ------
    ConfigError
        If the motion lasts longer than an hour.
    """
    motion = plan(config)
    total = sum(piece.ticks for piece in motion.pieces)
    _refuse_too_long(total)
    position, velocity, acceleration = (np.empty((total, 2)) for _ in range(3))
    start = 0
    for piece in motion.pieces:
        here = slice(start, start + piece.ticks)
        position[here], velocity[here], acceleration[here] = piece.at(
            np.arange(piece.ticks, dtype=np.float64)
        )
        start += piece.ticks
    for samples in (position, velocity, acceleration):
        samples.setflags(write=False)

    last = motion.pieces[-1]
    end = last.place_at(last.ticks)
    travel = np.ptp(np.vstack((position, end)), axis=0)
    measured = motion.period * motion.measured_laps
    return Reference(
        position=position,
        velocity=velocity,
        acceleration=acceleration,
        end=(float(end[0]), float(end[1])),
        moving=tuple(axis for axis, way in zip(AXES, travel, strict=True) if way > _SAME_PLACE),
        window=(max(total - measured, 0) if measured else 0, total),
        holds=_holds(motion.pieces),
        edges=_edges(motion.pieces),
        period=motion.period,
    )


def _holds(pieces: list[Piece]) -> tuple[Interval, ...]:
    """Find where the reference stands after a move, joining neighbours at the same place."""
    holds: list[Interval] = []
    start, stands_at = 0, None
    for piece in pieces:
        stop = start + piece.ticks
        place = piece.place_at(0) if piece.still else None
        if place is not None:
            waits_on = stands_at is not None and np.allclose(
                place, stands_at, rtol=0, atol=_SAME_PLACE
            )
            if not waits_on and start > 0:
                holds.append((start, stop))
            elif holds and holds[-1][1] == start:
                holds[-1] = (holds[-1][0], stop)
        start, stands_at = stop, place
    return tuple(holds)


def _edges(pieces: list[Piece]) -> tuple[Interval, ...]:
    """Find the moves."""
    edges: list[Interval] = []
    start = 0
    for piece in pieces:
        if not piece.still:
            edges.append((start, start + piece.ticks))
        start += piece.ticks
    return tuple(edges)


def _refuse_too_long(ticks: int) -> None:
    seconds = ticks * CONTROL_PERIOD
    if seconds > LONGEST:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="lasts too long",
                value=seconds,
                range=f"0 < duration <= {LONGEST:g}",
                unit="s",
            )
        )
