"""Curves of figures: decimated so that extremes stay, with digits enough to draw."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from motionlab.config.timing import CONTROL_PERIOD
from motionlab.paper.document import FigureSeries, PaperFigure, Role
from motionlab.paper.experiments import Experiments
from motionlab.telemetry.decimate import min_max

Build = Callable[[Experiments], PaperFigure]

_BINS = 400
_DIGITS = 6


def curve(
    label: str,
    role: Role,
    x: ArrayLike,
    y: ArrayLike,
    *,
    kind: Literal["line", "points"] = "line",
) -> FigureSeries:
    """Return a curve; samples that are not finite become gaps.

    Parameters
    ----------
    label, role, kind : str
        See `motionlab.paper.document.FigureSeries`.
    x, y : array_like, shape (n,)
        SI.
    """
    return FigureSeries(
        label=label,
        role=role,
        kind=kind,
        x=[_rounded(value) or 0.0 for value in np.asarray(x, dtype=float)],
        y=[_rounded(value) for value in np.asarray(y, dtype=float)],
    )


def trace(
    label: str, role: Role, samples: NDArray[np.floating], *, start: float = 0.0
) -> FigureSeries:
    """Return one sample a tick over time: of each bin the smallest and the largest.

    Parameters
    ----------
    label, role : str
        See `motionlab.paper.document.FigureSeries`.
    samples : ndarray, shape (ticks,)
        SI.
    start : float
        Time of the first, s.
    """
    ticks = len(samples)
    if ticks <= 2 * _BINS:
        return curve(label, role, start + np.arange(ticks) * CONTROL_PERIOD, samples)
    low, high = min_max(np.asarray(samples, dtype=np.float32)[None], _BINS)
    size = -(-ticks // _BINS)
    first = start + np.arange(low.shape[1]) * size * CONTROL_PERIOD
    time = np.stack([first, first + 0.5 * size * CONTROL_PERIOD], axis=1)
    return curve(label, role, time.ravel(), np.stack([low[0], high[0]], axis=1).ravel())


def _rounded(value: float) -> float | None:
    return float(f"{value:.{_DIGITS}g}") if np.isfinite(value) else None
