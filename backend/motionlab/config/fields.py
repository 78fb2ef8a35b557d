"""Fields of a model as the screen shows them: name, unit, factor, bounds, choices and default."""

from __future__ import annotations

import typing
from collections.abc import Iterator
from typing import Any, NamedTuple

from pydantic import BaseModel, Field
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined, to_jsonable_python

from motionlab.config.planar import AXES, PAIRS
from motionlab.config.quantity import Choice
from motionlab.config.validation_errors import (
    bounds_of,
    choices_of,
    members,
    strip,
    unit_of_field,
)
from motionlab.errors import FieldError

EVERY = "*"
"""Stands in a path for any key of a mapping, such as the letter of a variant."""


class FieldEntry(BaseModel):
    """One field of a form."""

    label: str = Field(description="Name on the screen; subscripts follow an underscore")
    symbol: str | None = Field(default=None, description="Letter in equations, or abbreviation")
    unit: str = Field(default="", description="Unit on the screen")
    factor: float = Field(default=1.0, description="Displayed number over SI number")
    whole: bool = Field(default=False, description="Whether it is a whole number")
    description: str = ""
    bounds: dict[str, float] | None = Field(
        default=None,
        description="`minimum`, `exclusive_minimum`, `maximum`, `exclusive_maximum`, SI",
    )
    choices: list[Choice] | None = Field(default=None, description="Values that it can take")
    default: Any = None
    example: Any = Field(
        default=None, description="A usual value where the default is none, or off"
    )
    usual: tuple[float, float] | None = Field(default=None, description="Range of a slider, SI")
    used_with: list[str] | None = Field(
        default=None, description="Choices of the field beside it with which it matters"
    )


def fields_of(model: type[BaseModel]) -> dict[str, FieldEntry]:
    """Return every field of a model by its dotted path; mappings and lists count as one item, `*`.

    Of alternatives, such as the kinds of a trajectory, fields of one name are one entry.
    """
    entries: dict[str, FieldEntry] = {}
    _walk(model, "", "", entries, {})
    return entries


def _walk(
    model: type[BaseModel],
    prefix: str,
    axis: str,
    entries: dict[str, FieldEntry],
    defaults: dict[str, Any],
) -> None:
    for name, info in model.model_fields.items():
        key = info.alias or name
        if key == "kind":  # distinguishes alternatives
            continue
        path = prefix + key
        default = defaults.get(key, _default(info))
        annotation = strip(info.annotation)
        if any(pair in members(annotation) for pair in PAIRS):
            for component in AXES:
                _add(entries, f"{path}.{component}", _entry(key, info, component))
            continue
        below = [(path, member) for member in members(annotation)]
        if typing.get_origin(annotation) in {dict, tuple}:
            items = [each for each in typing.get_args(annotation) if each is not ...]
            below = [(f"{path}.{EVERY}", member) for member in members(items[-1])]
        tables = [(at, each) for at, each in below if _is_table(each)]
        if key not in AXES or not tables:
            _add(entries, path, _entry(key, info, axis, default))
        inherited = axis if key == "model" else ""
        for at, table in tables:
            if table is not model and not issubclass(model, table):
                suffix = key if key in AXES and not model.__name__.startswith("Plant") else axis
                values = default if isinstance(default, dict) else {}
                _walk(table, f"{at}.", suffix or inherited, entries, values)


def _is_table(annotation: Any) -> bool:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _default(info: FieldInfo) -> Any:
    if info.default_factory is not None or info.default is PydanticUndefined:
        return None
    return to_jsonable_python(info.default)


def _entry(key: str, info: FieldInfo, axis: str, default: Any = None) -> FieldEntry:
    extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
    kinds = members(info.annotation)
    choices: Any = extra.get("choices")
    if choices is None and typing.get_origin(kinds[0]) is typing.Literal:
        values = typing.get_args(kinds[0])
        choices = [Choice(value=each, label=each.replace("_", " ")) for each in values]
    unit = str(extra.get("display_unit", unit_of_field(info)))
    return FieldEntry(
        label=" ".join(filter(None, (info.title or key.replace("_", " "), axis))),
        unit="" if unit == "1" else unit,
        factor=typing.cast("float", extra.get("display_factor", 1.0)),
        whole=int in kinds,
        description=info.description or "",
        bounds=bounds_of(info) or None,
        choices=choices,
        default=default,
        example=next(iter(info.examples or ()), None),
        symbol=typing.cast("Any", extra.get("symbol")),
        usual=typing.cast("Any", extra.get("usual")),
        used_with=typing.cast("Any", extra.get("used_with")),
    )


def _add(entries: dict[str, FieldEntry], path: str, entry: FieldEntry) -> None:
    """Add an entry, or merge it with that of another alternative."""
    before = entries.setdefault(path, entry)
    if before is not entry:
        differing = [
            name
            for name in ("description", "bounds", "default")
            if getattr(before, name) != getattr(entry, name)
        ]
        empty = {name: FieldEntry.model_fields[name].default for name in differing}
        entries[path] = before.model_copy(update=empty)


class FieldValue(NamedTuple):
    """A field of one scenario.

    Attributes
    ----------
    path : str
        Dotted path, as ``--set`` takes it.
    value : Any
        As JSON has it; None where it is left out.
    unit : str
        SI; empty for names and switches.
    range : str
        What is allowed, in words.
    description : str
        What it is.
    """

    path: str
    value: Any
    unit: str
    range: str
    description: str


def values_of(model: BaseModel) -> Iterator[FieldValue]:
    """Yield every field of a config with its value; lists of numbers are one field."""
    for name, info in type(model).model_fields.items():
        yield from _below(info.alias or name, getattr(model, name), info)


def _below(path: str, value: Any, info: FieldInfo) -> Iterator[FieldValue]:
    if isinstance(value, PAIRS):
        for axis, component in type(value).model_fields.items():
            of_axis = f"{info.description}, {axis}" if info.description else ""
            yield _value(f"{path}.{axis}", getattr(value, axis), component, of_axis)
    elif isinstance(value, BaseModel):
        for each in values_of(value):
            yield each._replace(path=f"{path}.{each.path}")
    elif isinstance(value, dict) and any(isinstance(item, BaseModel) for item in value.values()):
        for key, item in value.items():
            yield from _below(f"{path}.{key}", item, info)
    elif isinstance(value, tuple) and any(isinstance(item, BaseModel) for item in value):
        for index, item in enumerate(value):
            yield from _below(f"{path}.{index}", item, info)
    else:
        yield _value(path, value, info, info.description or "")


def _value(path: str, value: Any, info: FieldInfo, description: str) -> FieldValue:
    unit = unit_of_field(info)
    return FieldValue(
        path,
        to_jsonable_python(value),
        "" if unit == "1" else unit,
        FieldError(path, "", bounds=bounds_of(info)).range or choices_of(info),
        description,
    )
