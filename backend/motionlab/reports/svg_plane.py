"""The plane as SVG: the reference from above, each mover with its errors magnified alike."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.reports.markup import Markup, element
from motionlab.reports.svg_chart import (
    LEFT,
    RIGHT,
    VARIANT_LOOKS,
    Axis,
    axes,
    ends_of,
    framed,
    legend_of,
    path_of,
    stroked,
)
from motionlab.reports.units import scale_for

Values = NDArray[np.floating[Any]]

_POINTS = 1200
_SIDE = 380
_MARGIN = 0.08
_SHARE = 0.15  # of the path's size: the largest error in the picture, at most
_MARKERS = 9
_LEAST = 1e-3  # extent of the picture in distances from the centre: labels have few digits


def magnification(size: float, error: float) -> float:
    """Return 1, 2 or 5 times a power of ten, by which the largest error is drawn larger."""
    factor = _SHARE * size / error if error > 0.0 and size > 0.0 else 1.0
    if not math.isfinite(factor) or factor <= 1.0:
        return 1.0
    power = 10.0 ** math.floor(math.log10(factor))
    return max(m * power for m in (1.0, 2.0, 5.0) if m * power <= factor * (1.0 + 1e-9))


def plane(
    reference: Values, errors: Mapping[str, Values], labels: Mapping[str, str], first: int = 0
) -> Markup:
    """Return reference and movers; each is drawn at reference - factor * error.

    Where samples are left out, the one with the largest error stays. A script finds in the
    attributes what it needs to draw other runs of the same motion.

    Parameters
    ----------
    reference : ndarray, shape (2, samples)
        x and y, m.
    errors : mapping of str to ndarray, shape (2, samples)
        Following errors by variant, m.
    labels : mapping of str to str
        What each variant is called.
    first : int
        Number of the first sample in the run.
    """
    size = max((_extent(row) for row in reference), default=0.0)
    largest = max((float(np.nanmax(np.abs(e), initial=0.0)) for e in errors.values()), default=0.0)
    factor = magnification(size, largest)
    every = np.arange(reference.shape[1])
    picked = {name: _picked(error) for name, error in errors.items()}
    curves = {"reference": reference[:, every[:: max(1, len(every) // _POINTS)]]} | {
        name: reference[:, picked[name]] - factor * error[:, picked[name]]
        for name, error in errors.items()
    }
    looks = ["reference", *(VARIANT_LOOKS[i % len(VARIANT_LOOKS)] for i in range(len(errors)))]
    names = ["reference", *(labels.get(name, name) for name in errors)]
    legend, rows = legend_of(list(zip(names, looks, strict=True)))
    top = 30 + 15 * rows
    x, y = _axes(np.concatenate(list(curves.values()), axis=1), top)
    drawn = []
    for i, ((name, curve), look) in enumerate(zip(curves.items(), looks, strict=True)):
        places = np.stack([x.at(curve[0]), y.at(curve[1])])
        path = stroked(path_of(places[0], places[1], places[1]), look, _points(places, i))
        mover = name in errors
        drawn.append(element("g", path, data_mover=name, data_look=look) if mover else path)
    scale = scale_for([x.low, x.high, y.low, y.high], "m")
    title = "Plane" if factor == 1.0 else f"Plane, errors magnified \u00d7 {factor:,.0f}"
    grid = axes(x, y, ("x", scale), scale)
    return framed(
        title,
        [legend, grid, *drawn],
        height=y.begin + 34,
        data_plane=f"{first} {first + reference.shape[1]} {_POINTS} {factor!r}",
        data_x=ends_of(x),
        data_y=ends_of(y),
    )


def _axes(points: Values, top: float) -> tuple[Axis, Axis]:
    """Return axes on which a metre is as long in x as in y."""
    low, high = np.nanmin(points, axis=1), np.nanmax(points, axis=1)
    width, height = RIGHT - LEFT, _SIDE
    least = max(1e-9, _LEAST * float(np.max(np.abs([low, high]))))
    needed = np.maximum((1.0 + 2.0 * _MARGIN) * (high - low), least)
    per_metre = min(width / needed[0], height / needed[1])
    height = max(120.0, min(height, per_metre * needed[1]))
    middle = (low + high) / 2.0
    half = np.array([width, height]) / per_metre / 2.0
    (x_low, y_low), (x_high, y_high) = (middle - half).tolist(), (middle + half).tolist()
    bottom = round(top + height, 2)
    return Axis(x_low, x_high, LEFT, RIGHT), Axis(y_low, y_high, bottom, top)


def _picked(error: Values) -> NDArray[np.int64]:
    """Return the sample of each bin whose error is largest, and both ends."""
    samples = error.shape[1]
    step = max(1, -(-samples // _POINTS))
    size = np.nan_to_num(np.hypot(error[0], error[1]), nan=-1.0)
    largest = [i + int(np.argmax(size[i : i + step])) for i in range(0, samples, step)]
    return np.unique([0, *largest, samples - 1])


def _points(places: Values, marker: int) -> list[tuple[float, float]]:
    count = places.shape[1]
    picked = ((np.arange(_MARKERS) + 0.25 * marker) / _MARKERS * count).astype(int)
    points = places[:, picked[picked < count]].T
    return [(float(x), float(y)) for x, y in points if math.isfinite(x + y)]


def _extent(values: Values) -> float:
    finite = values[np.isfinite(values)]
    return float(np.ptp(finite)) if finite.size else 0.0
