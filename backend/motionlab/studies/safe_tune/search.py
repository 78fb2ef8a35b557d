r"""The next motion: the most promising one that model and measurements hold to be safe.

The logarithm of what a motion measures is the model's prediction plus a Gaussian process over the
logarithms of k_p and k_d: an unknown constant, since friction and thrust differ from the model's,
and a smooth discrepancy (Matern 5/2), with hyperparameters by maximum likelihood within bounds,
C. E. Rasmussen and C. K. I. Williams, *Gaussian Processes for Machine Learning*, MIT Press, 2006.
Gains are safe if the linearised loops keep their margins and the upper bounds of error and force
lie within the limits; so Y. Sui et al., "Safe exploration for optimization with Gaussian
processes", ICML 2015, with the stability boundary known in place of learnt. Of the safe ones
within a step, that of the largest expected improvement is proposed (D. Jones et al., Journal of
Global Optimization 13, 1998).
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.stats import norm

from motionlab.studies.safe_tune.documents import SafeTuneRequest
from motionlab.studies.safe_tune.model import Margins, MotorModel

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]

SIDE = 5
"""Gains examined to either side of a motion, evenly in logarithm up to the step."""
SURE = 2.0
"""Standard deviations of the upper bounds: 97.7 % one-sided."""
_CONSTANT = 0.5  # standard deviation of the logarithm of what the model is off by as a whole
_FEW = 3  # motions below which the hyperparameters stay as they are
_NOISE = 0.02  # of a motion repeated, and of what a smooth discrepancy cannot follow
_SMOOTH = (0.1, (0.05, 0.5))  # amplitude of the discrepancy, and its bounds
_LENGTH = (0.7, (0.35, 2.0))  # its length over ln k: 0.7 is a factor of two


@dataclass(frozen=True)
class Measured:
    """What motions measured.

    Attributes
    ----------
    gains : ndarray, shape (n, 2)
        k_p and k_d.
    outputs : ndarray, shape (3, n)
        Metric, largest error, largest force command.
    """

    gains: Array
    outputs: Array


@dataclass(frozen=True)
class Limits:
    """Largest error, m, and force command, N."""

    error: float
    force: float

    def keep(self, measured: Measured) -> Bools:
        """Return which motions stayed within them, and did not diverge."""
        _, error, force = measured.outputs
        return np.asarray(np.isfinite(error) & (error <= self.error) & (force <= self.force))


@dataclass(frozen=True)
class Examination:
    """Gains within a step of the motions made, shape (n, ...).

    Attributes
    ----------
    gains : ndarray, shape (n, 2)
        k_p and k_d.
    margins : Margins
        Of their loops.
    median, high : ndarray, shape (3, n)
        Median and upper bound of each output.
    holds : ndarray of bool, shape (3, n)
        Whether margins, error and force hold.
    improvement : ndarray, shape (n,)
        Expected improvement of the metric's logarithm, 0 where not safe.
    """

    gains: Array
    margins: Margins
    median: Array
    high: Array
    holds: Bools
    improvement: Array

    @property
    def safe(self) -> Bools:
        """Whether all holds, shape (n,)."""
        return np.asarray(self.holds.all(axis=0))


def examine(
    model: MotorModel, request: SafeTuneRequest, measured: Measured, limits: Limits
) -> Examination:
    """Return what is expected of the gains within a step of motions that kept the limits."""
    kept = limits.keep(measured)
    gains = _around(measured.gains[kept] if kept.any() else measured.gains, request.step)
    k_p, k_d = gains.T
    margins = model.margins(k_p, k_d)
    predicted, at_motions = model.measure(k_p, k_d), model.measure(*measured.gains.T)
    median, high, deviation = np.empty((3, len(gains))), np.empty((3, len(gains))), np.zeros(0)
    for output in range(3):
        finite = np.isfinite(at_motions[output]) & np.isfinite(measured.outputs[output])
        ratio = np.log(measured.outputs[output][finite]) - np.log(at_motions[output][finite])
        mean, spread = _discrepancy(np.log(measured.gains[finite]), ratio, np.log(gains))
        median[output] = predicted[output] * np.exp(mean)
        high[output] = median[output] * np.exp(SURE * spread)
        if output == 0:
            deviation = spread
    holds = np.array([margins.hold, high[1] <= limits.error, high[2] <= limits.force])
    best = measured.outputs[0][kept].min() if kept.any() else np.inf
    with np.errstate(divide="ignore"):
        gain = np.log(best) - np.log(median[0])
    score = gain / deviation
    improvement = gain * norm.cdf(score) + deviation * norm.pdf(score)
    improvement = np.where(holds.all(axis=0) & np.isfinite(median[0]), improvement, 0.0)
    return Examination(gains, margins, median, high, holds, improvement)


def _around(centres: Array, step: float) -> Array:
    """Return a lattice of gains within a step of any centre, without those nearly the same."""
    ratio = np.log(step) / SIDE
    offsets = np.arange(-SIDE, SIDE + 1)
    first = np.log(centres[0])
    places: set[tuple[int, int]] = set()
    for centre in np.log(centres):
        at = np.rint((centre - first) / ratio).astype(int)
        places |= {(at[0] + i, at[1] + j) for i in offsets for j in offsets}
    return np.exp(first + ratio * np.array(sorted(places), dtype=float))


def _discrepancy(at: Array, ratio: Array, where: Array) -> tuple[Array, Array]:
    """Return mean and standard deviation of the logarithm of measured over predicted.

    Parameters
    ----------
    at, where : ndarray, shape (n, 2) and (m, 2)
        Logarithms of gains measured, and of those of interest.
    ratio : ndarray, shape (n,)
        Logarithm of measured over predicted.
    """
    from sklearn.exceptions import ConvergenceWarning  # noqa: PLC0415 - an extra
    from sklearn.gaussian_process import GaussianProcessRegressor  # noqa: PLC0415
    from sklearn.gaussian_process.kernels import ConstantKernel, Matern  # noqa: PLC0415

    amplitude, (low, high) = _SMOOTH
    few = len(ratio) < _FEW
    kernel = ConstantKernel(_CONSTANT**2, "fixed") + ConstantKernel(
        amplitude**2, "fixed" if few else (low**2, high**2)
    ) * Matern(_LENGTH[0], "fixed" if few else _LENGTH[1], nu=2.5)
    process = GaussianProcessRegressor(kernel, alpha=_NOISE**2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)  # hyperparameters at their bounds
        process.fit(at, ratio)
    mean, spread = process.predict(where, return_std=True)
    return mean, np.hypot(spread, _NOISE)
