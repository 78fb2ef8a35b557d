"""The laps of a motion, and a force learnt of one over those of another."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from motionlab.config.learnt_force import PLACES, TICKS_MAX, TICKS_MIN, LearntForce
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.reference import Reference

Array = NDArray[np.float64]

SAME_PLACE = 1e-6
"""Positions that far apart, m, are those of one path; where it moves, a control period's way more:
laps begin at whole ticks."""
_NANOMETRES = 9
"""Digits of a position, m."""
_SAME = 1e-9
"""Ticks that far apart, m, are of one lap; a lap that repeats does so to rounding."""


class Lap(NamedTuple):
    """The laps of a motion: alike from tick `first` on, `ticks` each."""

    first: int
    ticks: int


def lap_of(reference: Reference) -> Lap:
    """Return the laps of a motion; one of 0 ticks where it has none.

    A motion that does not repeat, but ends at rest where it began, is one lap.
    """
    position, velocity, n = reference.position, reference.velocity, reference.period
    if n == 0:
        closed = np.abs(position[0] - np.array(reference.end)).max() < _SAME
        still = not velocity[0].any() and not velocity[-1].any()
        return Lap(0, reference.ticks if closed and still else 0)
    if np.abs(position[-n] - np.array(reference.end)).max() >= _SAME:
        return Lap(0, 0)
    other = np.flatnonzero(np.abs(position[:-n] - position[n:]).max(axis=1) >= _SAME)
    alike = int(other[-1]) + 1 if other.size else 0
    return Lap(reference.ticks - n * ((reference.ticks - alike) // n), n)


def checked_lap(reference: Reference) -> Lap:
    """Return the laps of a motion that can be learnt.

    Raises
    ------
    ConfigError
        If it has none, or none of a length that can be learnt.
    """
    lap = lap_of(reference)
    if lap.ticks == 0:
        raise ConfigError(
            FieldError("trajectory", "has no laps: it does not end where it begins, at rest")
        )
    if not TICKS_MIN <= lap.ticks <= TICKS_MAX:
        seconds = lap.ticks * CONTROL_PERIOD
        bounds = f"{TICKS_MIN * CONTROL_PERIOD:g} to {TICKS_MAX * CONTROL_PERIOD:g}"
        message = "has a lap of a length that cannot be learnt"
        raise ConfigError(FieldError("trajectory", message, seconds, bounds, "s"))
    return lap


def places(reference: Reference, lap: Lap) -> tuple[tuple[float, float], ...]:
    """Return the positions of a lap by which it is known again, m."""
    phases = lap.first + np.arange(PLACES) * lap.ticks / PLACES
    ticks = np.arange(reference.ticks)
    x, y = (
        (np.interp(phases, ticks, reference.position[:, axis]).round(_NANOMETRES) + 0.0).tolist()
        for axis in range(len(AXES))
    )
    return tuple(zip(x, y, strict=True))


def check_learnt(force: LearntForce, reference: Reference, pitch: tuple[float, ...]) -> str:
    """Refuse a force that was learnt of another motion; return what a user must know of it.

    A lap of another length is the same motion where its positions are, phase by phase; so is one
    that is moved by whole pole pitches, `pitch`, m.

    Raises
    ------
    ConfigError
        With the largest distance.
    """
    lap = checked_lap(reference)
    away = np.array(places(reference, lap)) - np.array(force.places)
    shift = away.mean(axis=0)
    whole = np.round(shift / pitch) * pitch
    distance = np.abs(away - whole).max(axis=1)
    worst = int(distance.argmax())
    allowed = SAME_PLACE + CONTROL_PERIOD * float(np.abs(reference.velocity).max())
    if distance[worst] > allowed:
        raise ConfigError(
            FieldError(
                "learnt",
                f"was learnt of another motion, which is elsewhere at {100 * worst / PLACES:.0f} % "
                "of the lap: learn this one, or remove it",
                float(distance[worst]),
                f"<= {allowed:.3g}",
                "m",
            )
        )
    if (known := len(force.force)) == lap.ticks:
        return ""
    before, now = known * CONTROL_PERIOD, lap.ticks * CONTROL_PERIOD
    return (
        f"the learnt force is of a lap of {before:.4g} s, stretched over one of {now:.4g} s: "
        "a few laps more fit it"
    )


def over_lap(force: LearntForce, lap: Lap) -> Array:
    """Return what was learnt for each tick of a lap, N, (ticks, 2): stretched if it is longer.

    Of a motion without laps it is 0.
    """
    if lap.ticks == 0:
        return np.zeros((1, len(AXES)))
    return _stretched(force, lap.ticks)


def _over_ticks(force: LearntForce, ticks: int) -> Array:
    known = force.force
    phase = np.arange(ticks) * (len(known) / ticks)
    around = np.concatenate([known, known[:1]]).astype(np.float64)
    columns = [np.interp(phase, np.arange(len(around)), column) for column in around.T]
    return np.stack(columns, axis=1)


_stretched = cast("Callable[..., Array]", functools.lru_cache(maxsize=4)(_over_ticks))
