"""Quadrant glitches: what the following error of an axis does where its reference reverses.

Friction changes its sign where an axis reverses. The error then leaves what it was before, and
stays elsewhere (a loop without integral action) or comes back. Each reversal is measured by itself,
on the error averaged over 5 ms: one count of the encoder is no glitch, and has no duration.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

Array = NDArray[np.float64]

AVERAGED = 5e-3
"""Time over which the error is averaged, s."""

BEFORE = 20e-3
"""Time before a reversal over which the error is what it was, s; its mean is the base."""

SETTLED = 20e-3
"""Time within which a settled error stays in its band, s."""

SHARE = 0.1
"""Of the height: where the rise begins, how far the error comes back after its peak, and the band
in which it has settled."""

NOISE = 3.0
"""Standard deviations of the error before a reversal, below which its height is noise."""


@dataclass(frozen=True)
class Glitch:
    """One reversal of one axis.

    Attributes
    ----------
    tick : int
        First tick whose reference moves in the new direction.
    direction : int
        The new direction, 1 or -1.
    height : float
        From the base to the peak after it, signed, m; of an error that neither leaves its noise
        nor two counts the largest deviation until it has settled.
    delay, rise, duration : float or None
        s: from the reversal to a tenth of the height; from a tenth to nine tenths of it; from the
        reversal until the error has settled. None for a height that is noise, and where the
        record or the stroke ends before.
    """

    tick: int
    direction: int
    height: float
    delay: float | None
    rise: float | None
    duration: float | None


class Reversal(NamedTuple):
    """A tick, the direction from it on, and where that ends: the next one, or the record's end."""

    tick: int
    direction: int
    end: int


def reversals(velocity: Array) -> list[Reversal]:
    """Return the samples at which a reference reverses, also after a rest.

    Parameters
    ----------
    velocity : ndarray, shape (ticks,)
        Reference velocity of one axis, m/s.
    """
    moving = np.flatnonzero(velocity)
    signs = np.sign(velocity[moving]).astype(int)
    turns = np.flatnonzero(np.diff(signs)) + 1
    ends = [*moving[turns[1:]].tolist(), len(velocity)]
    return [
        Reversal(int(moving[turn]), int(signs[turn]), end)
        for turn, end in zip(turns, ends, strict=False)
    ]


def glitches(velocity: Array, error: Array, *, count: float, period: float) -> list[Glitch]:
    """Measure the following error at every reversal of one axis.

    With e averaged over `AVERAGED`, b its mean over `BEFORE` and d = e - b, the peak is the first
    extremum of either sign from which d comes back by the largest of a tenth of it, a count and the
    noise; the larger of both signs is the height.

    Parameters
    ----------
    velocity, error : ndarray, shape (ticks,)
        Reference velocity, m/s, and following error, m, of one axis; errors that are NaN were not
        measured.
    count : float
        Of the encoder, m; 0 for one without steps.
    period : float
        Of the samples, s.

    Returns
    -------
    list of Glitch
        In order of time, without reversals too near the start, or with an error that is not known.
    """
    before = max(1, round(BEFORE / period))
    peaks: list[Glitch] = []
    for turn in reversals(velocity):
        around = error[max(0, turn.tick - before) : turn.end]
        if turn.tick >= before and np.isfinite(around).all():
            mean = _averaged(around, max(1, round(AVERAGED / period)))
            peaks.append(_measured(mean, turn, before, count, period))
    return peaks


def _measured(mean: Array, turn: Reversal, before: int, count: float, period: float) -> Glitch:
    base = mean[:before]
    deviation = mean[before:] - base.mean()
    noise = max(count, NOISE * float(np.std(base)))
    peak = max(
        (_peak(sign * deviation, noise) for sign in (1, -1)), key=lambda p: abs(deviation[p])
    )
    height = float(deviation[peak])
    glitch = Glitch(turn.tick, turn.direction, height, None, None, None)
    if abs(height) <= max(2 * count, noise):
        return glitch
    rising = np.abs(deviation[: peak + 1])
    begun = int(np.argmax(rising >= SHARE * abs(height)))
    risen = int(np.argmax(rising >= (1 - SHARE) * abs(height)))
    settled = _settled(deviation[peak:], max(SHARE * abs(height), noise), round(SETTLED / period))
    return Glitch(
        turn.tick,
        turn.direction,
        height,
        delay=begun * period,
        rise=(risen - begun) * period,
        duration=None if settled is None else (peak + settled) * period,
    )


def _peak(deviation: Array, noise: float) -> int:
    """Return the first maximum from which a deviation comes back, or the largest of all."""
    highest = np.maximum.accumulate(deviation)
    back = highest - deviation > np.maximum(SHARE * highest, noise)
    until = int(np.argmax(back)) if back.any() else len(deviation)
    return int(np.argmax(deviation[: max(until, 1)]))


def _settled(deviation: Array, band: float, ticks: int) -> int | None:
    """Return the first tick from which a deviation stays within a band for some ticks."""
    if len(deviation) < ticks:
        return None
    windows = sliding_window_view(deviation, ticks)
    still = np.flatnonzero(windows.max(axis=1) - windows.min(axis=1) <= band)
    return int(still[0]) if len(still) else None


def _averaged(values: Array, ticks: int) -> Array:
    """Return the mean of some ticks around each; at both ends the outermost value goes on."""
    ends = np.pad(values, (ticks // 2, ticks - 1 - ticks // 2), mode="edge")
    return np.convolve(ends, np.full(ticks, 1 / ticks), mode="valid")


def aligned(error: Array, peaks: Sequence[Glitch], *, before: int, after: int) -> Array:
    """Return the error around each reversal, from its mean before, in the new direction.

    Parameters
    ----------
    error : ndarray, shape (ticks,)
        Following error of one axis, m.
    found : sequence of Glitch
        From `glitches`, of the same error.
    before, after : int
        Ticks before and after each reversal, none behind the end of the record.

    Returns
    -------
    ndarray, shape (reversals, before + after)
        m; NaN where the error is not known.
    """
    return np.array(
        [
            one.direction
            * (
                error[one.tick - before : one.tick + after]
                - error[one.tick - before : one.tick].mean()
            )
            for one in peaks
        ]
    )
