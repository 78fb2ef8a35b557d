"""Margins of an open loop that is known at some frequencies, with intervals."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

NAMES = ("crossover", "phase_margin", "gain_margin", "gain_reduction")
DRAWS = 400
"""Loops that are drawn for an interval."""
_BETWEEN = 20  # points between two lines


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


def intervals(
    frequency: Array, L: Complex, deviation: Array, seed: int
) -> dict[str, tuple[float, float] | None]:
    """Return the 95 % interval of each margin; None where some drawn loop has no such margin.

    Parameters
    ----------
    frequency, L
        As `measured_margins`.
    deviation : ndarray, shape (lines,)
        Standard deviation of L as a complex number; lines are independent.
    seed : int
        Of the draws.
    """
    rng = np.random.default_rng(seed)
    shape = (2, DRAWS, len(L))
    real, imaginary = rng.standard_normal(shape) * deviation / np.sqrt(2.0)
    margins = [measured_margins(frequency, L + each) for each in real + 1j * imaginary]
    ends: dict[str, tuple[float, float] | None] = {}
    for name in NAMES:
        values = [each[name] for each in margins]
        known = [value for value in values if value is not None]
        low, high = np.quantile(known, [0.025, 0.975]) if known else (0.0, 0.0)
        ends[name] = (float(low), float(high)) if len(known) == DRAWS else None
    return ends
