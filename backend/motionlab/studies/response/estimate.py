"""A frequency response from repeated periods and repeated realisations of a multisine.

With the excitation R, command U and position Y, all as complex amplitudes at one line, the indirect
method divides ``Y = G_y R`` by ``U = G_u R``, so that feedback leaves no bias. Periods of one slide
differ by noise alone; slides, whose phases are drawn anew, by what is not linear as well (the
robust method of Pintelon and Schoukens, System Identification, 2nd ed., chapter 4). What slides in
one direction have in common besides R, such as ripple over the pole pitch, is fitted as a constant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t as student

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Slides:
    """What was measured at each line of each slide.

    Attributes
    ----------
    excitation : ndarray of complex, shape (slides, lines)
        R, of equal size in all slides.
    command, position : ndarray of complex, shape (slides, periods, lines)
        U, N, and Y, m.
    forward : ndarray of bool, shape (slides,)
        Direction of each slide.
    """

    excitation: Complex
    command: Complex
    position: Complex
    forward: NDArray[np.bool_]


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
        That part of it which periods of one slide show: noise, without distortion.
    coherence : ndarray
        Share of the position's power, among slides and periods, that the response explains.
    freedom : int
        Degrees of freedom of `deviation`.
    """

    response: Complex
    deviation: Array
    noise: Array
    coherence: Array
    freedom: int

    @property
    def half_width(self) -> Array:
        """Half of the 95 % interval of the magnitude; of the phase it is this over magnitude."""
        factor = float(student.ppf(0.5 + 0.5 * CONFIDENCE, self.freedom))
        return factor * self.deviation / np.sqrt(2.0)


def estimate(slides: Slides) -> Estimate:
    """Return the response from command to position.

    Parameters
    ----------
    slides : Slides
        At least two more than directions, of at least two periods.
    """
    count, periods, _ = slides.command.shape
    common = np.stack([slides.forward, ~slides.forward], axis=1).astype(np.float64)
    common = common[:, common.any(axis=0)]
    columns = [_line(slides, common, k) for k in range(slides.excitation.shape[1])]
    response, deviation, noise, coherence = (np.array(each) for each in zip(*columns, strict=True))
    free = count - 1 - common.shape[1]
    return Estimate(response, deviation, noise / np.sqrt(periods), coherence, 2 * free)


def _line(slides: Slides, common: Array, k: int) -> tuple[complex, float, float, float]:
    """Return response, deviation, noise of a single period as it would be in it, and coherence."""
    R, U, Y = slides.excitation[:, k], slides.command[:, :, k], slides.position[:, :, k]
    design = np.concatenate([R[:, None], common], axis=1)
    size = np.linalg.inv(design.conj().T @ design)[0, 0].real
    G_u, G_y = (np.linalg.lstsq(design, each.mean(axis=1))[0][0] for each in (U, Y))
    response = G_y / G_u
    rest = Y - response * U  # of every period: noise, and what is not linear
    mean = rest.mean(axis=1)
    mean = mean - common @ np.linalg.lstsq(common, mean)[0]
    variance = (np.abs(mean) ** 2).sum() / (len(R) - design.shape[1])
    of_periods = rest.var(axis=1, ddof=1).mean()
    scale = size / np.abs(G_u) ** 2
    explained = np.abs(G_y * R[0]) ** 2
    coherence = explained / (explained + variance)
    return (
        response,
        float(np.sqrt(variance * scale)),
        float(np.sqrt(of_periods * scale)),
        float(coherence),
    )
