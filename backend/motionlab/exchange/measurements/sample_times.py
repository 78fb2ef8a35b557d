"""Sample times of measurements: rate, gaps and jitter; samples put at equal steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.document import VALUES_MAX
from motionlab.exchange.measurements.table_file import refused

_GAP = 1.5  # periods between two samples from which some are missing
_UNEVEN = 0.5  # periods off equal steps from which the order of samples alone says too little
_UNEVEN_GAP = 5.0  # as _GAP, of samples that are that far off
_SPARSE = 20  # samples of equal steps for one in the file, at most
_PERIOD_LEAST = 1e-9  # s
_DURATION_MAX = 1e9  # s
_AT_SAMPLE = 1e-9  # share of a step within which an instant is that of a sample
_BLOCK = 1 << 18  # instants that are interpolated at once
_ROUND = 1e-4  # relative distance at which a rate is taken for a whole number of Hz


@dataclass(frozen=True)
class Grid:
    """Equal steps that the samples of a file lie on.

    Attributes
    ----------
    period : float
        Time between two steps, s.
    places : ndarray of int64
        Step of each sample of the file.
    times : ndarray of float64
        Time of each sample in the file, s, from 0.
    jitter : float
        Largest distance of a sample's time from that of its step, s.
    gaps : list of (int, int)
        First missing step and number of missing ones, of each gap.
    longest : float
        Time between two samples from which there is a gap, s.
    resolution : float
        Step of the clock of the file, s, where it is coarser than the samples; else 0.
    """

    period: float
    places: NDArray[np.int64]
    times: NDArray[np.float64]
    jitter: float
    gaps: list[tuple[int, int]]
    longest: float
    resolution: float = 0.0

    @property
    def ticks(self) -> int:
        """Number of steps from the first sample to the last."""
        return int(self.places[-1]) + 1

    @property
    def median_rate(self) -> float:
        """One over the median time between two samples that are apart, Hz."""
        steps = np.diff(self.times)
        return 1.0 / float(np.median(steps[steps > 0]))

    @property
    def uneven(self) -> bool:
        """Whether the file's times are too far from equal steps to be replaced by them.

        Times of a coarse clock may be one of its steps off.
        """
        return self.jitter > _UNEVEN * self.period + self.resolution

    def placed(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return values at equal steps, NaN where there is none."""
        result = np.full(self.ticks, np.nan)
        result[self.places] = values
        return result


def sample_times(
    times: NDArray[np.float64], place: Callable[[int], str], rate: float | None = None
) -> Grid:
    """Return the equal steps that some times lie on.

    Parameters
    ----------
    times : ndarray of float64
        Times of the samples, s.
    place : callable
        Returns where a row of the file is, for people.
    rate : float, optional
        Sample rate, Hz, if it is given and not measured.

    Raises
    ------
    ConfigError
        If a time is missing or before the one before it, or a gap is longer than everything else.
    """
    missing = np.flatnonzero(~np.isfinite(times))
    if missing.size:
        raise refused(f"{place(int(missing[0]))}: has no time")
    if rate is not None:
        return _bounded(Grid(1.0 / rate, np.arange(len(times)), times, 0.0, [], _GAP / rate))
    steps = np.diff(times)
    backwards = np.flatnonzero(steps < 0)
    if backwards.size:
        row = int(backwards[0]) + 1
        raise refused(f"{place(row)}: its time is before the one before it", float(times[row]))
    if not (steps > 0).any():
        raise refused("all its times are equal")
    grid = _fitted(times, steps, place, _GAP)
    return _bounded(_fitted(times, steps, place, _UNEVEN_GAP) if grid.uneven else grid)


def _bounded(grid: Grid) -> Grid:
    """Return equal steps if clocks of nanoseconds can say them."""
    if not (grid.period >= _PERIOD_LEAST and grid.period * grid.ticks <= _DURATION_MAX):
        raise refused(
            f"lasts {grid.period * grid.ticks:.3g} s in steps of {grid.period:.3g} s; allowed are "
            f"at most {_DURATION_MAX:g} s in steps of {_PERIOD_LEAST:g} s or more"
        )
    return grid


def _fitted(
    times: NDArray[np.float64],
    steps: NDArray[np.float64],
    place: Callable[[int], str],
    limit: float,
) -> Grid:
    """Return equal steps; two samples further apart than `limit` periods have a gap between."""
    typical, resolution = float(np.quantile(steps, 0.5, method="lower")), 0.0
    if typical <= 0.0 or np.count_nonzero(steps == 0) > len(steps) / 10:  # rounded times
        typical = float(times[-1] - times[0]) / len(steps)
        resolution = float(np.min(steps[steps > 0]))
    period = float(np.mean(steps[steps <= limit * typical + resolution]))
    places, apart, counts = np.arange(len(times)), np.empty(0, np.int64), np.empty(0, np.int64)
    for _ in range(3):
        apart = np.flatnonzero(steps > limit * period + resolution)
        widths = np.rint(steps[apart] / period)
        if len(steps) + np.sum(widths - 1) > max(_SPARSE * len(times), 1000):
            row = int(np.argmax(steps)) + 1
            raise refused(
                f"{place(row)}: the gap before it is longer than all samples can be, at "
                f"{1 / period:.6g} Hz: cut the file, or map another column to time",
                float(steps[row - 1]),
            )
        counts = widths.astype(np.int64)
        places[:] = 1
        places[0] = 0
        places[apart + 1] = counts
        np.cumsum(places, out=places)
        period = _whole_rate(_slope(places, times), int(places[-1]))
    if int(places[-1]) >= VALUES_MAX:
        raise refused("has too many samples with its gaps")
    offsets = places * -period
    offsets += times
    offsets -= np.median(offsets)
    jitter = float(np.max(np.abs(offsets, out=offsets)))
    gaps = [(int(places[i]) + 1, int(n) - 1) for i, n in zip(apart, counts, strict=True) if n > 1]
    return Grid(period, places, times, jitter, gaps, limit * period + resolution, resolution)


def _slope(places: NDArray[np.int64], times: NDArray[np.float64]) -> float:
    """Return the period that fits the times best, least squares."""
    steps = places - places.mean()
    return float(steps @ (times - times.mean()) / (steps @ steps))


def _whole_rate(period: float, steps: int) -> float:
    """Return the period of a whole number of Hz, where it fits as well."""
    rate = round(1.0 / period) if period < 1.0 else 0
    if rate and abs(1.0 / rate - period) * max(steps, 1) < min(0.25, _ROUND * steps) * period:
        return 1.0 / rate
    return period


def resampled_ticks(grid: Grid, period: float, columns: int) -> int:
    """Return the number of samples at other equal steps.

    Parameters
    ----------
    grid : Grid
        Of the file.
    period : float
        Time between two of the wanted steps, s.
    columns : int
        Columns that are resampled.

    Raises
    ------
    ConfigError
        If there would be too many samples.
    """
    count = int(np.floor((grid.times[-1] - grid.times[0]) / period * (1 + 1e-12))) + 1
    if count * columns > VALUES_MAX or count < 2:
        bounds: dict[str, float] = {"minimum": 2, "maximum": VALUES_MAX // columns}
        raise ConfigError(FieldError("resample", "gives too many samples", count, bounds=bounds))
    return count


def resampled(
    grid: Grid, values: NDArray[np.float64], period: float, ticks: int
) -> NDArray[np.float64]:
    """Return values at other equal steps, by linear interpolation; not across gaps.

    Parameters
    ----------
    grid : Grid
        Of the file.
    values : ndarray of float64
        Samples of the file.
    period : float
        Time between two of the wanted steps, s.
    ticks : int
        Number of wanted steps.
    """
    samples = np.empty(ticks)
    for start in range(0, ticks, _BLOCK):
        steps = np.arange(start, min(start + _BLOCK, ticks), dtype=np.float64)
        samples[start : start + len(steps)] = interpolated(grid, values, period * steps)
    return samples


def interpolated(
    grid: Grid, values: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return values at times from the first sample, linearly interpolated; NaN across gaps."""
    first, last = grid.times[0], grid.times[-1]
    times = np.minimum(at + first, last)
    right = np.clip(np.searchsorted(grid.times, times, "right"), 1, len(grid.times) - 1)
    left = right - 1
    width = grid.times[right] - grid.times[left]
    share = np.divide(times - grid.times[left], width, out=np.zeros(len(at)), where=width > 0)
    low, high = values[left], values[right]
    mixed = low + share * (high - low)
    mixed = np.where(share <= _AT_SAMPLE, low, np.where(share >= 1 - _AT_SAMPLE, high, mixed))
    across = (width > grid.longest) & (share > _AT_SAMPLE) & (share < 1 - _AT_SAMPLE)
    return np.where(across, np.nan, mixed)
