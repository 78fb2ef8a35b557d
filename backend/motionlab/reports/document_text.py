"""A document as text: one walk over its fields, a table for each kind of record in it.

Label, unit and the meaning of null are the field's own: its title, or its name; ``display_unit`` or
``unit`` of its JSON schema, or the unit that ends a clause of its description; the clause that
begins with null. Fields with ``repr=False``, long lists of numbers and empty values are left out.
A model may have `labels` in place of names, values `derived` from its fields, and a line, `foot`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from pydantic import BaseModel
from pydantic.fields import FieldInfo

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.analysis.result_document import ResultDocument
from motionlab.config.validation_errors import members, unit_of_field
from motionlab.reports.result_text import report
from motionlab.reports.tables import table
from motionlab.reports.units import Scale, scale_for

_UNIT = re.compile(
    r"(?:^|, )((?:[msNAJWTVK]|Hz|dB|kg|rad|unit)(?:\^\d)?(?: [sm])?"
    r"(?:/(?:[msAN]|Hz|sqrt\(Hz\))(?:\^\d)?)?)(?=$|[;:,])"
)
_UNDERSCORE = re.compile(r"(?<!\b[A-Za-z])(?<!\bsigma)_")  # none of symbols, such as F_c
_NULL = re.compile(r"null (where [^;]*)")
_NOTES = frozenset({"note", "notes", "warnings", "violations", "missing"})
_LIST_MAX = 5
_SIDE_MAX = 6
"""Records that stand side by side."""


class Cell(NamedTuple):
    """A value of a record; `column` tells it from others of the record, spaces indent `label`."""

    column: tuple[str, ...]
    label: str
    value: Any
    unit: Unit


class Unit(NamedTuple):
    """A unit, and the factor of a fixed one; others take prefixes."""

    name: str
    factor: float | None = None


class Record(NamedTuple):
    """A row of a table; `unit` is that of cells whose fields have none."""

    name: str
    unit: Unit
    cells: list[Cell]


def document_text(document: BaseModel | Mapping[str, BaseModel]) -> str:
    """Return the tables of a document, or of several by name, with notes and options below."""
    walk = _Walk()
    for name, each in document.items() if isinstance(document, Mapping) else [("", document)]:
        walk.add(each, (), (name,) if name else (), Unit(""))
    tables = [_table(title, rows) for title, rows in walk.tables.values()]
    parts = [*tables, "\n".join(walk.notes), "\n".join(walk.options), *walk.below]
    return "\n\n".join(filter(None, parts))


class _Walk:
    def __init__(self) -> None:
        self.tables: dict[tuple[Any, ...], tuple[str, list[Record]]] = {}
        self.notes: list[str] = []
        self.options: list[str] = []
        self.below: list[str] = []

    def add(
        self, model: BaseModel, path: tuple[str, ...], names: tuple[str, ...], unit: Unit
    ) -> None:
        """Add a record to the table of its kind, and what it has several of to others."""
        own = getattr(model, "unit", None)
        record = Record(" ".join(names), Unit(own) if isinstance(own, str) else unit, [])
        title = path[-1] if path else ""
        # Records of one kind share a table, but not those of different parts of the document.
        self.tables.setdefault((path[:1], type(model)), (title, []))[1].append(record)
        self._fields(model, record, path, names, ())

    def _fields(
        self,
        model: BaseModel,
        record: Record,
        path: tuple[str, ...],
        names: tuple[str, ...],
        within: tuple[str, ...],
    ) -> None:
        labels: dict[str, str] = getattr(model, "labels", {})
        for key, info in type(model).model_fields.items():
            value = getattr(model, key)
            if not info.repr or key == "unit" or (isinstance(value, str) and value in names):
                continue
            label = labels.get(key) or info.title or _UNDERSCORE.sub(" ", key)
            column, shown, unit = (*within, key), "  " * len(within) + label, _unit(info)
            rows = list(_rows(label, value))
            if key in _NOTES:  # below the tables, after the name of their record
                head = " ".join([*names, label.removesuffix("s")])
                texts = [value] if isinstance(value, str) else value
                self.notes += [f"{head}: {text}" for text in texts or () if text]
            elif key == "set":  # what a user may try next; those of rows are too many
                settings = value if isinstance(value, Mapping) and not path else {}
                self.options += [f"{label}:"] * bool(settings)
                self.options += [f"  --set {at}={_option(to)}" for at, to in settings.items()]
            elif isinstance(value, ResultDocument):
                self.below.append(report(value.model_dump()))
            elif rows or (value is None and _has(info, BaseModel)):
                for name, row in rows or [((), None)]:
                    further = [each for each in name if each not in names]
                    named = (*names, *further)
                    self._row(row, info, (*path, label), named, record.unit)
            elif isinstance(value, BaseModel):  # part of this record, below its own label
                place = len(record.cells)
                record.cells.append(Cell(column, shown, "", Unit("")))
                self._fields(value, record, path, names, column)
                if next(iter(type(value).model_fields)) == "value":  # in the row of the label
                    own = record.cells.pop(place + 1).value
                    record.cells[place] = Cell(column, shown, own, unit)
            elif not _is_left_out(value, info, alone=not record.name):
                unit = record.unit if isinstance(value, float) and not unit.name else unit
                record.cells.append(Cell(column, shown, value, unit))
        for label, value in getattr(model, "derived", dict)().items():
            record.cells.append(Cell((*within, label), label, value, record.unit))
        if (foot := getattr(model, "foot", "")) and foot not in self.notes:
            self.notes.append(foot)

    def _row(
        self,
        row: Any,
        info: FieldInfo,
        path: tuple[str, ...],
        names: tuple[str, ...],
        outer: Unit,
    ) -> None:
        metric = DEFINITIONS.get(names[-1]) if names else None
        stated = _unit(info)
        unit = stated if stated.name else outer
        if metric is not None:
            if row is None or not metric.printed:
                return
            names = (*names[:-1], metric.label.replace("_$", "").replace(" $", ""))
            of_metric = Unit("%", 100.0) if metric.unit == "1" else Unit(metric.unit)
            unit = stated if stated.name else of_metric
        if row is not None:
            self.add(row, path, names, unit)
        elif why := _NULL.search(info.description or ""):
            self.notes.append(f"{' '.join([*names, path[-1]])}: none {why[1]}")


def _rows(label: str, value: Any) -> Iterator[tuple[tuple[str, ...], Any]]:
    """Yield the records that a field has several of, with their names; none of other fields."""
    if isinstance(value, BaseModel) and any(
        any(_rows("", each)) for _, each in value if not isinstance(each, BaseModel)
    ):
        yield (label,), value
    elif isinstance(value, Mapping) and (
        any(isinstance(item, BaseModel | Mapping) for item in value.values())
        or all(item is None for item in value.values())
    ):
        for key, item in value.items():
            if isinstance(item, Mapping):
                yield from (((key, *name), row) for name, row in _rows("", item))
            elif item is None or isinstance(item, BaseModel):
                yield (key,), item
    elif isinstance(value, Sequence) and any(isinstance(item, BaseModel) for item in value):
        for item in value:
            yield (item.name,) if hasattr(item, "name") else (), item


def _unit(info: FieldInfo) -> Unit:
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    if "display_unit" in extra:
        name = str(extra["display_unit"]).replace("\u00b5", "u")  # as elsewhere in a pipe
        return Unit(name, float(str(extra["display_factor"])))
    return Unit(si_unit(info))


def si_unit(info: FieldInfo) -> str:
    """Return the SI unit of a field: its own, or that which ends a clause of its description."""
    stated = _UNIT.search(info.description or "")
    return unit_of_field(info) or (stated[1] if stated else "")


def _has(info: FieldInfo, *kinds: type) -> bool:
    return any(isinstance(m, type) and issubclass(m, kinds) for m in members(info.annotation))


def _is_left_out(value: Any, info: FieldInfo, *, alone: bool) -> bool:
    match value:
        case None:  # in a table a dash; alone only where it tells something
            tells = not alone or _NULL.search(info.description or "")
            return not (tells and _has(info, int, float))
        case str():
            return not value
        case list() | tuple():
            few = 0 < len(value) <= _LIST_MAX
            return not few or any(isinstance(item, list | tuple) for item in value)
        case dict():
            return not value or any(isinstance(item, list | tuple) for item in value.values())
        case _:
            return False


def _table(title: str, records: list[Record]) -> str:
    """Return records as a table; few with many values become its columns, one alone a list."""
    cells = {cell.column: cell for record in records for cell in record.cells}
    columns = {c: cell.label for c, cell in cells.items() if cell.value != "" or _heads(c, cells)}
    if not columns:
        return ""
    by_record = [{cell.column: cell for cell in record.cells} for record in records]
    grid = {column: [cells.get(column) for cells in by_record] for column in columns}
    if len(records) > 1 and len(columns) == 1 and not any(record.name for record in records):
        return f"{title}: {', '.join(str(c.value) for cells in grid.values() for c in cells if c)}"
    mixed = [c for c, cells in grid.items() if len({each.unit for each in cells if each}) > 1]
    scales = {column: [_scale(cells)] * len(records) for column, cells in grid.items()}
    of_rows = [_scale([cells.get(column) for column in mixed]) for cells in by_record]
    scales |= dict.fromkeys(mixed, of_rows)
    texts = {
        column: [_text(cell, scale) for cell, scale in zip(cells, scales[column], strict=True)]
        for column, cells in grid.items()
    }
    units = {column: "" if column in mixed else scales[column][0].unit for column in columns}
    if len(records) == 1 and not records[0].name:
        lines = [(columns[c], f"{texts[c][0]} {units[c]}".rstrip()) for c in columns]
        return "\n".join(filter(None, [title, table(("", ""), lines)]))
    names = [record.name for record in records]
    row_units = [scale.unit for scale in of_rows]
    numbers = {c for c, cells in grid.items() if all(_is_number(cell) for cell in cells)}
    nested = any(len(column) > 1 for column in columns)
    few = len(set(names)) == len(names) <= _SIDE_MAX
    if few and (nested or len(names) < len(columns)):
        rows = [[columns[c], units[c], *texts[c]] for c in columns]
        rows = [["", "", *row_units], *rows] if mixed else rows
        return table([title, "", *names], rows, right=range(2, len(names) + 2))
    heads = {(): title, ("unit",): "", **columns}
    by_head = {(): names, ("unit",): row_units, **texts}
    shown = [c for c in heads if any(by_head[c])]
    right = [i for i, column in enumerate(shown) if column in numbers]
    below = [units.get(column, "") for column in shown]
    rows = zip(*(by_head[column] for column in shown), strict=True)
    text = table([heads[c] for c in shown], rows, right=right, units=below if any(below) else ())
    return text if any(names) or not title else f"{title}\n{text}"


def _heads(column: tuple[str, ...], cells: Mapping[tuple[str, ...], Cell]) -> bool:
    """Return whether a column without values is the head of others."""
    return any(c[: len(column)] == column and cell.value != "" for c, cell in cells.items())


def _scale(cells: Sequence[Cell | None]) -> Scale:
    """Return the common scale of some cells."""
    cell = next((each for each in cells if each and each.value is not None), None)
    if cell is None:
        return Scale(1.0, "")
    if cell.unit.factor is not None:
        return Scale(1.0 / cell.unit.factor, cell.unit.name)
    numbers = [n for each in cells if each for n in _numbers(each.value)]
    return scale_for(numbers, cell.unit.name, micro="u")


def _numbers(value: Any) -> list[float]:
    values = value.values() if isinstance(value, dict) else value
    return [
        v for v in (values if isinstance(values, Iterable) else [values]) if isinstance(v, float)
    ]


def _is_number(cell: Cell | None) -> bool:
    return cell is None or cell.value is None or isinstance(cell.value, int | float)


def _text(cell: Cell | None, scale: Scale) -> str:
    if cell is None:
        return ""
    return _value(cell.value, scale)


def _value(value: Any, scale: Scale) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "no"
        case float():
            shown = value / scale.size
            return f"{shown:.0f}" if 1e4 <= abs(shown) < 1e9 else f"{shown:.4g}"
        case list() | tuple():
            return ", ".join(_value(item, scale) for item in value)
        case dict():
            return ", ".join(f"{key} {_value(item, scale)}" for key, item in value.items())
        case _:
            return str(value)


def _option(value: Any) -> str:
    """Return a value of ``--set``."""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.6g}" if isinstance(value, float) else str(value)
