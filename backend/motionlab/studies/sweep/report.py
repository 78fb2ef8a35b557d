"""A sweep as text for people, and as a table in a file."""

from __future__ import annotations

import csv
from collections.abc import Iterator
from itertools import product
from typing import Any

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.sweep.document import SweepDocument

_ROWS = 40  # of the table on a terminal
_PEAK = "max_abs_following_error"


def report(found: SweepDocument) -> str:
    """Return the largest following error of each case in um, and the best cases."""
    columns = [
        (f"{name} {axis}", axes.metrics[_PEAK])
        for name, variant in found.variants.items()
        for axis, axes in variant.axes.items()
    ]
    heads = [_head(field.path, field.unit) for field in found.fields]
    heads += [f"{title} max |e|, um" for title, _ in columns]
    rows = []
    for case, values in enumerate(case_values(found)):
        if case == _ROWS:
            break
        cells = [_cell(value) for value in values]
        peaks = [peak[case] for _, peak in columns]
        cells += ["diverged" if peak is None else f"{peak * 1e6:.3g}" for peak in peaks]
        if case in found.infeasible:
            cells[len(values) :] = ["cannot follow", *[""] * (len(peaks) - 1)]
        rows.append(cells)
    lines = [
        f"{found.scenario} on {found.plant}, {found.cases} cases",
        table(heads, rows, right=range(len(heads))),
    ]
    if found.cases > _ROWS:
        lines.append(f"... {found.cases - _ROWS} more; --out FILE.csv or --json has them all")
    for best in found.best:
        if best.metric == _PEAK:
            where = ", ".join(f"{path} = {_cell(value)}" for path, value in best.set.items())
            peaks = found.variants[best.variant].axes[best.axis].metrics[_PEAK]
            alike = len(peaks) > 1 and len(set(peaks)) == 1
            lines.append(
                f"best for {best.variant} {best.axis}: {best.value * 1e6:.3g} um "
                + ("in every case" if alike else f"at {where}")
            )
    return "\n".join(lines)


def write(found: SweepDocument, path: str) -> None:
    """Write one row a case as CSV: swept fields, then every metric of every variant and axis.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    columns = {
        f"{name}.{axis}.{metric}": values
        for name, variant in found.variants.items()
        for axis, axes in variant.axes.items()
        for metric, values in axes.metrics.items()
    }
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(["case", *(field.path for field in found.fields), *columns])
        for case, values in enumerate(case_values(found)):
            rows.writerow([case, *values, *(column[case] for column in columns.values())])


def case_values(found: SweepDocument) -> Iterator[tuple[Any, ...]]:
    """Yield the values of the swept fields of each case."""
    points = [field.values for field in found.fields]
    return zip(*points, strict=True) if len(found.shape) < len(points) else product(*points)


def _head(path: str, unit: str) -> str:
    name = path.removeprefix("variants.").replace(".controller.", ".", 1)
    return f"{name}, {unit}" if unit not in {"", "1"} else name


def _cell(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
