"""Measurements of real machines: a file's columns become channels of a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements.column_guess import (
    GUESSED_AXIS,
    OWN_NAME,
    TARGETS,
    UNITS,
    VARIANT,
    Mapping,
    channel_of,
    instant_of,
    label,
    parse_mapping,
    scaled,
    si_of,
    spelt,
    unit_by_range,
    unit_of_time,
)
from motionlab.exchange.measurements.document import (
    FIRST_SHOWN,
    GAPS_SHOWN,
    RATE_MAX,
    VALUES_MAX,
    Import,
    ImportedColumn,
    ImportedGap,
    ImportOptions,
)
from motionlab.exchange.measurements.sample_times import (
    Grid,
    resampled,
    resampled_ticks,
    sample_times,
)
from motionlab.exchange.measurements.table_file import FileColumn, MeasuredFile, refused

_RESERVED = {"tick", "time"}
_LISTED = 20  # columns that an error names
_NAME_MAX = 100


@dataclass
class Measurement:
    """Samples of a measurement at equal steps, SI.

    Attributes
    ----------
    document : Import
        How they came about.
    period : float
        Time between two, s.
    begun : float or None
        Instant of the first, seconds since 1970, where the file has it.
    columns : dict of str to (str, str)
        Unit and meaning of each column.
    values : dict of str to ndarray of float32
        NaN where one is missing.
    gaps : list of (int, int)
        First missing sample and number of missing ones, of each gap.
    """

    document: Import
    period: float
    begun: float | None
    columns: dict[str, tuple[str, str]] = field(default_factory=dict)
    values: dict[str, NDArray[np.float32]] = field(default_factory=dict)
    gaps: list[tuple[int, int]] = field(default_factory=list)


@dataclass
class _Column:
    """A column of the file on its way."""

    source: FileColumn
    name: str  # without unit
    unit: str
    channel: str = ""
    why: str = ""
    factor: float = 1.0
    mapped: int = -1  # number of the mapping that says so

    @property
    def values(self) -> NDArray[np.float64]:
        """Values in SI."""
        return self.factor * self.source.values

    @property
    def si(self) -> str:
        si_unit = si_of(self.unit) if self.unit else None
        return si_unit[0] if si_unit else ""


def read_measurement(file: MeasuredFile, options: ImportOptions) -> Measurement:
    """Return the samples of a file, and a document of all that was guessed and done.

    The columns of the file are empty afterwards.

    Where ``problems`` of the document is not empty there are no samples: the document is a preview.

    Raises
    ------
    ConfigError
        If a mapping or a rate cannot be used, or the times are not in order.
    """
    _check_rates(options)
    columns = _assigned(file, options)
    _find_units(columns)
    times, rate_from = _times(file, columns, options)
    document = Import(
        format=file.format,
        text=file.text,
        rows=len(file.columns[0].values),
        columns=[],
        ignored=file.ignored,
        rate=None,
        rate_from=rate_from,
        duration=None,
        ticks=None,
        median_rate=None,
        jitter=None,
        gaps=[],
        gap_count=0,
        missing=0,
        resampled=None,
        derived=[],
        problems=[],
        notes=file.notes,
        channels={"time": "s"} | {name: target.unit for name, target in TARGETS.items()},
        units={si: list(map(spelt, factors)) for si, factors in UNITS.items()},
    )
    kept = _named(columns)
    document.columns = [_described(file, column, name) for column, name in kept]
    data = [(column, name) for column, name in kept if name]
    if not data:
        document.problems.append("no column is left: map one to a channel")
    if times is None:
        document.problems.append("there is no column of time: map one to time, or give the rate")
    if document.problems or times is None:
        return Measurement(document, 0.0, None)
    grid = sample_times(times, file.place, options.rate)
    _describe_times(document, grid, file)
    if grid.uneven and options.resample is None:
        document.problems.append(
            f"samples are up to {grid.jitter:.3g} s off equal steps of {grid.period:.3g} s: give "
            f"the rate to resample to; the median rate is {document.median_rate:.6g} Hz"
        )
        return Measurement(document, 0.0, None)
    measurement = Measurement(document, grid.period, _begun(file, columns))
    errors = _missing_errors(data)
    document.derived = list(errors)
    count = len(data) + len(errors)
    spread: Callable[[NDArray[np.float64]], NDArray[np.float64]] = grid.placed
    if options.resample is None:
        measurement.gaps, document.ticks = grid.gaps, grid.ticks
        if grid.ticks * count > VALUES_MAX:
            raise refused("has too many samples with its gaps", grid.ticks * count)
    else:
        document.resampled, document.rate = document.rate, options.resample
        measurement.period = period = 1.0 / options.resample
        document.ticks = ticks = resampled_ticks(grid, period, count)
        spread = partial(resampled, grid, period=period, ticks=ticks)
    document.duration = document.ticks * measurement.period
    samples = {
        name: _stored(name, spread(reference.values - measured.values))
        for name, (reference, measured) in errors.items()
    }
    for column, name in data:
        samples[name] = _stored(name, spread(column.values))
        column.source.values = np.empty(0)  # of a long file, at most one column is there twice
    own = {
        name: (column.unit, f"column {column.source.header!r} of the file")
        for column, name in data
        if not column.channel
    }
    for name in [n for n in TARGETS if n in samples] + [n for n in samples if n in own]:
        target = TARGETS.get(name) if name not in own else None
        measurement.columns[name] = own[name] if target is None else (target.unit, target.meaning)
        measurement.values[name] = samples[name]
    return measurement


def time_of(
    file: MeasuredFile, options: ImportOptions, which: str = ""
) -> tuple[FileColumn, float, float | None]:
    """Return the column of time of a file, the factor to s, and the instant of its first row.

    Mappings of columns that the file does not have are passed over.

    Raises
    ------
    ConfigError
        If it has none; the text begins with `which`, such as ``the second file``.
    """
    columns = columns_of(file, options)
    for column in columns:
        if column.channel == "time":
            return column.source, column.factor, _begun(file, columns)
    headers = ", ".join(repr(column.header) for column in file.columns[:_LISTED])
    message = f"{which} has no column of time: call one 'time', or map it to time; it has {headers}"
    raise refused(message.strip())


def columns_of(file: MeasuredFile, options: ImportOptions) -> list[_Column]:
    """Return the columns of a file with channel and unit, where mappings may be of another file."""
    headings = [label(c.header, c.unit, bare=c.bare).name for c in file.columns]
    names = {c.header for c in file.columns} | set(headings)
    mapping = tuple(text for text in options.mapping if text.rpartition("=")[0].strip() in names)
    columns = _assigned(file, replace(options, mapping=mapping, rate=None))
    _find_units(columns)
    return columns


def _stored(name: str, values: NDArray[np.float64]) -> NDArray[np.float32]:
    with np.errstate(over="ignore"):
        samples = values.astype(np.float32)
    if np.isinf(samples).any():
        raise refused(f"column {name!r} has a number that float32 cannot hold")
    return samples


def _check_rates(options: ImportOptions) -> None:
    for loc, rate in (("rate", options.rate), ("resample", options.resample)):
        if rate is not None and not 0.0 < rate <= RATE_MAX:
            bounds: dict[str, float] = {"exclusive_minimum": 0.0, "maximum": RATE_MAX}
            raise ConfigError(FieldError(loc, "is out of range", rate, unit="Hz", bounds=bounds))


def _assigned(file: MeasuredFile, options: ImportOptions) -> list[_Column]:
    """Return the columns with their channels, given or guessed; each channel once."""
    columns = []
    for source in file.columns:
        heading = label(source.header, source.unit, bare=source.bare)
        columns.append(_Column(source, heading.name, heading.unit))
    assignments = _assignments(columns, parse_mapping(options.mapping))
    taken = {mapping.channel for _, mapping in assignments.values()} - {"", "-"}
    if options.rate is not None:
        taken.add("time")
    for index, column in enumerate(columns):
        if index in assignments:
            column.mapped, mapping = assignments[index]
            column.channel, column.why = mapping.channel, "map"
            column.unit = mapping.unit or column.unit
    guessed = [c for index, c in enumerate(columns) if index not in assignments]
    guesses = [(column, *_guess(column, own=file.own)) for column in guessed]
    timed = any(guess == "time" for _, guess, _ in guesses)
    instants = [column for column in guessed if column.source.instant]
    if not timed and len(instants) == 1:
        at = guessed.index(instants[0])
        guesses[at] = instants[0], "time", "the only column of instants"
    # A name that says all goes before one that says a part, whichever comes first.
    for column, channel, why in sorted(guesses, key=_vagueness):
        if column.name == "tick" and timed:
            column.channel, column.why = "-", "counts the samples"
        elif channel is None:
            column.why = "no channel has such a name"
        elif channel in taken:
            column.why = f"{channel} is another column already"
        elif column.unit and si_of(column.unit) is None:
            column.why = f"unit {column.unit!r} is not understood"
        elif channel != "time" and column.si and TARGETS[channel].unit != column.si:
            column.why = f"unit {column.unit} is not that of {channel}"
        else:
            column.channel, column.why = channel, why
            taken.add(channel)
    return columns


def _guess(column: _Column, *, own: bool) -> tuple[str | None, str]:
    """Return the channel that a column suggests; in files of exports names are what they are."""
    channel, why = channel_of(column.name, column.si)
    named = not own or why == OWN_NAME or column.name in {"time", "log_time"}
    return (channel, why) if named else (None, "")


def _vagueness(guess: tuple[_Column, str | None, str]) -> int:
    column, channel, why = guess
    if why == OWN_NAME or (channel == "time" and column.name.lower() in {"time", "zeit", "t"}):
        return 0
    return 2 if GUESSED_AXIS in why else 1


def _assignments(
    columns: Sequence[_Column], mappings: Sequence[Mapping]
) -> dict[int, tuple[int, Mapping]]:
    """Return number and mapping of each column that one is given for."""
    assignments: dict[int, tuple[int, Mapping]] = {}
    wrong = []
    channels: set[str] = set()
    for number, mapping in enumerate(mappings):
        text = f"{mapping.column}={mapping.channel}"
        exact = [i for i, c in enumerate(columns) if c.source.header == mapping.column]
        places = exact or [i for i, c in enumerate(columns) if c.name == mapping.column]
        if len(places) != 1:
            headers = ", ".join(c.source.header for c in columns[:30])
            message = "more than one column has that name" if places else "no column of that name"
            wrong.append(FieldError(f"map.{number}", message, mapping.column, f"one of {headers}"))
        elif places[0] in assignments or mapping.channel in channels:
            wrong.append(FieldError(f"map.{number}", "comes twice", text))
        else:
            assignments[places[0]] = (number, mapping)
            channels |= {mapping.channel} - {"", "-"}
    if wrong:
        raise ConfigError(*wrong)
    return assignments


def _find_units(columns: Sequence[_Column]) -> None:
    """Give every mapped column a unit; columns of one quantity without any share theirs."""
    for column in columns:
        if column.channel in {"", "-"}:
            continue
        si = "s" if column.channel == "time" else TARGETS[column.channel].unit
        if not column.unit and column.channel == "time":
            column.unit, why = unit_of_time(column.source.values)
            column.why += f"; {why}"
        elif not column.unit:
            column.unit = _unit_like(columns, column, si)
            column.why += "; unit from range"
        factor = si_of(column.unit) if column.mapped < 0 else scaled(column.unit)
        if factor is None or factor[0] != si:
            loc, allowed = f"map.{column.mapped}", f"a unit of {column.channel}, as in [{si}]"
            raise ConfigError(FieldError(loc, "has another unit", column.unit, allowed))
        column.factor = factor[1]


def _unit_like(columns: Sequence[_Column], column: _Column, si: str) -> str:
    if si == "1":
        return "1"
    kind = _quantity(column.channel)
    alike = [c for c in columns if c.channel in TARGETS and TARGETS[c.channel].unit == si]
    plain = [c for c in alike if si_of(c.unit)]  # no factor of another column
    known = [c.unit for c in plain if _quantity(c.channel) == kind]
    if not known and kind == "error":  # in the unit of the positions, as a rule
        known = [c.unit for c in plain]
    if known:
        return known[0]
    shared = [c for c in alike if _quantity(c.channel) == kind] or [column]
    if kind == "error":
        shared = [c for c in alike if _quantity(c.channel) == "position"] or shared
    return unit_by_range(si, max(float(np.nanmax(np.abs(c.source.values))) for c in shared))


def _quantity(channel: str) -> str:
    return (
        "error"
        if channel.endswith("following_error")
        else channel.rsplit(".", maxsplit=1)[-1].split("_", maxsplit=1)[0]
    )


def _times(
    file: MeasuredFile, columns: Sequence[_Column], options: ImportOptions
) -> tuple[NDArray[np.float64] | None, str]:
    if options.rate is not None:
        return np.arange(len(file.columns[0].values)) / options.rate, "rate"
    for column in columns:
        if column.channel == "time":
            first = column.source.values[0]
            return column.factor * (column.source.values - first), column.source.header
    return None, ""


def _begun(file: MeasuredFile, columns: Sequence[_Column]) -> float | None:
    """Return the instant of the first sample, seconds since 1970, if the file has it."""
    if file.begun is not None:
        return file.begun
    column = next((c for c in columns if c.channel == "time"), None)
    return column and instant_of(float(column.source.values[0]), column.unit)


def _named(columns: Sequence[_Column]) -> list[tuple[_Column, str]]:
    """Return each column with its name in the run; empty for time and what is left out."""
    used = {c.channel for c in columns} | _RESERVED | set(TARGETS)
    pairs = []
    for column in columns:
        name = column.channel
        if column.channel in {"time", "-"}:
            name = ""
        elif not column.channel:
            plain = " ".join(column.name.replace(",", "_").split())[:_NAME_MAX] or "column"
            name, number = plain, 2
            while name in used:
                name, number = f"{plain} ({number})", number + 1
            used.add(name)
        pairs.append((column, name))
    return pairs


def _described(file: MeasuredFile, column: _Column, name: str) -> ImportedColumn:
    values = column.source.values
    missing = np.flatnonzero(np.isnan(values))
    return ImportedColumn(
        column=column.source.header,
        channel=column.channel,
        name=name,
        unit=column.unit,
        factor=column.factor,
        why=column.why,
        minimum=float(np.nanmin(values)),
        maximum=float(np.nanmax(values)),
        missing=missing.size,
        missing_at=file.place(int(missing[0])) if missing.size else "",
        first=[float(v) if np.isfinite(v) else None for v in values[:FIRST_SHOWN]],
    )


def _describe_times(document: Import, grid: Grid, file: MeasuredFile) -> None:
    document.rate = 1.0 / grid.period
    document.median_rate = grid.median_rate
    document.jitter = grid.jitter
    document.gap_count = len(grid.gaps)
    document.missing = sum(length for _, length in grid.gaps)
    document.gaps = [
        ImportedGap(
            start=(first - 1) * grid.period,
            end=(first + length) * grid.period,
            samples=length,
            place=file.place(int(np.searchsorted(grid.places, first))),
        )
        for first, length in grid.gaps[:GAPS_SHOWN]
    ]
    document.ticks, document.duration = grid.ticks, grid.ticks * grid.period


def _missing_errors(data: Sequence[tuple[_Column, str]]) -> dict[str, tuple[_Column, _Column]]:
    """Return reference and measured position of each following error that is not in the file."""
    columns = {name: column for column, name in data}
    sources = {}
    for axis in AXES:
        reference, measured = f"{axis}.position_reference", f"{VARIANT}.{axis}.position_measured"
        error = f"{VARIANT}.{axis}.following_error"
        if error not in columns and reference in columns and measured in columns:
            sources[error] = columns[reference], columns[measured]
    return sources
