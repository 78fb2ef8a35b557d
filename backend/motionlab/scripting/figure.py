"""Curves of a run as a figure, by matplotlib."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.reports.svg_chart import LOOKS
from motionlab.reports.units import scale_for
from motionlab.scripting.channels import look_of

_WIDTH, _HEIGHT = 9.0, 2.4  # inch, of one panel
_POINTS = 20_000  # of a curve
_FURTHER = ("c", "d", "two", "e", "one")  # looks of further curves of a variant


class Curve(NamedTuple):
    """One channel over time."""

    name: str
    unit: str
    values: NDArray[Any]


class NotebookFigure(Figure):
    """A figure that belongs to no window, and that a notebook shows."""

    def _repr_png_(self) -> bytes:
        file = io.BytesIO()
        self.savefig(file, format="png", dpi=100)
        return file.getvalue()


def figure_of(
    time: NDArray[np.float64],
    curves: Sequence[Curve],
    title: str = "",
    ax: Axes | Sequence[Axes] | None = None,
) -> Figure:
    """Draw curves over time, s: a panel for each unit and axis, a colour for each variant.

    Parameters
    ----------
    time : ndarray, shape (n,)
        s.
    curves : sequence of Curve
        Values in SI, shape (n,); shown with the prefix of their unit that fits.
    title : str
        Above all panels.
    ax : Axes or sequence of Axes, optional
        Where to draw: one for all curves, or one for each panel; a new figure when left out.

    Raises
    ------
    ConfigError
        If `ax` is something else, or does not fit the curves.
    """
    panels: dict[tuple[str, str], list[Curve]] = {}
    for each in curves:
        axis = "" if isinstance(ax, Axes) else each.name.rpartition(".")[0][-1:]
        panels.setdefault((each.unit, axis), []).append(each)
    if ax is None:
        figure = NotebookFigure(figsize=(_WIDTH, 0.6 + _HEIGHT * len(panels)), layout="constrained")
        axes = figure.subplots(len(panels), 1, sharex=True, squeeze=False)[:, 0].tolist()
    else:
        axes = _checked_axes(ax, [unit for unit, _ in panels])
        figure = axes[0].figure.figure  # that of a part, too
    for (unit, _), place, drawn in zip(panels, axes, panels.values(), strict=True):
        scale = scale_for([_largest(each.values) for each in drawn], unit)
        taken: set[str] = set()
        for each in drawn:
            free = [look for look in (look_of(each.name), *_FURTHER) if look not in taken]
            look = free[0] if free else look_of(each.name)
            taken.add(look)
            instants, values = _thinned(time, np.asarray(each.values, np.float64) / scale.size)
            place.plot(
                instants,
                values,
                color=LOOKS[look],
                linewidth=1.0,
                label=each.name,
            )
        place.set_ylabel(scale.unit or "1")
        place.grid(alpha=0.3)
        place.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
    if title and ax is None:
        figure.suptitle(title)
    elif title:
        axes[0].set_title(title)
    axes[-1].set_xlabel("time, s")
    return figure


def _checked_axes(ax: Any, units: list[str]) -> list[Axes]:
    """Return the axes that were given, one for each panel."""
    axes = list(np.ravel(np.asarray(ax, object)))
    if not all(isinstance(one, Axes) for one in axes):
        raise ConfigError(FieldError("ax", "is not an Axes of matplotlib, nor a list of them", ax))
    if len(axes) != len(units):
        panels = f"{len(units)}, of {', '.join(unit or '1' for unit in units)}"
        raise ConfigError(FieldError("ax", "must have an Axes for each panel", len(axes), panels))
    return axes


def _largest(values: NDArray[Any]) -> float:
    finite = values[np.isfinite(values)]
    return float(np.abs(finite).max()) if len(finite) else 0.0


def _thinned(
    time: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return a curve; of a long one, the least and the largest value of each stretch."""
    size = -(-len(values) // (_POINTS // 2))
    if size <= 2:
        return time, values
    count = len(values) // size
    parts = values[: count * size].reshape(count, size)
    pairs = np.stack([parts.min(axis=1), parts.max(axis=1)], axis=1).ravel()
    return np.repeat(time[: count * size : size], 2), pairs
