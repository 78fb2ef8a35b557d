"""Contour error beside tracking error, along the path and over time.

With the reference r, the following error e = r - p and the unit tangent t of the path at r, n to
its left, the tracking error has a part along the path, by which the mover is late, and one across::

    e_t = e.t;   e_n = -e.n;   abs(e)^2 = e_t^2 + e_n^2

The contour error eps is the distance of p from the nearest point of the path, positive to its
left. On a straight line eps = e_n; on a curve a lag alone takes the mover off the tangent but not
off the path. Y. Koren, "Cross-coupled biaxial computer control for manufacturing systems", J. Dyn.
Syst. Meas. Control 102 (1980) 265, doi:10.1115/1.3149612.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.contouring import nearest

Array = NDArray[np.float64]

PEAKS = 5
"""Most peaks of a variant."""
_PARTS = 200
"""Parts of the path, each of which may have a peak."""
_DRAWN = 400
"""Parts of the stretch, of each of which the extremes are drawn."""


class Peak(NamedTuple):
    """A sample, and the contour error there, m."""

    sample: int
    contour: float


@dataclass(frozen=True)
class PathErrors:
    """Errors of one variant; every array of shape (n,) but `foot`, m.

    Attributes
    ----------
    arc : ndarray
        Length of the path from the beginning of the stretch to the reference.
    contour, lag : ndarray
        As `contouring.Nearest`.
    foot : ndarray, shape (n, 2)
        The nearest point of the path less the reference.
    tracking, along, across : ndarray
        abs(e), e_t and e_n.
    """

    arc: Array
    contour: Array
    lag: Array
    foot: Array
    tracking: Array
    along: Array
    across: Array


@dataclass(frozen=True)
class PathFigures:
    """Figures of one variant.

    Attributes
    ----------
    contour_max, tracking_max, along_max, across_max : float
        Largest magnitudes, m.
    contour_rms, tracking_rms, along_rms, across_rms : float
        Root mean squares over time, m.
    lag_distance : float
        Mean lag along the path while the reference moves, m.
    lag_time : float
        The same over its mean speed, s: of a mover that is late by tau at any speed, tau.
    """

    contour_max: float
    contour_rms: float
    tracking_max: float
    tracking_rms: float
    along_max: float
    along_rms: float
    across_max: float
    across_rms: float
    lag_distance: float
    lag_time: float


def arc_length(position: Array) -> Array:
    """Return the length of the path up to each sample of a reference, shape (n, 2), m."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(position, axis=0).T))])


def tangents(velocity: Array) -> Array:
    """Return unit tangents of the path, shape (n, 2): at rest the last one, at first the next.

    Parameters
    ----------
    velocity : ndarray, shape (n, 2)
        Of the reference, m/s, or any multiple of it.
    """
    speed = np.hypot(*velocity.T)
    moving = speed > 1e-9 * speed.max()
    known = np.flatnonzero(moving)
    last = np.maximum(np.searchsorted(known, np.arange(len(speed)), side="right") - 1, 0)
    return (velocity / np.where(moving, speed, 1.0)[:, None])[known[last]]


def path_errors(
    path: Array, window: tuple[int, int], tangent: Array, following_error: Array
) -> PathErrors:
    """Return the errors of one variant over a window of a path.

    Parameters
    ----------
    path : ndarray, shape (ticks, 2)
        Reference positions, of the window and of what is around it, m.
    window : tuple of int
        Samples [start, end) of the path that the errors are of.
    tangent : ndarray, shape (n, 2)
        Unit tangents over the window.
    following_error : ndarray, shape (n, 2)
        Reference less measured position, finite, m.
    """
    e_x, e_y = following_error.T
    t_x, t_y = tangent.T
    errors = nearest(path, window, following_error)
    return PathErrors(
        arc=arc_length(path[slice(*window)]),
        contour=errors.contour,
        lag=errors.lag,
        foot=errors.foot,
        tracking=np.hypot(e_x, e_y),
        along=e_x * t_x + e_y * t_y,
        across=e_x * t_y - e_y * t_x,
    )


def figures_of(errors: PathErrors, period: float) -> PathFigures:
    """Return the figures of a variant whose reference moves, samples `period` s apart."""
    step = np.diff(errors.arc)
    moving = step > 0.0
    lag = float(errors.lag[1:][moving].mean())
    each = {name: getattr(errors, name) for name in ("contour", "tracking", "along", "across")}
    return PathFigures(
        **{f"{name}_max": float(np.abs(values).max()) for name, values in each.items()},
        **{f"{name}_rms": float(np.sqrt(np.mean(values**2))) for name, values in each.items()},
        lag_distance=lag,
        lag_time=lag * period / float(step[moving].mean()),
    )


def peaks_of(errors: PathErrors) -> list[Peak]:
    """Return the largest peaks of the contour error, each the largest of its surroundings."""
    size = np.abs(errors.contour)
    part = np.minimum((errors.arc * (_PARTS / errors.arc[-1])).astype(int), _PARTS - 1)
    starts = np.flatnonzero(np.diff(part, prepend=-1))
    highest = np.maximum.reduceat(size, starts)
    around = np.concatenate([[-np.inf], highest, [-np.inf]])
    tops = np.flatnonzero((highest > around[:-2]) & (highest >= around[2:]))
    ends = np.append(starts[1:], len(size))
    peaks = []
    for top in tops[np.argsort(-highest[tops], kind="stable")][:PEAKS]:
        sample = int(starts[top] + np.argmax(size[starts[top] : ends[top]]))
        peaks.append(Peak(sample, float(errors.contour[sample])))
    return peaks


def drawn_samples(errors: PathErrors) -> NDArray[np.int64]:
    """Return the samples that are drawn: of each part of the stretch first and extremes."""
    count = len(errors.arc)
    bounds = np.linspace(0, count, min(count, _DRAWN) + 1).astype(int)
    samples = {0, count - 1}
    for start, stop in itertools.pairwise(bounds):
        part = slice(start, stop)
        extremes = (errors.contour[part].argmin(), errors.contour[part].argmax())
        samples.update(int(start + k) for k in (0, *extremes, errors.tracking[part].argmax()))
    return np.array(sorted(samples))
