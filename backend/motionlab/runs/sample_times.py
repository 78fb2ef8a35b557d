"""Sample times of measurements: rate, gaps and jitter; samples put at equal steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.runs.import_document import VALUES_MAX
from motionlab.runs.measured_file import refused

_GAP = 1.5  # periods between two samples from which some are missing
_UNEVEN = 0.5  # periods off equal steps from which the order of samples alone says too little
_UNEVEN_GAP = 5.0  # as _GAP, of samples that are that far off
_SPARSE = 20  # samples of equal steps for one in the file, at most
_PERIOD_LEAST = 1e-9  # s
_DURATION_MAX = 1e9  # s
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
    counts, places = np.ones(len(steps)), np.arange(len(times))
    for _ in range(3):
        counts = np.where(steps > limit * period + resolution, np.rint(steps / period), 1.0)
        if counts.sum() > max(_SPARSE * len(times), 1000):
            row = int(np.argmax(steps)) + 1
            raise refused(
                f"{place(row)}: the gap before it is longer than all samples can be, at "
                f"{1 / period:.6g} Hz: cut the file, or map another column to time",
                float(steps[row - 1]),
            )
        places = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        period = _whole_rate(_slope(places, times), int(places[-1]))
    if int(places[-1]) >= VALUES_MAX:
        raise refused("has too many samples with its gaps")
    offsets = times - places * period
    jitter = float(np.max(np.abs(offsets - np.median(offsets))))
    starts = np.flatnonzero(counts > 1)
    gaps = [(int(places[i]) + 1, int(counts[i]) - 1) for i in starts]
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


def resampled(
    grid: Grid, values: dict[str, NDArray[np.float64]], period: float
) -> dict[str, NDArray[np.float64]]:
    """Return values at other equal steps, by linear interpolation; not across gaps.

    Parameters
    ----------
    grid : Grid
        Of the file.
    values : dict of str to ndarray
        Samples of the file.
    period : float
        Time between two of the wanted steps, s.

    Raises
    ------
    ConfigError
        If there would be too many samples.
    """
    times = grid.times - grid.times[0]
    count = int(np.floor(times[-1] / period * (1 + 1e-12))) + 1
    if count * len(values) > VALUES_MAX or count < 2:
        bounds: dict[str, float] = {"minimum": 2, "maximum": VALUES_MAX // len(values)}
        raise ConfigError(FieldError("resample", "gives too many samples", count, bounds=bounds))
    wanted = np.minimum(np.arange(count) * period, times[-1])
    right = np.clip(np.searchsorted(times, wanted, "right"), 1, len(times) - 1)
    left = right - 1
    width = times[right] - times[left]
    share = np.divide(wanted - times[left], width, out=np.zeros(count), where=width > 0)
    across = (width > grid.longest) & (share > 1e-9) & (share < 1 - 1e-9)
    found = {}
    for name, each in values.items():
        low, high = each[left], each[right]
        mixed = low + share * (high - low)
        mixed = np.where(share <= 1e-9, low, np.where(share >= 1 - 1e-9, high, mixed))
        found[name] = np.where(across, np.nan, mixed)
    return found
