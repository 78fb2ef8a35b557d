"""Covariance of least-squares estimates when the variances of the residuals are unknown.

Residuals of one motion, there and back, are correlated, and those of slow and fast motions have
different variances. Only independence between motions is assumed: the covariance is that of the
jackknife over motions, CR3, and every parameter has its own degrees of freedom, by Satterthwaite.
See Bell and McCaffrey (2002) and Imbens and Kolesar (2016), doi 10.1162/REST_a_00552.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Scatter(NamedTuple):
    """Covariance of estimates.

    Attributes
    ----------
    errors : ndarray, shape (p,)
        Standard errors; inf where the data do not determine a parameter.
    correlation : ndarray, shape (p, p)
        Of the estimates; 0 with one that is not determined.
    degrees : ndarray, shape (p,)
        Degrees of freedom of each standard error.
    """

    errors: Array
    correlation: Array
    degrees: Array


def scatter(jacobian: Array, residuals: Array, motion: NDArray[np.intp]) -> Scatter:
    """Return the covariance of least-squares estimates.

    ``C = sum u_g u_g^T, u_g = (J^T J)^-1 J_g^T (I - H_gg)^-1 e_g`` over the motions g, with the
    projection ``H = J (J^T J)^-1 J^T``.

    Parameters
    ----------
    jacobian : ndarray, shape (n, p)
        Of the residuals, at the minimum.
    residuals : ndarray, shape (n,)
        At the minimum.
    motion : ndarray of int, shape (n,)
        Motion of each residual.
    """
    length = np.linalg.norm(jacobian, axis=0)
    seen = length > 0.0
    scale = np.where(seen, length, 1.0)
    U, s, vt = np.linalg.svd(jacobian / scale, full_matrices=False)
    determined = s > np.finfo(np.float64).eps * max(jacobian.shape) * s[0]
    # A direction without effect makes every parameter that it holds undetermined.
    lost = (np.abs(vt[~determined]) > 1e-6).any(axis=0) | ~seen
    U, inverse = U[:, determined], vt[determined].T / s[determined]
    moves, scores, lengths = [], [], []
    for g in np.unique(motion):
        rows = U[motion == g]
        # (I - U_g U_g^T)^-1 U_g = U_g (I - U_g^T U_g)^-1, which is small
        part, basis = np.linalg.eigh(np.eye(rows.shape[1]) - rows.T @ rows)
        free = part > 1e-9  # a parameter that one motion alone determines leaves no residual
        left = (basis[:, free] / part[free]) @ basis[:, free].T
        weights = rows @ left @ inverse.T
        moves.append(residuals[motion == g] @ weights)
        scores.append(rows.T @ weights)
        lengths.append(np.sum(weights**2, axis=0))
    covariance = np.sum([np.outer(u, u) for u in moves], axis=0)
    spread = np.sqrt(np.diag(covariance))
    divisor = np.where(spread > 0.0, spread, 1.0)
    return Scatter(
        np.where(lost, np.inf, spread / scale),
        np.where(lost[:, None] | lost, 0.0, covariance / np.outer(divisor, divisor)),
        _degrees(np.array(scores), np.array(lengths)),
    )


def correlation_of(jacobian: Array) -> Array:
    """Return how least-squares estimates correlate for white noise, shape (p, p)."""
    length = np.linalg.norm(jacobian, axis=0)
    unit = jacobian / np.where(length > 0.0, length, 1.0)
    inverse = np.linalg.pinv(unit.T @ unit, rcond=1e-14, hermitian=True)
    spread = np.sqrt(np.diag(inverse))
    divisor = np.where(spread > 0.0, spread, 1.0)
    return inverse / np.outer(divisor, divisor)


def _degrees(scores: Array, lengths: Array) -> Array:
    """Return ``tr(G)^2/tr(G^2)`` of each parameter, G the covariance of its parts for white noise.

    ``G = diag(w_g^T w_g) - (U_g^T w_g)^T (U_h^T w_h)``
    """
    degrees = np.ones(lengths.shape[1])
    for i, own in enumerate(lengths.T):
        score = scores[:, :, i]
        G = np.diag(own) - score @ score.T
        square = float(np.sum(G * G))
        if square > 0.0:
            degrees[i] = max(1.0, float(np.trace(G)) ** 2 / square)
    return degrees
