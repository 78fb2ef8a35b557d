"""Bands of the following error over time, gathered while the cases run."""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES

POINTS_MAX = 600
"""Points of a band; each stands for as many ticks as it takes."""

LEVELS = (0.05, 0.25, 0.5, 0.75, 0.95)


class Bands:
    """Quantiles over cases at some ticks, extremes over cases and all ticks.

    Parameters
    ----------
    cases, variants : int
        How many.
    window : tuple of int
        Ticks [start, end) that the bands show.
    """

    def __init__(self, cases: int, variants: int, window: tuple[int, int]) -> None:
        self._variants = variants
        self._window = window
        self.stride = math.ceil((window[1] - window[0]) / POINTS_MAX)
        self.ticks = np.arange(window[0], window[1], self.stride)
        shape = (variants, len(AXES), len(self.ticks))
        self._samples = np.full((cases, *shape), np.nan, dtype=np.float32)
        self._least = np.full(shape, np.inf, dtype=np.float32)
        self._most = np.full(shape, -np.inf, dtype=np.float32)

    def watch(self, movers: NDArray[np.int64], errors: NDArray[np.float32]) -> None:
        """Take following errors as `motionlab.simulation.batch.run_prepared` gives them."""
        inside = errors[:, :, slice(*self._window)]
        starts = np.arange(0, inside.shape[2], self.stride)
        least = np.minimum.reduceat(inside, starts, axis=2)
        most = np.maximum.reduceat(inside, starts, axis=2)
        for i, mover in enumerate(movers):
            if np.isnan(errors[i, :, -1]).any():
                continue  # it diverged: it counts, but is in no band
            case, variant = divmod(int(mover), self._variants)
            self._samples[case, variant] = inside[i, :, :: self.stride]
            np.minimum(self._least[variant], least[i], out=self._least[variant])
            np.maximum(self._most[variant], most[i], out=self._most[variant])

    def join(self, parts: Iterable[Bands]) -> None:
        """Take the bands of all cases from those of some cases each, in order."""
        first = 0
        for part in parts:
            self._samples[first : first + len(part._samples)] = part._samples
            np.minimum(self._least, part._least, out=self._least)
            np.maximum(self._most, part._most, out=self._most)
            first += len(part._samples)

    def of(self, variant: int, axis: int) -> dict[str, NDArray[np.float32]] | None:
        """Return the bands of one axis of one variant, m; None where every case diverged."""
        samples = self._samples[:, variant, axis]
        samples = samples[~np.isnan(samples[:, 0])]
        if not len(samples):
            return None
        levels = np.quantile(samples, LEVELS, axis=0)
        named = {
            f"q{round(100 * level):02d}": row for level, row in zip(LEVELS, levels, strict=True)
        }
        return {
            "min": self._least[variant, axis],
            **named,
            "max": self._most[variant, axis],
        }
