"""Text tables as measuring systems write them: delimiter, decimal sign and header are found out."""

from __future__ import annotations

import codecs
import contextlib
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray
from pyarrow import csv as arrow_csv

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.encodings import DOS_END, encoding_of, lines_of, with_whole_cells
from motionlab.exchange.measurements import clock_text
from motionlab.exchange.measurements.csv_form import (
    DECIMALS,
    DELIMITERS,
    MISSING,
    TIMES,
    Form,
    Layout,
    form_of,
    layout_of,
)

_HEAD = 256 * 1024  # bytes that are looked at first
_LINES = 500  # of them
_BLOCK = 8 << 20
_OWN = ("tick [1]", "time [s]")  # headers with which a CSV of an export begins


@dataclass
class CsvColumn:
    """A column: header, unit of a line of units, values."""

    header: str
    unit: str
    values: NDArray[np.float64]
    instant: bool


@dataclass
class CsvTable:
    """A text table: its columns of numbers, what is ignored, how it is written."""

    columns: list[CsvColumn]
    ignored: dict[str, str]
    facts: dict[str, str | int]
    begun: float | None
    notes: list[str]
    own: bool


def read_csv(path: Path, values_max: int, delimiter: str = "", decimal: str = "") -> CsvTable:
    """Read a text table; numbers of its rows come back as float64, NaN where there is none.

    Parameters
    ----------
    path : Path
        A text in UTF-8, UTF-16 with its mark, or Windows-1252.
    values_max : int
        Most numbers that are read.
    delimiter : str
        comma, semicolon or tab; empty to find it out.
    decimal : str
        point or comma; empty to find it out.

    Raises
    ------
    ConfigError
        Naming line, column and reason.
    """
    with path.open("rb") as stream:
        head = stream.read(_HEAD)
        whole = len(head) < _HEAD
    encoding = encoding_of(head, whole=whole)
    if encoding is None:
        raise _refused("is neither a text nor Parquet, MAT (level 5), NPZ or MCAP")
    text = head.decode(encoding, errors="replace")
    lines = with_whole_cells(lines_of(text)[: _LINES if whole else -1][:_LINES])
    delimiters = [sign for sign, name in DELIMITERS.items() if delimiter in {"", name}]
    decimals = [sign for sign, name in DECIMALS.items() if decimal in {"", name}]
    form = form_of(lines, delimiters, decimals)
    if form.plain and len(decimals) > 1 and form.delimiter != ",":  # as of a machine at rest
        form = replace(form, decimal=_later_decimal(path, encoding, form.delimiter))
    layout = layout_of(form, lines)
    reader = _Reader(form, layout, values_max)
    indices = reader.indices
    values = reader.read(path, encoding, indices)
    ignored = {
        header: "is text" if kind == "text" else "is the date of the clock beside it"
        for i, (header, kind) in enumerate(zip(layout.headers, layout.kinds, strict=True))
        if i not in indices
    }
    columns = []
    for index in indices:
        timed = layout.kinds[index] != "number"
        unit = "s" if timed else layout.units[index]
        columns.append(CsvColumn(layout.headers[index], unit, values[index], timed))
    facts: dict[str, str | int] = {
        "delimiter": DELIMITERS[form.delimiter],
        "decimal": DECIMALS[form.decimal],
        "encoding": encoding,
        "first_line": layout.first + 1,
    }
    own = tuple(layout.headers[:2]) == _OWN
    begun = reader.begun(lines)
    return CsvTable(columns, ignored, facts, begun, layout.notes, own)


def _later_decimal(path: Path, encoding: str, delimiter: str) -> str:
    """Return the decimal sign of the first number that has one; a point if none has."""
    between = re.escape(delimiter)
    number = re.compile(
        rf"(?:^|[{between}\n\r])[ \"]*[+-]?\d{{0,40}}([.,])\d{{1,40}}(?:[eE][+-]?\d{{1,4}})?[ \"]*"
        rf"(?=[{between}\n\r])"
    )
    with path.open("rb") as file, codecs.getreader(encoding)(file, "replace") as text:
        rest = ""
        while block := text.read(1 << 20):
            if match := number.search(rest + block):
                return match[1]
            rest = block[-200:]
    return "."


class _Reader:
    """Reads the lines of numbers, block by block."""

    def __init__(self, form: Form, layout: Layout, values_max: int) -> None:
        self._form = form
        self._layout = layout
        self._headers, self._kinds = layout.headers, layout.kinds
        self._first = layout.first + 1  # line of the first row, counted from 1
        self._values_max = values_max
        self._origins: dict[int, int] = {}  # ns, of columns of times
        self._bad: Any = None
        dated = "clock" in self._kinds
        left_out = {"text", "date"} if dated else {"text"}
        self.indices = [i for i, kind in enumerate(self._kinds) if kind not in left_out]

    def begun(self, lines: Sequence[str]) -> float | None:
        """Return the instant of the first row, seconds since 1970, if the table has it."""
        for index in self.indices:
            if self._kinds[index] in {"instant", "date"} and index in self._origins:
                return self._origins[index] / clock_text.SECOND
        fields = self._form.split(lines[self._layout.first])
        for index, kind in enumerate(self._kinds):
            if kind == "date" and index < len(fields):
                day = clock_text.day(fields[index], self._layout.day_first)
                time = next((t for i, t in self._origins.items() if self._kinds[i] == "clock"), 0)
                return None if day is None else (day * clock_text.DAY + time) / clock_text.SECOND
        return None

    def read(self, path: Path, encoding: str, indices: list[int]) -> dict[int, NDArray[np.float64]]:
        """Return the values of the wanted columns."""
        parts: dict[int, list[NDArray[np.float64]]] = {index: [] for index in indices}
        rows = 0
        try:
            with self._opened(path, encoding) as source:
                for batch in self._batches(source, indices):
                    for index, column in zip(indices, batch.columns, strict=True):
                        parts[index].append(self._numbers(index, column, rows))
                    rows += batch.num_rows
                    if rows * len(indices) > self._values_max:
                        raise _refused(f"has more than {self._values_max} numbers")
        except pa.ArrowInvalid as error:
            if self._bad is None:
                raise _refused(f"cannot be read: {error}") from None
        if self._bad is not None:
            raise self._bad
        values: dict[int, NDArray[np.float64]] = {}
        filled = np.zeros(rows, dtype=bool)
        for index in indices:
            values[index] = np.concatenate(parts.pop(index))
            if self._kinds[index] == "clock":
                values[index] = _over_midnight(values[index])
            filled |= np.isfinite(values[index])
        end = int(np.flatnonzero(filled)[-1]) + 1 if filled.any() else 0  # empty lines follow
        return {index: array[:end] for index, array in values.items()}

    @contextlib.contextmanager
    def _opened(self, path: Path, encoding: str) -> Iterator[Any]:
        """Give the file in UTF-8, converted as it is read."""
        with path.open("rb") as file:
            plain = encoding in {"utf-8", "utf-8-sig"}
            yield file if plain else codecs.EncodedFile(file, "utf-8", encoding, errors="replace")

    def _batches(self, source: Any, indices: list[int]) -> Iterator[pa.RecordBatch]:
        """Yield the texts of the wanted columns, block by block."""
        names = [str(index) for index in range(self._form.width)]
        yield from arrow_csv.open_csv(
            source,
            read_options=arrow_csv.ReadOptions(
                use_threads=False,
                block_size=_BLOCK,
                skip_rows=self._first - 1,
                column_names=names,
            ),
            parse_options=arrow_csv.ParseOptions(
                delimiter=self._form.delimiter,
                ignore_empty_lines=False,
                invalid_row_handler=self._invalid,
            ),
            convert_options=arrow_csv.ConvertOptions(
                column_types=dict.fromkeys(names, pa.string()),
                include_columns=[str(index) for index in indices],
                strings_can_be_null=False,
            ),
        )

    def _invalid(self, row: Any) -> str:
        """Skip an empty line; refuse any other line of another number of fields."""
        if not row.text.strip(" \t\r\n" + DOS_END):
            return "skip"
        line = "" if row.number is None else f"line {row.number}: "
        self._bad = _refused(
            f"{line}{row.actual_columns} fields instead of {row.expected_columns}", row.text[:80]
        )
        return "error"

    def _numbers(self, index: int, column: pa.Array, row: int) -> NDArray[np.float64]:
        if len(column) and str(column[-1]).endswith(DOS_END):
            column = pc.utf8_rtrim(  # pyright: ignore[reportAttributeAccessIssue]
                column, characters=DOS_END
            )
        texts = pc.utf8_trim_whitespace(column)  # pyright: ignore[reportAttributeAccessIssue]
        missing = pc.is_in(  # pyright: ignore[reportAttributeAccessIssue]
            pc.utf8_lower(texts),  # pyright: ignore[reportAttributeAccessIssue]
            value_set=pa.array(sorted(MISSING)),
        )
        texts = pc.if_else(missing, None, texts)  # pyright: ignore[reportAttributeAccessIssue]
        if self._kinds[index] != "number":
            return self._checked(index, texts, row, partial(self._time, index))
        plain = texts
        if self._form.decimal == ",":
            dotted = pc.match_substring(texts, ".")  # pyright: ignore[reportAttributeAccessIssue]
            if pc.any(dotted).as_py():  # pyright: ignore[reportAttributeAccessIssue]
                return self._checked(index, texts, row, self._number)
            plain = pc.replace_substring(  # pyright: ignore[reportAttributeAccessIssue]
                texts, ",", "."
            )
        try:
            values = pc.cast(plain, pa.float64()).to_numpy(zero_copy_only=False)
        except pa.ArrowInvalid:  # a plus sign, or no number
            return self._checked(index, texts, row, self._number)
        if np.isinf(values).any():
            return self._checked(index, texts, row, self._number)
        return values

    def _time(self, index: int, text: str) -> float | None:
        """Return seconds from the first time of a column."""
        read = TIMES[self._kinds[index]]
        time = read(text, self._layout.day_first)
        if time is None:
            return None
        if self._kinds[index] == "date":
            time *= clock_text.DAY
        return (time - self._origins.setdefault(index, time)) / clock_text.SECOND

    def _number(self, text: str) -> float | None:
        if not self._form.number(text):
            return None
        value = float(text.replace(",", ".") if self._form.decimal == "," else text)
        return value if np.isfinite(value) else None

    def _checked(self, index: int, texts: pa.Array, row: int, read: Any) -> NDArray[np.float64]:
        """Return values read one by one; refuse the first that is none."""
        values = np.full(len(texts), np.nan)
        for place, text in enumerate(texts.to_pylist()):
            if text is None:
                continue
            value = read(text)
            if value is None:
                where = f"line {self._first + row + place}, column {self._headers[index]!r}"
                what = f"finite number (decimal {DECIMALS[self._form.decimal]})"
                if self._kinds[index] != "number":
                    what = self._kinds[index]
                raise _refused(f"{where}: is no {what}", text)
            values[place] = value
        return values


def _over_midnight(times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return times of day, s, that go on after midnight."""
    day = clock_text.DAY / clock_text.SECOND
    steps = np.diff(times, prepend=times[:1])
    return times + day * np.cumsum(np.nan_to_num(steps) < -0.5 * day)


def _refused(message: str, value: object = None) -> ConfigError:
    return ConfigError(FieldError("file", message, value))
