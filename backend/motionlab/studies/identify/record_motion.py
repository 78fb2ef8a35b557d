"""Which samples of a record can tell friction: motion, reversals, rests, gaps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ExperimentFailed
from motionlab.studies.identify.record_filter import SHORTEST, Window, filtered

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

LOSS_OF_MEMORY = 0.5e-3
"""Distance after which friction no longer depends on where a motion began, m."""

_REST_SECONDS = 0.1
_SLOWEST = 20e-6  # m/s: slower than this for longer than that is a rest
_NOISES = 4.0
"""Standard deviations of the velocity's noise below which nothing is taken to move."""

_LAGS = 4
"""Samples by which force and position may be apart."""

_QUIET = 1e-3
"""Noise that the velocity may have, as a share of its RMS."""

_STILL = 3e-3
"""Noise that the acceleration may have, as a share of its RMS."""

_LONGEST = 8.0
"""Times by which noise may lengthen the filter."""

_BLOCK = 256
_FEWEST = 100
"""Windows of sliding that a fit needs."""


class Record(NamedTuple):
    """Position and force of one axis at equal steps; NaN where a sample is missing.

    Attributes
    ----------
    period : float
        Between two samples, s.
    position, force : ndarray, shape (n,)
        m and N.
    doubt : ndarray, shape (n,), or None
        How far the force may be off, always to the same side, N.
    """

    period: float
    position: Array
    force: Array
    doubt: Array | None = None

    def noisier(self, noise: float) -> Record:
        """Return the record with white noise of a standard deviation added to the position."""
        draws = np.random.default_rng(len(self.position)).standard_normal(len(self.position))
        return self._replace(position=self.position + noise * draws)


@dataclass(frozen=True)
class Motion:
    """A record, filtered, and which windows of it are used.

    Attributes
    ----------
    period : float
        Between two samples, s.
    window : Window
        Filter of all terms of the equation of motion.
    inner : Window
        Filter of the velocity on which the level of friction depends.
    position, force : ndarray, shape (n,)
        As measured, zero where missing.
    velocity : ndarray, shape (n,)
        After `inner`, m/s.
    doubt : ndarray, shape (n,)
        Of the force, N.
    lost : ndarray of bool, shape (n,)
        Where the state of the bristle is not known: beside gaps and ends, at rest.
    step : int
        Samples from one window to the next.
    at : ndarray of int, shape (m,)
        Windows used, as multiples of `step`.
    sliding : ndarray of bool, shape (m,)
        Whether a window lies beyond `LOSS_OF_MEMORY` of the last reversal.
    noise : float
        Standard deviation of the position's noise, m.
    reversals : int
        Changes of direction, rests apart.
    shares : dict of str to float
        Of the record: what is not used and why.
    hidden : ndarray, shape (m,)
        Of windows that do not slide: displacement within half of `inner` at the reversal, m.
    """

    period: float
    window: Window
    inner: Window
    position: Array
    velocity: Array
    force: Array
    doubt: Array
    lost: Mask
    step: int
    at: NDArray[np.intp]
    sliding: Mask
    noise: float
    reversals: int
    shares: dict[str, float]
    hidden: Array

    @property
    def lag_max(self) -> float:
        """Largest time that force and position may be apart, s."""
        return _LAGS * self.period

    def of(self, values: Array, order: int, ahead: float = 0.0) -> Array:
        """Return a filtered signal, or a derivative of it, in the windows used, shape (m,)."""
        return filtered(values, self.window.kernel(order, ahead), self.step)[self.at]


def motion_of(record: Record, bandwidth: float, like: Motion | None = None) -> Motion:
    """Return a record filtered, and what of it can be used.

    Parameters
    ----------
    record : Record
        Of one axis.
    bandwidth : float
        Of the filter at -3 dB, Hz; less where the position is noisy.
    like : Motion, optional
        Whose filters are taken instead.

    Raises
    ------
    ExperimentFailed
        If too little of it moves, for which reasons.
    """
    T = record.period
    missing = ~(np.isfinite(record.position) & np.isfinite(record.force))
    if missing.all():
        raise ExperimentFailed("position and force have no samples at the same time")
    raw, force = (np.where(missing, 0.0, a) for a in (record.position, record.force))
    noise = _noise(raw, missing)
    if like is None:
        window = _quiet(raw, missing, noise, Window.of(bandwidth, T))
        inner = _inner(window, noise, _rms(raw, missing, window, 1))
    else:
        window, inner = like.window, like.inner
    smooth, velocity = (filtered(raw, inner.kernel(order)) for order in (0, 1))
    beside = _widened(missing, inner.reach)
    slowest = max(_SLOWEST, _NOISES * noise * inner.noise(1))
    rest = _long((np.abs(velocity) <= slowest) & ~beside, round(_REST_SECONDS / T))
    lost = beside | rest
    path = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(smooth)))])
    memory = path - _last(path, lost) >= LOSS_OF_MEMORY
    sign = np.sign(np.where(np.abs(velocity) > slowest, velocity, 0.0))
    crossing = np.concatenate([[False], velocity[1:] * velocity[:-1] <= 0.0])
    settled = path - _last(path, crossing) >= LOSS_OF_MEMORY
    step = max(1, int(window.half / T / 2.0))
    reach = window.reach + _LAGS
    usable = ~lost & memory
    used = _whole(usable, reach, step)
    sliding = _whole(usable & settled, reach, step)
    at = np.flatnonzero(used)
    shares = {
        "missing": float(missing.mean()),
        "at rest": float(rest.mean()),
        "within 0.5 mm of a gap, a rest or an end": float((~lost & ~memory).mean()),
        "used": float(used.mean()),
    }
    moved = float(np.ptp(record.position[~missing]))
    if int(sliding.sum()) < _FEWEST:
        raise ExperimentFailed(_too_little(shares, moved, int(sliding.sum()) * step * T))
    acceleration = filtered(raw, window.kernel(2))
    held = np.where(crossing, np.abs(acceleration), np.nan)
    return Motion(
        period=T,
        window=window,
        inner=inner,
        position=raw,
        velocity=velocity,
        force=force,
        doubt=np.zeros(len(raw)) if record.doubt is None else record.doubt,
        lost=lost,
        step=step,
        at=at,
        sliding=sliding[at],
        noise=noise,
        reversals=_reversals(sign),
        shares=shares,
        hidden=0.5 * inner.half**2 * _latest(held)[at * step],
    )


def _rms(position: Array, missing: Mask, window: Window, order: int) -> float:
    """Return the RMS of a derivative of the position."""
    derivative = filtered(position, window.kernel(order))[~_widened(missing, window.reach)]
    return float(np.sqrt(np.mean(derivative**2))) if derivative.size else 0.0


def _quiet(position: Array, missing: Mask, noise: float, window: Window) -> Window:
    """Return a window, longer where noise would drown the acceleration, which biases the mass."""
    for longer in np.geomspace(1.0, _LONGEST, 13):
        found = Window(longer * window.half, window.period)
        if noise * found.noise(2) <= _STILL * _rms(position, missing, found, 2):
            return found
    return Window(_LONGEST * window.half, window.period)


def _inner(window: Window, noise: float, speed: float) -> Window:
    """Return the shortest window whose velocity is quiet enough; none longer than `window`."""
    T = window.period
    for half in np.arange(SHORTEST, window.half / T):
        inner = Window(half * T, T)
        if noise * inner.noise(1) <= _QUIET * speed:
            return inner
    return window


def _noise(position: Array, missing: Mask) -> float:
    """Return the standard deviation of white noise: of third differences, block by block."""
    third = np.diff(position, 3)
    known = ~_widened(missing, 3)[3:]
    count = len(third) // _BLOCK
    if count == 0:
        return 0.0
    squares = np.where(known, third, np.nan)[: count * _BLOCK].reshape(count, _BLOCK) ** 2
    blocks = squares.mean(axis=1)
    blocks = blocks[np.isfinite(blocks)]
    return float(np.sqrt(np.median(blocks) / 20.0)) if blocks.size else 0.0


def _widened(mask: Mask, reach: int) -> Mask:
    """Return a mask with `reach` samples more on either side, and at both ends."""
    held = np.concatenate([[True] * reach, mask, [True] * reach])
    count = np.concatenate([[0], np.cumsum(held)])
    return count[2 * reach + 1 :] - count[: -2 * reach - 1] > 0


def _whole(mask: Mask, reach: int, step: int) -> Mask:
    """Return for each window whether a mask holds throughout."""
    return ~_widened(~mask, reach)[::step]


def _long(mask: Mask, least: int) -> Mask:
    """Return a mask without its stretches shorter than `least` samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], mask.astype(np.int8), [0]])))
    found = np.zeros(len(mask), dtype=bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin > least:
            found[begin:end] = True
    return found


def _last(path: Array, mask: Mask) -> Array:
    """Return the path at the last sample at which a mask held, -inf before the first."""
    return np.maximum.accumulate(np.where(mask, path, -np.inf))


def _latest(values: Array) -> Array:
    """Return the last value that is no NaN at each sample; inf before the first."""
    places = np.maximum.accumulate(np.where(np.isnan(values), -1, np.arange(len(values))))
    return np.where(places < 0, np.inf, values[np.maximum(places, 0)])


def _reversals(sign: Array) -> int:
    moving = sign[sign != 0.0]
    return int(np.count_nonzero(np.diff(moving)))


def _too_little(shares: dict[str, float], moved: float, seconds: float) -> str:
    parts = [f"{100 * share:.0f} % {name}" for name, share in shares.items() if name != "used"]
    return (
        f"too little sliding to identify from: {seconds:.2g} s are left. The axis moved "
        f"{moved * 1e3:.3g} mm in all; of the record {', '.join(parts)}; what is within 0.5 mm "
        "of a reversal is presliding. Record at least ten strokes of several mm at different "
        "speeds, without gaps"
    )
