"""How a text table is written: separator, decimal sign, names, units, where its numbers begin."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.measurements import clock_text
from motionlab.exchange.measurements.column_guess import si_of
from motionlab.exchange.measurements.document import COLUMNS_MAX

DELIMITERS = {"\t": "tab", ";": "semicolon", ",": "comma"}
DECIMALS = {".": "point", ",": "comma"}
MISSING = frozenset(
    "|nan|-nan|+nan|nan(ind)|-nan(ind)|1.#qnan|-1.#qnan|1.#ind|-1.#ind|null|nil|na|n/a|#n/a|#na|"
    "<na>|n.a.|n. def.|none|-|--|---".split("|")
)
"""Words for no number, in lower case."""

TIMES: dict[str, Callable[[str, bool | None], int | None]] = {
    "instant": clock_text.instant,
    "date": clock_text.day,
    "clock": clock_text.clock,
}
"""Kinds of columns of times, and what reads them."""

_NUMBER = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_THOUSANDS = re.compile(r"[+-]?\d{1,3}(?:[.,'\u2019 \u00a0\u202f]\d{3})+(?:[.,]\d+)?")
_UNIT = re.compile(r"[\[(]?[^\d\[\]()]{0,8}[\])]?(\^?[23])?[\])]?")
_UNITS = frozenset(
    "v mv kv °c c k % hz khz mhz rad deg ° rpm 1/min bar pa hpa kpa mbar kg g w kw va counts inc "
    "nm ohm volt volts amps ampere g's".split()
)
"""Units of what is no motion, in lower case: they mark a line of units."""
_FIELD_MAX = 100  # characters of a number
_NO_DATA = -(10**9)
_SHOWN = 5


@dataclass(frozen=True)
class Form:
    """Separator and decimal sign of a table, and fields of a line of data."""

    delimiter: str
    decimal: str
    width: int
    score: int = 0
    plain: bool = False  # no number has shown the decimal sign

    def split(self, line: str) -> list[str]:
        """Return the fields of a line."""
        return [f.strip() for f in _fields(line, self.delimiter)]

    def number(self, text: str) -> bool:
        """Return whether a field is a finite number, but for its size."""
        if len(text) > _FIELD_MAX:
            return False
        if self.decimal == ",":
            return "." not in text and _NUMBER.fullmatch(text.replace(",", ".")) is not None
        return _NUMBER.fullmatch(text) is not None

    def counts(self, text: str) -> bool:
        """Return whether a field is a number, date, clock or instant."""
        return self.number(text) or _is_time(text)

    def is_data(self, fields: Sequence[str]) -> bool:
        """Return whether at least half of what stands in a line are numbers."""
        filled = [f for f in fields if not missing(f)]
        grouped = sum(_THOUSANDS.fullmatch(f[:_FIELD_MAX]) is not None for f in filled)
        count = sum(map(self.counts, filled))
        return count > 0 and 2 * (count + grouped) >= len(filled)


@dataclass
class Layout:
    """Where everything stands in a table.

    Attributes
    ----------
    first : int
        Place of the first line of data, from 0.
    headers, units, kinds : list of str
        Of each column; kinds are ``number``, ``instant``, ``clock``, ``date``, ``text``.
    day_first : bool
        Whether ``5/2/2024`` is in February.
    notes : list of str
        What was passed over or guessed.
    """

    first: int
    headers: list[str]
    units: list[str]
    kinds: list[str]
    day_first: bool
    notes: list[str] = field(default_factory=list)


def _fields(line: str, delimiter: str) -> list[str]:
    try:
        return next(csv.reader([line], delimiter=delimiter), [])
    except csv.Error as error:
        raise _refused(f"is no table: {error}", line[:80]) from None


def missing(text: str) -> bool:
    """Return whether a field stands for no number."""
    return text.lower() in MISSING


def form_of(lines: Sequence[str], delimiters: Sequence[str], decimals: Sequence[str]) -> Form:
    """Return the form in which most fields are numbers."""
    forms = []
    for delimiter in delimiters:
        rows = [_fields(line, delimiter) for line in lines]
        for decimal in decimals:
            trial = Form(delimiter, decimal, 0)
            split = [[f.strip() for f in row] for row in rows]
            data = [row for row in split if trial.is_data(row)]
            widths = Counter(map(len, data))
            width = max(widths, key=lambda w: widths[w], default=0)
            fields = [f for row in data if len(row) == width for f in row if not missing(f)]
            score = sum(1 if trial.counts(f) else -1 for f in fields) if data else _NO_DATA
            signs = any("." in f or "," in f for f in fields if trial.number(f))
            forms.append(Form(delimiter, decimal, width, score, plain=not signs))
    best = max(forms, key=lambda form: form.score)
    if best.width > COLUMNS_MAX:  # before names and kinds are made of them
        bounds: dict[str, float] = {"maximum": COLUMNS_MAX}
        raise ConfigError(FieldError("file", "has too many columns", best.width, bounds=bounds))
    return best


def layout_of(form: Form, lines: Sequence[str]) -> Layout:
    """Return where names, units and numbers of a table stand.

    Raises
    ------
    ConfigError
        If it has no numbers, or lines of numbers of two widths, or thousands separators.
    """
    rows = [form.split(line) for line in lines]
    bulk = [row for row in rows if len(row) == form.width and form.is_data(row)]
    if not bulk:
        raise _refused("has no line of numbers between commas, semicolons or tabs: is it a table?")
    kinds = [_kind(form, [row[i] for row in bulk]) for i in range(form.width)]
    first = _first(form, rows, kinds)
    _refuse_widths(form, rows, first)
    layout = Layout(first, [], [], kinds, False)
    _name(form, rows, layout)
    _refuse_thousands(form, rows, layout)
    dates = [row[i] for i, kind in enumerate(kinds) if kind in {"instant", "date"} for row in bulk]
    if any(map(clock_text.is_ambiguous, dates)):
        day_first = clock_text.is_day_first(dates)
        layout.day_first = bool(day_first)
        if day_first is None:
            layout.notes.append("dates are taken for month/day/year")
    return layout


def _is_time(text: str) -> bool:
    return any(read(text, None) is not None for read in TIMES.values())


def _kind(form: Form, fields: Sequence[str]) -> str:
    """Return what at least half of the fields are."""
    filled = [f for f in fields if not missing(f)]

    def most(test: Callable[[str], bool]) -> bool:
        return 2 * sum(map(test, filled)) >= len(filled)

    if most(form.number):
        return "number"
    times = (kind for kind, read in TIMES.items() if most(lambda f, r=read: r(f, None) is not None))
    return next(times, "text")


def _first(form: Form, rows: Sequence[Sequence[str]], kinds: Sequence[str]) -> int:
    """Return the first line that has numbers where the columns have them.

    A line right above that is mostly numbers is one of data with a fault, not one of names.
    """

    def fits(row: Sequence[str]) -> bool:
        pairs = [(k, f) for k, f in zip(kinds, row, strict=True) if k != "text" and not missing(f)]
        return bool(pairs) and all(
            form.number(f) if k == "number" else _is_time(f) for k, f in pairs
        )

    def faulty(row: Sequence[str]) -> bool:
        filled = [f for f in row if not missing(f)]
        count = sum(map(form.counts, filled))
        return bool(filled) and form.counts(filled[0]) and 2 * count > len(filled)

    fitting = [i for i, row in enumerate(rows) if len(row) == form.width and fits(row)]
    first = fitting[0] if fitting else len(rows)
    if not fitting:
        data = (i for i, row in enumerate(rows) if len(row) == form.width and form.is_data(row))
        return next(data)
    while first > 0 and len(rows[first - 1]) == form.width and faulty(rows[first - 1]):
        first -= 1
    return first


def _refuse_widths(form: Form, rows: Sequence[Sequence[str]], first: int) -> None:
    """Refuse lines of numbers of another width right above the first line of data."""
    before = next((row for row in reversed(rows[:first]) if any(row)), [])
    filled = [f for f in before if not missing(f)]
    if len(before) != form.width and len(filled) > 1 and all(map(form.counts, filled)):
        raise _refused(f"line {first + 1}: {form.width} fields instead of {len(before)}")
    names = len(before) > 1 and all(before) and not any(map(form.counts, before))
    if names and form.delimiter == "," and form.width == 2 * len(before):
        message = "commas between the columns and in the numbers: write it with semicolons"
        raise _refused(
            f"line {first + 1}: {form.width} fields under {len(before)} names; {message}"
        )


def _refuse_thousands(form: Form, rows: Sequence[Sequence[str]], layout: Layout) -> None:
    for index, kind in enumerate(layout.kinds):
        fields = [r[index] for r in rows[layout.first :] if len(r) == form.width]
        filled = [f for f in fields if not missing(f)]
        if kind == "text" and 2 * sum(bool(_THOUSANDS.fullmatch(f)) for f in filled) >= len(filled):
            where = f"line {layout.first + 1}, column {layout.headers[index]!r}"
            raise _refused(f"{where}: has thousands separators, which are not read", filled[0])


def _name(form: Form, rows: Sequence[Sequence[str]], layout: Layout) -> None:
    """Find names and units in the lines above the numbers; note what is passed over."""
    named = {}
    for index, row in enumerate(rows[: layout.first]):
        fields = _fitted(row, form, rows[layout.first :])
        if fields is not None and any(fields):
            named[index] = fields
    used: set[int] = set()
    units = [""] * form.width
    headers = _of_pairs(named, units, used, layout)
    if headers is None:
        last = max(named, default=-1)
        if len(named) > 1 and _is_units(named[last]):
            units = [f.strip("[]() ") for f in named[last]]
            used.add(last)
        index = next(
            (
                i
                for i in sorted(named, reverse=True)
                if i not in used and (i + 1 in used or _is_names(form, named[i]))
            ),
            None,
        )
        headers = [""] * form.width if index is None else list(named[index])
        used |= set() if index is None else {index}
    headers[0] = headers[0].lstrip("#%! ")
    layout.headers, layout.units = _different(headers), units
    over = [i + 1 for i in range(layout.first) if i not in used and any(rows[i])]
    if over:
        shown = ", ".join(map(str, over[:_SHOWN])) + (", ..." if len(over) > _SHOWN else "")
        lines = f"line {shown} is" if len(over) == 1 else f"lines {shown} are"
        layout.notes.append(f"{lines} passed over: neither names nor units nor numbers")


def _fitted(row: Sequence[str], form: Form, data: Sequence[Sequence[str]]) -> list[str] | None:
    """Return a line above the numbers with as many fields as these have, or None.

    A separator may end the lines of numbers only, or the line of names only.
    """
    fields = list(row)
    while len(fields) > form.width and not fields[-1]:
        fields.pop()
    short = len(fields) == form.width - 1
    if short and all(not r[-1] for r in data if len(r) == form.width):
        fields.append("")
    return fields if len(fields) == form.width else None


def _of_pairs(
    named: dict[int, list[str]], units: list[str], used: set[int], layout: Layout
) -> list[str] | None:
    """Return names of a table with pairs of key and value above pairs of time and value.

    As TwinCAT Scope writes it: ``Name;A;Name;B`` above ``SampleTime[ms];1;SampleTime[ms];1``.
    """
    rows = {index: fields for index, fields in named.items() if len(set(fields[::2])) == 1}
    keys = {fields[0].lower(): index for index, fields in rows.items()}
    times = next((key for key in keys if key.startswith("sampletime")), None)
    if times is None or "name" not in keys or len(units) % 2:
        return None
    unit = times.partition("[")[2].rstrip("]") or "ms"
    units[::2] = [unit] * (len(units) // 2)
    used |= set(rows)
    layout.notes.append(f"the column left of each name is taken for its time in {unit}")
    return [each for name in rows[keys["name"]][1::2] for each in ("time", name)]


def _is_units(fields: Sequence[str]) -> bool:
    filled = [f for f in fields if f]
    if not filled or not all(map(_UNIT.fullmatch, fields)):
        return False
    known = sum(f[0] in "[(" or si_of(f) is not None or f.lower() in _UNITS for f in filled)
    return 2 * known >= len(filled)


def _is_names(form: Form, fields: Sequence[str]) -> bool:
    filled = [f for f in fields if f]
    numbers = sum(map(form.counts, filled))
    return 2 * numbers <= len(filled)


def _different(names: Sequence[str]) -> list[str]:
    """Return names of which none comes twice; a column without one is called by its number."""
    taken, next_number = set(names), Counter[str]()
    headers: list[str] = []
    seen: set[str] = set()
    for index, text in enumerate(names, start=1):
        header = text or f"column {index}"
        if header in seen or (not text and header in taken):
            number = next_number[header] or 2
            while (name := f"{text or 'column'} ({number})") in seen or name in taken:
                number += 1
            next_number[header] = number + 1
            header = f"{text or 'column'} ({number})"
        seen.add(header)
        headers.append(header)
    return headers


def _refused(message: str, value: object = None) -> ConfigError:
    return ConfigError(FieldError("file", message, value))
