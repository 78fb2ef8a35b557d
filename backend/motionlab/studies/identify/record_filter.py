"""Zero-phase filters of a record: one smooth window of finite length, and its derivatives.

The window is ``phi(t) = c cos^4(pi t/(2 h))`` for ``abs(t) < h``. Because a convolution may be
differentiated on either side, ``(phi * p)'' = phi'' * p``: a filtered acceleration comes from
positions without a difference of samples, and every term of the equation of motion passes through
the same filter. A sample further than h from a gap does not know of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_WIDTH = 0.4645
"""Half length of the window times its bandwidth at -3 dB, 1."""

SHORTEST = 3.0
"""Least half length, in samples: shorter ones have no derivative worth the name."""


class Window(NamedTuple):
    """A window, sampled.

    Attributes
    ----------
    half : float
        Half its length, s.
    period : float
        Between two samples, s.
    """

    half: float
    period: float

    @classmethod
    def of(cls, bandwidth: float, period: float) -> Window:
        """Return the window of a bandwidth at -3 dB, Hz."""
        return cls(_WIDTH / bandwidth, period)

    @property
    def bandwidth(self) -> float:
        """At -3 dB, Hz."""
        return _WIDTH / self.half

    @property
    def reach(self) -> int:
        """Samples that it takes in on either side."""
        return math.ceil(self.half / self.period)

    def kernel(self, order: int, ahead: float = 0.0) -> Array:
        """Return its samples, or those of a derivative, for a convolution.

        Parameters
        ----------
        order : int
            0, 1 or 2: the window, its first or second derivative.
        ahead : float
            Time by which the result is ahead of the instant that it is for, s, at most `period`
            times a few samples.

        Returns
        -------
        ndarray, shape (2 n + 1,)
            Exact for polynomials up to `order`.
        """
        shift = math.ceil(abs(ahead) / self.period)
        n = self.reach + shift
        t = np.arange(-n, n + 1) * self.period + ahead
        w = math.pi / (2.0 * self.half)
        c, s = np.cos(w * t), np.sin(w * t)
        inside = np.abs(t) < self.half
        if order == 0:
            values = np.where(inside, c**4, 0.0)
            return values / values.sum()
        if order == 1:
            values = np.where(inside, -4.0 * c**3 * s, 0.0)
            values -= np.where(inside, c**4, 0.0) * (values.sum() / np.sum(c[inside] ** 4))
            return values / -float(t @ values)
        values = np.where(inside, 12.0 * c**2 * s**2 - 4.0 * c**4, 0.0)
        weight = np.where(inside, c**4, 0.0)
        values -= weight * (values.sum() / weight.sum())
        slope = np.where(inside, -4.0 * c**3 * s, 0.0)
        slope -= weight * (slope.sum() / weight.sum())
        values -= slope * (float(t @ values) / float(t @ slope))
        return values / (0.5 * float(t * t @ values))

    def noise(self, order: int) -> float:
        """Return the standard deviation of a derivative of white noise of unit deviation."""
        return float(np.linalg.norm(self.kernel(order)))


def filtered(values: Array, kernel: Array, step: int = 1) -> Array:
    """Return a convolution at every `step`-th sample from the first on, zero beyond the ends.

    Parameters
    ----------
    values : ndarray, shape (n,)
        Samples.
    kernel : ndarray, shape (2 m + 1,)
        Of `Window.kernel`.
    step : int
        Samples from one result to the next.

    Returns
    -------
    ndarray, shape (ceil(n/step),)
        Sample k is at ``values[k step]``.
    """
    from scipy.signal import upfirdn

    reach = len(kernel) // 2
    padded = np.concatenate([values, np.zeros(reach)])
    whole = upfirdn(kernel, np.concatenate([np.zeros((-reach) % step), padded]), down=step)
    first = (reach + (-reach) % step) // step
    return whole[first : first + -(-len(values) // step)]
