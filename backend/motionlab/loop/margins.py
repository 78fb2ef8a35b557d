"""Margins of a sampled loop, read off its open-loop frequency response."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Response = Callable[[Array], Complex]

NYQUIST = 0.5 / CONTROL_PERIOD
"""Hz"""

_LOWEST = 0.05
GRID = np.geomspace(_LOWEST, NYQUIST * (1.0 - 1e-6), 1000)
_NEXT, _HALVINGS = 0.2, 8
"""Share by which L may change between neighbouring frequencies, and how often a gap is halved."""


MEANINGS = {
    "crossover": "highest frequency at which abs(L) = 1, Hz",
    "phase_margin": "smallest distance of arg L from -180 degrees where abs(L) = 1, rad",
    "gain_margin": "smallest factor > 1 by which the gain may grow to the stability boundary",
    "gain_reduction": "largest factor < 1 to which the gain may fall before the stability boundary",
    "Ms": "largest abs(1/(1 + L)): peak of the sensitivity",
    "bandwidth": "frequency at which abs(L/(1 + L)) falls for good below 1/sqrt(2), Hz",
}
"""Of each margin of the open loop L."""


@dataclass(frozen=True)
class Margins:
    """Stability margins of a loop; None where it has no such crossing.

    Attributes
    ----------
    crossover : float or None
        Highest frequency at which abs(L) = 1, Hz.
    phase_margin : float or None
        Smallest distance of arg L from -180 degrees where abs(L) = 1, rad.
    gain_margin : float or None
        Smallest factor > 1 by which the gain may grow to the stability boundary.
    gain_reduction : float or None
        Largest factor < 1 to which the gain may fall before the stability boundary.
    Ms : float
        Largest abs(1/(1 + L)): peak of the sensitivity.
    bandwidth : float or None
        Frequency at which abs(L/(1 + L)) falls for good below 1/sqrt(2), Hz.
    """

    crossover: float | None
    phase_margin: float | None
    gain_margin: float | None
    gain_reduction: float | None
    Ms: float
    bandwidth: float | None


def margins(response: Response) -> Margins:
    """Return the margins of a loop whose open-loop response is `response`.

    Parameters
    ----------
    response : callable
        Frequencies (n,), Hz, to L (n,); closed by negative feedback.

    Returns
    -------
    Margins
        Looked for from 0.05 Hz to half the control rate, closely about a resonance.
    """
    grid, L = sampled(response)
    crossings = _roots(response, grid, L, lambda value: np.abs(value) - 1.0)
    turns = _roots(response, grid, L, lambda value: value.imag)
    closed = _roots(response, grid, L, lambda value: np.abs(value / (1.0 + value)) - math.sqrt(0.5))
    phases = [float(abs(np.angle(-response(np.array([f]))[0]))) for f in crossings]
    gains = [  # where arg L is 180 degrees: the other sign changes lie right of the origin
        float(abs(value)) for f in turns if (value := response(np.array([f]))[0]).real < 0.0
    ]
    return Margins(
        crossover=max(crossings, default=None),
        phase_margin=min(phases, default=None),
        gain_margin=min((1.0 / gain for gain in gains if gain < 1.0), default=None),
        gain_reduction=max((1.0 / gain for gain in gains if gain > 1.0), default=None),
        Ms=float((1.0 / np.abs(1.0 + L)).max()),
        bandwidth=max(closed, default=None),
    )


def sampled(response: Response, grid: Array = GRID, change: float = _NEXT) -> tuple[Array, Complex]:
    """Return frequencies, Hz, and L there: those of `grid`, and more where a mode is narrow.

    Parameters
    ----------
    response : callable
        As `margins` takes it, or frequencies (n,) to several loops, (..., n).
    grid : ndarray, shape (n,)
        Frequencies to begin with, Hz.
    change : float
        Share by which L may change between neighbours; a gap is halved until it does not.
    """
    L = response(grid)
    for _ in range(_HALVINGS):
        least = np.minimum(np.abs(L[..., 1:]), np.abs(L[..., :-1]))
        coarse = np.abs(np.diff(L)) > change * least
        wide = np.flatnonzero(coarse.reshape(-1, len(grid) - 1).any(axis=0))
        if len(wide) == 0:
            break
        between = np.sqrt(grid[wide] * grid[wide + 1])
        L = np.insert(L, wide + 1, response(between), axis=-1)
        grid = np.insert(grid, wide + 1, between)
    return grid, L


def _roots(
    response: Response, grid: Array, L: Complex, measure: Callable[[Complex], Array]
) -> list[float]:
    """Return the frequencies at which a real measure of L, known on the grid, changes sign, Hz."""
    from scipy.optimize import brentq

    values = measure(L)
    places = np.flatnonzero(np.sign(values[1:]) * np.sign(values[:-1]) < 0)

    def at(frequency: float) -> float:
        return float(measure(response(np.array([frequency])))[0])

    roots = [brentq(at, grid[k], grid[k + 1], xtol=1e-9) for k in places]
    return [float(root) for root in roots]  # pyright: ignore[reportArgumentType]
