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
        An offset, s, of which the correlation is nearly as large: the signal repeats.
    """

    offset: float
    drift: float
    offset_half_width: float
    drift_half_width: float
    correlation: float
    other: float | None = None


def aligned(one: Record, two: Record) -> Alignment | None:
    """Estimate offset and drift between the clocks of two records of one signal.

    The offset of largest correlation, over all lags at which half of the shorter record is
    covered, is refined by Gauss-Newton on ``y1(t) = g y2((t - offset)/(1 + drift)) + c`` over
    offset, drift, gain g and bias c, with the slopes of y1 as instruments (Söderström and Stoica,
    Instrumental variable methods, 1983); a drift within its 95 % interval of 0 is left out.

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
    if not (np.ptp(a.values) > 0 and np.ptp(b.values) > 0):
        return None
    lags, correlation = _correlations(a.values, b.values)
    best = int(np.argmax(correlation))
    origin = float(a.times[0] - b.times[0])
    offset, other = origin + step * float(lags[best]), _other_peak(correlation, best)
    fit, drifting = _fit(a, two, offset, drifting=False), _fit(a, two, offset, drifting=True)
    if drifting is not None and (fit is None or abs(drifting.drift) > drifting.drift_half_width):
        fit = drifting
    elif drifting is not None and fit is not None:  # it may be there, and moves the offset
        unsure = abs(float(two.times.mean())) * drifting.drift_half_width
        width = float(np.hypot(fit.offset_half_width, unsure))
        drift_width = drifting.drift_half_width
        fit = replace(fit, offset_half_width=width, drift_half_width=drift_width)
    if fit is None or other is None:
        return fit
    return replace(fit, other=origin + step * float(lags[other]))


def _of_later_times(record: Record) -> Record:
    """Leave out samples whose time is that of the one before."""
    keep = np.diff(record.times, prepend=-np.inf) > 0
    return Record(record.times[keep], record.values[keep])


def _at_equal_steps(record: Record, step: float) -> Record:
    times, values = record
    grid = times[0] + step * np.arange(int(np.ptp(times) / step) + 1)
    return Record(grid, np.interp(grid, times, values))


def _correlations(a: Array, b: Array) -> tuple[NDArray[np.int64], Array]:
    """Return lags, a(n + lag) against b(n), and the correlation over what each lag covers."""
    a, b = (a - a.mean()) / a.std(), (b - b.mean()) / b.std()
    size = 1 << (len(a) + len(b) - 1).bit_length()
    products = np.fft.irfft(np.fft.rfft(a, size) * np.conj(np.fft.rfft(b, size)), size)
    least = max(_OVERLAP_LEAST, int(_OVERLAP * min(len(a), len(b))))
    lags = np.arange(least - len(b), len(a) - least + 1)
    first, last = np.maximum(lags, 0), np.minimum(lags + len(b), len(a))
    count = last - first

    def sums(values: Array, start: NDArray[np.int64], stop: NDArray[np.int64]) -> Array:
        total = np.concatenate([[0.0], np.cumsum(values)])
        return total[stop] - total[start]

    sum_a, sum_b = sums(a, first, last), sums(b, first - lags, last - lags)
    square_a, square_b = sums(a * a, first, last), sums(b * b, first - lags, last - lags)
    variances = (square_a - sum_a**2 / count) * (square_b - sum_b**2 / count)
    covariance = products[lags % size] - sum_a * sum_b / count
    # A stretch at rest correlates with nothing.
    least_variance = 1e-6 * count**2
    return lags, np.where(
        variances > least_variance, covariance / np.sqrt(np.maximum(variances, least_variance)), 0.0
    )


def _other_peak(correlation: Array, best: int) -> int | None:
    """Return another maximum that is nearly as high, outside of the hill of the best one."""
    low = correlation < 0.5 * correlation[best]
    left = np.flatnonzero(low[:best])
    right = np.flatnonzero(low[best:])
    outside = correlation.copy()
    begin = int(left[-1]) if left.size else 0
    end = best + int(right[0]) if right.size else len(correlation)
    outside[begin:end] = -1.0
    other = int(np.argmax(outside))
    return other if outside[other] > correlation[best] - 0.02 else None


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
    inside = (at >= two.times[0]) & (at <= two.times[-1])
    if np.count_nonzero(inside) < _OVERLAP_LEAST:
        return None
    at, values = at[inside], one.values[inside]
    model, slope = np.interp(at, two.times, two.values), np.interp(at, two.times, slopes)
    other = np.gradient(one.values, one.times)[inside]
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
