r"""Spectrum of a stretch of samples: one-sided density, amplitude, cumulative RMS, peaks.

The mean is taken off once. K segments of L samples, half of each shared with the next (Welch 1967,
doi 10.1109/TAU.1967.1161901), are weighted by a window w, transformed and averaged::

    S_k = c_k <|X_k|^2> / (f_s sum w^2),   c_k = 2, or 1 at half the rate

B = f_s sum w^2 / (sum w)^2 is the noise bandwidth: a sine of amplitude A in the middle of a bin has
A^2/2 = S_k B.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import NormalDist
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError

Array = NDArray[np.float64]
Window = Literal["hann", "rectangular", "blackman-harris", "flat-top"]

_COSINES: dict[Window, tuple[float, ...]] = {
    "rectangular": (1.0,),
    "hann": (0.5, 0.5),
    "blackman-harris": (0.35875, 0.48829, 0.14128, 0.01168),
    "flat-top": (0.21557895, 0.41663158, 0.277263158, 0.083578947, 0.006947368),
}
"""Coefficients of the cosines of each window, whose signs alternate (Harris 1978,
doi 10.1109/PROC.1978.10837). Their number is half the width of its main lobe in bins."""

SEGMENT_LEAST = 64
"""Least samples of a segment."""

AVERAGES_MAX = 1000
"""Most segments."""

PEAKS_MAX = 20
"""Most peaks of a spectrum, the strongest."""

_CHANCE = 1e-3
"""Probability that noise alone has a bin that is called a line."""
_BLOCK = 33
"""Bins whose median is the level of the noise there."""
_AROUND = 10
"""Bins on either side of a line that have less power above the noise than the line itself."""
_BANDS = 12
"""Bands of an octave in which broad peaks are looked for."""
_BAND_BINS = 32
"""Least bins of a band, over all segments: chance changes its mean by less than 3 dB."""
_PROMINENT = 4.0
"""Ratio of power, 6 dB, by which a broad peak stands above the valleys on either side."""
_SURROUNDINGS = 2.0
"""A peak is compared with what lies within an octave of it, on either side."""


@dataclass(frozen=True)
class Spectrum:
    """A spectrum, from one resolution up to half the rate of the samples.

    Attributes
    ----------
    frequency : ndarray, shape (bins,)
        Hz, evenly spaced.
    density : ndarray, shape (bins,)
        Power spectral density, one-sided, unit^2/Hz.
    amplitude : ndarray, shape (bins,)
        Peak value that a sine in the middle of a bin would have, unit.
    rms : float
        Of the samples without their mean, unit.
    window : str
        Window function.
    averages, segment : int
        Segments, and samples of each.
    resolution, noise_bandwidth : float
        Distance of the bins, and B, Hz.
    """

    frequency: Array
    density: Array
    amplitude: Array
    rms: float
    window: Window
    averages: int
    segment: int
    resolution: float
    noise_bandwidth: float

    @property
    def cumulative(self) -> Array:
        """RMS of all that lies at each frequency or below; the last value is `rms`.

        It is the root of the sum of density times resolution. A window weighs the samples, so this
        sum is their mean square only on average: all values are scaled by one factor that makes the
        last one right. For the rectangular window and one segment the factor is 1 (Parseval).
        """
        power = np.cumsum(self.density)
        return self.rms * np.sqrt(power / power[-1]) if power[-1] > 0.0 else power


class Peak(NamedTuple):
    """A peak of a spectrum.

    Attributes
    ----------
    frequency : float
        Interpolated between bins, or bands, Hz.
    density : float
        At its highest bin, or band, unit^2/Hz.
    rms : float
        Of the bins of a line without the noise below, or of the bands of a broad peak above half
        its density, unit.
    narrow : bool
        A line, as narrow as the window resolves; otherwise broad.
    """

    frequency: float
    density: float
    rms: float
    narrow: bool


class Bands(NamedTuple):
    """A spectrum without its lines, averaged over bands of frequency: Hz and unit^2/Hz."""

    frequency: Array
    density: Array
    width: Array


def longest_whole(samples: Array) -> slice:
    """Return the longest stretch without a missing sample, the first of several."""
    ends = np.flatnonzero(np.diff(np.isfinite(samples), prepend=False, append=False))
    if len(ends) == 0:
        return slice(0, 0)
    starts, stops = ends[::2], ends[1::2]
    k = int(np.argmax(stops - starts))
    return slice(int(starts[k]), int(stops[k]))


def spectrum(samples: Array, *, period: float, window: Window, averages: int) -> Spectrum:
    """Return the spectrum of some samples.

    Parameters
    ----------
    samples : ndarray, shape (n,)
        None of them missing.
    period : float
        Time between them, s.
    window : str
        Window function, periodic.
    averages : int
        Segments, of which each shares half with the next; 1 is the whole stretch. Several are as
        long as they can be without a prime factor above 5, with which a transform takes four times
        as long: up to some per cent of the samples at the end are left out.

    Raises
    ------
    ConfigError
        If there are fewer than 64 samples in a segment.
    """
    count = len(samples)
    if count < SEGMENT_LEAST:
        least: dict[str, float] = {"minimum": SEGMENT_LEAST}
        raise ConfigError(
            FieldError(
                "samples", "too few without a missing one for a spectrum", count, bounds=least
            )
        )
    segment = count if averages == 1 else _smooth(2 * (count // (averages + 1)))
    if segment < SEGMENT_LEAST:
        most: dict[str, float] = {"maximum": 2 * count // SEGMENT_LEAST - 1}
        message = f"leaves segments of fewer than {SEGMENT_LEAST} samples"
        raise ConfigError(FieldError("averages", message, averages, bounds=most))
    values = samples - samples.mean()
    weight = _weights(window, segment)
    power = np.zeros(segment // 2 + 1)
    for k in range(averages):
        first = k * segment // 2
        transform = np.fft.rfft(weight * values[first : first + segment])
        power += transform.real**2 + transform.imag**2
    area, energy = float(weight.sum()), float((weight**2).sum())
    power = power[1:] * (2.0 / averages)
    amplitude = np.sqrt(2.0 * power) / area
    if segment % 2 == 0:  # half the rate has no image at a negative frequency
        power[-1] /= 2.0
        amplitude[-1] /= 2.0
    resolution = 1.0 / (segment * period)
    return Spectrum(
        frequency=resolution * np.arange(1.0, len(power) + 1.0),
        density=power * (period / energy),
        amplitude=amplitude,
        rms=float(np.sqrt(np.mean(values**2))),
        window=window,
        averages=averages,
        segment=segment,
        resolution=resolution,
        noise_bandwidth=energy / (period * area**2),
    )


def _smooth(count: int) -> int:
    """Return the largest even number up to a count whose prime factors are 2, 3 and 5."""
    for even in range(count - count % 2, SEGMENT_LEAST, -2):
        rest = even
        for factor in (2, 3, 5):
            while rest % factor == 0:
                rest //= factor
        if rest == 1:
            return even
    return count


def _weights(window: Window, count: int) -> Array:
    phase = 2.0 * np.pi * np.arange(count) / count
    terms = enumerate(_COSINES[window])
    return np.sum([(-1.0) ** k * a * np.cos(k * phase) for k, a in terms], axis=0)


def peaks(density: Spectrum) -> tuple[list[Peak], Bands]:
    """Return the peaks that stand out, and the bands of the spectrum without its lines.

    A line is a bin above both neighbours and all noise (chance of one in a thousand for the whole
    spectrum, from the median of 33 bins) whose window holds more than half of the power above the
    noise within 10 bins on either side. A broad peak is a maximum of the bands, a twelfth of an
    octave or 32 bins wide, 6 dB above the valleys on either side.

    Returns
    -------
    list of Peak
        The strongest by RMS, at most 20, in order of frequency.
    Bands
        Where nothing is but lines, no band.
    """
    lines, rest = _lines(density)
    bands = _bands(density, rest)
    every = sorted([*lines, *_broad(bands)], key=lambda peak: -peak.rms)[:PEAKS_MAX]
    return sorted(every), bands


def _lines(density: Spectrum) -> tuple[list[Peak], NDArray[np.bool_]]:
    """Return the lines, and which bins belong to none."""
    S, df = density.density, density.resolution
    lobe = len(_COSINES[density.window])
    rest = np.ones(len(S), dtype=bool)
    # Segments that share half of their samples count for at least those that share none.
    degrees = (density.averages + 1) / 2
    noise = _noise(S) / _share(0.5, degrees)
    high = _share(1.0 - _CHANCE / len(S), degrees) * noise
    top = (S > high) & (S >= np.append(S[1:], 0.0)) & (S >= np.append(np.inf, S[:-1]))
    above = np.maximum(S - noise, 0.0)
    lines: list[Peak] = []
    candidates = np.flatnonzero(top)
    for k in candidates[np.argsort(-S[candidates])].tolist():
        if not rest[k]:
            continue
        own = slice(max(0, k - lobe), k + lobe + 1)
        around = slice(max(0, k - _AROUND), k + _AROUND + 1)
        power = float((above[own] * rest[own]).sum())
        if power <= 0.5 * float((above[around] * rest[around]).sum()):
            continue
        rest[own] = False
        place = density.frequency[k] + df * _vertex(S[max(0, k - 1) : k + 2])
        lines.append(Peak(float(place), float(S[k]), math.sqrt(power * df), narrow=True))
    return lines, rest


def _noise(S: Array) -> Array:
    """Return the median of blocks of bins, interpolated between their middles."""
    size = min(_BLOCK, len(S))
    blocks = len(S) // size
    medians = np.median(S[: blocks * size].reshape(blocks, size), axis=1)
    return np.interp(np.arange(len(S)), size * (np.arange(blocks) + 0.5), medians)


def _share(probability: float, degrees: float) -> float:
    """Return a quantile of chi squared of 2 K degrees over its mean (Wilson and Hilferty 1931)."""
    spread = 1.0 / (9.0 * degrees)
    return (1.0 - spread + NormalDist().inv_cdf(probability) * math.sqrt(spread)) ** 3


def _vertex(three: Array) -> float:
    """Return the offset from the middle of the vertex of the parabola through three logarithms."""
    if len(three) < 3 or (three <= 0.0).any():
        return 0.0
    low, middle, high = np.log(three)
    bend = 2.0 * middle - low - high
    return 0.5 * float((high - low) / bend) if bend > 0.0 else 0.0


def _bands(density: Spectrum, rest: NDArray[np.bool_]) -> Bands:
    S, df = density.density, density.resolution
    least = max(4, math.ceil(_BAND_BINS / density.averages))
    ratio = 2.0 ** (1.0 / _BANDS)
    edges = [0]
    while edges[-1] + least <= len(S):
        last = edges[-1]
        edges.append(min(max(last + least, round((last + 1) * ratio) - 1), len(S)))
    starts = np.array(edges[:-1], dtype=int)
    if len(starts) == 0:
        return Bands(np.zeros(0), np.zeros(0), np.zeros(0))
    bins = np.diff(edges).astype(np.float64)
    S, rest = S[: edges[-1]], rest[: edges[-1]]
    count = np.add.reduceat(rest.astype(float), starts)
    total = np.add.reduceat(np.where(rest, S, 0.0), starts)
    kept = (count > 0) & (total > 0.0)
    middle = df * np.sqrt((starts + 1.0) * (starts + bins))
    return Bands(middle[kept], total[kept] / count[kept], df * bins[kept])


def _broad(bands: Bands) -> list[Peak]:
    level = bands.density
    humps: list[Peak] = []
    for k in range(1, len(level) - 1):
        if not level[k - 1] < level[k] >= level[k + 1]:
            continue
        higher = np.flatnonzero(level > level[k])
        left = int(higher[higher < k].max(initial=-1)) + 1
        right = int(higher[higher > k].min(initial=len(level)))
        valley = max(level[left:k].min(initial=level[k]), level[k + 1 : right].min())
        if level[k] < _PROMINENT * valley:
            continue
        below = np.flatnonzero(level < 0.5 * level[k])
        first, stop = below[below < k].max(initial=-1) + 1, below[below > k].min(initial=len(level))
        power = float((level[first:stop] * bands.width[first:stop]).sum())
        step = math.log(bands.frequency[k + 1] / bands.frequency[k - 1]) / 2.0
        place = bands.frequency[k] * math.exp(step * _vertex(level[k - 1 : k + 2]))
        humps.append(Peak(float(place), float(level[k]), math.sqrt(power), narrow=False))
    return humps


def level(bands: Bands, shape: Array, floor: Array) -> float:
    """Return the density d for which ``d shape + floor`` explains the median of the bands.

    Parameters
    ----------
    bands : Bands
        Of a spectrum.
    shape, floor : ndarray, shape (bands,)
        Squared response, and density that is known beforehand, at their frequencies. Only bands
        count whose shape is no more than 20 dB below its largest value.
    """
    if len(shape) == 0:
        return 0.0
    near = shape >= 0.01 * shape.max()
    return max(0.0, float(np.median((bands.density[near] - floor[near]) / shape[near])))


def decibels_above(peak: Peak, bands: Bands, expected: Array, at_peak: float) -> float | None:
    """Return the rise of a peak above its surroundings beyond what noise explains, dB.

    The expected density is scaled to the median of the bands within an octave; None without any.

    Parameters
    ----------
    peak : Peak
        From `peaks`.
    bands : Bands
        As well.
    expected : ndarray, shape (bands,)
        Expected density at the frequencies of the bands, up to a factor.
    at_peak : float
        The same at the peak.
    """
    ratio = bands.frequency / peak.frequency
    near = (ratio > 1.0 / _SURROUNDINGS) & (ratio < _SURROUNDINGS) & (expected > 0.0)
    if not near.any() or at_peak <= 0.0:
        return None
    scale = float(np.median(bands.density[near] / expected[near]))
    return 10.0 * math.log10(peak.density / (scale * at_peak))


def thinned(density: Array, frequency: Array, points: int) -> NDArray[np.intp]:
    """Return the bins to draw: least and largest of equal steps of the logarithm of frequency.

    Parameters
    ----------
    density, frequency : ndarray, shape (bins,)
        A spectrum or part of it.
    points : int
        Bins at most; all of them where there are no more.
    """
    if len(frequency) <= points:
        return np.arange(len(frequency))
    edges = np.geomspace(frequency[0], frequency[-1], max(1, points // 2) + 1)[1:-1]
    step = np.searchsorted(edges, frequency, side="right")
    chosen = []
    first = np.flatnonzero(np.diff(step, prepend=-1))
    lengths = np.diff(np.append(first, len(step)))
    for extreme in (np.minimum, np.maximum):
        at_end = density == np.repeat(extreme.reduceat(density, first), lengths)
        places = np.flatnonzero(at_end)
        chosen.append(places[np.unique(step[places], return_index=True)[1]])
    return np.unique(np.concatenate(chosen))
