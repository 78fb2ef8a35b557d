"""Comparison of two runs: every channel of the candidate held against the baseline's."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor

import numpy as np

from motionlab.analysis.aligned_runs import Aligned, align
from motionlab.analysis.columns import Columns
from motionlab.analysis.comparison_document import ChannelComparison, Comparison, Side, Verdict
from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.curve_difference import Curve, Difference, within
from motionlab.analysis.judgement import CHANNELS_MAX, spread, verdict

_BATCH = 6  # columns that a thread reads at a time: fewer read the file's footer too often
_THREADS = 4
_DOUBLES = 12  # arrays of float64 an instant takes at most while runs are aligned


def size(baseline: Columns, candidate: Columns) -> int:
    """Return the memory that a comparison takes at most, bytes."""
    ticks = baseline.grid.ticks + candidate.grid.ticks
    columns = _threads() * _batch(ticks)
    return (
        baseline.size(columns)
        + candidate.size(columns)
        + (_DOUBLES + 6 * _threads()) * ticks * np.dtype(np.float64).itemsize
    )


def compare(
    baseline: Columns,
    candidate: Columns,
    how: Comparing,
    progress: Callable[[float], None] = lambda _: None,
) -> Comparison:
    """Compare every channel of two runs over their overlap.

    Each channel has one verdict, the first of these that is true: *missing* in one of the runs;
    *units-differ*; *ranges-differ*, the runs do not overlap; *not-aligned*, they do, but no
    instant belongs to both; *empty*, there is no instant at which both have a value;
    *out-of-tolerance* at one instant at least; *within*.

    A sample that is not finite is missing. An instant at which one run alone has a value is beyond
    every tolerance in value; one at which neither has counts for nothing.

    Parameters
    ----------
    baseline, candidate : Columns
        The runs; their periods may differ.
    how : Comparing
        Alignment, interpolation and tolerances.
    progress : callable
        Called with the share of the channels that are done.

    Raises
    ------
    ConfigError
        See `motionlab.analysis.aligned_runs.align`.
    StoreError
        If a run cannot be read.
    """
    aligned = align(baseline, candidate, how)
    names = aligned.names
    batch = _batch(baseline.grid.ticks + candidate.grid.ticks)
    batches = [names[i : i + batch] for i in range(0, len(names), batch)]
    channels: list[ChannelComparison] = []
    with ThreadPoolExecutor(_threads()) as threads:
        try:
            for compared in threads.map(lambda some: _channels(aligned, some), batches):
                channels += compared
                progress(len(channels) / len(names))
        except BaseException:
            threads.shutdown(cancel_futures=True)
            raise
    if not (how.only or how.exact):
        some = [channel for channel in channels if channel.verdict != "empty"]
        channels = (some or channels)[:CHANNELS_MAX]
    good = sum(channel.verdict == "within" for channel in channels)
    count, path = aligned.alignment.instants, aligned.alignment.path
    comparison = Comparison(
        a=_side(baseline),
        b=_side(candidate),
        align=how.align,
        offset=how.offset,
        samples=how.samples,
        instants=count,
        start=aligned.place(0) if count else None,
        end=aligned.place(count - 1) if count else None,
        lap_length=None if path is None else path.lap_length,
        standing=0.0 if path is None else path.standing,
        note=aligned.alignment.note,
        channels=channels,
        within=good,
        holds=good == len(channels),
        headline="",
    )
    return comparison.model_copy(update={"headline": verdict(comparison)})


def _channels(aligned: Aligned, names: Sequence[str]) -> list[ChannelComparison]:
    sides = (aligned.baseline, aligned.candidate)
    read: list[str] = []
    if aligned.alignment.instants:
        both = dict(sides[0].units.items() & sides[1].units.items())
        read = [name for name in names if name in both]
    own, other = (side.read(read) if read else np.empty((0, 0)) for side in sides)
    rows = {name: row for row, name in enumerate(read)}
    return [
        _channel(aligned, name, own[rows[name]], other[rows[name]])
        if name in rows
        else _verdict(aligned, name)
        for name in names
    ]


def _channel(aligned: Aligned, name: str, own: Curve, other: Curve) -> ChannelComparison:
    _, interpolation = aligned.rule(name)
    baseline, candidate = aligned.curves(own, other, interpolation)
    tolerance, _ = aligned.rule(name, baseline, candidate)
    difference = within(baseline, candidate, tolerance.absolute, tolerance.relative)
    if difference.beyond and tolerance.time > 0.0:
        flags = aligned.beyond(baseline, candidate, other, name)
        difference = difference._replace(beyond=int(np.count_nonzero(flags)))
    return _verdict(aligned, name, difference, baseline, candidate)


def _verdict(
    aligned: Aligned, name: str, difference: Difference | None = None, *values: Curve
) -> ChannelComparison:
    """Return the verdict of a channel; without a difference it could not be compared."""
    tolerance, interpolation = aligned.rule(name, *values)
    units = (aligned.baseline.units.get(name), aligned.candidate.units.get(name))
    verdict: Verdict
    if None in units:
        verdict = "missing"
    elif units[0] != units[1]:
        verdict = "units-differ"
    elif difference is None:
        verdict = aligned.alignment.reason or "not-aligned"
    elif not difference.compared:
        verdict = "empty"
    else:
        verdict = "out-of-tolerance" if difference.beyond else "within"
    compared = 0 if difference is None else difference.compared
    single = 0 if difference is None else difference.single
    return ChannelComparison(
        name=name,
        unit=units[0],
        candidate_unit=units[1],
        verdict=verdict,
        interpolation=interpolation,
        tolerance=tolerance,
        largest=difference.largest if difference and compared else None,
        at=aligned.place(difference.where) if difference and compared else None,
        beyond=difference.beyond / (compared + single)
        if difference and compared + single
        else None,
        rms=difference.rms if difference and compared else None,
        range=spread(values[0]) if values and compared else None,
        compared=compared,
        single=single,
    )


def _side(columns: Columns) -> Side:
    first, period, ticks = columns.grid
    return Side(name=columns.name, start=first, period=period, ticks=ticks)


def _batch(ticks: int) -> int:
    """Return the number of columns to read at a time: one of a run of hours."""
    return max(1, min(_BATCH, _BATCH * 2_000_000 // max(1, ticks)))


def _threads() -> int:
    return min(_THREADS, len(os.sched_getaffinity(0)))
