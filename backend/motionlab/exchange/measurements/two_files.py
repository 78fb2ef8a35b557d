"""Two files of one motion, each with its own clock, as one: the second on the time of the first."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.channels import columns_of, time_of
from motionlab.exchange.measurements.clock_alignment import Alignment, Record, aligned
from motionlab.exchange.measurements.document import VALUES_MAX, ImportOptions, Merged
from motionlab.exchange.measurements.sample_times import Grid, interpolated, sample_times
from motionlab.exchange.measurements.table_file import FileColumn, MeasuredFile, refused

_CORRELATION_LEAST = 0.5
_OFFSET_MAX = 1e10  # s: one clock may count from 1970, the other from its start


@dataclass
class _Clocked:
    """A file with its times."""

    file: MeasuredFile
    column: FileColumn
    grid: Grid  # times from the first row
    start: float  # s, of the first row
    begun: float | None  # the same since 1970, where the file has it

    @property
    def times(self) -> NDArray[np.float64]:
        return self.grid.times

    @classmethod
    def of(cls, file: MeasuredFile, options: ImportOptions, which: str) -> _Clocked:
        column, factor, begun = time_of(file, options, which)
        seconds = factor * (column.values - column.values[0])
        grid = sample_times(seconds, file.place)
        return cls(file, column, grid, factor * float(column.values[0]), begun)


def merged(
    first: MeasuredFile, second: MeasuredFile, options: ImportOptions
) -> tuple[MeasuredFile, Merged, ImportOptions]:
    """Put the columns of a second file on the times of the first, by linear interpolation.

    Parameters
    ----------
    first, second : MeasuredFile
        The files.
    options : ImportOptions
        `align` and `offset` say how the clocks are set against each other; a mapping holds for the
        file that has its column.

    Returns
    -------
    MeasuredFile
        Columns of both; those of the second whose name the first has too end in `` (2)``. NaN where
        the second has nothing.
    Merged
        Offset, drift and how they came about.
    ImportOptions
        Those that hold for both as one.

    Raises
    ------
    ConfigError
        If a file has no time, no column is in both, or they do not show one motion.
    """
    if options.rate is not None:
        raise ConfigError(FieldError("rate", "two files are merged by their own times"))
    one = _Clocked.of(first, options, "the first file")
    two = _Clocked.of(second, options, "the second file")
    # Time of the second file's first row, s from the first row of the first, were they one clock.
    base = two.start - one.start
    if one.begun is not None and two.begun is not None:
        base = two.begun - one.begun
    fit, names = None, ("", "")
    if options.offset is None:
        fit, names = _estimated(one, two, base, options)
        offset, drift = fit.offset, fit.drift
        if fit.other is not None:
            message = (
                f"offsets of {_seconds(offset)} and {_seconds(fit.other)} fit about as well, since "
                f"{names[0]!r} repeats: give the offset, or align a column that does not repeat"
            )
            raise ConfigError(FieldError("offset", message))
    else:
        offset, drift = options.offset, 0.0
        if not abs(offset) <= _OFFSET_MAX:
            bounds: dict[str, float] = {"minimum": -_OFFSET_MAX, "maximum": _OFFSET_MAX}
            raise ConfigError(
                FieldError("offset", "is out of range", offset, unit="s", bounds=bounds)
            )
    at = (one.times - offset) / (1.0 + drift) - base  # in s from the first row of the second
    inside = (at >= 0.0) & (at <= two.times[-1])
    if not inside.any():
        raise refused(
            "the second file has no sample while the first lasts, at an offset of "
            f"{_seconds(offset)}: the first lasts {_seconds(float(one.times[-1]))}, and the second "
            f"begins {_seconds(base + offset)} after its first row and lasts "
            f"{_seconds(float(two.times[-1]))}"
        )
    added = [column for column in second.columns if column is not two.column]
    if len(at) * (len(first.columns) + len(added)) > VALUES_MAX:
        raise refused("has too many numbers with those of the second file")
    taken = {column.header for column in first.columns}
    for column in added:
        values = np.where(
            inside, interpolated(two.grid, column.values, np.maximum(at, 0.0)), np.nan
        )
        header = column.header if column.header not in taken else f"{column.header} (2)"
        taken.add(header)
        first.columns.append(replace(column, header=header, values=values, instant=False))
    first.ignored |= {f"{name} (2)": why for name, why in second.ignored.items()}
    first.notes += [f"second file: {note}" for note in second.notes]
    about = Merged(
        rows=len(two.times),
        samples=int(np.count_nonzero(inside)),
        offset=offset,
        offset_half_width=_width(fit and fit.offset_half_width),
        drift=drift,
        drift_half_width=_width(fit and fit.drift_half_width),
        first=names[0],
        second=names[1],
        correlation=fit and fit.correlation,
    )
    return first, about, replace(options, mapping=_left(one, two, options))


def _seconds(value: float) -> str:
    """Return a time to the microsecond, of any size."""
    return f"{value:.6f}".rstrip("0").rstrip(".") + " s"


def _width(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None


def _left(one: _Clocked, two: _Clocked, options: ImportOptions) -> tuple[str, ...]:
    """Return the mappings but for the second file's time, which the merged table lacks."""
    names = {column.header for column in one.file.columns}

    def of_second(text: str) -> bool:
        column, _, channel = text.rpartition("=")
        time = channel.strip().split("[")[0] == "time"
        return time and column.strip() not in names and two.column.header.startswith(column.strip())

    return tuple(text for text in options.mapping if not of_second(text))


def _estimated(
    one: _Clocked, two: _Clocked, base: float, options: ImportOptions
) -> tuple[Alignment, tuple[str, str]]:
    """Return offset and drift by a column of each file, and the columns' names."""
    left, right, sign = _common(one, two, options)
    pairs = []
    for clocked, column, shift, factor in ((one, left, 0.0, 1.0), (two, right, base, sign)):
        finite = np.isfinite(column.values)
        if np.count_nonzero(finite) < 2:
            raise ConfigError(FieldError("align", "has too few numbers", column.header))
        record = Record(clocked.times[finite] + shift, factor * column.values[finite])
        pairs.append(record)
    fit = aligned(*pairs)
    names = left.header, right.header
    if fit is None or fit.correlation < _CORRELATION_LEAST:
        largest = "" if fit is None else f", the largest correlation is {fit.correlation:.2f}"
        message = f"{names[0]!r} and {names[1]!r} do not show one motion{largest}: name others, or "
        raise ConfigError(FieldError("align", f"{message}give the offset", options.align or None))
    return fit, names


def _common(
    one: _Clocked, two: _Clocked, options: ImportOptions
) -> tuple[FileColumn, FileColumn, float]:
    """Return the columns that are aligned, and the sign of the second."""
    if options.align:
        return _named(one, two, options.align)
    channels = [
        {c.channel: c.source for c in columns_of(each.file, options) if c.channel not in {"", "-"}}
        for each in (one, two)
    ]
    headers = [{c.header: c for c in each.file.columns} for each in (one, two)]
    for first, second in (channels, headers):
        for name, column in first.items():
            other = second.get(name)
            if name != "time" and other is not None and column is not one.column:
                if other is not two.column and np.nanstd(column.values) > 0:
                    return column, other, 1.0
    message = "no column is in both files: name one of each as A=B, or give the offset"
    raise ConfigError(FieldError("align", message))


def _named(one: _Clocked, two: _Clocked, align: str) -> tuple[FileColumn, FileColumn, float]:
    left, equals, right = align.rpartition("=")
    if not equals:
        left = right
    column = _column(one.file, left)
    if (other := _column(two.file, right)) is None and right.startswith("-"):
        return _required(column, left), _required(_column(two.file, right[1:]), right[1:]), -1.0
    return _required(column, left), _required(other, right), 1.0


def _column(file: MeasuredFile, name: str) -> FileColumn | None:
    return next((column for column in file.columns if column.header == name.strip()), None)


def _required(column: FileColumn | None, name: str) -> FileColumn:
    if column is None:
        raise ConfigError(FieldError("align", "no column of that name", name, "COLUMN or A=B"))
    return column
