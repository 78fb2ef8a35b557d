"""A motion as pieces: paths with motion profiles in whole control periods."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from motionlab.errors import ConfigError, FieldError
from motionlab.timing import CONTROL_PERIOD, to_ticks
from motionlab.trajectories.motion_profile import (
    Law,
    minimum_jerk,
    minimum_jerk_ticks,
    smooth_start,
    trapezoidal,
    trapezoidal_ticks,
)
from motionlab.trajectories.path import Array, Path, Vector, line, ray

LONGEST = 3600.0
"""Longest motion, s; the arrays of its reference take 350 MB."""

EdgeRule = Callable[[Vector, Vector], "Piece"]
"""Edge rule: the motion from one point to the next."""


@dataclass(frozen=True)
class Piece:
    """One stretch of a motion, `ticks` control periods long.

    Attributes
    ----------
    path : Path
        Path parameter to position and its derivatives.
    law : callable
        Ticks since the piece began to the path parameter and its derivatives per tick.
    ticks : int
        Duration, >= 1.
    still : bool
        Whether the reference stands.
    stretches : tuple of (int, bool)
        Ticks of each stretch and whether the reference stands in it, for a piece that stops and
        goes on; the piece as a whole when left out.
    notes : tuple of str
        What a user must know of it.
    """

    path: Path
    law: Callable[[Array], Law]
    ticks: int
    still: bool = False
    stretches: tuple[tuple[int, bool], ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def parts(self) -> tuple[tuple[int, bool], ...]:
        """Ticks of each stretch between stops, and whether the reference is at rest in it."""
        return self.stretches or ((self.ticks, self.still),)

    def at(self, ticks: Array) -> tuple[Array, Array, Array]:
        """Return position, velocity and acceleration, each (n, 2), by the chain rule."""
        q, rate, second = self.law(ticks)
        place, slope, bend = self.path(q)
        velocity, acceleration = _chain_rule(slope, bend, rate[:, None], second[:, None])
        return place, velocity, acceleration

    def place_at(self, tick: int) -> Array:
        """Return the position (2,) at one tick of the piece."""
        return self.at(np.array([float(tick)]))[0][0]


def _chain_rule(slope: Array, bend: Array, rate: Array, second: Array) -> tuple[Array, Array]:
    # Not compiled: it is part of every motion, and a fresh machine's first curves wait for one.
    r = rate / CONTROL_PERIOD
    s = second / CONTROL_PERIOD**2
    return slope * r, bend * r**2 + slope * s


def whole_ticks(seconds: float) -> int:
    """Round a duration to whole control periods, at least one unless it is zero."""
    return max(1, to_ticks(seconds)) if seconds > 0 else 0


def hold(position: Vector, seconds: float) -> list[Piece]:
    """Rest at `position`; no piece for a time of zero."""
    ticks = whole_ticks(seconds)
    if ticks == 0:
        return []
    return [Piece(ray(position, (0.0, 0.0)), partial(smooth_start, lead_in=0), ticks, still=True)]


def run(path: Path, *, rate: float, lead_in: int, ticks: int) -> Piece:
    """Run along a path whose parameter grows by `rate` per tick once the lead-in has passed."""

    def law(u: Array) -> Law:
        clock, speed, gain = smooth_start(u, lead_in)
        return rate * clock, rate * speed, rate * gain

    return Piece(path, law, ticks)


def ease_out(piece: Piece, *, rate: float, ticks: int) -> Piece:
    """Come to rest after a piece whose parameter grows by `rate` per tick at its end."""
    (begin,), _, _ = piece.law(np.array([float(piece.ticks)]))
    whole, _, _ = smooth_start(np.array([float(ticks)]), ticks)

    def law(u: Array) -> Law:
        clock, speed, gain = smooth_start(ticks - u, ticks)
        return begin + rate * (whole - clock), rate * speed, -rate * gain

    return Piece(piece.path, law, ticks)


def minimum_jerk_edge(start: Vector, end: Vector, *, ticks: int) -> Piece:
    """Go from rest to rest in a given number of ticks."""
    return Piece(line(start, end), partial(minimum_jerk, duration=ticks), ticks)


def fast_minimum_jerk_edge(start: Vector, end: Vector, *, v_max: float, a_max: float) -> Piece:
    """Go from rest to rest with minimum jerk as fast as both limits allow."""
    ticks = minimum_jerk_ticks(math.dist(start, end), v_max=v_max, a_max=a_max)
    return minimum_jerk_edge(start, end, ticks=ticks)


def trapezoidal_edge(start: Vector, end: Vector, *, v_max: float, a_max: float) -> Piece:
    """Go from rest to rest with trapezoidal velocity as fast as both limits allow."""
    ramp, cruise = trapezoidal_ticks(math.dist(start, end), v_max=v_max, a_max=a_max)
    law = partial(trapezoidal, ramp=ramp, cruise=cruise)
    return Piece(line(start, end), law, 2 * ramp + cruise)


def point_to_point(points: Sequence[Vector], *, dwell: float, edge: EdgeRule | None) -> list[Piece]:
    """Stand at each point in turn, joined by edges, or by jumps when there is no edge rule."""
    pieces = hold(points[0], dwell)
    for start, end in itertools.pairwise(points):
        if edge is not None:
            pieces.append(edge(start, end))
        pieces += hold(end, dwell)
    return pieces


def chain(parts: Iterable[Sequence[Piece]]) -> list[Piece]:
    """Put motions end to end, each moved so that it starts where the one before ended."""
    chained: list[Piece] = []
    for pieces in parts:
        if chained:
            end = chained[-1].place_at(chained[-1].ticks)
            offset = end - pieces[0].place_at(0)
            pieces = [  # noqa: PLW2901 - the part, in its new place
                replace(piece, path=_moved(piece.path, offset)) for piece in pieces
            ]
        chained += pieces
    return chained


def _moved(path: Path, offset: Array) -> Path:
    def at(q: Array) -> tuple[Array, Array, Array]:
        place, slope, bend = path(q)
        return place + offset, slope, bend

    return at


def refuse_too_long(ticks: int) -> None:
    """Refuse a motion of more than an hour.

    Raises
    ------
    ConfigError
        With its duration.
    """
    seconds = ticks * CONTROL_PERIOD
    if seconds > LONGEST:
        raise ConfigError(
            FieldError(
                loc="trajectory",
                message="lasts too long",
                value=seconds,
                bounds={"exclusive_minimum": 0.0, "maximum": LONGEST},
                unit="s",
            )
        )
