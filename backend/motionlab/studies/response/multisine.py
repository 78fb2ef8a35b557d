"""Periodic multisines: sums of sines with random phases that fill a period with whole cycles."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


@dataclass(frozen=True)
class Lines:
    """The frequencies of a multisine.

    Attributes
    ----------
    ticks : int
        Control periods of one period of the multisine.
    cycles : ndarray of int, shape (lines,)
        Whole cycles of each in a period.
    """

    ticks: int
    cycles: NDArray[np.int64]

    @classmethod
    def between(cls, low: float, high: float, count: int, ticks: int) -> Lines:
        """Return lines between two frequencies, Hz, evenly over their logarithm.

        Where lines of whole cycles lie further apart than that, there are fewer than `count`.
        """
        seconds = ticks * CONTROL_PERIOD
        cycles = np.round(np.geomspace(low, high, count) * seconds).astype(np.int64)
        return cls(ticks, np.unique(cycles))

    @property
    def frequency(self) -> Array:
        """Of each line, Hz."""
        return self.cycles / (self.ticks * CONTROL_PERIOD)

    @functools.cached_property
    def _turns(self) -> Complex:
        return np.exp(2j * np.pi * np.outer(np.arange(self.ticks), self.cycles) / self.ticks)

    def motion(self, amplitudes: Complex) -> tuple[Array, Array, Array]:
        """Return a period of the sum of sines, and of its first and second derivative in time.

        Parameters
        ----------
        amplitudes : ndarray of complex, shape (lines,)
            Of each sine, with the phase as argument.
        """
        turns, rate = self._turns, 2j * np.pi * self.frequency
        value, first, second = ((turns @ (amplitudes * rate**n)).real for n in range(3))
        return value, first, second

    def amplitudes(self, signal: Array) -> Complex:
        """Return the complex amplitudes at the lines of each whole period, (periods, lines).

        Parameters
        ----------
        signal : ndarray, shape (periods * ticks,)
            Tick by tick.
        """
        sums = signal.reshape(-1, self.ticks) @ np.conj(self._turns)
        return np.asarray(sums * (2.0 / self.ticks), dtype=np.complex128)
