"""Margins of an open loop that is known at some frequencies, with intervals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.response.estimate import Smaller

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Interval = tuple[float, float]

NAMES = ("crossover", "phase_margin", "gain_margin", "gain_reduction")
DRAWS = 400
"""Loops that are drawn for an interval."""
_BETWEEN = 20  # points between two lines
_FAR = 1.5  # ratio of two frequencies


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


def intervals(
    frequency: Array, L: Complex, deviation: Array, seed: int, smaller: Smaller | None = None
) -> dict[str, Interval | None]:
    """Return the 95 % interval of each margin; None where some drawn loop has no such margin.

    Parameters
    ----------
    frequency, L
        As `measured_margins`.
    deviation : ndarray, shape (lines,)
        Standard deviation of L as a complex number; lines are independent.
    seed : int
        Of the draws.
    smaller : Smaller, optional
        How L differs for a smaller force: the interval is of any force in between.
    """
    rng = np.random.default_rng(seed)
    real, imaginary = rng.standard_normal((2, DRAWS, len(L))) * deviation / np.sqrt(2.0)
    drawn = L + real + 1j * imaginary
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
