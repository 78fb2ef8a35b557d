"""A measured response as text, and as a table in a file."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable

import numpy as np

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.response.documents import (
    FittedPlant,
    MarginInterval,
    MeasuredResponse,
    PlantValue,
)

_ROWS = 16  # frequencies of the text
MARGINS: dict[str, tuple[str, Callable[[float], float]]] = {
    "crossover": ("crossover, Hz", lambda value: value),
    "phase_margin": ("phase margin, deg", math.degrees),
    "gain_margin": ("gain margin up, dB", lambda value: 20.0 * math.log10(value)),
    "gain_reduction": ("gain margin down, dB", lambda value: -20.0 * math.log10(value)),
}
"""Title with the unit of each margin, and how its SI value is shown."""
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
    rows, heads = margin_rows(result.margins), ["open loop", "measured", "95 %", "linearised"]
    if result.own_margins is not None:
        heads += ["record's own loop", "95 %"]
        for row, of_own in zip(rows, margin_rows(result.own_margins), strict=True):
            row.extend(of_own[1:3])
    if result.fitted is not None:
        heads.append("fitted model")
        for row, name in zip(rows, MARGINS, strict=True):
            row.append(_shown(name, result.fitted.margins[name]))
    lines += [table(heads, rows, right=tuple(range(1, len(heads)))), ""]
    if (half := result.half_force) is not None:
        lines += [
            f"with half the force the plant answers {half.gain:.3f} +- {half.interval:.3f} times "
            f"as much, its phase is {math.degrees(half.phase):+.1f} +- "
            f"{math.degrees(half.interval):.1f} deg apart; intervals of margins hold both",
            "",
        ]
    if len(result.crossings) > 1:
        each = (
            f"{at.frequency:.3g} Hz ({math.degrees(at.phase_margin):.3g} deg)"
            for at in result.crossings
        )
        lines += [f"all crossovers, with their phase margins: {', '.join(each)}", ""]
    if result.fitted is not None:
        lines += [*_fitted(result.fitted, result.frequency), ""]
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


def _shown(name: str, value: float | None) -> str:
    return "none" if value is None else f"{MARGINS[name][1](value):.3g}"


def margin_rows(margins: dict[str, MarginInterval]) -> list[list[str]]:
    """Return each margin with its interval and what it is compared with."""
    rows = []
    for name, (title, shown) in MARGINS.items():
        each = margins[name]
        ends = None if each.interval is None else sorted(map(shown, each.interval))
        rows.append(
            [
                title,
                _shown(name, each.value),
                "-" if ends is None else " to ".join(f"{end:.3g}" for end in ends),
                _shown(name, each.model),
            ]
        )
    return rows


_FITTED: dict[str, tuple[str, float]] = {
    "mass": ("mass, kg", 1.0),
    "delay": ("delay, ms", 1e3),
    "lag": ("lag, ms", 1e3),
    "damping": ("damping, N s/m", 1.0),
    "stiffness": ("stiffness, N/mm", 1e-3),
}
_MODE: dict[str, str] = {"frequency": "Hz", "damping": "damping ratio", "coupling": "coupling"}
_NORMAL = 1.96


def _fitted(model: FittedPlant, frequency: list[float]) -> list[str]:
    """Return the parameters of the fitted model, and how far it is right."""
    rows = []

    def row(title: str, each: PlantValue | None, factor: float) -> None:
        if each is not None:
            half = _NORMAL * factor * each.error
            # Two figures of the interval, and no more of the value.
            places = min(12, max(0, 1 - math.floor(math.log10(half)))) if half > 0.0 else 6
            known = [each.value] if each.model is None else [each.value, each.model]
            shown = [f"{factor * value:.{places}f}" for value in known]
            rows.append([title, shown[0], f"{half:.{places}f}", *(shown[1:] or ["-"])])

    for name, (title, factor) in _FITTED.items():
        row(title, getattr(model, name), factor)
    for number, mode in enumerate(model.modes, 1):
        for name, unit in _MODE.items():
            row(f"mode {number}, {unit}", getattr(mode, name), 1.0)
    worst = max(range(len(frequency)), key=model.residual.__getitem__)
    return [
        table(("fitted model", "measured", "95 % +-", "linearised"), rows, right=(1, 2, 3)),
        f"misfit {model.misfit:.3g} (1: intervals explain it); worst at {frequency[worst]:.4g} Hz, "
        f"by {model.residual[worst]:.3g} times half of the interval",
    ]


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
    if result.fitted is not None:
        at = {f: k for k, f in enumerate(result.fitted.loop.frequency)}
        rows = [at[f] for f in result.frequency]
        curve = result.fitted.plant
        columns["fitted.magnitude [m/N]"] = [curve.magnitude[k] for k in rows]
        columns["fitted.phase [rad]"] = [curve.phase[k] for k in rows]
        columns["fitted.residual [1]"] = result.fitted.residual
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(columns)
        rows.writerows(zip(*columns.values(), strict=True))


def _decibels(value: float) -> float:
    return 20.0 * math.log10(value)
