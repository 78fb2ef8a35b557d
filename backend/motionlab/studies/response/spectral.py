"""A frequency response from any record, by local polynomials.

About each frequency the excitation's response and what the ends of the record leave are smooth over
frequency, and so are fitted as polynomials over a narrow band of the record's own frequencies
(the local polynomial method: Pintelon and Schoukens, System Identification, 2nd ed., chapter 7).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.response.estimate import Estimate, explained_share

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

ORDERS = 2, 4
"""Of the polynomials; about a peak that is no wider than the band the second is chosen by what is
left."""
BINS_MIN = 8
"""Least frequencies of the record on either side: 17 for 6 unknowns."""
_BAND = 0.015  # share of a frequency to which its band reaches on either side
_SPREAD = 4.0
"""Least number of frequencies over which the excitation in a band is spread. A slow motion to and
fro excites its own harmonics alone, to which friction answers, and just as coherently."""
_MOST = 10.0
"""Largest response of a position to its reference: what answers more was moved by something else,
such as ripple over the pole pitch, which repeats with the motion."""


@dataclass(frozen=True)
class Signals:
    """A record at a constant rate, all of shape (samples,).

    Attributes
    ----------
    excitation : ndarray
        What moves the loop and does not depend on it, such as its reference; the command where
        there is none, whose estimate feedback biases where the coherence is low.
    command, position : ndarray
        N and m.
    period : float
        Between samples, s.
    referred : bool
        Whether `excitation` is the reference of the position.
    """

    excitation: Array
    command: Array
    position: Array
    period: float
    referred: bool


def lines_between(low: float, high: float, count: int, signals: Signals) -> Array:
    """Return frequencies evenly over their logarithm, Hz, about which a record has enough."""
    df = 1.0 / (len(signals.position) * signals.period)
    least = max(low, (BINS_MIN + 1) * df)
    most = min(high, 0.5 / signals.period - (BINS_MIN + 1) * df)
    if most <= least:
        return np.empty(0)
    bins = np.unique(np.round(np.geomspace(least, most, count) / df))
    return np.asarray(bins * df, dtype=np.float64)


def local_estimate(signals: Signals, frequency: Array) -> Estimate:
    """Return the response from command to position at some frequencies of a record.

    Parameters
    ----------
    signals : Signals
        The record.
    frequency : ndarray, shape (lines,)
        Hz, of `lines_between`.
    """
    count = len(signals.position)
    df = 1.0 / (count * signals.period)
    spectra = [
        np.fft.rfft(each - each.mean()) * (2.0 / count)
        for each in (signals.excitation, signals.command, signals.position)
    ]
    most = _MOST if signals.referred else np.inf
    lines = [_about(round(f / df), spectra, most) for f in frequency]
    response, deviation, coherence, free = (np.array(each) for each in zip(*lines, strict=True))
    # The middle of a quadratic over a band counts nine quarters of a single line.
    width = (2 * _half(np.round(frequency / df), len(spectra[0])) + 1) / 2.25
    shared = np.maximum(1.0, width * df / np.gradient(frequency)) if len(frequency) > 1 else None
    return Estimate(response, deviation, deviation, coherence, 2 * int(free.min()), shared=shared)


def _half(k: Array, count: int) -> Array:
    """Return how many frequencies of the record a band has on either side of some."""
    half = np.maximum(BINS_MIN, np.round(_BAND * k))
    return np.minimum(half, np.minimum(k - 1, count - 1 - k))


def _about(k: int, spectra: list[Complex], most: float) -> tuple[complex, float, float, int]:
    """Return response, deviation, coherence, and degrees of freedom about one bin."""
    tried = [_of_order(order, k, spectra, most) for order in ORDERS]
    best = min(tried, key=lambda each: each.criterion)
    return best.response, best.deviation, best.coherence, best.free


class _Local(NamedTuple):
    response: complex
    deviation: float
    coherence: float
    free: int
    criterion: float  # information criterion of Akaike, corrected for few frequencies


def _of_order(order: int, k: int, spectra: list[Complex], most: float) -> _Local:
    R, U, Y = spectra
    half = int(_half(np.array(k), len(Y)))
    here = slice(k - half, k + half + 1)
    powers = (np.arange(-half, half + 1) / half)[:, None] ** np.arange(order + 1)
    design = np.concatenate([R[here, None] * powers, powers], axis=1)
    scale = np.abs(design).max(axis=0)
    free = 2 * half + 1 - design.shape[1]
    if not scale.all():  # nothing moves there
        return _Local(0j, np.inf, 0.0, free, np.inf)
    inverse = np.linalg.pinv(design / scale)
    both = np.stack([U[here], Y[here]], axis=1)
    rest = both - (design / scale) @ (inverse @ both)
    G_u, G_y = (inverse @ both)[0] / scale[0]
    # What of the excitation is not smooth over frequency: the ends of any motion are.
    sharp = R[here] - powers @ (np.linalg.pinv(powers) @ R[here])
    power = np.abs(sharp) ** 2
    spread = power.sum() ** 2 / max(float((power**2).sum()), 1e-300)
    if G_u == 0.0 or abs(G_y) > most or spread < _SPREAD:
        return _Local(0j, np.inf, 0.0, free, np.inf)
    response = G_y / G_u
    variance = float((np.abs(rest[:, 1] - response * rest[:, 0]) ** 2).sum() / free)
    size = float((np.abs(inverse[0]) ** 2).sum()) / scale[0] ** 2
    power = 1.0 / (size * (2 * half + 1))
    own = float((np.abs(rest[:, 0]) ** 2).sum() / free)
    coherence = min(explained_share(G_y, power, variance), explained_share(G_u, power, own))
    deviation = float(np.sqrt(variance * size) / np.abs(G_u))
    parts, numbers = 2 * (2 * half + 1), 2 * design.shape[1]  # real ones
    spent = 2.0 * numbers * parts / max(1, parts - numbers - 1)
    criterion = parts * np.log(max(variance * free, 1e-300)) + spent
    return _Local(complex(response), deviation, coherence, free, float(criterion))
