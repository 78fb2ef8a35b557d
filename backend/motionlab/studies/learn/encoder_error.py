"""The sub-divisional error of an encoder, found in the laps of a motion.

At speed it is faster than the loop: a reading that is off by ``S sin(2 pi p/period)`` moves the
following error by as much, times the loop's sensitivity ``1/(1 + L)``. Both, filtered by that, are
fitted to the error of a lap by least squares, where the mover is fast enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.loop.linearise import linearise
from motionlab.studies.learn.learning_filter import SLIDING, lap_frequencies, modelled

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

FAST = 300.0
"""Periods of the scale a second, Hz, from which on the loop does not follow the error."""
_LEAST = 500
"""Fewest ticks of a lap at that speed."""


@dataclass(frozen=True)
class EncoderErrorFit:
    """Finds an error of the reading in laps of one axis.

    Attributes
    ----------
    period : float
        Of the scale, m.
    sensitivity : ndarray, shape (n,)
        ``1/(1 + L)`` at the frequencies of a lap.
    """

    period: float
    sensitivity: Complex

    @classmethod
    def of(cls, scenario: Scenario, variant: str, axis: str, ticks: int) -> EncoderErrorFit:
        """Return the fit for laps of some control periods; the loop is that of the model."""
        known = modelled(scenario, variant)
        v = SLIDING * getattr(known.plant, axis).friction.v_s
        loop = linearise(known, variant, axis, v=v)
        frequency = lap_frequencies(ticks)
        frequency[0] = frequency[1]
        model = getattr(scenario.variants[variant].controller.model, axis)
        return cls(model.subdivision.period, 1.0 / (1.0 + loop.open(frequency)))

    def amplitudes(
        self, error: Array, position: Array, velocity: Array
    ) -> tuple[float, float] | None:
        """Return sine and cosine of the error that a lap shows, m; None if it is too slow.

        Parameters
        ----------
        error, position, velocity : ndarray, shape (ticks,)
            Following error, m, measured position, m, and velocity of the reference, m/s.
        """
        fast = np.abs(velocity) > FAST * self.period
        if fast.sum() < _LEAST:
            return None
        angle = 2.0 * np.pi * position / self.period
        columns = [-self._passed(shape) for shape in (np.sin(angle), np.cos(angle))]
        columns += [self._passed(np.ones(len(error)))]
        fit, *_ = np.linalg.lstsq(np.stack(columns, axis=1)[fast], error[fast], rcond=None)
        return float(fit[0]), float(fit[1])

    def _passed(self, values: Array) -> Array:
        return np.fft.irfft(np.fft.rfft(values) * self.sensitivity, len(values))
