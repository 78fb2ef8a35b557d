"""The part of a kept run that a study reads: chosen by time, within limits, without gaps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.plant import OURS
from motionlab.config.quantity import Config, quantity
from motionlab.errors import Busy, ConfigError, FieldError, Unknown
from motionlab.library.run import RunDetail

SAMPLES_MAX = 1_000_000
"""Most samples of a part: 500 s at 2 kHz."""


class PartOptions(Config):
    """The part of a run that is read."""

    start: float = quantity(
        "Where the part of the run that is read begins",
        label="from",
        unit="s",
        source=OURS,
        default=0.0,
        ge=0.0,
        le=1e9,
    )
    end: float | None = quantity(
        "Where it ends; left out: the end of the run",
        label="to",
        unit="s",
        source=OURS,
        default=None,
        gt=0.0,
        le=1e9,
    )


class Part(NamedTuple):
    """Samples of a run, [first, stop)."""

    run: RunDetail
    first: int
    stop: int

    @property
    def samples(self) -> int:
        """How many there are."""
        return self.stop - self.first

    @property
    def seconds(self) -> float:
        """Their length, s."""
        return self.samples * self.run.period

    @property
    def is_whole(self) -> bool:
        """Whether it is the whole run."""
        return (self.first, self.stop) == (0, self.run.ticks)

    def interval(self, begin: int, end: int) -> str:
        """Return samples counted from its first as times of the run."""
        first, last = (rounded((self.first + k) * self.run.period) for k in (begin, end))
        return f"{first:g} s to {last:g} s"


def kept_run(run_id: str, loc: str = "run") -> RunDetail:
    """Return a run that is complete; errors name `loc`.

    Raises
    ------
    ConfigError
        If there is none, or it is still recorded.
    """
    from motionlab.library.library import library

    try:
        return library().complete(run_id)
    except (Unknown, Busy) as error:
        raise ConfigError(FieldError(loc, str(error), run_id, "a kept run")) from error


def part_of(  # noqa: PLR0913 - what is chosen, and the limits of a study
    options: PartOptions,
    run: RunDetail,
    *,
    loc: str = "",
    seconds_min: float = 0.0,
    samples_max: int = SAMPLES_MAX,
    short: str = "leaves too short a part",
) -> Part:
    """Return the part that options choose.

    Parameters
    ----------
    options : PartOptions
        Begin and end, s.
    run : RunDetail
        The run.
    loc : str
        Before the names of the fields, such as ``record.``.
    seconds_min : float
        Least length, s.
    samples_max : int
        Most samples.
    short : str
        What is wrong with one that is shorter than `seconds_min`.

    Raises
    ------
    ConfigError
        If it lies after the run, is too short or too long; naming the field below `loc`.
    """
    period, end = run.period, options.end
    first = round(options.start / period)
    stop = run.ticks if end is None else min(run.ticks, round(end / period))
    part, least = Part(run, first, stop), max(seconds_min, 2.0 * period)
    if first >= run.ticks:
        message, bounds = "lies after the end of the run", {"exclusive_maximum": run.ticks * period}
        raise ConfigError(
            FieldError(f"{loc}start", message, options.start, unit="s", bounds=bounds)
        )
    field = "run" if part.is_whole else f"{loc}end" if end is not None else f"{loc}start"
    if end is not None and stop <= first:
        bounds = {"exclusive_minimum": options.start}
        raise ConfigError(FieldError(f"{loc}end", "is before the start", end, "", "s", bounds))
    if part.seconds < least * (1.0 - 1e-9):
        raise ConfigError(_short(field, short, part.seconds, least))
    if part.samples > samples_max:
        bounds = {"maximum": samples_max * period}
        message = "is longer than this study reads: choose a part by start and end"
        length = rounded(part.seconds)
        raise ConfigError(FieldError(field, message, length, unit="s", bounds=bounds))
    return part


def without_gaps(
    part: Part, samples: NDArray[np.float64], seconds_min: float = 0.0
) -> tuple[Part, list[str]]:
    """Return the longest stretch of a part in which no sample is missing, and a note on others.

    Parameters
    ----------
    part : Part
        That was read.
    samples : ndarray, shape (columns, n)
        Its columns; NaN where a sample is missing.
    seconds_min : float
        Least length of the stretch, s.

    Raises
    ------
    ConfigError
        If there is no such stretch.
    """
    first, stop = longest(np.asarray(np.isfinite(samples).all(axis=0)))
    if stop - first == part.samples:
        return part, []
    stretch = Part(part.run, part.first + first, part.first + stop)
    gap = np.flatnonzero(~np.isfinite(samples).all(axis=0))
    lacking = f"lacks {len(gap)} samples from {part.interval(int(gap[0]), int(gap[-1]) + 1)}"
    least = max(seconds_min, 2.0 * part.run.period)
    if stretch.seconds < least * (1.0 - 1e-9):
        message = f"{lacking}, and its longest stretch without a gap is too short"
        raise ConfigError(_short("run", message, stretch.seconds, least))
    return stretch, [
        f"the run {lacking}: its longest stretch without a gap is read, "
        f"{part.interval(first, stop)}"
    ]


def longest(flags: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the longest stretch of true flags, [first, stop)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], flags.astype(np.int8), [0]])))
    if not edges.size:
        return 0, 0
    begin, end = edges[::2], edges[1::2]
    most = int(np.argmax(end - begin))
    return int(begin[most]), int(end[most])


def first_stretch(flags: NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first stretch of true flags, [first, stop), of which there is one."""
    first = int(np.argmax(flags))
    rest = flags[first:]
    return first, first + (len(rest) if rest.all() else int(np.argmin(rest)))


def rounded(seconds: float) -> float:
    """Return a time as an error shows it, s."""
    return float(f"{seconds:.6g}")


def _short(loc: str, message: str, seconds: float, least: float) -> FieldError:
    bounds = {"minimum": rounded(least)}
    return FieldError(loc, message, rounded(seconds), unit="s", bounds=bounds)
