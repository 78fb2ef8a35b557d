"""A measured response as text, and as a table in a file."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable

import numpy as np

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.response.documents import MarginInterval, MeasuredResponse

_ROWS = 16  # frequencies of the text
_MARGINS: dict[str, tuple[str, Callable[[float], float]]] = {
    "crossover": ("crossover, Hz", lambda value: value),
    "phase_margin": ("phase margin, deg", math.degrees),
    "gain_margin": ("gain margin up, dB", lambda value: 20.0 * math.log10(value)),
    "gain_reduction": ("gain margin down, dB", lambda value: -20.0 * math.log10(value)),
}
_HEADS = ("frequency", "plant", "95 %", "phase", "coherence", "linearised", "phase")
_UNITS = ("Hz", "dB m/N", "+- dB", "deg", "1", "dB m/N", "deg")


def report(result: MeasuredResponse) -> str:
    """Return margins with their intervals, and the plant at some frequencies."""
    lines = [
        f"{result.variant} {result.axis}, sliding at {1e3 * result.velocity:.3g} mm/s: "
        + (f"run {result.run}, " if result.run else "")
        + (f"{result.slides} slides of {result.periods} periods, " if result.slides > 1 else "")
        + f"{result.seconds:.3g} s",
        *(f"note: {each}" for each in result.warnings),
        "",
    ]
    rows = margin_rows(result.margins)
    lines += [table(("open loop", "measured", "95 %", "linearised"), rows, right=(1, 2, 3)), ""]
    plant, model = result.plant, result.linearised_plant
    count = len(result.frequency)
    some = np.unique(np.linspace(0, count - 1, min(_ROWS, count)).round().astype(int)).tolist()
    rows = [
        [
            f"{result.frequency[k]:.4g}",
            f"{_decibels(plant.magnitude[k]):.2f}",
            f"{_decibels(1.0 + plant.interval[k]):.2f}",
            f"{math.degrees(plant.phase[k]):.1f}",
            f"{plant.coherence[k]:.3f}",
            f"{_decibels(model.magnitude[k]):.2f}",
            f"{math.degrees(model.phase[k]):.1f}",
        ]
        for k in some
    ]
    heads = [f"{head}, {unit}" for head, unit in zip(_HEADS, _UNITS, strict=True)]
    return "\n".join([*lines, table(heads, rows, right=tuple(range(len(heads))))])


def margin_rows(margins: dict[str, MarginInterval]) -> list[list[str]]:
    """Return each margin with its interval and what it is compared with."""
    rows = []
    for name, (title, shown) in _MARGINS.items():
        each = margins[name]
        ends = None if each.interval is None else sorted(map(shown, each.interval))
        rows.append(
            [
                title,
                "none" if each.value is None else f"{shown(each.value):.3g}",
                "-" if ends is None else " to ".join(f"{end:.3g}" for end in ends),
                "none" if each.model is None else f"{shown(each.model):.3g}",
            ]
        )
    return rows


def write(result: MeasuredResponse, path: str) -> None:
    """Write one row a frequency as CSV, SI.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    columns: dict[str, list[float]] = {"frequency [Hz]": result.frequency}
    measured = result.plant
    curves = {
        "plant": (measured, "m/N"),
        "open": (result.open, "1"),
        "linearised_plant": (result.linearised_plant, "m/N"),
    }
    for name, (curve, unit) in curves.items():
        columns[f"{name}.magnitude [{unit}]"] = curve.magnitude
        columns[f"{name}.phase [rad]"] = curve.phase
    for name in ("interval", "noise", "distortion", "coherence"):
        columns[f"plant.{name} [1]"] = getattr(measured, name)
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))


def _decibels(value: float) -> float:
    return 20.0 * math.log10(value)
