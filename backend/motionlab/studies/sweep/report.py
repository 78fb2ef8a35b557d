"""Text and file of a sweep's document."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import product
from typing import Any

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.sweep.documents import SweepDocument

_ROWS = 40  # of the table on a terminal
_PEAK = "max_abs_following_error"


def report(document: SweepDocument) -> str:
    """Return the best cases, and a table of the front or of each case's largest error, in um."""
    columns = _objectives(document) or [
        (f"{name} {axis} max |e|, um", axes.metrics[_PEAK], 1e6)
        for name, variant in document.variants.items()
        for axis, axes in variant.axes.items()
    ]
    shown = document.front if document.objectives else list(range(document.cases))
    heads = ["case"] if document.objectives else []
    heads += [_head(field.path, field.unit) for field in document.fields]
    heads += [title for title, _, _ in columns]
    points = list(case_values(document))
    rows = []
    for case in shown[:_ROWS]:
        cells = [str(case)] if document.objectives else []
        cells += [_cell(value) for value in points[case]]
        figures = [_figure(values[case], factor) for _, values, factor in columns]
        if case in document.infeasible:
            figures = ["cannot follow", *[""] * (len(figures) - 1)]
        rows.append(cells + figures)
    lines = [f"{document.scenario} on {document.plant}, {document.cases} cases"]
    lines += _limit_lines(document)
    if document.objectives and not shown:
        lines.append("no case meets all limits and has every objective")
    elif document.objectives:
        better = "none of the others is better in every objective"
        lines.append(f"{len(shown)} of them, {better}:" if len(columns) > 1 else "the best:")
    if rows:
        lines.append(table(heads, rows, right=range(len(heads))))
    if len(shown) > _ROWS:
        lines.append(f"... {len(shown) - _ROWS} more; --out FILE.csv or --json has them all")
    if not document.objectives:
        lines += _best_lines(document) or ["no case meets all limits"]
    return "\n".join(lines)


def _objectives(document: SweepDocument) -> list[tuple[str, list[float | None], float]]:
    """Return title, values and factor of a column of each objective."""
    return [
        (f"{each.of}, um" if each.unit == "m" else _head(each.of, each.unit), each.values, factor)
        for each, factor in (
            (each, 1e6 if each.unit == "m" else 1.0) for each in document.objectives
        )
    ]


def _limit_lines(document: SweepDocument) -> list[str]:
    lines = []
    for each in document.limits:
        bounds = [
            f"{sign} {bound:g}"
            for sign, bound in ((">=", each.at_least), ("<=", each.at_most))
            if bound is not None
        ]
        unit = f" {each.unit}" if each.unit != "1" else ""
        met = document.cases - len(each.exceeded)
        lines.append(f"{each.of} {' and '.join(bounds)}{unit}: met by {met} cases")
    return lines


def _best_lines(document: SweepDocument) -> list[str]:
    lines = []
    for best in document.best:
        if best.metric == _PEAK:
            where = ", ".join(f"{path} = {_cell(value)}" for path, value in best.set.items())
            peaks = document.variants[best.variant].axes[best.axis].metrics[_PEAK]
            alike = len(peaks) > 1 and len(set(peaks)) == 1
            lines.append(
                f"best for {best.variant} {best.axis}: {best.value * 1e6:.3g} um "
                + ("in every case" if alike else f"at {where}")
            )
    return lines


def write(document: SweepDocument, path: str) -> None:
    """Write one row a case as CSV: swept fields, then every metric of every variant and axis.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    columns = {
        f"{name}.{axis}.{metric}": values
        for name, variant in document.variants.items()
        for axis, axes in variant.axes.items()
        for metric, values in axes.metrics.items()
    }
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["case", *(field.path for field in document.fields), *columns])
        for case, values in enumerate(case_values(document)):
            rows.writerow([case, *values, *(column[case] for column in columns.values())])


def case_values(document: SweepDocument) -> Iterator[tuple[Any, ...]]:
    """Yield the values of the swept fields of each case."""
    points = [field.values for field in document.fields]
    return zip(*points, strict=True) if len(document.shape) < len(points) else product(*points)


def _head(path: str, unit: str) -> str:
    name = path.removeprefix("variants.").replace(".controller.", ".", 1)
    return f"{name}, {unit}" if unit not in {"", "1"} else name


def _figure(value: float | None, factor: float) -> str:
    return "diverged" if value is None else f"{value * factor:.3g}"


def _cell(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
