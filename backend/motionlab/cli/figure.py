"""Curves of a run as a figure, by matplotlib."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

_SHOWN = {"m": (1e6, "µm"), "m/s": (1e3, "mm/s")}
_LARGE = 1e-3  # m; longer ones are shown in mm
_WIDTH, _HEIGHT = 9.0, 2.6  # inch, of one panel
_POINTS = 20_000  # of a curve


class Curve(NamedTuple):
    """One channel over time."""

    name: str
    unit: str
    values: NDArray[Any]


def draw(time: NDArray[np.float64], curves: list[Curve], title: str, path: str) -> None:
    """Write the figure: a panel for each unit and axis, the curves of variants in it."""
    from matplotlib import pyplot as plt

    from motionlab.store.files import complete_file

    panels: dict[tuple[str, str], list[Curve]] = {}
    for each in curves:
        panels.setdefault((each.unit, each.name.rpartition(".")[0][-1:]), []).append(each)
    size = (_WIDTH, 0.6 + _HEIGHT * len(panels))
    figure, axes = plt.subplots(
        len(panels), sharex=True, squeeze=False, figsize=size, layout="constrained"
    )
    for (unit, _), place, drawn in zip(panels, axes[:, 0], panels.values(), strict=True):
        factor, shown = _scale(unit, drawn)
        for each in drawn:
            for instant, value in _thinned(time, each.values * factor):
                place.plot(instant, value, linewidth=0.9, label=each.name)
        place.set_ylabel(shown or "1")
        place.grid(alpha=0.3)
        place.legend(loc="upper right", fontsize="small")
    axes[0, 0].set_title(title)
    axes[-1, 0].set_xlabel("time, s")
    with complete_file(path) as part:
        figure.savefig(part, format=Path(path).suffix[1:], dpi=150)
    plt.close(figure)


def _scale(unit: str, curves: list[Curve]) -> tuple[float, str]:
    """Return factor and unit in which curves are shown."""
    if unit == "m" and max(float(np.nanmax(np.abs(each.values))) for each in curves) > _LARGE:
        return 1e3, "mm"
    return _SHOWN.get(unit, (1.0, unit))


def _thinned(
    time: NDArray[np.float64], values: NDArray[Any]
) -> Iterator[tuple[NDArray[np.float64], NDArray[Any]]]:
    """Yield a curve; of a long one, the least and the largest value of each stretch."""
    size = -(-len(values) // (_POINTS // 2))
    if size < 2:
        yield time, values
        return
    count = len(values) // size
    parts = values[: count * size].reshape(count, size)
    pairs = np.stack([parts.min(axis=1), parts.max(axis=1)], axis=1).ravel()
    yield np.repeat(time[: count * size : size], 2), pairs
