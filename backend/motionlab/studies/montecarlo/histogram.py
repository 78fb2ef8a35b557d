"""Histograms of a metric over the cases, with the same bins for every variant."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.montecarlo.document import Histogram

Array = NDArray[np.float64]

_FEWEST, _MOST = 8, 40
_WIDE = 20.0
"""Ratio of largest to least value from which on bins are as wide as one another in logarithm."""


def histogram(values: Mapping[str, Array]) -> Histogram | None:
    """Return how many cases of each variant lie in which bin; None where all values are the same.

    As wide as Freedman and Diaconis (1981, doi 10.1007/BF01025868) have it,
    ``2 (q75 - q25)/n^(1/3)``, of the variant whose values lie closest; 8 to 40 bins.

    Parameters
    ----------
    values : mapping of str to ndarray, shape (cases,)
        A metric by variant; what is not finite is in no bin.
    """
    found = {name: each[np.isfinite(each)] for name, each in values.items()}
    every = np.concatenate(list(found.values()))
    if not len(every) or every.min() == every.max():
        return None
    least, most = float(every.min()), float(every.max())
    log = least > 0.0 and most > _WIDE * least
    scaled = {name: np.log(each) if log else each for name, each in found.items() if len(each)}
    span = math.log(most / least) if log else most - least
    widths = [_width(each) for each in scaled.values()]
    narrow = min((width for width in widths if width > 0.0), default=span)
    count = min(_MOST, max(_FEWEST, math.ceil(span / narrow)))
    edges = np.geomspace(least, most, count + 1) if log else np.linspace(least, most, count + 1)
    edges[0], edges[-1] = least, most
    return Histogram(
        edges=edges.tolist(),
        log=log,
        counts={name: np.histogram(each, edges)[0].tolist() for name, each in found.items()},
    )


def _width(values: Array) -> float:
    low, high = np.quantile(values, (0.25, 0.75))
    return 2.0 * float(high - low) / len(values) ** (1.0 / 3.0)
