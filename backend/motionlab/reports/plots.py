"""Which channels of a run are drawn, and their samples."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.library.run import RunDetail
from motionlab.reports.history import Happened
from motionlab.reports.markup import Markup, element
from motionlab.reports.svg_chart import VARIANT_LOOKS, Chart, Curve, Grid, Mark, Source, svg
from motionlab.reports.svg_plane import plane
from motionlab.telemetry.decimate import extremes
from motionlab.telemetry.parquet import read_ticks

if TYPE_CHECKING:
    from pyarrow import parquet

BINS = 680
"""Of a curve: about one for each unit of a plot's width."""
VALUES_MAX = 90_000
"""Least and largest values in all plots of a page together: about 1 MB."""

_PIECE = 2_000_000  # samples read at a time
_PLANE_SECONDS = 12.0
_PLANE_MAX = 200_000  # samples of the plane
_MARKS = 30
_CHARTS = 24
_VARIANTS = 5
_PER_VARIANT = (
    ("following_error", "Following error"),
    ("velocity", "Velocity"),
    ("force_command", "Force command"),
    ("friction", "Friction"),
)
_PHASES = ("a", "b", "c")


class Trace(NamedTuple):
    """A column, and how it is drawn."""

    column: str
    label: str
    look: str


class Plot(NamedTuple):
    """A plot of some columns of a common unit."""

    title: str
    unit: str
    traces: list[Trace]


def plots_memory(run: RunDetail) -> int:
    """Return the memory that the plots of a run take, bytes."""
    widest = max((len(each.traces) for each in run_plots(run)), default=1)
    columns = max(widest, 2 + 2 * len(_drawn(run)))
    return 3 * 4 * columns * min(run.ticks, max(_PIECE // max(1, widest), _PLANE_MAX))


def plots(run: RunDetail, file: parquet.ParquetFile, happened: Sequence[Happened]) -> Markup:
    """Return the plots of a run: plane, following errors, other main channels."""
    if run.ticks == 0:
        return element("p", "Nothing was recorded.")
    charts = run_plots(run)
    curves = sum(len(each.traces) for each in charts)
    bins = max(40, min(BINS, VALUES_MAX // (2 * max(1, curves))))
    parts = [drawn for drawn in [_plane(run, file)] if drawn is not None]
    parts += [svg(chart) for each in charts if (chart := _chart(run, file, each, bins, happened))]
    hidden = len(run.variants) - len(_drawn(run))
    note = element("p", f"{hidden} more variants are not drawn.", class_="quiet") if hidden else ""
    return element("div", note, *(element("figure", part) for part in parts))


def run_plots(run: RunDetail) -> list[Plot]:
    """Return the plots of a run."""
    units = {column["name"]: column["unit"] or "1" for column in run.columns}
    charts = [
        _of_variants(run, axis, name, title, units) for name, title in _PER_VARIANT for axis in AXES
    ]
    last = _drawn(run)[-1:] or [""]
    for axis in AXES:
        phases = [
            Trace(f"{last[0]}.{axis}.current_{phase}", f"{last[0]} {phase}", f"phase-{phase}")
            for phase in _PHASES
        ]
        phases = [trace for trace in phases if trace.column in units]
        charts.append(Plot(f"Phase currents {axis}", "A", phases))
    charts.append(_load(units))
    if run.kind == "measurement":
        shown = {trace.column for each in charts for trace in each.traces}
        charts += [
            Plot(_title(name), unit, [Trace(name, "", "a")])
            for name, unit in units.items()
            if name not in shown
        ]
    return [each for each in charts if each.traces][:_CHARTS]


def envelope(
    file: parquet.ParquetFile, columns: Sequence[str], ticks: int, bins: int
) -> tuple[int, NDArray[np.float32], NDArray[np.float32]]:
    """Return samples of a bin, and least and largest values, shape (columns, bins).

    Read piece by piece, so that memory does not grow with the run.
    """
    size = max(1, -(-ticks // bins))
    piece = size * max(1, _PIECE // (size * len(columns)))
    parts = [
        extremes(read_ticks(file, columns, start, min(start + piece, ticks)), size)
        for start in range(0, ticks, piece)
    ]
    low, high = (np.concatenate(each, axis=1) for each in zip(*parts, strict=True))
    return size, low, high


def _drawn(run: RunDetail) -> list[str]:
    return run.variants[:_VARIANTS]


def _of_variants(run: RunDetail, axis: str, name: str, title: str, units: dict[str, str]) -> Plot:
    traces = [
        Trace(f"{v}.{axis}.{name}", f"{v} {run.labels.get(v, '')}".strip(), VARIANT_LOOKS[i])
        for i, v in enumerate(_drawn(run))
        if f"{v}.{axis}.{name}" in units
    ]
    reference = f"{axis}.{name}_reference"
    if reference in units and traces:
        traces = [Trace(reference, "reference", "reference"), *traces]
    unit = units[traces[0].column] if traces else "1"
    return Plot(f"{title} {axis}", unit, traces)


def _load(units: dict[str, str]) -> Plot:
    traces = [
        Trace(f"{axis}.load_force", axis, VARIANT_LOOKS[i])
        for i, axis in enumerate(AXES)
        if f"{axis}.load_force" in units
    ]
    return Plot("Load force", "N", traces)


def _title(column: str) -> str:
    return column.replace("_", " ")


def _chart(
    run: RunDetail,
    file: parquet.ParquetFile,
    chart: Plot,
    bins: int,
    happened: Sequence[Happened],
) -> Chart | None:
    """Return a plot; None if all of it is zero or missing."""
    names = [trace.column for trace in chart.traces]
    size, low, high = envelope(file, names, run.ticks, bins)
    if not (np.nan_to_num(low).any() or np.nan_to_num(high).any()):
        return None
    starts = np.arange(low.shape[1]) * size
    middles = (starts + np.minimum(starts + size, run.ticks) - 1) / 2.0 * run.period
    return Chart(
        title=chart.title,
        unit=chart.unit,
        x=middles,
        span=(0.0, run.duration),
        curves=[
            Curve(trace.label, trace.look, low[i], high[i], Source(trace.column))
            for i, trace in enumerate(chart.traces)
        ],
        marks=marks(run, happened),
        grid=Grid(0.0, run.period, size),
    )


def marks(run: RunDetail, happened: Sequence[Happened]) -> list[Mark]:
    """Return the marks of what happened within what is left of a run."""
    within = [each for each in happened if 0.0 <= each.time <= run.duration]
    return [Mark(each.time, each.number) for each in within[:_MARKS]]


def _plane(run: RunDetail, file: parquet.ParquetFile) -> Markup | None:
    """Return the plane over the window of the metrics; None without reference or errors."""
    there = {column["name"] for column in run.columns}
    references = [f"{axis}.position_reference" for axis in AXES]
    variants = [v for v in _drawn(run) if {f"{v}.{a}.following_error" for a in AXES} <= there]
    if not variants or not set(references) <= there:
        return None
    start, stop = _plane_samples(run)
    errors = [f"{v}.{axis}.following_error" for v in variants for axis in AXES]
    samples = read_ticks(file, [*references, *errors], start, stop).astype(np.float64)
    if not np.isfinite(samples[:2]).any():
        return None
    pairs = {name: samples[2 + 2 * i : 4 + 2 * i] for i, name in enumerate(variants)}
    labels = {v: f"{v} {run.labels.get(v, '')}".strip() for v in variants}
    return plane(samples[:2], pairs, labels, start)


def _plane_samples(run: RunDetail) -> tuple[int, int]:
    """Return the samples of the plane: the metrics' window, of a long one its end."""
    start, end = run.measured() or (0.0, run.duration)
    stop = min(run.ticks, max(1, round(end / run.period)))
    most = min(_PLANE_MAX, max(1, round(_PLANE_SECONDS / run.period)))
    return max(0, round(start / run.period), stop - most), stop
