"""The page: a comparison of two runs as one HTML file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from motionlab.analysis.aligned_runs import Aligned, Curves, align, curves
from motionlab.analysis.columns import Columns
from motionlab.analysis.comparison_document import ChannelComparison, Comparison
from motionlab.analysis.comparison_options import Comparing, Tolerance
from motionlab.analysis.run_comparison import compare
from motionlab.library.run import RunDetail
from motionlab.reports import results
from motionlab.reports.experiment import experiments, program
from motionlab.reports.history import differences, events, scenario_of
from motionlab.reports.markup import Markup
from motionlab.reports.page import page
from motionlab.reports.plots import BINS, VALUES_MAX
from motionlab.reports.quantities import digits, quantity
from motionlab.reports.svg_chart import Chart, Curve, Grid, Source, spanned, svg
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
    runs = [first.run, second.run]
    columns = [
        column for i, run in enumerate(runs, start=1) for column in results.columns_of(run, f"{i} ")
    ]
    ranked_channels = ranked(comparison.channels)
    aligned = align(first.columns, second.columns, how)
    return page(
        "comparison.html.j2",
        f"{second.run.name} compared with {first.run.name}",
        sides=[
            {
                "run": side.run,
                "digest": side.digest,
                "scenario": scenario_of(side.run),
                "events": events(side.run),
            }
            for side in (first, second)
        ],
        comparison=comparison,
        differences=differences(*runs),
        alignment=_alignment(comparison, how),
        verdicts=[_verdict(channel) for channel in ranked_channels],
        plots=_plots(aligned, ranked_channels),
        metrics=results.metrics(columns),
        program=program(),
        still=not _coincident(aligned),
        experiments=experiments({"1 ": first.run, "2 ": second.run}),
    )


def _alignment(comparison: Comparison, how: Comparing) -> list[tuple[str, str]]:
    rows = [("aligned by", _ALIGNED[comparison.align])]
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
    every = how.tolerance or (Tolerance() if how.exact else None)
    rows.append(("tolerance", _tolerance(every)))
    rows += [
        (f"of {pattern}", _tolerance((every or Tolerance()).model_copy(update=_limits(rule))))
        for pattern, rule in how.channels.items()
    ]
    rows += [
        (f"variant {letter} of run 2", f"compared with {target} of run 1")
        for letter, target in how.variants.items()
    ]
    if how.only:
        rows.append(("compared", ", ".join(how.only)))
    return rows


def _limits(rule: object) -> dict[str, float]:
    values = {name: getattr(rule, name) for name in Tolerance.model_fields}
    return {name: value for name, value in values.items() if value is not None}


def _tolerance(tolerance: Tolerance | None) -> str:
    if tolerance is None:
        return "2 % of the range of run 1, six times its noise, an encoder count; 1 ms in time"
    if not any((tolerance.absolute, tolerance.relative, tolerance.time)):
        return "none: values must be equal"
    parts = [f"{tolerance.absolute:g} in the unit of the channel"]
    if tolerance.relative:
        parts.append(f"{100 * tolerance.relative:g} % of run 1")
    if tolerance.time:
        parts.append(f"{quantity(tolerance.time, 's')} in time")
    return ", ".join(parts)


def _verdict(channel: ChannelComparison) -> tuple[ChannelComparison, Scale, str]:
    """Return a channel, the scale of its differences, and where the largest is."""
    unit = channel.unit or channel.candidate_unit or ""
    if channel.verdict == "units-differ":
        unit = f"{channel.unit or '?'} and {channel.candidate_unit or '?'}"
    errors = [value for value in (channel.largest, channel.rms) if value is not None]
    at = f"{digits(channel.at.time, 5)} s" if channel.at is not None and channel.largest else ""
    if channel.at is not None and channel.at.arc is not None and at:
        at += f", lap {channel.at.lap}, {quantity(channel.at.arc, 'm')}"
    return channel, scale_for(errors, unit), at


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


def _plots(aligned: Aligned, channels: Sequence[ChannelComparison]) -> list[tuple[Markup, Markup]]:
    instants = aligned.alignment.instants
    drawn = [each for each in channels if each.largest is not None][:DRAWN] if instants else []
    bins = min(BINS // 2, VALUES_MAX // (8 * max(1, len(drawn))))
    return [
        _pair(channel, curves(aligned, channel.name, 0, instants, bins), aligned)
        for channel in drawn
    ]


def _pair(channel: ChannelComparison, shown: Curves, aligned: Aligned) -> tuple[Markup, Markup]:
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
        "grid": _grid(shown, aligned),
    }
    own, other = _sources(channel.name, aligned)
    both = Chart(
        title=channel.name,
        unit=channel.unit or "1",
        curves=[
            Curve("run 1", "one", *rows["baseline"], own),
            Curve("run 2", "two", *rows["candidate"], other),
        ],
        **common,
    )
    difference = Chart(
        title=f"{channel.name}: run 2 \u2212 run 1",
        unit=channel.unit or "1",
        curves=[Curve("", "two", *rows["difference"], other, own)],
        band=rows["tolerance"][1],
        **common,
    )
    return svg(both), svg(difference)


def _coincident(aligned: Aligned) -> bool:
    """Return whether the instants are samples of both runs at equal steps of the axis."""
    alignment = aligned.alignment
    return alignment.path is None and all(
        isinstance(each, slice) for each in (alignment.baseline, alignment.candidate)
    )


def _grid(shown: Curves, aligned: Aligned) -> Grid | None:
    """Return the instants of curves, where they are samples of both runs."""
    if not _coincident(aligned):
        return None
    step = 1.0 if aligned.how.align == "index" else aligned.baseline.grid.period
    return Grid(shown.start, step, shown.bin)


def _sources(name: str, aligned: Aligned) -> tuple[Source | None, Source | None]:
    """Return the columns of both runs that a channel compares, where instants are samples."""
    baseline, candidate = aligned.alignment.baseline, aligned.alignment.candidate
    if not (isinstance(baseline, slice) and isinstance(candidate, slice)):
        return None, None
    variant, _, rest = name.partition(".")
    letters = {target: letter for letter, target in aligned.how.variants.items()}
    other = f"{letters.get(variant, variant)}.{rest}"
    return Source(f"1 {name}", baseline.start), Source(f"2 {other}", candidate.start)
