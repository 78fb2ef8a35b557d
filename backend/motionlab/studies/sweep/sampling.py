"""Cases drawn from the ranges of all swept fields at once."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np

from motionlab.studies.sweep.request import SweepRequest


def draw(request: SweepRequest, whole: list[bool]) -> list[list[Any]]:
    """Return the values of each swept field, one a case.

    ``random`` draws evenly; ``latin-hypercube`` has one case in each of `samples` slices of every
    range (McKay, Beckman and Conover, Technometrics 21(2), 1979); ``sobol`` is a scrambled Sobol
    sequence, which fills the ranges most evenly where `samples` is a power of two.

    Parameters
    ----------
    request : SweepRequest
        Whose `combine` is one of `SAMPLINGS`.
    whole : list of bool
        Whether each field takes whole numbers alone.

    Raises
    ------
    ValueError
        If an end of a range is a fraction where the field takes whole numbers.
    """
    assert request.samples is not None
    dimensions, seed = len(request.grid), request.seed
    from scipy.stats import qmc  # noqa: PLC0415 - half a second, for those who draw

    if request.combine == "random":
        shares = np.random.default_rng(seed).random((request.samples, dimensions))
    elif request.combine == "latin-hypercube":
        shares = qmc.LatinHypercube(dimensions, rng=seed).random(request.samples)
    else:
        with warnings.catch_warnings():  # of a number that is no power of two
            warnings.simplefilter("ignore", UserWarning)
            shares = qmc.Sobol(dimensions, rng=seed).random(request.samples)
    return [
        [dimension.at(share, whole=of_whole) for share in column]
        for dimension, of_whole, column in zip(request.grid, whole, shares.T.tolist(), strict=True)
    ]
