"""Offset and drift between two clocks, from one signal that both have recorded."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_SAMPLES_MAX = 1 << 20  # of each record, on the common grid
_OVERLAP = 0.5  # of the shorter record, at least
_OVERLAP_LEAST = 16  # samples
_GAP = 1.5  # usual steps between two samples, from which there is nothing between them
_PEAKS = 6  # offsets that are refined
_NEAR = 0.1  # of the largest correlation, within which another offset is refined
_APART = 2.0  # samples between two offsets that are not one
_AS_WELL = 2.0  # times the unexplained variance of the best offset, below which another fits too
_ROUNDING = 1e-9  # of a signal's variance
_ITERATIONS = 20
_SETTLED = 1e-6  # of a sample, in one iteration
_DRIFT_MAX = 0.02
_BLOCKS = 20  # of a record, whose residuals are taken for independent
_WIDE = 2.09  # standard errors of a 95 % interval, Student's t of 19 degrees of freedom


class Record(NamedTuple):
    """A signal: times, s, in order, and values, all finite."""

    times: Array
    values: Array


@dataclass(frozen=True)
class Alignment:
    """The second clock on the first: t1 = offset + (1 + drift) t2.

    Attributes
    ----------
    offset, drift : float
        s, and dimensionless.
    offset_half_width, drift_half_width : float
        Of 95 % intervals, by blocks of the record; NaN where no drift could be estimated.
    correlation : float
        Of both signals, aligned.
    other : float or None
        Another offset, s, that fits about as well: the signal repeats, and neither is certain.
    """

    offset: float
    drift: float
    offset_half_width: float
    drift_half_width: float
    correlation: float
    other: float | None = None


def aligned(one: Record, two: Record) -> Alignment | None:
    """Estimate offset and drift between the clocks of two records of one signal.

    The offsets of largest correlation, over all lags at which half of the shorter record is
    covered, are refined by Gauss-Newton on ``y1(t) = g y2((t - offset)/(1 + drift)) + c`` over
    offset, drift, gain g and bias c, and the best of them is returned, with the slopes of y1 as
    instruments (Söderström and Stoica, Instrumental variable methods, 1983); a drift within its
    95 % interval of 0 is left out. Gaps count for nothing.

    Parameters
    ----------
    one, two : Record
        What the clocks have recorded.

    Returns
    -------
    Alignment or None
        None where a record is constant, too short, or nothing converges.
    """
    one, two = _of_later_times(one), _of_later_times(two)
    if min(len(one.times), len(two.times)) < _OVERLAP_LEAST:
        return None
    spans = [float(np.ptp(record.times)) for record in (one, two)]
    step = min(float(np.median(np.diff(record.times))) for record in (one, two))
    step = max(step, max(spans) / _SAMPLES_MAX)
    if min(spans) < _OVERLAP_LEAST * step:
        return None
    a, b = _at_equal_steps(one, step), _at_equal_steps(two, step)
    if not (np.nanstd(a.values) > 0 and np.nanstd(b.values) > 0):
        return None
    lags, correlation = _correlations(a.values, b.values)
    origin = float(a.times[0] - b.times[0])
    offsets = [origin + step * float(lags[peak]) for peak in _peaks(correlation)]
    fits = [fit for offset in offsets if (fit := _refined(a, two, offset)) is not None]
    if not fits:
        return None
    best = max(fits, key=lambda fit: fit.correlation)
    for fit in sorted(fits, key=lambda fit: -fit.correlation):
        apart = abs(fit.offset - best.offset) > _APART * step
        if apart and _unexplained(fit) < _AS_WELL * _unexplained(best):
            return replace(best, other=fit.offset)
    return best


def _unexplained(fit: Alignment) -> float:
    """Return the share of the signal's variance that a fit leaves, rounding of numbers aside."""
    return max(1.0 - fit.correlation**2, _ROUNDING)


def _refined(a: Record, two: Record, offset: float) -> Alignment | None:
    """Return the fit about an offset, with a drift where one is certain."""
    fit, drifting = _fit(a, two, offset, drifting=False), _fit(a, two, offset, drifting=True)
    if drifting is not None and (fit is None or abs(drifting.drift) > drifting.drift_half_width):
        fit = drifting
    elif drifting is not None and fit is not None:  # it may be there, and moves the offset
        unsure = abs(float(two.times.mean())) * drifting.drift_half_width
        width = float(np.hypot(fit.offset_half_width, unsure))
        drift_width = drifting.drift_half_width
        fit = replace(fit, offset_half_width=width, drift_half_width=drift_width)
    return fit


def _of_later_times(record: Record) -> Record:
    """Leave out samples whose time is that of the one before."""
    keep = np.diff(record.times, prepend=-np.inf) > 0
    return Record(record.times[keep], record.values[keep])


def _at_equal_steps(record: Record, step: float) -> Record:
    times, values = record
    grid = times[0] + step * np.arange(int(np.ptp(times) / step) + 1)
    return Record(grid, np.where(_in_gap(times, grid), np.nan, np.interp(grid, times, values)))


def _in_gap(times: Array, at: Array) -> NDArray[np.bool_]:
    """Return which instants lie between two samples that are further apart than usual."""
    steps = np.diff(times)
    right = np.clip(np.searchsorted(times, at), 1, len(times) - 1)
    inside = (at > times[right - 1]) & (at < times[right])
    return inside & (steps[right - 1] > _GAP * np.median(steps))


def _correlations(a: Array, b: Array) -> tuple[NDArray[np.int64], Array]:
    """Return lags, a(n + lag) against b(n), and the correlation over what each lag covers."""
    size = 1 << (len(a) + len(b) - 1).bit_length()
    least = max(_OVERLAP_LEAST, int(_OVERLAP * min(np.isfinite(a).sum(), np.isfinite(b).sum())))
    lags = np.arange(least - len(b), len(a) - least + 1)

    def spectra(values: Array) -> list[NDArray[np.complex128]]:
        """Return those of which samples there are, of the samples, and of their squares."""
        there = np.isfinite(values)
        scaled = np.where(there, (values - np.nanmean(values)) / np.nanstd(values), 0.0)
        return [np.fft.rfft(each, size) for each in (there.astype(float), scaled, scaled**2)]

    there_a, of_a, square_a = spectra(a)
    there_b, of_b, square_b = (np.conj(each) for each in spectra(b))

    def sums(one: NDArray[np.complex128], two: NDArray[np.complex128]) -> Array:
        """Return the products of one record with another at each lag, summed."""
        return np.fft.irfft(one * two, size)[lags % size]

    count = np.maximum(np.rint(sums(there_a, there_b)), 1.0)
    sum_a, sum_b = sums(of_a, there_b), sums(there_a, of_b)
    variance_a = sums(square_a, there_b) - sum_a**2 / count
    variance_b = sums(there_a, square_b) - sum_b**2 / count
    covariance = sums(of_a, of_b) - sum_a * sum_b / count
    # A stretch at rest correlates with nothing.
    moving = (count >= least) & (variance_a > 1e-3 * count) & (variance_b > 1e-3 * count)
    scale = np.sqrt(np.where(moving, variance_a * variance_b, 1.0))
    return lags, np.where(moving, covariance / scale, 0.0)


def _peaks(correlation: Array) -> list[int]:
    """Return the highest maxima, the highest first, each outside of the hills of the others."""
    outside, peaks = correlation.copy(), []
    highest = float(correlation.max())
    while len(peaks) < _PEAKS:
        peak = int(np.argmax(outside))
        if peaks and outside[peak] < highest - _NEAR:
            break
        peaks.append(peak)
        low = correlation < 0.5 * correlation[peak]
        left, right = np.flatnonzero(low[:peak]), np.flatnonzero(low[peak:])
        begin = int(left[-1]) if left.size else 0
        outside[begin : peak + int(right[0]) if right.size else len(correlation)] = -1.0
    return peaks


class _Step(NamedTuple):
    """Gain and bias about some offset and drift, and what these change by, times the gain.

    Noise of the second record's slopes would make intervals too small: the slopes of the first,
    whose noise is another, are the instruments.
    """

    matrix: Array
    instruments: Array
    solution: Array
    residual: Array
    correlation: float


def _fit(one: Record, two: Record, offset: float, *, drifting: bool) -> Alignment | None:
    """Refine an offset, and a drift, by Gauss-Newton; None where that does not converge."""
    slopes = np.gradient(two.values, two.times)
    period = float(one.times[1] - one.times[0])
    middle = 0.5 * float(two.times[0] + two.times[-1])
    # Parameters: time of the first clock at the middle of the second record, and drift.
    centre, drift, step = offset + middle, 0.0, None
    for _ in range(_ITERATIONS):
        at = (one.times - centre) / (1.0 + drift)
        step = _step(one, two, slopes, at + middle, drifting=drifting)
        if step is None:
            return None
        moves = step.solution[2:] / step.solution[0]
        centre += float(moves[0])
        drift += float(moves[1]) if drifting else 0.0
        if not (abs(drift) <= _DRIFT_MAX and np.isfinite(centre)):
            return None
        if abs(moves[0]) < _SETTLED * period:
            break
    if step is None:
        return None
    covariance = _covariance(step) / float(step.solution[0]) ** 2
    # offset = centre - (1 + drift) middle
    weights = np.array([1.0, -middle] if drifting else [1.0])
    spread = float(weights @ covariance[2:, 2:] @ weights)
    return Alignment(
        offset=centre - (1.0 + drift) * middle,
        drift=drift,
        offset_half_width=_WIDE * float(np.sqrt(max(spread, 0.0))),
        drift_half_width=_WIDE * float(np.sqrt(covariance[3, 3])) if drifting else np.nan,
        correlation=step.correlation,
    )


def _covariance(step: _Step) -> Array:
    """Return the covariance of a solution: residuals are independent between blocks alone."""
    count = min(_BLOCKS, len(step.residual) // _OVERLAP_LEAST)
    scores = np.array_split(step.instruments * step.residual[:, None], max(2, count))
    sums = np.stack([block.sum(axis=0) for block in scores])
    bread = np.linalg.pinv(step.instruments.T @ step.matrix)
    return bread @ (sums.T @ sums * len(sums) / (len(sums) - 1)) @ bread.T


def _step(one: Record, two: Record, slopes: Array, at: Array, *, drifting: bool) -> _Step | None:
    """Solve for gain, bias and changes of the parameters; `at` are times of the second clock."""
    inside = (at >= two.times[0]) & (at <= two.times[-1]) & ~_in_gap(two.times, at)
    slopes_one = np.gradient(one.values, one.times)
    inside &= np.isfinite(one.values) & np.isfinite(slopes_one)
    if np.count_nonzero(inside) < _OVERLAP_LEAST:
        return None
    at, values = at[inside], one.values[inside]
    model, slope = np.interp(at, two.times, two.values), np.interp(at, two.times, slopes)
    other = slopes_one[inside]
    from_middle = at - 0.5 * (two.times[0] + two.times[-1])

    def columns(slope: Array) -> Array:
        drift = [-slope * from_middle] if drifting else []
        return np.stack([model, np.ones_like(model), -slope, *drift], axis=1)

    matrix, instruments = columns(slope), columns(other)
    normal = instruments.T @ matrix
    scale = np.sqrt(np.diag(matrix.T @ matrix) * np.diag(instruments.T @ instruments))
    if not (scale > 0).all() or np.linalg.matrix_rank(normal / scale, tol=1e-9) < len(normal):
        return None
    solution = np.asarray(np.linalg.solve(normal, instruments.T @ values), dtype=np.float64)
    if solution[0] == 0.0:
        return None
    residual = values - matrix @ solution
    correlation = float(np.corrcoef(values, model)[0, 1])
    return _Step(matrix, instruments, solution, residual, correlation)
