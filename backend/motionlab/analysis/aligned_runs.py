"""Two runs aligned: the curves of a channel at common instants, and its tolerance there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.alignment import (
    COINCIDENT,
    REFERENCE,
    Alignment,
    between,
    by_index,
    by_reference,
    by_time,
)
from motionlab.analysis.columns import Columns, renamed
from motionlab.analysis.comparison_document import Place
from motionlab.analysis.comparison_options import Comparing, Interpolation, Rule, Tolerance, fits
from motionlab.analysis.curve_difference import (
    Bounds,
    Curve,
    Positions,
    beyond_in_time,
    beyond_in_value,
    resampled,
)
from motionlab.analysis.judgement import sensible, telling
from motionlab.errors import ConfigError, FieldError
from motionlab.telemetry.decimate import min_max


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
        own, other, only = self.baseline.units, self.candidate.units, self.how.only
        every = list(dict.fromkeys([*own, *other]))
        if only or self.how.exact:
            return [n for n in every if not only or any(fits(n, p) for p in only)]
        return telling([name for name in every if own.get(name) == other.get(name)] or every)

    def rule(
        self, name: str, own: Curve | None = None, other: Curve | None = None
    ) -> tuple[Tolerance, Interpolation]:
        """Return tolerance and interpolation of a channel, given its values in both runs."""
        rule = self.how.channels.get(name)
        if rule is None:
            fit = [r for p, r in self.how.channels.items() if fits(name, p)]
            rule = fit[-1] if fit else Rule()
        limits = rule.model_dump(exclude={"interpolation"}, exclude_none=True)
        unit = self.baseline.units.get(name) or self.candidate.units.get(name)
        held = unit == "1" or "command" in name
        tolerance = self.how.tolerance or Tolerance()
        if self.how.tolerance is None and not self.how.exact and own is not None:
            axis = name.rpartition(".")[0][-1:]
            count = self.baseline.counts.get(axis, 0.0) if unit == "m" else 0.0
            tolerance = sensible(own, own if other is None else other, count)
        return (
            tolerance.model_copy(update=limits),
            rule.interpolation or ("hold" if held else "linear"),
        )

    def place(self, instant: int) -> Place:
        """Return the abscissa of an instant."""
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
        """Return the abscissa of instants: baseline time, arc length over all laps, or sample."""
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
        tolerance, interpolation = self.rule(name, baseline, candidate)
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
        If a rule or a selection fits no channel, an offset is given without align time, the end is
        before the start, or a variant cannot be renamed.
    """
    candidate = renamed(candidate, baseline, how.variants)
    known = [*baseline.units, *candidate.units]
    wrong = [
        FieldError(f"{field}.{pattern}", "fits no channel of either run")
        for field, patterns in (("channels", how.channels), ("only", how.only))
        for pattern in patterns
        if not any(fits(name, pattern) for name in known)
    ]
    if how.offset != 0.0 and how.align != "time":
        wrong.append(FieldError("offset", "only moves runs aligned by time", how.offset, "0", "s"))
    if how.start is not None and how.end is not None and how.end < how.start:
        bounds = {"minimum": how.start}
        wrong.append(FieldError("end", "is before the start", how.end, unit="s", bounds=bounds))
    if wrong:
        raise ConfigError(*wrong)
    return Aligned(
        baseline, candidate, how, _within(_aligned(baseline, candidate, how), baseline, how)
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
    _, interpolation = aligned.rule(name)
    baseline, candidate = aligned.curves(own, other, interpolation)
    tolerance, _ = aligned.rule(name, baseline, candidate)
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


def _within(alignment: Alignment, baseline: Columns, how: Comparing) -> Alignment:
    """Return the instants within the requested time range."""
    if not alignment.instants or (how.start is None and how.end is None):
        return alignment
    start, end = (
        default if time is None else time
        for time, default in ((how.start, -math.inf), (how.end, math.inf))
    )
    first, period, _ = baseline.grid
    low, high = ((time - first) / period for time in (start, end))
    cut = between(alignment, low - COINCIDENT, high + COINCIDENT)
    if cut.instants:
        return cut
    stretch = " ".join(
        f"{word} {time:g} s"
        for word, time in (("from", how.start), ("to", how.end))
        if time is not None
    )
    return Alignment(0, reason="ranges-differ", note=f"the runs share no instant {stretch}")


def _at(positions: Positions, instant: int) -> float:
    if isinstance(positions, slice):
        return float(positions.start + instant)
    return float(positions[instant])
