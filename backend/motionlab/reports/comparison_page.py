"""The page: a comparison of two runs as one HTML file."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np

from motionlab.analysis.aligned_runs import Aligned, Curves, align, curves
from motionlab.analysis.columns import Columns
from motionlab.analysis.comparison_document import ChannelComparison, Comparison
from motionlab.analysis.comparison_options import Comparing, Tolerance
from motionlab.analysis.run_comparison import compare
from motionlab.library.run import RunDetail
from motionlab.reports import results
from motionlab.reports.history import (
    KINDS,
    about,
    again,
    between,
    events,
    happened_table,
    instant,
    length,
    partial,
    record,
    scenario_of,
)
from motionlab.reports.markup import (
    Markup,
    element,
    joined,
    pairs,
    right,
    section,
    symbol,
    table,
)
from motionlab.reports.plots import BINS, VALUES_MAX
from motionlab.reports.quantities import digits, number, quantity
from motionlab.reports.run_page import document
from motionlab.reports.svg_chart import Chart, Curve, spanned, svg
from motionlab.reports.units import Scale, scale_for

DRAWN = 10
"""Channels whose curves are drawn."""
_WIDTH = 352  # of a plot: two are side by side
_AXES = {"time": ("time", "s"), "reference": ("arc length", "m"), "index": ("sample", "1")}
_ALIGNED = {
    "time": "time",
    "reference": "lap and arc length of the commanded path",
    "index": "sample",
}


class Side(NamedTuple):
    """A run that is compared: its record, its columns, the SHA-256 of its telemetry."""

    run: RunDetail
    columns: Columns
    digest: str


def comparison_page(first: Side, second: Side, how: Comparing) -> bytes:
    """Return the report of a comparison as an HTML file.

    Raises
    ------
    ConfigError
        See `motionlab.analysis.aligned_runs.align`.
    StoreError
        If a run cannot be read.
    """
    comparison = compare(first.columns, second.columns, how)
    sides = (first, second)
    runs = [side.run for side in sides]
    title = f"{runs[1].name} compared with {runs[0].name}"
    return document(
        title,
        _heading(title, runs, comparison),
        section("The runs", _beside(_about(run, i) for i, run in enumerate(runs, start=1))),
        section("Differences between their scenarios", between(*runs)),
        section("Alignment and tolerance", _alignment(comparison, how)),
        section("Verdicts", _verdicts(comparison.channels)),
        section("Plots", _plots(align(first.columns, second.columns, how), comparison)),
        section("Metrics", *_metrics(runs)),
        section("Stability margins", *_of_each(runs, _margins)),
        section("How to simulate them again", *_of_each(runs, _again)),
        section(
            "Record",
            _beside(
                joined([element("h3", f"Run {i}"), record(side.run, side.digest)])
                for i, side in enumerate(sides, start=1)
            ),
        ),
    )


def _beside(parts: Iterable[Markup]) -> Markup:
    """Return what is said of each run, side by side where there is room."""
    return element("div", *(element("div", part) for part in parts), class_="beside")


def _heading(title: str, runs: Sequence[RunDetail], comparison: Comparison) -> Markup:
    lines = [
        element(
            "p",
            f"Run {i}, {role}: {run.name}, {run.id}, {KINDS[run.kind]}, {instant(run.created)}, "
            f"{length(run.duration)}",
            class_="quiet",
        )
        for i, role, run in zip((1, 2), ("baseline", "candidate"), runs, strict=True)
    ]
    verdict = element("p", f"{comparison.headline}.", class_=f"verdict {_good(comparison.holds)}")
    return joined([element("h1", title), *lines, verdict])


def _about(run: RunDetail, number: int) -> Markup:
    happened = events(run)
    return joined(
        [
            element("h3", f"Run {number}: {run.name}"),
            partial(run),
            about(run),
            happened_table(run, happened) if happened else None,
        ]
    )


def _alignment(comparison: Comparison, how: Comparing) -> Markup:
    rows: list[tuple[object, object]] = [("aligned by", _ALIGNED[comparison.align])]
    if comparison.align == "time" and comparison.offset:
        rows.append(("run 2 moved by", quantity(comparison.offset, "s")))
    if how.start is not None or how.end is not None:
        ends = [
            f"{word} {quantity(time, 's')}"
            for word, time in (("from", how.start), ("to", how.end))
            if time is not None
        ]
        rows.append(("range", f"{' '.join(ends)} of run 1"))
    if comparison.start is None or comparison.end is None:
        rows.append(("overlap", f"none: {comparison.note}"))
    else:
        overlap = spanned(comparison.start.time, comparison.end.time, "s")
        rows.append(("overlap", f"{overlap} of run 1, {comparison.instants:,} instants"))
        rows.append(("instants", f"{comparison.samples} of the samples of both"))
    if comparison.lap_length is not None:
        rows.append(("length of a lap", quantity(comparison.lap_length, "m")))
    if comparison.standing:
        rows.append(("left out", f"{digits(100 * comparison.standing)} % at rest"))
    rows.append(("tolerance", _tolerance(how.tolerance)))
    rows += [
        (f"of {pattern}", _tolerance(how.tolerance.model_copy(update=_limits(rule))))
        for pattern, rule in how.channels.items()
    ]
    rows += [
        (f"variant {letter} of run 2", f"compared with {target} of run 1")
        for letter, target in how.variants.items()
    ]
    if how.only:
        rows.append(("compared", ", ".join(how.only)))
    meaning = (
        "An instant is within tolerance if the difference is at most the larger of the absolute "
        "tolerance and the relative one times run 1. What could not be compared does not hold."
    )
    return joined([pairs(rows), element("p", meaning, class_="quiet")])


def _limits(rule: object) -> dict[str, float]:
    values = {name: getattr(rule, name) for name in Tolerance.model_fields}
    return {name: value for name, value in values.items() if value is not None}


def _tolerance(tolerance: Tolerance) -> str:
    if not any((tolerance.absolute, tolerance.relative, tolerance.time)):
        return "none: values must be equal"
    parts = [f"{tolerance.absolute:g} in the unit of the channel"]
    if tolerance.relative:
        parts.append(f"{100 * tolerance.relative:g} % of run 1")
    if tolerance.time:
        parts.append(f"{quantity(tolerance.time, 's')} in time")
    return ", ".join(parts)


def _verdicts(channels: Sequence[ChannelComparison]) -> Markup:
    head = [
        "channel",
        "verdict",
        right("largest 2 \u2212 1"),
        right("at"),
        right("RMS"),
        "",
        right("beyond"),
    ]
    return table(head, [_verdict(channel) for channel in ranked(channels)], class_="verdicts")


def _verdict(channel: ChannelComparison) -> list[object]:
    unit = channel.unit or channel.candidate_unit or ""
    if channel.verdict == "units-differ":
        unit = f"{channel.unit or '?'} and {channel.candidate_unit or '?'}"
    errors = [value for value in (channel.largest, channel.rms) if value is not None]
    scale = scale_for(errors, unit)
    verdict = channel.verdict.replace("-", " ")
    at = f"{digits(channel.at.time, 5)} s" if channel.at is not None and channel.largest else ""
    if channel.at is not None and channel.at.arc is not None and at:
        at += f", lap {channel.at.lap}, {quantity(channel.at.arc, 'm')}"
    beyond = "" if channel.beyond is None else f"{digits(100 * channel.beyond)} %"
    return [
        channel.name,
        element("span", verdict, class_=_good(channel.verdict == "within")),
        _difference(channel.largest, scale),
        element("td", at, class_="number"),
        _difference(channel.rms, scale),
        symbol(scale.unit),
        element("td", beyond, class_="number"),
    ]


def _difference(value: float | None, scale: Scale) -> Markup:
    return element("td", "") if value is None else number(value, scale)


def ranked(channels: Sequence[ChannelComparison]) -> list[ChannelComparison]:
    """Return channels, those first that are beyond the tolerance: following errors, then others.

    Among alike, those come first that are beyond at more instants.
    """
    return sorted(
        channels,
        key=lambda each: (
            each.verdict == "within",
            each.largest is None,
            not each.name.endswith("following_error"),
            -(each.beyond or 0.0),
        ),
    )


def _plots(aligned: Aligned, comparison: Comparison) -> Markup:
    instants = aligned.alignment.instants
    drawn = [each for each in ranked(comparison.channels) if each.largest is not None][:DRAWN]
    if not instants or not drawn:
        return element("p", "None: no channel has values of both runs at the same instants.")
    bins = min(BINS // 2, VALUES_MAX // (8 * len(drawn)))
    parts = []
    for channel in drawn:
        shown = curves(aligned, channel.name, 0, instants, bins)
        parts.append(_pair(channel, shown, aligned))
    more = f"Drawn are the {len(drawn)} channels at the top of the table above."
    return joined([element("p", more, class_="quiet"), *parts])


def _pair(channel: ChannelComparison, shown: Curves, aligned: Aligned) -> Markup:
    """Return both runs over each other, and beside them their difference with the tolerance."""
    name, unit = _AXES[aligned.how.align]
    x = shown.start + shown.axis.astype(np.float64)
    end = float(aligned.axis(np.array([aligned.alignment.instants - 1]))[0])
    x = np.append((x[:-1] + x[1:]) / 2.0, (x[-1] + end) / 2.0)
    rows = {label: (shown.low[i], shown.high[i]) for i, label in enumerate(shown.names)}
    common: dict[str, Any] = {
        "x": x,
        "span": (shown.start, end),
        "x_label": name,
        "x_unit": unit,
        "width": _WIDTH,
    }
    both = Chart(
        title=channel.name,
        unit=channel.unit or "1",
        curves=[
            Curve("run 1", "one", *rows["baseline"]),
            Curve("run 2", "two", *rows["candidate"]),
        ],
        **common,
    )
    difference = Chart(
        title=f"{channel.name}: run 2 \u2212 run 1",
        unit=channel.unit or "1",
        curves=[Curve("", "two", *rows["difference"])],
        band=rows["tolerance"][1],
        **common,
    )
    return element("figure", svg(both), svg(difference), class_="pair")


def _metrics(runs: Sequence[RunDetail]) -> list[Markup]:
    columns = [
        column
        for i, run in enumerate(runs, start=1)
        for column in results.columns_of(run, f"{i} " if len(runs) > 1 else "")
    ]
    windows = [
        joined([element("h3", f"Run {i}"), results.window_of(run), results.diverged(run)])
        for i, run in enumerate(runs, start=1)
    ]
    return [*windows, results.metrics(columns)]


def _of_each(runs: Sequence[RunDetail], what: Callable[[RunDetail], Markup]) -> list[Markup]:
    return [
        joined([element("h3", f"Run {i}: {run.name}"), what(run)])
        for i, run in enumerate(runs, start=1)
    ]


def _margins(run: RunDetail) -> Markup:
    return results.margins(scenario_of(run), run)


def _again(run: RunDetail) -> Markup:
    return again(run, scenario_of(run))


def _good(holds: bool) -> str:
    return "good" if holds else "bad"
