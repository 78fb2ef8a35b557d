"""Text tables as measuring systems write them: delimiter, decimal sign and header are found out."""

from __future__ import annotations

import codecs
import contextlib
import csv
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
from numpy.typing import NDArray
from pyarrow import csv as arrow_csv

from motionlab.errors import ConfigError, FieldError

_HEAD = 256 * 1024  # bytes that are looked at first
_LINES = 500  # of them
_BLOCK = 8 << 20
_DELIMITERS = {"\t": "tab", ";": "semicolon", ",": "comma"}
_DECIMALS = {".": "point", ",": "comma"}
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_MISSING = ("", "nan", "null", "na", "n/a", "none", "-", "--")
_UNIT = re.compile(r"[\[(]?[^\d\[\]()]{0,8}[\])]?(\^?[23])?[\])]?")


@dataclass
class CsvColumn:
    """A column: header, unit of a line of units, values."""

    header: str
    unit: str
    values: NDArray[np.float64]


@dataclass
class CsvTable:
    """A text table: its columns of numbers, what is ignored, how it is written."""

    columns: list[CsvColumn]
    ignored: dict[str, str]
    facts: dict[str, str | int]
    begun: float | None


@dataclass(frozen=True)
class _Form:
    """How a table is written."""

    delimiter: str
    decimal: str
    width: int
    score: int

    def split(self, line: str) -> list[str]:
        return [f.strip() for f in next(csv.reader([line], delimiter=self.delimiter), [])]

    def number(self, text: str) -> bool:
        if self.decimal == ",":
            return "." not in text and _NUMBER.fullmatch(text.replace(",", ".")) is not None
        return _NUMBER.fullmatch(text) is not None

    def is_data(self, fields: Sequence[str]) -> bool:
        """Return whether a line is one of data: some numbers or instants, at least half of it."""
        filled = [f for f in fields if f.lower() not in _MISSING]
        found = sum(self.number(f) or _instant(f) is not None for f in filled)
        return len(fields) == self.width and found > 0 and 2 * found >= len(filled)


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
    encoding = _encoding(head)
    text = head.decode(encoding, errors="replace")
    lines = text.splitlines()[: _LINES if whole else -1][:_LINES]
    delimiters = [sign for sign, name in _DELIMITERS.items() if delimiter in {"", name}]
    decimals = [sign for sign, name in _DECIMALS.items() if decimal in {"", name}]
    form = _form(lines, delimiters, decimals)
    rows = [form.split(line) for line in lines]
    first = next((i for i, fields in enumerate(rows) if form.is_data(fields)), None)
    if first is None:
        raise _refused("has no line of numbers: is it a table?")
    headers, units = _headers(form, rows[:first])
    kinds = [
        _kind(form, [r[i] for r in rows[first:] if len(r) == form.width]) for i in range(form.width)
    ]
    ignored = {
        header: "is text" for header, kind in zip(headers, kinds, strict=True) if kind == "text"
    }
    wanted = [i for i, kind in enumerate(kinds) if kind != "text"]
    reader = _Reader(form, headers, kinds, first + 1, values_max)
    values = reader.read(path, encoding, wanted)
    columns, begun = [], None
    for index in wanted:
        unit = units[index]
        if kinds[index] == "instant":
            begun = float(values[index][0]) if begun is None else begun
            unit = "s"
        columns.append(CsvColumn(headers[index], unit, values[index]))
    facts: dict[str, str | int] = {
        "delimiter": _DELIMITERS[form.delimiter],
        "decimal": _DECIMALS[form.decimal],
        "encoding": encoding,
        "first_line": first + 1,
    }
    return CsvTable(columns, ignored, facts, begun)


def _encoding(head: bytes) -> str:
    if head.startswith((b"\xff\xfe", b"\xfe\xff")):
        return "utf-16"
    if b"\0" in head:
        raise _refused("is neither a text nor Parquet, MAT (level 5) or MCAP")
    try:
        head[: max(0, len(head) - 4)].decode("utf-8-sig")  # the last letter may be cut
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig" if head.startswith(b"\xef\xbb\xbf") else "utf-8"


def _form(lines: Sequence[str], delimiters: Sequence[str], decimals: Sequence[str]) -> _Form:
    """Return the form in which most fields are numbers."""
    forms = []
    for delimiter in delimiters:
        rows = [next(csv.reader([line], delimiter=delimiter), []) for line in lines]
        widths = Counter(len(fields) for fields in rows[len(rows) // 4 :])
        width = max(widths, key=lambda w: widths[w], default=0)
        for decimal in decimals:
            trial = _Form(delimiter, decimal, width, 0)
            fields = [f.strip() for row in rows if len(row) == width for f in row]
            score = sum(
                1 if trial.number(f) or _instant(f) is not None else -1
                for f in fields
                if f.lower() not in _MISSING
            )
            forms.append(_Form(delimiter, decimal, width, score))
    return max(forms, key=lambda form: form.score)


def _headers(form: _Form, before: Sequence[Sequence[str]]) -> tuple[list[str], list[str]]:
    """Return headers and units from the lines before the numbers."""
    named = [list(fields) for fields in before if len(fields) == form.width]
    units = [""] * form.width
    if len(named) > 1 and all(_UNIT.fullmatch(f) for f in named[-1]) and any(named[-1]):
        units = [f.strip("[]() ") for f in named.pop()]
    found = named[-1] if named else [""] * form.width
    found[0] = found[0].lstrip("#%! ")
    headers: list[str] = []
    for index, text in enumerate(found, start=1):
        header, number = text or f"column {index}", 2
        while header in headers:
            header, number = f"{text or 'column'} ({number})", number + 1
        headers.append(header)
    return headers, units


def _kind(form: _Form, fields: Sequence[str]) -> str:
    filled = [f for f in fields if f.lower() not in _MISSING]
    if 2 * sum(map(form.number, filled)) >= len(filled):
        return "number"
    instants = sum(_instant(f) is not None for f in filled)
    return "instant" if 2 * instants >= len(filled) else "text"


def _instant(text: str) -> float | None:
    """Return an instant of ISO 8601, seconds since 1970; UTC where it names no zone."""
    if len(text) < 10 or text[4] != "-":
        return None
    try:
        found = datetime.fromisoformat(text)
    except ValueError:
        return None
    return (found if found.tzinfo else found.replace(tzinfo=UTC)).timestamp()


class _Reader:
    """Reads the lines of numbers, block by block."""

    def __init__(
        self, form: _Form, headers: list[str], kinds: list[str], first: int, values_max: int
    ) -> None:
        self._form = form
        self._headers = headers
        self._kinds = kinds
        self._first = first  # line of the first row, counted from 1
        self._values_max = values_max
        self._bad: Any = None

    def read(self, path: Path, encoding: str, wanted: list[int]) -> dict[int, NDArray[np.float64]]:
        """Return the values of the wanted columns."""
        parts: dict[int, list[NDArray[np.float64]]] = {index: [] for index in wanted}
        rows = 0
        try:
            with self._opened(path, encoding) as source:
                for batch in self._batches(source, wanted):
                    for index, column in zip(wanted, batch.columns, strict=True):
                        parts[index].append(self._numbers(index, column, rows))
                    rows += batch.num_rows
                    if rows * len(wanted) > self._values_max:
                        raise _refused(f"has more than {self._values_max} numbers")
        except pa.ArrowInvalid as error:
            if self._bad is None:
                raise _refused(f"cannot be read: {error}") from None
        if self._bad is not None:
            raise self._bad
        values: dict[int, NDArray[np.float64]] = {}
        filled = np.zeros(rows, dtype=bool)
        for index in wanted:
            values[index] = np.concatenate(parts.pop(index))
            filled |= np.isfinite(values[index])
        end = int(np.flatnonzero(filled)[-1]) + 1 if filled.any() else 0  # empty lines follow
        return {index: array[:end] for index, array in values.items()}

    @contextlib.contextmanager
    def _opened(self, path: Path, encoding: str) -> Iterator[Any]:
        """Give the file in UTF-8, converted as it is read."""
        with path.open("rb") as file:
            plain = encoding in {"utf-8", "utf-8-sig"}
            yield file if plain else codecs.EncodedFile(file, "utf-8", encoding, errors="replace")

    def _batches(self, source: Any, wanted: list[int]) -> Iterator[pa.RecordBatch]:
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
                include_columns=[str(index) for index in wanted],
                strings_can_be_null=False,
            ),
        )

    def _invalid(self, row: Any) -> str:
        """Skip an empty line; refuse any other line of another number of fields."""
        if not row.text.strip():
            return "skip"
        line = "" if row.number is None else f"line {row.number}: "
        self._bad = _refused(
            f"{line}{row.actual_columns} fields instead of {row.expected_columns}", row.text[:80]
        )
        return "error"

    def _numbers(self, index: int, column: pa.Array, row: int) -> NDArray[np.float64]:
        texts = pc.utf8_trim_whitespace(column)  # pyright: ignore[reportAttributeAccessIssue]
        missing = pc.is_in(  # pyright: ignore[reportAttributeAccessIssue]
            pc.utf8_lower(texts),  # pyright: ignore[reportAttributeAccessIssue]
            value_set=pa.array(_MISSING),
        )
        texts = pc.if_else(missing, None, texts)  # pyright: ignore[reportAttributeAccessIssue]
        if self._kinds[index] == "instant":
            return self._checked(index, texts, row, _instant)
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
                what = "instant" if self._kinds[index] == "instant" else "finite number"
                sign = f" (decimal {_DECIMALS[self._form.decimal]})"
                raise _refused(f"{where}: is no {what}{sign if what != 'instant' else ''}", text)
            values[place] = value
        return values


def _refused(message: str, value: object = None) -> ConfigError:
    return ConfigError(FieldError("file", message, value))
