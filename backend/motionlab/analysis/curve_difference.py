"""Difference of two curves at common instants, held against tolerances in value and in time."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.lanes import cached, compiled

Curve = NDArray[np.floating[Any]]
Positions = Curve | slice
"""Of each instant its place among the samples of a curve: whole numbers are samples."""


class Difference(NamedTuple):
    """Candidate minus baseline over all instants at which at least one of them has a value.

    Attributes
    ----------
    compared : int
        Instants at which both have one.
    single : int
        Instants at which only one has; they are beyond every tolerance in value.
    beyond : int
        Instants beyond the tolerance, `single` included.
    where : int
        First instant of the largest absolute difference; -1 where nothing was compared.
    largest : float
        Difference there, with its sign.
    rms : float
        Root mean square of the differences that were compared.
    """

    compared: int
    single: int
    beyond: int
    where: int
    largest: float
    rms: float


class Bounds(NamedTuple):
    """Tolerance band about the baseline, in value and in time.

    Attributes
    ----------
    absolute, relative : float
        a, in the unit of the curves, and r: together max(a, r |b|).
    reach : float
        h: the tolerance in time over the candidate's period.
    """

    absolute: float
    relative: float
    reach: float


def resampled(samples: Curve, positions: Positions, *, hold: bool) -> Curve:
    """Return a curve's values at some instants.

    Parameters
    ----------
    samples : ndarray, shape (ticks,)
        Its samples; one that is not finite is missing.
    positions : slice, or ndarray of float64, shape (instants,)
        Places from 0 to ticks - 1.
    hold : bool
        Whether a value holds until the next sample; otherwise it changes linearly, and is missing
        between two samples of which one is.

    Returns
    -------
    ndarray, shape (instants,)
        A view for a slice, otherwise float64.
    """
    if isinstance(positions, slice):
        return samples[positions]
    return _resampled(samples, positions, hold)


def within(baseline: Curve, candidate: Curve, absolute: float, relative: float) -> Difference:
    r"""Hold the difference of two curves against a tolerance in value.

    An instant is within it if :math:`|c - b| \le \max(a, r |b|)`. One at which only one curve is
    finite is beyond it; one at which neither is counts for nothing.

    Parameters
    ----------
    baseline, candidate : ndarray, shape (instants,)
        b and c.
    absolute : float
        a, in the unit of the curves.
    relative : float
        r.
    """
    compared, single, beyond, where, largest, squares = _within(
        baseline, candidate, absolute, relative
    )
    rms = float(np.sqrt(squares / compared)) if compared else 0.0
    return Difference(compared, single, beyond, where, largest, rms)


def beyond_in_time(
    baseline: Curve, samples: Curve, positions: Positions, bounds: Bounds, *, hold: bool
) -> NDArray[np.bool_]:
    r"""Return the instants beyond a tolerance in value and in time.

    Instant j passes if the candidate takes a value within :math:`\max(a, r |b_j|)` of
    :math:`b_j` at some place of :math:`[p_j - h, p_j + h]`, cut to its first and last sample.
    Linear candidates take every value between two samples, held ones only those of samples.

    Parameters
    ----------
    baseline : ndarray, shape (instants,)
        b.
    samples : ndarray, shape (ticks,)
        The candidate's samples.
    positions : slice, or ndarray of float64, shape (instants,)
        p, in order.
    bounds : Bounds
        a, r and h.
    hold : bool
        Whether the candidate is held; see `resampled`.
    """
    if isinstance(positions, slice):
        positions = np.arange(positions.start, positions.stop, dtype=np.float64)
    return _beyond_in_time(baseline, samples, positions, bounds, hold)


@cached
def beyond_in_value(
    baseline: Curve, candidate: Curve, absolute: float, relative: float
) -> NDArray[np.bool_]:
    """Return the instants beyond a tolerance in value, by the rule of `within`."""
    result = np.empty(len(baseline), dtype=np.bool_)
    for j in range(len(baseline)):
        b, c = np.float64(baseline[j]), np.float64(candidate[j])
        if np.isfinite(b) and np.isfinite(c):
            result[j] = not abs(c - b) <= max(absolute, relative * abs(b))
        else:
            result[j] = np.isfinite(b) or np.isfinite(c)
    return result


@compiled
def _value(samples: Curve, position: float, hold: bool) -> float:
    i = int(position)
    share = position - i
    if hold or share == 0.0:
        return np.float64(samples[i])
    first = np.float64(samples[i])
    return first + share * (np.float64(samples[i + 1]) - first)


@cached
def _resampled(samples: Curve, positions: Curve, hold: bool) -> NDArray[np.float64]:
    result = np.empty(len(positions))
    for j in range(len(positions)):
        result[j] = _value(samples, positions[j], hold)
    return result


@cached
def _within(
    baseline: Curve, candidate: Curve, absolute: float, relative: float
) -> tuple[int, int, int, int, float, float]:
    compared = single = beyond = 0
    where = -1
    most, largest, squares = -1.0, 0.0, 0.0
    for j in range(len(baseline)):
        b, c = np.float64(baseline[j]), np.float64(candidate[j])
        difference = c - b
        size = abs(difference)
        if size < np.inf:  # so both are finite
            compared += 1
            squares += difference * difference
            if size > most:
                most, largest, where = size, difference, j
            if size > absolute and size > relative * abs(b):
                beyond += 1
        elif np.isfinite(b) or np.isfinite(c):
            single += 1
    return compared, single, beyond + single, where, largest, squares


@cached
def _beyond_in_time(  # noqa: PLR0912 - a kernel
    baseline: Curve, samples: Curve, positions: Curve, bounds: Bounds, hold: bool
) -> NDArray[np.bool_]:
    """Least and largest sample of the moving window decide, but where samples are missing.

    Two queues hold the samples that can still become the least or the largest; each sample enters
    and leaves once, however wide the window is.
    """
    count = len(samples)
    low = np.empty(count, dtype=np.int64)
    high = np.empty(count, dtype=np.int64)
    low_first = low_end = high_first = high_end = 0
    entered, missing = 0, -1  # samples in the window so far; the last of them that is missing
    result = np.empty(len(baseline), dtype=np.bool_)
    for j in range(len(baseline)):
        start = max(positions[j] - bounds.reach, 0.0)
        stop = min(positions[j] + bounds.reach, count - 1.0)
        while entered <= stop:
            value = samples[entered]
            if np.isfinite(value):
                while low_end > low_first and samples[low[low_end - 1]] >= value:
                    low_end -= 1
                low[low_end] = entered
                low_end += 1
                while high_end > high_first and samples[high[high_end - 1]] <= value:
                    high_end -= 1
                high[high_end] = entered
                high_end += 1
            else:
                missing = entered
            entered += 1
        while low_first < low_end and low[low_first] < start:
            low_first += 1
        while high_first < high_end and high[high_first] < start:
            high_first += 1
        b = np.float64(baseline[j])
        if not np.isfinite(b):
            result[j] = np.isfinite(_value(samples, positions[j], hold))
            continue
        allowed = max(bounds.absolute, bounds.relative * abs(b))
        least, most = np.inf, -np.inf
        if low_first < low_end:
            least, most = np.float64(samples[low[low_first]]), np.float64(samples[high[high_first]])
        for end in (start, stop):
            value = _value(samples, end, hold)
            if np.isfinite(value):
                least, most = min(least, value), max(most, value)
        if least > b + allowed or most < b - allowed:
            result[j] = True
        elif not hold and missing < np.floor(start):
            result[j] = False
        else:
            result[j] = not _taken(samples, (start, stop), (b - allowed, b + allowed), hold)
    return result


@cached
def _taken(
    samples: Curve, places: tuple[float, float], values: tuple[float, float], hold: bool
) -> bool:
    """Return whether a curve takes a value of an interval between two places."""
    place, stop = places
    low, high = values
    before = _value(samples, place, hold)
    if low <= before <= high:
        return True
    while place < stop:
        place = min(np.floor(place) + 1.0, stop)
        value = _value(samples, place, hold)
        if low <= value <= high:
            return True
        if not hold and min(before, value) <= high and max(before, value) >= low:
            return True  # comparisons with what is missing are false
        before = value
    return False
