"""Resonances of a measured plant that are no scatter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.shape.documents import Resonance

Array = NDArray[np.float64]

HEIGHT = 3.0
"""Least height over the neighbourhood at the lower end of the interval, dB."""
_RESOLVED = 0.35  # 3 dB as a logarithm: what a top may stand above the frequencies beside it
_NEIGHBOURHOOD = 2.5  # a factor in frequency to either side


def significant(frequency: Array, magnitude: Array, half_width: Array) -> list[Resonance]:
    """Return the peaks of a plant that stand out, at the lower end of their 95 % interval.

    A mass falls with the square of the frequency, so the height is that of ``abs(P) f^2`` over its
    median within a factor of 2.5 of the frequency, the peak's own sixth of that left out.

    Parameters
    ----------
    frequency : ndarray, shape (lines,)
        Hz.
    magnitude : ndarray, shape (lines,)
        abs(P).
    half_width : ndarray, shape (lines,)
        Half of the 95 % interval, as a share of it.
    """
    flat = np.log(magnitude * frequency**2)
    log_f = np.log(frequency)
    near = np.abs(log_f[:, None] - log_f[None, :])
    reach = np.log(_NEIGHBOURHOOD)
    level = np.array(
        [
            np.median(flat[around]) if (around := (row < reach) & (row > reach / 6.0)).any() else f
            for row, f in zip(near, flat, strict=True)
        ]
    )
    decibels = 20.0 / np.log(10.0)
    height = decibels * (flat - level)
    least = height + decibels * np.log(np.maximum(1.0 - half_width, 1e-6))
    peaks: list[Resonance] = []
    for k in np.argsort(-least):
        alone = all(abs(log_f[k] - np.log(each.frequency)) > reach / 6.0 for each in peaks)
        inner = 0 < k < len(flat) - 1 and flat[k] >= flat[k - 1] and flat[k] >= flat[k + 1]
        if least[k] >= HEIGHT and inner and alone:
            peaks.append(
                Resonance(
                    frequency=float(frequency[k]),
                    height=float(f"{height[k]:.3g}"),
                    least=float(f"{least[k]:.3g}"),
                    resolved=bool(flat[k] - max(flat[k - 1], flat[k + 1]) < _RESOLVED),
                )
            )
    return sorted(peaks, key=lambda each: each.frequency)
