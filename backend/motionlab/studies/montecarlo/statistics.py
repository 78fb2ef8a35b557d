"""Statistics over the cases: quantile bands of the error, histograms, rank correlations."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.studies.montecarlo.documents import DrawnParameter, Histogram, Variation
from motionlab.studies.montecarlo.draw import own_value

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


Array = NDArray[np.float64]

_FEWEST, _MOST = 8, 40
_WIDE = 20.0
"""Ratio of largest to least value from which on bins are as wide as one another in logarithm."""


def histogram(values: Mapping[str, Array]) -> Histogram | None:
    """Return the counts of cases by bin of each variant; None where all values are the same.

    As wide as Freedman and Diaconis (1981, doi 10.1007/BF01025868) have it,
    ``2 (q75 - q25)/n^(1/3)``, of the variant whose values lie closest; 8 to 40 bins.

    Parameters
    ----------
    values : mapping of str to ndarray, shape (cases,)
        A metric by variant; what is not finite is in no bin.
    """
    finite = {name: each[np.isfinite(each)] for name, each in values.items()}
    every = np.concatenate(list(finite.values()))
    if not len(every) or every.min() == every.max():
        return None
    least, most = float(every.min()), float(every.max())
    log = least > 0.0 and most > _WIDE * least
    scaled = {name: np.log(each) if log else each for name, each in finite.items() if len(each)}
    span = math.log(most / least) if log else most - least
    widths = [_width(each) for each in scaled.values()]
    narrow = min((width for width in widths if width > 0.0), default=span)
    count = min(_MOST, max(_FEWEST, math.ceil(span / narrow)))
    edges = np.geomspace(least, most, count + 1) if log else np.linspace(least, most, count + 1)
    edges[0], edges[-1] = least, most
    return Histogram(
        edges=edges.tolist(),
        log=log,
        counts={name: np.histogram(each, edges)[0].tolist() for name, each in finite.items()},
    )


def _width(values: Array) -> float:
    low, high = np.quantile(values, (0.25, 0.75))
    return 2.0 * float(high - low) / len(values) ** (1.0 / 3.0)


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
