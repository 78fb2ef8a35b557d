"""Comparison of two runs: every channel of the candidate held against the baseline's."""

from __future__ import annotations

import fnmatch
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field

from motionlab.config.scenario import VariantName
from motionlab.errors import ConfigError, FieldError
from motionlab.runs.align import (
    REFERENCE,
    Align,
    Alignment,
    Reason,
    Samples,
    by_index,
    by_reference,
    by_time,
)
from motionlab.runs.columns import Columns, renamed
from motionlab.runs.difference import (
    Bounds,
    Curve,
    Difference,
    Positions,
    beyond_in_time,
    beyond_in_value,
    resampled,
    within,
)
from motionlab.telemetry.decimate import min_max

Interpolation = Literal["linear", "hold"]
Verdict = Literal["within", "out-of-tolerance", "units-differ", "empty", "missing"] | Reason
Pattern = Annotated[str, Field(min_length=1, max_length=100)]

RULES_MAX = 1000
"""Rules and selections of channels in one request."""

_BATCH = 6  # columns that a thread reads at a time: fewer read the file's footer too often
_THREADS = 4
_DOUBLES = 12  # arrays of float64 an instant takes at most while runs are aligned


class Tolerance(BaseModel):
    """How far a channel may be from the baseline: max(absolute, relative * abs(baseline))."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    absolute: float = Field(default=0.0, ge=0.0, description="In the unit of the channel")
    relative: float = Field(default=0.0, ge=0.0, description="Share of the baseline's value")
    time: float = Field(
        default=0.0, ge=0.0, description="How much earlier or later it may be there, s"
    )


class Rule(BaseModel):
    """What holds for some channels; what is left out is as for all others."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    absolute: float | None = Field(default=None, ge=0.0, description="In the unit of the channel")
    relative: float | None = Field(default=None, ge=0.0, description="Share of the baseline")
    time: float | None = Field(default=None, ge=0.0, description="Tolerance in time, s")
    interpolation: Interpolation | None = Field(
        default=None, description="Between samples; hold for flags and commands, otherwise linear"
    )


class Comparing(BaseModel):
    """How two runs are compared."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    align: Align = Field(
        default="time", description="reference: by lap and arc length of the position reference"
    )
    offset: float = Field(
        default=0.0, strict=True, description="With align time: how far b is moved, s"
    )
    samples: Samples = Field(
        default="union", description="Instants: samples of either run, or only those of both"
    )
    tolerance: Tolerance = Field(default=Tolerance(), description="Of all channels")
    channels: dict[Pattern, Rule] = Field(
        default_factory=dict,
        max_length=RULES_MAX,
        description="By name, or by a pattern such as *.following_error; a name counts before "
        "patterns, of these the last that fits",
    )
    only: list[Pattern] = Field(
        default_factory=list,
        max_length=RULES_MAX,
        description="Names or patterns of the channels to compare; all when left out",
    )
    variants: dict[VariantName, VariantName] = Field(
        default_factory=dict,
        max_length=26,
        description="Letters of variants of b to those of a that they are compared with",
    )


class Side(BaseModel):
    """One of the two runs."""

    name: str = Field(description="Identifier or file")
    start: float = Field(description="Time of its first sample, s")
    period: float = Field(description="Time between two samples, s")
    ticks: int = Field(description="Samples, missing ones included")


class Place(BaseModel):
    """An instant of the comparison."""

    time: float = Field(description="In the baseline, s")
    candidate_time: float = Field(description="In the candidate, by its own clock, s")
    lap: int | None = Field(description="With align reference; counted from 0")
    arc: float | None = Field(description="With align reference: since the lap began, m")


class ChannelComparison(BaseModel):
    """One channel of the candidate against that of the baseline."""

    name: str
    unit: str | None = Field(description="In the baseline; null where it is missing")
    candidate_unit: str | None
    verdict: Verdict
    interpolation: Interpolation
    tolerance: Tolerance
    largest: float | None = Field(
        description="Candidate minus baseline where they are farthest apart; null without a value"
    )
    at: Place | None = Field(description="Where that is first")
    beyond: float | None = Field(description="Share of the instants beyond the tolerance")
    rms: float | None = Field(description="Root mean square of the difference")
    compared: int = Field(description="Instants at which both have a value")
    single: int = Field(description="Instants at which only one has; beyond any value")


class Comparison(BaseModel):
    """Two runs compared; what could not be compared does not hold."""

    a: Side = Field(description="The baseline")
    b: Side = Field(description="The candidate")
    align: Align
    offset: float
    samples: Samples
    instants: int = Field(description="Instants of the overlap")
    start: Place | None = Field(description="Where the overlap begins; null where there is none")
    end: Place | None = Field(description="Its last instant")
    lap_length: float | None = Field(description="Mean length of the baseline's laps, m")
    standing: float = Field(
        description="Share of the baseline left out because its reference stands still"
    )
    note: str = Field(description="Why the runs are not aligned; empty where they are")
    channels: list[ChannelComparison]
    within: int = Field(description="Channels within tolerance")
    holds: bool = Field(description="Whether all are")
    headline: str


@dataclass(frozen=True)
class Aligned:
    """Two runs and how they are compared.

    Attributes
    ----------
    baseline, candidate : Columns
        The runs.
    how : Comparing
        What was asked for.
    alignment : Alignment
        The instants.
    """

    baseline: Columns
    candidate: Columns
    how: Comparing
    alignment: Alignment

    @property
    def names(self) -> list[str]:
        """Channels to compare: those of the baseline, then those that only the candidate has."""
        every = list(dict.fromkeys([*self.baseline.units, *self.candidate.units]))
        only = self.how.only
        return [n for n in every if not only or any(_fits(n, p) for p in only)]

    def rule(self, name: str) -> tuple[Tolerance, Interpolation]:
        """Return tolerance and interpolation of a channel."""
        wanted = self.how.channels.get(name)
        if wanted is None:
            fit = [r for p, r in self.how.channels.items() if _fits(name, p)]
            wanted = fit[-1] if fit else Rule()
        given = wanted.model_dump(exclude={"interpolation"}, exclude_none=True)
        unit = self.baseline.units.get(name) or self.candidate.units.get(name)
        held = unit == "1" or "command" in name
        return (
            self.how.tolerance.model_copy(update=given),
            wanted.interpolation or ("hold" if held else "linear"),
        )

    def place(self, instant: int) -> Place:
        """Return where an instant is."""
        path = self.alignment.path
        own = _at(self.alignment.baseline, instant)
        other = _at(self.alignment.candidate, instant)
        return Place(
            time=self.baseline.grid.first + own * self.baseline.grid.period,
            candidate_time=self.candidate.grid.first + other * self.candidate.grid.period,
            lap=None if path is None else int(path.lap[instant]),
            arc=None if path is None else float(path.arc[instant]),
        )

    def axis(self, instants: NDArray[np.int64]) -> NDArray[np.floating[Any]]:
        """Return where instants are: baseline's time, arc length over all laps, or sample."""
        if self.alignment.path is not None:
            return self.alignment.path.coordinate[instants]
        positions = self.alignment.baseline
        if isinstance(positions, slice):
            places = positions.start + instants.astype(np.float64)
        else:
            places = positions[instants]
        if self.how.align == "index":
            return places
        return self.baseline.grid.first + places * self.baseline.grid.period

    def curves(self, own: Curve, other: Curve, interpolation: Interpolation) -> tuple[Curve, Curve]:
        """Return the values of a channel of both runs at all instants."""
        hold = interpolation == "hold"
        return (
            resampled(own, self.alignment.baseline, hold=hold),
            resampled(other, self.alignment.candidate, hold=hold),
        )

    def beyond(
        self, baseline: Curve, candidate: Curve, samples: Curve, name: str
    ) -> NDArray[np.bool_]:
        """Return the instants at which a channel is beyond its tolerance.

        Parameters
        ----------
        baseline, candidate : ndarray, shape (instants,)
            From `curves`.
        samples : ndarray, shape (ticks,)
            The candidate's.
        name : str
            The channel.
        """
        tolerance, interpolation = self.rule(name)
        absolute, relative = tolerance.absolute, tolerance.relative
        if tolerance.time == 0.0:
            return beyond_in_value(baseline, candidate, absolute, relative)
        return beyond_in_time(
            baseline,
            samples,
            self.alignment.candidate,
            Bounds(absolute, relative, tolerance.time / self.candidate.grid.period),
            hold=interpolation == "hold",
        )


def align(baseline: Columns, candidate: Columns, how: Comparing) -> Aligned:
    """Align two runs.

    Raises
    ------
    ConfigError
        If a rule or a selection fits no channel, an offset is given without align time, or a
        variant cannot be renamed.
    """
    candidate = renamed(candidate, baseline, how.variants)
    known = [*baseline.units, *candidate.units]
    wrong = [
        FieldError(f"{field}.{pattern}", "fits no channel of either run")
        for field, patterns in (("channels", how.channels), ("only", how.only))
        for pattern in patterns
        if not any(_fits(name, pattern) for name in known)
    ]
    if how.offset != 0.0 and how.align != "time":
        wrong.append(FieldError("offset", "only moves runs aligned by time", how.offset, "0", "s"))
    if wrong:
        raise ConfigError(*wrong)
    return Aligned(baseline, candidate, how, _aligned(baseline, candidate, how))


def _fits(name: str, pattern: str) -> bool:
    """Return whether a channel has a name, which may hold brackets, or fits a pattern."""
    return name == pattern or fnmatch.fnmatchcase(name, pattern)


def size(baseline: Columns, candidate: Columns) -> int:
    """Return the memory that a comparison takes at most, bytes."""
    ticks = baseline.grid.ticks + candidate.grid.ticks
    columns = _threads() * _batch(ticks)
    return (
        baseline.size(columns)
        + candidate.size(columns)
        + (_DOUBLES + 2 * _threads()) * ticks * np.dtype(np.float64).itemsize
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
        See `align`.
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
            for found in threads.map(lambda some: _channels(aligned, some), batches):
                channels += found
                progress(len(channels) / len(names))
        except BaseException:
            threads.shutdown(cancel_futures=True)
            raise
    good = sum(channel.verdict == "within" for channel in channels)
    count, path = aligned.alignment.instants, aligned.alignment.path
    return Comparison(
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
        headline=f"{good} of {len(channels)} channels hold",
    )


class Curves(NamedTuple):
    """One channel of two runs over bins of as many instants each; the last may hold fewer.

    Attributes
    ----------
    start : float
        Where the first instant is: time of the baseline, s; lap times lap length plus arc, m; or
        sample.
    bin : int
        Instants in a bin.
    axis : ndarray, shape (bins,)
        Where the first instant of each bin is, less `start`.
    names : tuple of str
        baseline, candidate, difference, tolerance, and beyond: 1 where it is, otherwise 0.
    low, high : ndarray of float32, shape (names, bins)
        Least and largest value; NaN where one of the bin is missing.
    """

    start: float
    bin: int
    axis: NDArray[np.floating[Any]]
    names: tuple[str, ...]
    low: NDArray[np.float32]
    high: NDArray[np.float32]


def curves(aligned: Aligned, name: str, start: int, stop: int, points: int) -> Curves:
    """Return a channel of two runs at instants [start, stop) in at most `points` bins."""
    (own,), (other,) = aligned.baseline.read([name]), aligned.candidate.read([name])
    tolerance, interpolation = aligned.rule(name)
    baseline, candidate = aligned.curves(own, other, interpolation)
    beyond = aligned.beyond(baseline, candidate, other, name)
    part = slice(start, stop)
    b, c = (curve[part].astype(np.float64) for curve in (baseline, candidate))
    allowed = np.maximum(tolerance.absolute, tolerance.relative * np.abs(b))
    samples = np.stack([b, c, c - b, allowed, beyond[part]]).astype(np.float32)
    low, high = min_max(samples, points)
    bin_size = max(1, -(-(stop - start) // points))
    axis = aligned.axis(np.arange(start, stop, bin_size))
    names = ("baseline", "candidate", "difference", "tolerance", "beyond")
    return Curves(float(axis[0]), bin_size, axis - axis[0], names, low, high)


def _aligned(baseline: Columns, candidate: Columns, how: Comparing) -> Alignment:
    match how.align:
        case "time":
            return by_time(baseline.grid, candidate.grid, offset=how.offset, samples=how.samples)
        case "index":
            return by_index(baseline.grid, candidate.grid)
        case "reference":
            for side in (baseline, candidate):
                if lacking := [name for name in REFERENCE if name not in side.units]:
                    note = f"{side.name} has no {' and no '.join(lacking)}"
                    return Alignment(0, reason="not-aligned", note=note)
            own, other = (side.read(REFERENCE).astype(float) for side in (baseline, candidate))
            return by_reference(own, other, samples=how.samples)


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
    tolerance, interpolation = aligned.rule(name)
    baseline, candidate = aligned.curves(own, other, interpolation)
    found = within(baseline, candidate, tolerance.absolute, tolerance.relative)
    if found.beyond and tolerance.time > 0.0:
        flags = aligned.beyond(baseline, candidate, other, name)
        found = found._replace(beyond=int(np.count_nonzero(flags)))
    return _verdict(aligned, name, found)


def _verdict(aligned: Aligned, name: str, found: Difference | None = None) -> ChannelComparison:
    """Return the verdict of a channel; without a difference it could not be compared."""
    tolerance, interpolation = aligned.rule(name)
    units = (aligned.baseline.units.get(name), aligned.candidate.units.get(name))
    verdict: Verdict
    if None in units:
        verdict = "missing"
    elif units[0] != units[1]:
        verdict = "units-differ"
    elif found is None:
        verdict = aligned.alignment.reason or "not-aligned"
    elif not found.compared:
        verdict = "empty"
    else:
        verdict = "out-of-tolerance" if found.beyond else "within"
    compared = 0 if found is None else found.compared
    single = 0 if found is None else found.single
    return ChannelComparison(
        name=name,
        unit=units[0],
        candidate_unit=units[1],
        verdict=verdict,
        interpolation=interpolation,
        tolerance=tolerance,
        largest=found.largest if found and compared else None,
        at=aligned.place(found.where) if found and compared else None,
        beyond=found.beyond / (compared + single) if found and compared + single else None,
        rms=found.rms if found and compared else None,
        compared=compared,
        single=single,
    )


def _side(columns: Columns) -> Side:
    first, period, ticks = columns.grid
    return Side(name=columns.name, start=first, period=period, ticks=ticks)


def _at(positions: Positions, instant: int) -> float:
    if isinstance(positions, slice):
        return float(positions.start + instant)
    return float(positions[instant])


def _batch(ticks: int) -> int:
    """Return how many columns are read at a time: one of a run of hours."""
    return max(1, min(_BATCH, _BATCH * 2_000_000 // max(1, ticks)))


def _threads() -> int:
    return min(_THREADS, len(os.sched_getaffinity(0)))
