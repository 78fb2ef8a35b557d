"""Motion of a recorded axis: filtered derivatives, rests, reversals, noise.

The window is ``phi(t) = c cos^4(pi t/(2 h))`` for ``abs(t) < h``. Because a convolution may be
differentiated on either side, ``(phi * p)'' = phi'' * p``: a filtered acceleration comes from
positions without a difference of samples, and every term of the equation of motion passes through
the same filter. A sample further than h from a gap does not know of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, ExperimentFailed, FieldError

Array = NDArray[np.float64]

_WIDTH = 0.4645
"""Half length of the window times its bandwidth at -3 dB, 1."""

SHORTEST = 3.0
"""Least half length, in samples: shorter ones have no derivative worth the name."""


class Window(NamedTuple):
    """A window, sampled.

    Attributes
    ----------
    half : float
        Half its length, s.
    period : float
        Between two samples, s.
    """

    half: float
    period: float

    @classmethod
    def of(cls, bandwidth: float, period: float) -> Window:
        """Return the window of a bandwidth at -3 dB, Hz."""
        return cls(_WIDTH / bandwidth, period)

    @property
    def bandwidth(self) -> float:
        """At -3 dB, Hz."""
        return _WIDTH / self.half

    @property
    def reach(self) -> int:
        """Samples that it takes in on either side."""
        return math.ceil(self.half / self.period)

    def kernel(self, order: int, ahead: float = 0.0) -> Array:
        """Return its samples, or those of a derivative, for a convolution.

        Parameters
        ----------
        order : int
            0, 1 or 2: the window, its first or second derivative.
        ahead : float
            Time by which the result is ahead of the instant that it is for, s, at most `period`
            times a few samples.

        Returns
        -------
        ndarray, shape (2 n + 1,)
            Exact for polynomials up to `order`.
        """
        shift = math.ceil(abs(ahead) / self.period)
        n = self.reach + shift
        t = np.arange(-n, n + 1) * self.period + ahead
        w = math.pi / (2.0 * self.half)
        c, s = np.cos(w * t), np.sin(w * t)
        inside = np.abs(t) < self.half
        if order == 0:
            values = np.where(inside, c**4, 0.0)
            return values / values.sum()
        if order == 1:
            values = np.where(inside, -4.0 * c**3 * s, 0.0)
            values -= np.where(inside, c**4, 0.0) * (values.sum() / np.sum(c[inside] ** 4))
            return values / -float(t @ values)
        values = np.where(inside, 12.0 * c**2 * s**2 - 4.0 * c**4, 0.0)
        weight = np.where(inside, c**4, 0.0)
        values -= weight * (values.sum() / weight.sum())
        slope = np.where(inside, -4.0 * c**3 * s, 0.0)
        slope -= weight * (slope.sum() / weight.sum())
        values -= slope * (float(t @ values) / float(t @ slope))
        return values / (0.5 * float(t * t @ values))

    def noise(self, order: int) -> float:
        """Return the standard deviation of a derivative of white noise of unit deviation."""
        return float(np.linalg.norm(self.kernel(order)))


def filtered(values: Array, kernel: Array, step: int = 1) -> Array:
    """Return a convolution at every `step`-th sample from the first on, zero beyond the ends.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples.
    kernel : ndarray, shape (2 m + 1,)
        Of `Window.kernel`.
    step : int
        Samples from one result to the next.

    Returns
    -------
    ndarray, shape (ceil(n/step),)
        Sample k is at ``values[k step]``.
    """
    reach = len(kernel) // 2
    if step == 1:
        return np.convolve(values, kernel)[reach : reach + len(values)]
    count = -(-len(values) // step)
    padded, backwards = np.pad(values, (reach, reach + step)), kernel[::-1]
    result = np.zeros(count)
    for phase in range(min(step, len(kernel))):  # every step-th sample with every step-th weight
        weights = backwards[phase::step]
        result += np.correlate(padded[phase::step][: count + len(weights) - 1], weights)
    return result


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

_SMOOTHED = 0.02
"""Displacement that `inner` hides at a reversal, as a share of ``a h^2/2``."""

_STILL = 3e-4
"""Noise that the acceleration may have, as a share of its RMS: it biases the mass by its square."""

_STILL_ABOUT_REVERSALS = 3e-3
"""The same about reversals, where the mass is known and a short filter counts for more."""

_LONGEST = 8.0
"""Times by which noise may lengthen the filter."""

_BLOCK = 256
_ENOUGH = 400
"""Windows of sliding that a long filter must leave."""

_FEWEST = 100
"""Windows of sliding that a fit needs."""

_ONE_WAY = 0.01
"""Least share of them in each direction by which friction and a constant force are apart."""

_EXPLAINED = 0.3
"""Residual, as a share of the friction, below which the sign of the friction is certain."""


class Record(NamedTuple):
    """Position and force of one axis at equal steps; NaN where a sample is missing.

    Attributes
    ----------
    period : float
        Between two samples, s.
    position, force : ndarray, shape (n,)
        m and N.
    within : ndarray, shape (n,), or None
        What may add to the force within a sample, N: the regression finds the share of it.
    """

    period: float
    position: Array
    force: Array
    within: Array | None = None


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
        Filter of the motion that the bristle follows.
    position, force : ndarray, shape (n,)
        As measured, zero where missing.
    path, velocity : ndarray, shape (n,)
        Position and velocity after `inner`, m and m/s.
    within : ndarray, shape (n,), or None
        Of the record, zero where missing, N.
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
    path: Array
    velocity: Array
    force: Array
    within: Array | None
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


class Motions(NamedTuple):
    """A record filtered twice."""

    sliding: Motion
    turning: Motion  # with a filter as short as reversals need


def motions_of(record: Record, bandwidth: float, like: Motions | None = None) -> Motions:
    """Return a record filtered for sliding and for reversals.

    Where the long filter leaves too little sliding, the short one serves for both.

    Parameters
    ----------
    record : Record
        Of one axis.
    bandwidth : float
        Of the filters at -3 dB, Hz; less where the position is noisy.
    like : Motions, optional
        Whose filters are taken instead.

    Raises
    ------
    ExperimentFailed
        If too little of it moves, for which reasons.
    """
    if like is not None:
        return Motions(*(motion_of(record, bandwidth, like=each) for each in like))
    turning = motion_of(record, bandwidth, still=_STILL_ABOUT_REVERSALS)
    try:
        sliding = motion_of(record, bandwidth)
    except ExperimentFailed:
        return Motions(turning, turning)
    enough = int(sliding.sliding.sum()) >= _ENOUGH
    return Motions(sliding if enough else turning, turning)


def motion_of(
    record: Record, bandwidth: float, *, still: float = _STILL, like: Motion | None = None
) -> Motion:
    """Return a record filtered, and what of it can be used.

    Parameters
    ----------
    record : Record
        Of one axis.
    bandwidth : float
        Of the filter at -3 dB, Hz; less where the position is noisy.
    still : float
        Noise that the acceleration may have, as a share of its RMS.
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
        window = _quiet(raw, missing, noise, Window.of(bandwidth, T), still)
        inner = _inner(window, noise, raw, missing)
    else:
        window, inner = like.window, like.inner
    path, velocity = (filtered_twice(raw, inner, order) for order in (0, 1))
    beside = _widened(missing, 2 * inner.reach)
    slowest = max(_SLOWEST, _NOISES * noise * inner.noise(1))
    rest = _long((np.abs(velocity) <= slowest) & ~beside, round(_REST_SECONDS / T))
    lost = beside | rest
    length = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(path)))])
    memory = length - _last(length, lost) >= LOSS_OF_MEMORY
    sign = np.sign(np.where(np.abs(velocity) > slowest, velocity, 0.0))
    crossing = np.concatenate([[False], velocity[1:] * velocity[:-1] <= 0.0])
    settled = length - _last(length, crossing) >= LOSS_OF_MEMORY
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
        path=path,
        velocity=velocity,
        force=force,
        within=None if record.within is None else np.nan_to_num(record.within),
        lost=lost,
        step=step,
        at=at,
        sliding=sliding[at],
        noise=noise,
        reversals=_reversals(sign),
        shares=shares,
        hidden=0.5 * inner.half**2 * _latest(held)[at * step],
    )


def check_sign(motion: Motion, loc: str, column: str) -> None:
    """Refuse a force whose sign is reversed.

    While it slides, ``f = M a + F_c sign(v) + c v + f_0``, and friction takes power from f.

    Raises
    ------
    ConfigError
        If friction gives power, naming `loc` and the column.
    """
    sliding = motion.sliding
    acceleration, v = (motion.of(motion.position, order)[sliding] for order in (2, 1))
    if min(np.mean(v > 0.0), np.mean(v < 0.0)) < _ONE_WAY:
        return
    force = motion.of(motion.force, 0)[sliding]
    terms = np.stack([np.sign(v), v, acceleration, np.ones(len(v))], axis=1)
    terms /= np.maximum(np.linalg.norm(terms, axis=0), np.finfo(float).tiny)
    sizes = np.linalg.lstsq(terms, force, rcond=None)[0]
    friction, rest = terms[:, :2] @ sizes[:2], force - terms @ sizes
    if friction @ v < 0.0 and np.linalg.norm(rest) < _EXPLAINED * np.linalg.norm(friction):
        message = (
            "acts against the motion, where a force that overcomes friction acts along it: its "
            "sign is reversed; import it turned around, such as by --map 'f=M.x.thrust[-1 N]'"
        )
        raise ConfigError(FieldError(loc, message, column))


def _rms(position: Array, missing: Mask, window: Window, order: int) -> float:
    """Return the RMS of a derivative of the position."""
    derivative = filtered(position, window.kernel(order))[~_widened(missing, window.reach)]
    return float(np.sqrt(np.mean(derivative**2))) if derivative.size else 0.0


def filtered_twice(position: Array, window: Window, order: int) -> Array:
    """Return a smooth derivative without bias up to the third power: ``2 phi - phi*phi``."""
    once = filtered(position, window.kernel(order))
    return 2.0 * once - filtered(once, window.kernel(0))


def _quiet(position: Array, missing: Mask, noise: float, window: Window, still: float) -> Window:
    """Return a window, longer where noise would drown the acceleration, which biases the mass."""
    for longer in np.geomspace(1.0, _LONGEST, 13):
        longer_window = Window(longer * window.half, window.period)
        if noise * longer_window.noise(2) <= still * _rms(position, missing, longer_window, 2):
            return longer_window
    return Window(_LONGEST * window.half, window.period)


def _inner(window: Window, noise: float, position: Array, missing: Mask) -> Window:
    """Return the filter of the motion that the bristle follows, none longer than `window`.

    Its velocity is quiet beside the RMS. About a reversal of acceleration a, noise v of it leaves
    the direction unsure over ``v^2/(2 a)``, and smoothing hides a share of ``a h^2/2``: the sum is
    as small as can be.
    """
    T = window.period
    velocity, acceleration = (filtered(position, window.kernel(order)) for order in (1, 2))
    quiet = _QUIET * _rms(position, missing, window, 1)
    turns = (velocity[1:] * velocity[:-1] <= 0.0) & ~_widened(missing, window.reach)[1:]
    a = np.abs(acceleration[1:][turns])
    a = a[a > _NOISES * noise * window.noise(2)]  # at rest noise alone changes the sign
    least, best = np.inf, window
    for half in np.arange(SHORTEST, window.half / T):
        inner = Window(half * T, T)
        v = noise * inner.noise(1)
        unsure = v * v / (2.0 * a) + _SMOOTHED * 0.5 * inner.half**2 * a
        cost = float(np.mean(unsure**2)) if a.size else 0.0
        if v <= quiet and cost < least:
            least, best = cost, inner
    return best


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
    long = np.zeros(len(mask), dtype=bool)
    for begin, end in zip(edges[::2], edges[1::2], strict=True):
        if end - begin > least:
            long[begin:end] = True
    return long


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
