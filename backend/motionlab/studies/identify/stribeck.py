"""The Stribeck curve, its fit, and the fit's confidence band."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.plant.friction import steady_friction, stribeck_fade

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Fitted:
    """Parameters that minimise the sum of squared residuals.

    Attributes
    ----------
    names : tuple of str
        Of the parameters.
    values, errors : ndarray, shape (n,)
        Estimates and standard errors; an error is inf where the data do not determine it.
    half_width : ndarray, shape (n,)
        Half of the 95 % interval, by Student's t.
    residual_rms : float
        Root mean square of the residuals.
    correlation : ndarray, shape (n, n)
        Of the estimates.
    warnings : list of str
        What is not determined.
    edge : tuple of str
        Parameters of a record at the edge of their range.
    """

    names: tuple[str, ...]
    values: Array
    errors: Array
    half_width: Array
    residual_rms: float
    correlation: Array
    warnings: list[str]
    edge: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> float:
        """Return an estimate by name."""
        return float(self.values[self.names.index(name)])

    def half(self, name: str) -> float:
        """Return half of the interval of a parameter by name; inf or NaN where undetermined."""
        return float(self.half_width[self.names.index(name)])

    def determines(self, name: str) -> bool:
        """Return whether a parameter is off its edges and known to less than its own size."""
        return self.half(name) <= abs(self[name]) and name not in self.edge


def stribeck_curve(v: Array, parameters: Sequence[float] | Array) -> Array:
    """Return the force of uniform motion, N, eqs (20) to (22) with dz/dt = 0, and an offset.

    Parameters are F_c, F_s, v_s, sigma_2 and the offset.
    """
    *friction, f_0 = parameters
    return steady_friction(v, *friction) + f_0


def curve_half_width(v: Array, fitted: Fitted) -> Array | None:
    """Return half the width of the 95 % band around a fitted Stribeck curve, N.

    ``h(v)^2 = g(v)^T H g(v)`` with g the gradient of the curve by its parameters and H their
    covariance times the square of Student's t.

    Parameters
    ----------
    v : ndarray, shape (n,)
        Velocities, m/s.
    fitted : Fitted
        From `fit_sliding`.

    Returns
    -------
    ndarray, shape (n,), or None
        None where the data leave a parameter undetermined.
    """
    if not np.isfinite(fitted.half_width).all():
        return None
    F_c, F_s, v_s, _, _ = fitted.values
    falling = stribeck_fade(v, v_s)
    sign = np.sign(v)
    gradient = np.stack(
        [
            sign * (1.0 - falling),
            sign * falling,
            sign * (F_s - F_c) * falling * 2.0 * v**2 / v_s**3,
            v,
            np.ones_like(v),
        ]
    )
    H = fitted.correlation * np.outer(fitted.half_width, fitted.half_width)
    return np.sqrt(np.maximum(np.einsum("in,ij,jn->n", gradient, H, gradient), 0.0))
