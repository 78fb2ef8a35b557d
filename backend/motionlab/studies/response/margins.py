"""Margins of an open loop that is known at some frequencies, with intervals."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.response.documents import FittedPlant, MarginInterval
from motionlab.studies.response.estimate import Estimate, Smaller

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Interval = tuple[float, float]

NAMES = ("crossover", "phase_margin", "gain_margin", "gain_reduction")
DRAWS = 400
"""Loops that are drawn for an interval."""
_BETWEEN = 20  # points between two lines
_FAR = 1.5  # ratio of two frequencies
BESIDE = 1.2
"""Factor to either side of a mode within which a plant is refined."""


def _between(frequency: Array, L: Complex) -> tuple[Array, Array, Array]:
    """Return log of frequencies, log of the magnitude and phase, between lines too.

    Between two both follow a line over the logarithm of the frequency.
    """
    log_f = np.log(frequency)
    fine = np.interp(
        np.arange(_BETWEEN * (len(log_f) - 1) + 1) / _BETWEEN, np.arange(len(log_f)), log_f
    )
    size = np.interp(fine, log_f, np.log(np.abs(L)))
    return fine, size, np.interp(fine, log_f, np.unwrap(np.angle(L)))


def crossings(frequency: Array, L: Complex) -> list[tuple[float, float]]:
    """Return every crossover of a measured open loop, Hz, and its phase margin, rad."""
    fine, size, phase = _between(frequency, L)
    there = _roots(fine, size)
    margins = np.abs(np.angle(-np.exp(1j * np.interp(there, fine, phase))))
    return list(zip(np.exp(there).tolist(), margins.tolist(), strict=True))


def measured_margins(frequency: Array, L: Complex) -> dict[str, float | None]:
    """Return crossover, Hz, phase margin, rad, and gain margins of a measured open loop.

    As `motionlab.loop.margins` has them, of the frequencies that were measured: the highest
    crossover, and the least phase margin of all.
    """
    fine, size, phase = _between(frequency, L)
    crossed = crossings(frequency, L)
    turns = _roots(fine, np.sin(phase))
    there = np.interp(turns, fine, size)[np.cos(np.interp(turns, fine, phase)) < 0.0]
    above, below = there[there < 0.0], there[there > 0.0]
    return {
        "crossover": crossed[-1][0] if crossed else None,
        "phase_margin": min(margin for _, margin in crossed) if crossed else None,
        "gain_margin": float(np.exp(-above.max())) if above.size else None,
        "gain_reduction": float(np.exp(-below.min())) if below.size else None,
    }


def _roots(x: Array, y: Array) -> Array:
    """Return where a line through points crosses zero."""
    k = np.flatnonzero(np.sign(y[1:]) * np.sign(y[:-1]) < 0)
    return x[k] - y[k] * (x[k + 1] - x[k]) / (y[k + 1] - y[k])


def refined(
    frequency: Array, plant: Complex, deviation: Array, fitted: FittedPlant | None
) -> tuple[Array, Complex, Array]:
    """Return a measured plant with further frequencies about modes.

    There a straight line would miss the mode, or what a notch makes of it. Between two lines the
    ratio to the fitted model, not the plant, follows a straight line.

    Parameters
    ----------
    frequency, plant, deviation : ndarray, shape (lines,)
        Hz, m/N, and the standard deviation of the plant as a complex number.
    fitted : FittedPlant, optional
        Its model; nothing is added without one.
    """
    if fitted is None:
        return frequency, plant, deviation
    fine = np.array(fitted.loop.frequency)
    model = np.array(fitted.plant.magnitude) * np.exp(1j * np.array(fitted.plant.phase))

    apart = np.abs(fine[:, None] / frequency - 1.0)
    at_lines = model[apart.argmin(axis=0)]  # which the model has, too
    modes = np.array([mode.frequency.value for mode in fitted.modes])
    beside = (np.abs(np.log(fine / modes[:, None])) < math.log(BESIDE)).any(axis=0)
    added = beside & (fine > frequency[0]) & (fine < frequency[-1]) & (apart.min(axis=1) > 1e-6)
    P = (model * _along(fine, frequency, plant / at_lines))[added]
    share = np.interp(np.log(fine), np.log(frequency), deviation / np.abs(plant))[added]
    order = np.argsort(every := np.concatenate([frequency, fine[added]]))
    plants, deviations = np.concatenate([plant, P]), np.concatenate([deviation, share * np.abs(P)])
    return every[order], plants[order], deviations[order]


def own_margins(
    own: tuple[Array, Estimate], lines: Array, fine: Array, L: Complex, seed: int
) -> dict[str, MarginInterval]:
    """Return margins of a loop that was measured as a whole, beside those of `L`.

    Parameters
    ----------
    own : (ndarray, Estimate)
        Its frequencies, Hz, and the loop there.
    lines, fine : ndarray
        Frequencies at which the plant of `L` was measured, and those with what `refined` adds:
        there the loop is to `L` as on either side.
    L : ndarray of complex, shape (fine,)
        Another open loop.
    seed : int
        As `intervals`.
    """
    f, of_loop = own
    there = measured_margins(fine, L)
    both, between = np.isin(f, fine), ~np.isin(fine, lines)
    ratio = of_loop.response[both] / L[np.isin(fine, f)]
    added = L[between] * _along(fine[between], f[both], ratio)
    order = np.argsort(every := np.concatenate([f, fine[between]]))
    every, loop = every[order], np.concatenate([of_loop.response, added])[order]
    share = np.interp(np.log(every), np.log(f), of_loop.deviation / np.abs(of_loop.response))
    here = measured_margins(every, loop)
    spread = intervals(every, loop, share * np.abs(loop), seed, lines=np.isin(every, f))
    return {
        name: MarginInterval(value=here[name], interval=spread[name], model=there[name])
        for name in NAMES
    }


def _along(fine: Array, frequency: Array, values: Complex) -> Complex:
    """Return values between frequencies, on straight lines over the logarithm of them."""
    at, log_f = np.log(fine), np.log(frequency)
    size = np.interp(at, log_f, np.log(np.abs(values)))
    return np.exp(size + 1j * np.interp(at, log_f, np.unwrap(np.angle(values))))


def far_apart(frequency: Array, L: Complex) -> list[str]:
    """Return a note where L crosses 1, or -180 degrees, between lines that lie far apart."""
    fine, size, phase = _between(frequency, L)
    turns = _roots(fine, np.sin(phase))
    turns = turns[np.cos(np.interp(turns, fine, phase)) < 0.0]
    places = np.exp(np.concatenate([_roots(fine, size), turns]))
    k = np.searchsorted(frequency, places, side="right").clip(1, len(frequency) - 1)
    steps = frequency[k] / frequency[k - 1]
    if not (steps > _FAR).any():
        return []
    at = k[int(steps.argmax())]
    return [
        f"a margin lies between {frequency[at - 1]:.3g} and {frequency[at]:.3g} Hz, far apart: its "
        "interval does not hold by how much a straight line is wrong between the two"
    ]


def intervals(  # noqa: PLR0913, PLR0917 - what is known of a loop
    frequency: Array,
    L: Complex,
    deviation: Array,
    seed: int,
    smaller: Smaller | None = None,
    lines: NDArray[np.bool_] | None = None,
) -> dict[str, Interval | None]:
    """Return the 95 % interval of each margin; None where some drawn loop has no such margin.

    Parameters
    ----------
    frequency, L
        As `measured_margins`.
    deviation : ndarray, shape (lines,)
        Standard deviation of L as a complex number.
    seed : int
        Of the draws.
    smaller : Smaller, optional
        How L differs for a smaller force: the interval is of any force in between.
    lines : ndarray of bool, optional
        Which of the frequencies were measured, all if left out: they are independent, and the
        others are wrong by a share between those of their neighbours.
    """
    rng = np.random.default_rng(seed)
    lines = np.ones(len(L), bool) if lines is None else lines
    share = (deviation / np.abs(L))[lines] / np.sqrt(2.0)
    real, imaginary = rng.standard_normal((2, DRAWS, len(share))) * share
    log_f = np.log(frequency)
    between = np.array([np.interp(log_f, log_f[lines], unit) for unit in np.eye(len(share))])
    drawn = L * (1.0 + (real + 1j * imaginary) @ between)
    ends = _ends(frequency, drawn)
    if smaller is None:
        return ends
    real, imaginary = rng.standard_normal((2, DRAWS, 1)) * smaller.error / np.sqrt(2.0)
    others = _ends(frequency, (smaller.ratio + real + 1j * imaginary) * drawn)
    return {name: _union(ends[name], others[name]) for name in NAMES}


def _union(a: Interval | None, b: Interval | None) -> Interval | None:
    return None if a is None or b is None else (min(a[0], b[0]), max(a[1], b[1]))


def _ends(frequency: Array, drawn: Complex) -> dict[str, Interval | None]:
    """Return the 95 % interval of each margin of drawn loops, shape (draws, lines)."""
    margins = [measured_margins(frequency, each) for each in drawn]
    ends: dict[str, Interval | None] = {}
    for name in NAMES:
        values = [each[name] for each in margins]
        known = [value for value in values if value is not None]
        low, high = np.quantile(known, [0.025, 0.975]) if known else (0.0, 0.0)
        ends[name] = (float(low), float(high)) if len(known) == DRAWS else None
    return ends
