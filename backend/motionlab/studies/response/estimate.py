"""A frequency response from repeated periods and repeated realisations of a multisine.

With the excitation R, command U and position Y, all as complex amplitudes at one line, the indirect
method divides ``Y = G_y R`` by ``U = G_u R``, so that feedback leaves no bias. Periods of one slide
differ by noise alone; slides, whose phases are drawn anew, by what is not linear as well (the
robust method of Pintelon and Schoukens, System Identification, 2nd ed., chapter 4). What slides in
one direction have in common besides R, such as ripple over the pole pitch, is fitted as a constant.
Where ripple changes from period to period, and periods do not show noise alone, a slide without an
excitation tells the noise. Slides of a smaller excitation tell whether the response depends on it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Quiet:
    """What a slide without excitation shows about each line.

    Attributes
    ----------
    command, position : ndarray of complex, shape (bins, lines)
        Amplitudes at the frequencies of the whole slide next to the line, N and m.
    """

    command: Complex
    position: Complex

    @classmethod
    def about(cls, bins: NDArray[np.int64], command: Array, position: Array) -> Quiet:
        """Return it of the columns of a slide: `bins` are the lines' cycles in all of it."""
        near = int(bins.min())  # not the mean, with the place of the slide
        here = bins + np.arange(1 - near, near)[:, None]
        U, Y = (np.fft.rfft(each) * (2.0 / len(each)) for each in (command, position))
        return cls(U[here], Y[here])


@dataclass(frozen=True)
class Slides:
    """What was measured at each line of each slide.

    Attributes
    ----------
    excitation : ndarray of complex, shape (slides, lines)
        R.
    command, position : ndarray of complex, shape (slides, periods, lines)
        U, N, and Y, m.
    forward : ndarray of bool, shape (slides,)
        Direction of each slide.
    quiet : Quiet, optional
        Noise; without it that of the periods.
    smaller : ndarray of bool, shape (slides,), optional
        Slides that do not count for the response, since their excitation is smaller.
    """

    excitation: Complex
    command: Complex
    position: Complex
    forward: NDArray[np.bool_]
    quiet: Quiet | None = None
    smaller: NDArray[np.bool_] | None = None


@dataclass(frozen=True)
class Smaller:
    """How the response to a smaller excitation differs, in the mean of all lines.

    Attributes
    ----------
    ratio : complex
        Of that response to the other.
    error : float
        Its standard error as a complex number; grows with the scatter of lines.
    """

    ratio: complex
    error: float

    @classmethod
    def mean(cls, ratios: Complex, deviations: Array) -> Smaller:
        """Return it of the ratios of all lines, and their standard deviations."""
        weights = deviations**-2.0
        ratio = complex(np.average(ratios, weights=weights))
        scatter = np.average(np.abs(ratios - ratio) ** 2 / deviations**2)
        return cls(ratio, float(np.sqrt(max(1.0, scatter) / weights.sum())))


@dataclass(frozen=True)
class Estimate:
    """A response and how sure it is, all of shape (lines,).

    Attributes
    ----------
    response : ndarray of complex
        Y/U.
    deviation : ndarray
        Standard deviation of the response, as a complex number, from the slides.
    noise : ndarray
        That part of it which is there without distortion.
    coherence : ndarray
        Share of the position's power among slides that the response explains, or of the command's
        that the excitation does where that is less.
    freedom : int
        Degrees of freedom of `deviation`.
    smaller : Smaller, optional
        What a smaller excitation changes, where slides show that.
    shared : ndarray, optional
        Of how many lines in the mean each has its noise, where lines share some.
    """

    response: Complex
    deviation: Array
    noise: Array
    coherence: Array
    freedom: int
    smaller: Smaller | None = None
    shared: Array | None = None

    @property
    def half_width(self) -> Array:
        """Half of the 95 % interval of the magnitude; of the phase it is this over magnitude."""
        factor = float(student.ppf(0.5 + 0.5 * CONFIDENCE, self.freedom))
        return factor * self.deviation / np.sqrt(2.0)


def estimate(slides: Slides, around: Sequence[tuple[int, int]] | None = None) -> Estimate:
    """Return the response from command to position.

    Parameters
    ----------
    slides : Slides
        At least two more than directions, of at least two periods.
    around : sequence of (int, int), optional
        Which lines are estimated, and how many on either side of each tell it, too, over which both
        responses to the excitation are polynomials of frequency; each line by itself if left out.
    """
    common = np.stack([slides.forward, ~slides.forward], axis=1).astype(np.float64)
    common = common[:, common.any(axis=0)]
    if around is None:
        around = [(k, 0) for k in range(slides.excitation.shape[1])]
    columns = [_line(slides, common, k, half) for k, half in around]
    response, deviation, noise, coherence, free, ratio, doubt = map(
        np.array, zip(*columns, strict=True)
    )
    smaller = None if slides.smaller is None else Smaller.mean(ratio, doubt)
    return Estimate(response, deviation, noise, coherence, 2 * int(free.min()), smaller)


def _line(
    slides: Slides, common: Array, k: int, half: int
) -> tuple[complex, float, float, float, int, complex, float]:
    """Return response, deviation, noise as it is in it, coherence, and degrees of freedom.

    Then the ratio of the response to a smaller excitation, and its deviation.
    """
    here = slice(k - half, k + half + 1)
    means = slides.command[:, :, here].mean(axis=1), slides.position[:, :, here].mean(axis=1)
    smaller = np.zeros(len(common), bool) if slides.smaller is None else slides.smaller
    excitation = slides.excitation[:, here]
    apart = np.stack([excitation, *means, excitation * smaller[:, None]])
    apart -= common @ (np.linalg.pinv(common) @ apart)
    powers = (np.arange(-half, half + 1) / max(half, 1))[:, None] ** np.arange(min(half, 2) + 1)
    R, U, Y, more = (each.ravel() for each in apart)
    design = (apart[0][..., None] * powers).reshape(len(R), -1)
    if smaller.any():
        design = np.column_stack([design, more])
    inverse = np.linalg.pinv(design)
    size = float((np.abs(inverse[0]) ** 2).sum())
    of_u, of_y = inverse @ U, inverse @ Y
    response = of_y[0] / of_u[0]
    rest = (Y - design @ of_y) - response * (U - design @ of_u)  # noise, and what is not linear
    free = len(R) - design.shape[1] - (2 * half + 1) * common.shape[1]
    variance = float((np.abs(rest) ** 2).sum()) / free
    if slides.quiet is None:
        of_periods = slides.position[:, :, k] - response * slides.command[:, :, k]
        of_noise = of_periods.var(axis=1, ddof=1).mean() / of_periods.shape[1]
    else:
        silent = slides.quiet.position[:, k] - response * slides.quiet.command[:, k]
        of_noise = np.median(np.abs(silent) ** 2) / np.log(2.0)  # single bins have ripple
    scale = size / np.abs(of_u[0]) ** 2
    power = float(np.mean(np.abs(slides.excitation[~smaller, k]) ** 2))
    own = float((np.abs(U - design @ of_u) ** 2).sum()) / free
    # Where feedback makes the command of noise, P is -1/C, which explains that noise: U counts too.
    coherence = min(explained_share(of_y[0], power, variance), explained_share(of_u[0], power, own))
    ratio, apart_from = complex(1.0), 0.0
    if smaller.any():
        command = of_u[0] + of_u[-1]
        ratio = (of_y[0] + of_y[-1]) / command / response
        rows = (inverse[0] + inverse[-1]) / command - inverse[0] / of_u[0]
        apart_from = float(np.linalg.norm(rows) * np.sqrt(variance) / np.abs(response))
    return (
        complex(response),
        float(np.sqrt(variance * scale)),
        float(np.sqrt(of_noise * scale)),
        coherence,
        free,
        ratio,
        apart_from,
    )


def explained_share(response: complex, power: float, rest: float) -> float:
    """Return the share of a signal's power that its response to the excitation explains."""
    explained = np.abs(response) ** 2 * power
    total = explained + rest
    return float(explained / total) if total > 0.0 else 0.0
