"""Request, document and text report of a sweep."""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from typing import Annotated, Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from motionlab.config.changes import twice
from motionlab.config.quantity import Config, quantity
from motionlab.config.validation_errors import checked
from motionlab.declarations import OURS
from motionlab.files import complete_file
from motionlab.reports.tables import table

CASES_MAX = 10_000
_ROUNDING = 1e-12  # of the values of a range, relative
_Text = Annotated[str, Field(max_length=200)]
Value = bool | int | float | _Text
"""A value of a field; text also names a shipped part, as in ``plant``."""


class Dimension(Config):
    """One swept field: its values one by one, or a range of numbers."""

    path: str = Field(
        min_length=1,
        max_length=200,
        description="Dotted path of a field of the scenario, such as variants.B.controller.x.k_p",
    )
    values: Annotated[tuple[Value, ...], Field(strict=False, min_length=1)] | None = Field(
        default=None, max_length=CASES_MAX, description="Values, or names of shipped parts"
    )
    start: float | None = Field(default=None, description="First value of a range")
    stop: float | None = Field(default=None, description="Last value of a range")
    count: int | None = quantity(
        "Values in a range, ends included",
        unit="1",
        source=OURS,
        default=None,
        ge=2,
        le=CASES_MAX,
    )
    scale: Literal["linear", "log"] = Field(default="linear", description="Spacing of a range")

    @model_validator(mode="after")
    def _is_values_or_range(self) -> Self:
        ends = (self.start, self.stop, self.count)
        if self.values is not None:
            if any(end is not None for end in ends):
                raise ValueError("takes values, or start, stop and count, not both")
        elif self.start is None or self.stop is None or self.count is None:
            raise ValueError("needs values, or start, stop and count")
        elif not math.isfinite(self.stop - self.start):
            raise ValueError("is too wide a range")
        elif self.scale == "log" and (self.start <= 0.0 or self.stop <= 0.0):
            raise ValueError("a logarithmic range needs start and stop above 0")
        return self

    def points(self, *, whole: bool = False) -> list[Any]:
        """Return the values, in order.

        Raises
        ------
        ValueError
            If a range gives `whole` a fraction.
        """
        if self.values is not None:
            return list(self.values)
        assert self.start is not None and self.stop is not None and self.count is not None
        if self.scale == "linear":
            points = np.linspace(self.start, self.stop, self.count).tolist()
        else:
            inner = np.geomspace(self.start, self.stop, self.count).tolist()[1:-1]
            points = [self.start, *inner, self.stop]
        return [_whole(value) for value in points] if whole else points


class SweepRequest(Config):
    """A scenario and the fields that are swept."""

    scenario: str | dict[str, Any] = Field(
        default="circle", description="Name of a shipped scenario, or its tables"
    )
    set: dict[str, Any] = Field(
        default_factory=dict, max_length=4096, description="Dotted path to value, SI"
    )
    grid: Annotated[tuple[Dimension, ...], Field(strict=False, min_length=1, max_length=6)] = Field(
        description="Swept fields; of a grid the last one changes fastest"
    )
    combine: Literal["grid", "list"] = Field(
        default="grid",
        description="grid: every combination of values; list: first with first, second with second",
    )

    @model_validator(mode="after")
    def _is_a_grid(self) -> Self:
        for path, other in twice(dimension.path for dimension in self.grid):
            raise ValueError(f"{path} is swept twice" + (f", also as {other}" * (other != path)))
        sizes = [_size(dimension) for dimension in self.grid]
        if self.combine == "list" and len(set(sizes)) > 1:
            raise ValueError(f"a list needs as many values of each field, not {sizes}")
        cases = math.prod(self.shape)
        if cases > CASES_MAX:
            raise ValueError(f"{cases} cases are more than {CASES_MAX}")
        return self

    @property
    def shape(self) -> tuple[int, ...]:
        """Number of values along each dimension of the result; one dimension for a list."""
        sizes = tuple(_size(dimension) for dimension in self.grid)
        return sizes[:1] if self.combine == "list" else sizes

    def cases(self, points: Sequence[Sequence[Any]]) -> list[dict[str, Any]]:
        """Return the changes of each case, dotted path to value, of the values of each field."""
        paths = [dimension.path for dimension in self.grid]
        rows = zip(*points, strict=True) if self.combine == "list" else product(*points)
        return [dict(zip(paths, row, strict=True)) for row in rows]


def read_request(request: Mapping[str, Any]) -> SweepRequest:
    """Return a request, checked; raise ConfigError naming every field that is wrong."""
    return checked(SweepRequest, request, "sweep")


def _whole(value: float) -> int:
    near = round(value)
    if abs(value - near) > _ROUNDING * max(1.0, abs(value)):
        raise ValueError(f"takes whole numbers, and the range gives {value:.6g}: list its values")
    return near


def _size(dimension: Dimension) -> int:
    return len(dimension.values) if dimension.values is not None else dimension.count or 0


class _Document(BaseModel):
    model_config = ConfigDict(extra="forbid")


class SweptField(_Document):
    """One swept field."""

    path: str
    unit: str = Field(description="SI; empty for names and switches")
    values: list[Any]


class SweptAxis(_Document):
    """One axis of one variant over all cases."""

    metrics: dict[str, list[float | None]] = Field(
        description="Metrics of a run by name, SI, one value a case; null where the case has none"
    )


class SweptVariant(_Document):
    """One variant over all cases."""

    label: str
    diverged: list[int] = Field(description="Cases in which it diverged")
    axes: dict[str, SweptAxis]


class Best(_Document):
    """Case with the smallest value of a metric."""

    variant: str
    axis: str
    metric: str
    case: int
    value: float
    set: dict[str, Any] = Field(description="Changes that make the case")


class PartialSweep(_Document):
    """Metrics of the first cases of a sweep; null for the others."""

    done: int = Field(description="Cases that have run")
    variants: dict[str, SweptVariant]


class SweepDocument(_Document):
    """Metrics of a scenario over a grid or a list of values of its fields."""

    scenario: str
    plant: str
    seed: int
    version: str = Field(repr=False)
    model: str = Field(description="Hash of the model's sources", repr=False)
    fields: list[SweptField]
    shape: list[int] = Field(
        description="Values along each dimension; cases are in row-major order, a list has one"
    )
    cases: int
    infeasible: list[int] = Field(description="Cases whose motor cannot follow the motion")
    variants: dict[str, SweptVariant]
    best: list[Best]


_ROWS = 40  # of the table on a terminal
_PEAK = "max_abs_following_error"


def report(document: SweepDocument) -> str:
    """Return the largest following error of each case in um, and the best cases."""
    columns = [
        (f"{name} {axis}", axes.metrics[_PEAK])
        for name, variant in document.variants.items()
        for axis, axes in variant.axes.items()
    ]
    heads = [_head(field.path, field.unit) for field in document.fields]
    heads += [f"{title} max |e|, um" for title, _ in columns]
    rows = []
    for case, values in enumerate(case_values(document)):
        if case == _ROWS:
            break
        cells = [_cell(value) for value in values]
        peaks = [peak[case] for _, peak in columns]
        cells += ["diverged" if peak is None else f"{peak * 1e6:.3g}" for peak in peaks]
        if case in document.infeasible:
            cells[len(values) :] = ["cannot follow", *[""] * (len(peaks) - 1)]
        rows.append(cells)
    lines = [
        f"{document.scenario} on {document.plant}, {document.cases} cases",
        table(heads, rows, right=range(len(heads))),
    ]
    if document.cases > _ROWS:
        lines.append(f"... {document.cases - _ROWS} more; --out FILE.csv or --json has them all")
    for best in document.best:
        if best.metric == _PEAK:
            where = ", ".join(f"{path} = {_cell(value)}" for path, value in best.set.items())
            peaks = document.variants[best.variant].axes[best.axis].metrics[_PEAK]
            alike = len(peaks) > 1 and len(set(peaks)) == 1
            lines.append(
                f"best for {best.variant} {best.axis}: {best.value * 1e6:.3g} um "
                + ("in every case" if alike else f"at {where}")
            )
    return "\n".join(lines)


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


def _cell(value: object) -> str:
    return f"{value:.6g}" if isinstance(value, float) else str(value)
