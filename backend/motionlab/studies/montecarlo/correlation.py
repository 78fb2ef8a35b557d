"""Which drawn parameter decides: rank correlation of parameters and metrics over the cases."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.montecarlo.document import DrawnParameter
from motionlab.studies.montecarlo.draw import own_value
from motionlab.studies.montecarlo.request import Variation

Array = NDArray[np.float64]

_LEVEL = 0.05
"""Chance that any of the parameters passes `threshold` although none has an influence."""
_DIGITS = 4


def drawn_parameters(
    draws: Sequence[Mapping[str, Any]],
    vary: Sequence[Variation],
    plant: Mapping[str, Any],
    axis: str,
) -> tuple[list[DrawnParameter], Array]:
    """Return the numbers of an axis that differ from case to case, and their values.

    Each is there as its value, and as its deviation from the plant's own: what a controller's model
    assumes does harm if it is wrong in either direction, and so does an offset.

    Parameters
    ----------
    draws : sequence of mapping
        Of each case, dotted path to value.
    vary : sequence of Variation
        What was drawn.
    plant : mapping
        Tables of the plant that the cases are around.
    axis : str
        ``x`` or ``y``.

    Returns
    -------
    list of DrawnParameter, ndarray of shape (cases, parameters)
        A deviation is ``abs(p - p_0)``, of what is drawn in logarithm ``abs(log(p/p_0))``.
    """
    parameters: list[DrawnParameter] = []
    columns: list[Array] = []
    for variation in vary:
        if variation.kind == "value":
            continue
        values = np.array([case[f"plant.{axis}.{variation.path}"] for case in draws], dtype=float)
        own = own_value(plant[axis], variation.path).ravel()
        for index, item in enumerate(values.reshape(len(draws), -1).T):
            path = variation.path if values.ndim == 1 else f"{variation.path}.{index}"
            parameters.append(DrawnParameter(path=path, of="value"))
            columns.append(item)
            logarithmic = variation.kind.startswith("log-") and own[index] > 0.0
            deviation = np.log(item / own[index]) if logarithmic else item - own[index]
            if np.isfinite(deviation).all():  # a plant may have no such number of its own
                parameters.append(DrawnParameter(path=path, of="deviation"))
                columns.append(np.abs(deviation))
    return parameters, np.array(columns).reshape(len(columns), len(draws)).T


def rank_correlations(parameters: Array, metrics: Array) -> list[list[float | None]]:
    """Return Spearman's rho of each metric with each parameter.

    ``rho = cov(R(p), R(m))/(std(R(p)) std(R(m)))`` with ranks R, ties sharing their mean rank.

    Parameters
    ----------
    parameters : ndarray, shape (cases, parameters)
        Drawn numbers.
    metrics : ndarray, shape (cases, metrics)
        A case without a metric, because it diverged or never settled, ranks above all others.

    Returns
    -------
    list of list of float or None
        For each metric, of each parameter; None where either is the same in every case.
    """
    p = _standardised(parameters)
    m = _standardised(np.where(np.isnan(metrics), math.inf, metrics))
    rho = m.T @ p
    return [
        [None if math.isnan(value) else round(value, _DIGITS) for value in row]
        for row in rho.tolist()
    ]


def threshold(cases: int, parameters: int) -> float:
    """Return the rho that chance exceeds for any of the parameters in one of twenty studies.

    ``rho = t/sqrt(n - 2 + t^2)`` with the quantile t of Student's distribution of n - 2 degrees of
    freedom at ``1 - 0.05/(2 m)``, after Bonferroni for m parameters.
    """
    from scipy.special import stdtrit

    free = cases - 2
    if free < 1:
        return 1.0
    t = float(stdtrit(free, 1.0 - 0.5 * _LEVEL / max(parameters, 1)))
    return round(t / math.sqrt(free + t**2), _DIGITS)


def _standardised(columns: Array) -> Array:
    """Return ranks of each column, without mean and of length one; NaN for a constant column."""
    ranks = np.empty_like(columns, dtype=float)
    for k, column in enumerate(columns.T):
        _, place, count = np.unique(column, return_inverse=True, return_counts=True)
        ranks[:, k] = (np.cumsum(count) - 0.5 * (count - 1))[place]
    ranks -= ranks.mean(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        return ranks / np.sqrt((ranks**2).sum(axis=0))
