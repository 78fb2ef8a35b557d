"""Text and file of sensitivities."""

from __future__ import annotations

import csv

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.sensitivity.documents import SensitivityDocument

_ROWS = 12  # of the table of an axis
_PEAK = "max_abs_following_error"


def report(document: SensitivityDocument) -> str:
    """Return what moves the largest following error of the last variant most, by axis."""
    name = list(document.variants)[-1]
    lines = [
        f"{document.scenario} on {document.plant}: {len(document.fields)} fields, "
        f"each {document.step:.3g} of its value down and up"
    ]
    if document.left:
        lines.append(f"{len(document.left)} left out: zeros, and what the scenario refuses")
    for axis, metrics in document.variants[name].items():
        effect = metrics[_PEAK]
        base = effect.base or 0.0
        rows = []
        for field, low, high in zip(document.fields, effect.low, effect.high, strict=True):
            sides = [None if side is None else side - base for side in (low, high)]
            most = max((abs(side) for side in sides if side is not None), default=0.0)
            cells = ["diverged" if side is None else f"{side * 1e9:+.3g}" for side in sides]
            if field.low is None or field.high is None:
                cells = [
                    "-" if at is None else cell
                    for at, cell in zip((field.low, field.high), cells, strict=True)
                ]
            rows.append((most, [field.path, f"{field.value:.6g}", *cells]))
        rows.sort(key=lambda row: -row[0])
        heads = [f"{name} {axis}: max |e| {base * 1e6:.3g} um", "value", "down, nm", "up, nm"]
        lines += ["", table(heads, [cells for _, cells in rows[:_ROWS]], right=(1, 2, 3))]
    return "\n".join(lines)


def write(document: SensitivityDocument, path: str) -> None:
    """Write one row a field as CSV: the slope of every metric of every variant and axis.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    columns = {
        f"{name}.{axis}.{metric}": effect.slope
        for name, axes in document.variants.items()
        for axis, metrics in axes.items()
        for metric, effect in metrics.items()
    }
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["field", "unit", "value", "low", "high", *(f"d({c})" for c in columns)])
        for index, field in enumerate(document.fields):
            slopes = [column[index] for column in columns.values()]
            rows.writerow([field.path, field.unit, field.value, field.low, field.high, *slopes])
