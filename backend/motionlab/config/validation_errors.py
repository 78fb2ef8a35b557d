"""From pydantic's validation errors to errors that name field, value, range and unit."""

from __future__ import annotations

import re
import types
import typing
from collections.abc import Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeGuard, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from motionlab.config.named_configs import did_you_mean
from motionlab.config.units import si_amount
from motionlab.errors import SHOWN_MAX, ConfigError, FieldError, Written, shown

ModelT = TypeVar("ModelT", bound=BaseModel)

_MESSAGES = {
    "missing": "is missing",
    "float_type": "must be a number",
    "float_parsing": "must be a number",
    "int_type": "must be a whole number",
    "int_parsing": "must be a whole number",
    "int_from_float": "must be a whole number",
    "bool_type": "must be true or false",
    "bool_parsing": "must be true or false",
    "string_type": "must be text",
    "finite_number": "must be a finite number",
    "greater_than": "is out of range",
    "greater_than_equal": "is out of range",
    "less_than": "is out of range",
    "less_than_equal": "is out of range",
    "literal_error": "is not one of the choices",
    "model_type": "must be a table",
    "model_attributes_type": "must be a table",
    "list_type": "must be a list",
    "extra_forbidden": "unknown key",
    "string_unicode": "holds half of a surrogate pair, which is no character",
    "string_too_short": "is too short",
    "string_too_long": "is too long",
    "string_pattern_mismatch": "is not of the allowed form",
    "dict_type": "must be a table",
    "tuple_type": "must be a list",
    "too_short": "has too few items",
    "too_long": "has too many items",
    "union_tag_not_found": "is missing",
    "union_tag_invalid": "is not one of the choices",
}
_ENDS = {
    "ge": "minimum",
    "gt": "exclusive_minimum",
    "le": "maximum",
    "lt": "exclusive_maximum",
}
_WORDS = {
    float: "a number",
    str: "a name",
    dict: "a table",
    tuple: "a list",
    list: "a list",
    bool: "true or false",
}
"""Members of a union, in the order in which an error lists them."""
_FORMS = {"^[A-Z]$": "one capital letter"}
"""Patterns of text in words."""
_CHOICE = re.compile(r"'([^']*)'")
_LONGEST_VALUE = 80
_FULL_MAX = 10 * SHOWN_MAX  # a file's errors are put in its order before the first are shown
_TAGS = "kind", "effect"
"""Fields that tell the members of a union apart."""
_PARTS = ("controller",)
"""Fields of a table that take a name where the table does not."""


def checked(model: type[ModelT], fields: Mapping[str, Any], name: str) -> ModelT:
    """Return a table of fields as a model; an error of the table as a whole has `name` as location.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    try:
        return model.model_validate(dict(fields))
    except ValidationError as error:
        # A key that is no text, half of a surrogate pair, fails the table as a whole.
        errors = (replace(e, loc=e.loc or name) for e in field_errors(error, model))
        raise ConfigError(*errors) from None
    except RecursionError:
        raise ConfigError(FieldError(loc=name, message="is nested too deeply")) from None


def field_errors(error: ValidationError, model: type[BaseModel]) -> list[FieldError]:
    """Return every error of a model's validation, in pydantic's order; the first 200 in full."""
    items = _one_of_each_union([dict(item) for item in error.errors(include_url=False)], model)
    containing = {item["loc"][:end] for item in items for end in range(len(item["loc"]))}
    return [
        _field_error(item, model)
        if index < _FULL_MAX
        else FieldError(".".join(map(str, item["loc"])), str(item["msg"]))  # counted, not shown
        for index, item in enumerate(items)
        # A list with a bad item is also "too short": its good items alone were counted.
        if not (item["type"] == "too_short" and item["loc"] in containing)
    ]


def in_words(item: Mapping[str, Any]) -> tuple[str, str]:
    """Return the message of a pydantic error, and the allowed range if it has one."""
    kind, details = item["type"], item.get("ctx", {})
    message = _MESSAGES.get(kind) or str(item["msg"]).removeprefix("Value error, ")
    allowed = ""
    match kind:
        case "string_pattern_mismatch":
            pattern = str(details["pattern"])
            allowed = _FORMS.get(pattern, f"text that matches {pattern}")
        case "string_too_short":
            allowed = f"{details['min_length']} or more characters"
        case "string_too_long":
            allowed = f"{details['max_length']} or fewer characters"
        case "too_short":
            allowed = f"{details['min_length']} or more"
        case "too_long":
            allowed = f"{details['max_length']} or fewer"
        case "literal_error":
            allowed = "one of " + ", ".join(_CHOICE.findall(str(details["expected"])))
        case _:
            pass
    return message, allowed


def _one_of_each_union(items: list[dict[str, Any]], model: type[BaseModel]) -> list[dict[str, Any]]:
    """Return the errors with one for a value that is of no member of a union, without its tag.

    The error that says most stays: text may be too long and, as any text is, no number.
    """
    kept: dict[object, dict[str, Any]] = {}
    for number, item in enumerate(items):
        union = _walk(item["loc"], model).union
        if not union:
            kept[number] = item
            continue
        loc = item["loc"][:-1]
        if item["type"].endswith(("_type", "_from_float")):
            kept.setdefault(loc, item | {"loc": loc, "type": "union", "members": union})
        elif kept.get(loc, {"type": "union"})["type"] == "union":
            kept[loc] = item | {"loc": loc}
    return list(kept.values())


def unit_of(path: str, model: BaseModel) -> str:
    """Return the unit of a field by its dotted path; empty for tables, names and switches."""
    return unit_of_field(_field_at(path, model))


def is_whole(path: str, model: BaseModel) -> bool:
    """Return whether a field, by its dotted path, takes whole numbers alone."""
    info = _field_at(path, model)
    return info is not None and [strip(kind) for kind in members(info.annotation)] == [int]


def _field_at(path: str, model: BaseModel) -> FieldInfo | None:
    at: Any = model
    info: FieldInfo | None = None
    for step in path.split("."):
        if isinstance(at, BaseModel):
            info = type(at).model_fields.get(step)
            at = getattr(at, step, None)
        elif isinstance(at, Mapping):
            at = at.get(step)
        elif isinstance(at, tuple):  # its items have the unit of the field
            at = at[int(step)]
        else:
            return None  # below what the scenario leaves out
    return info


def _field_error(item: dict[str, Any], model: type[BaseModel]) -> FieldError:
    path, info, siblings, _ = _walk(item["loc"], model)
    kind = item["type"]
    bounds = bounds_of(info)
    if kind == "extra_forbidden":
        deeper = _deeper(item["loc"], path[-1], model)
        message = f"unknown key{did_you_mean(path[-1], siblings) or deeper}"
        return FieldError(
            loc=".".join(path),
            message=message,
            value=_shown(item["input"]),
            range="one of " + ", ".join(siblings),
        )
    message, allowed = in_words(item)
    if kind != "value_error":  # else it is one of the choices, and refused for another reason
        allowed = choices_of(info) or allowed
    if kind == "union":
        kinds = [words for member, words in _WORDS.items() if member in item["members"]]
        message = f"must be {', '.join(kinds[:-1])} or {kinds[-1]}"
    unit = unit_of_field(info)
    if kind in {"model_type", "model_attributes_type"}:
        message, allowed = _table_in_words(item["input"], path, info)
    if isinstance(item["input"], bool) and _has_switch(info):
        message += f": set {'.'.join(path)}.enabled"
    if kind in {"float_type", "int_type", "float_parsing", "int_parsing"}:
        message += _number_in_words(item["input"], unit)
    at_fault = kind != "missing" and not (kind == "value_error" and isinstance(item["input"], dict))
    value = _shown(item["input"]) if at_fault else None
    if kind == "union_tag_invalid":
        known = [word.strip("'") for word in item["ctx"]["expected_tags"].split(", ")]
        value = item["ctx"]["tag"]
        message += did_you_mean(value, known)
        allowed, unit = "one of " + ", ".join(known), ""
    if kind in {"too_short", "too_long"}:
        value, unit = item["ctx"]["actual_length"], "items"
    if path and path[-1] == "[key]":
        path, unit = path[:-1], ""
        if kind == "literal_error":
            known = _CHOICE.findall(item["ctx"]["expected"])
            message = f"unknown key{did_you_mean(path[-1], known)}"
    if kind in {"union_tag_invalid", "union_tag_not_found"}:
        path = [*path, item["ctx"]["discriminator"].strip("'").removesuffix("_kind()") or "kind"]
    return FieldError(
        loc=".".join(path),
        message=message,
        value=value,
        range=allowed,
        unit=unit,
        bounds={} if allowed else bounds,
    )


def _table_in_words(value: Any, path: list[str], info: FieldInfo | None) -> tuple[str, str]:
    """Return the message about a value in place of a table, with the table's fields."""
    tables = [each for each in (members(info.annotation) if info else ()) if _is_table(each)]
    fields = [key for each in tables for key in each.model_fields] if len(tables) == 1 else []
    part = next((field for field in fields if field in _PARTS), None)
    hint = f", did you mean '{'.'.join(path)}.{part}'?" if isinstance(value, str) and part else ""
    listed = fields and not isinstance(value, bool)  # a switch is named
    return f"must be a table{hint}", f"a table of {', '.join(fields)}" if listed else ""


def _is_table(annotation: Any) -> TypeGuard[type[BaseModel]]:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)


def _number_in_words(value: Any, unit: str) -> str:
    """Return the number that a text such as ``15mm`` stands for, in words; or nothing."""
    amount = si_amount(value, unit) if isinstance(value, str) else None
    if amount is None:
        return ""
    return f", in {unit}: {amount!r}" if unit not in {"", "1"} else f": {amount!r}"


def _deeper(loc: tuple[Any, ...], key: str, model: type[BaseModel]) -> str:
    """Return a hint at a field of that name one table deeper, or nothing."""
    info = _walk(loc[:-1], model).info if loc[:-1] else None
    for table in [model] if info is None else members(info.annotation):
        for name, field in getattr(table, "model_fields", {}).items():
            if any(key in getattr(m, "model_fields", {}) for m in members(field.annotation)):
                return f", did you mean '{name}.{key}'?"
    return ""


def _shown(value: Any) -> Any:
    """Return a value as shown in a message; None as text."""
    return Written("null") if value is None else shown(value, _LONGEST_VALUE)


def _has_switch(info: FieldInfo | None) -> bool:
    """Return whether a field is a table with the field ``enabled``."""
    kinds = members(info.annotation) if info is not None else []
    return any("enabled" in getattr(kind, "model_fields", {}) for kind in kinds)


class _Walked(NamedTuple):
    """A location without the tags that pydantic adds for unions, and where it ends.

    Attributes
    ----------
    path : list of str
        The location.
    info : FieldInfo or None
        Field at its end.
    siblings : list of str
        Names of the fields next to it.
    union : list
        Members of the union of plain values, if the location ends with a tag of it.
    """

    path: list[str]
    info: FieldInfo | None
    siblings: list[str]
    union: list[Any]


def _walk(loc: tuple[int | str, ...], model: type[BaseModel]) -> _Walked:
    """Follow an error's location through the models."""
    path: list[str] = []
    info: FieldInfo | None = None
    siblings: list[str] = []
    union: list[Any] = []
    at: Any = model
    for step in loc:
        at, union = strip(at), []
        kinds = members(at)
        if len(kinds) > 1:
            tagged = [m for m in kinds if _tag(m) == step]
            if tagged:
                at = tagged[0]
                continue
            models = [m for m in kinds if _is_table(m)]
            if not models:
                union = [typing.get_origin(strip(m)) or strip(m) for m in kinds]
            kinds = models or kinds
        at = kinds[0]
        path.append(str(step))
        if _is_table(at):
            named = {known.alias or name: known for name, known in at.model_fields.items()}
            siblings = list(named)
            info = named.get(str(step))
            at = info.annotation if info is not None else Any
        else:
            at = item_of(at)
            unit = unit_of_field(info)
            info = FieldInfo.from_annotation(at)
            info.json_schema_extra = {"unit": unit}  # a list has the unit of its items
            siblings = []
    return _Walked(path, info, siblings, union)


def strip(annotation: Any) -> Any:
    """Return an annotation without its pydantic metadata."""
    while typing.get_origin(annotation) is typing.Annotated:
        annotation = typing.get_args(annotation)[0]
    return annotation


def members(annotation: Any) -> list[Any]:
    """Return the members of a union, nested ones included and None left out."""
    annotation = strip(annotation)
    if typing.get_origin(annotation) in {typing.Union, types.UnionType}:
        return [
            member
            for argument in typing.get_args(annotation)
            for member in members(argument)
            if member is not types.NoneType
        ]
    return [annotation]


def model_of(annotation: Any, tables: Any) -> type[BaseModel] | None:
    """Return the model of some tables: of several, that of their kind, by default the first."""
    models = [each for each in members(annotation) if _is_table(each)]
    if len(models) > 1:
        tag = next((name for name in _TAGS if name in models[0].model_fields), "")
        kind = tables.get(tag) if isinstance(tables, Mapping) else getattr(tables, tag, None)
        models = [each for each in models if kind is None or _tag(each) == kind]
    return models[0] if models else None


def item_of(annotation: Any) -> Any:
    """Return the type of the items of a list, or of the values of a mapping."""
    arguments = typing.get_args(strip(annotation))
    return next((each for each in reversed(arguments) if each is not ...), Any)


def _tag(model: Any) -> Any:
    fields = getattr(model, "model_fields", {})
    return next((_only(fields[name]) for name in _TAGS if name in fields), None)


def _only(info: FieldInfo) -> Any:
    """Return the default of a tag, or the only value that it can take."""
    values = typing.get_args(strip(info.annotation))
    return values[0] if info.is_required() and len(values) == 1 else info.default


def unit_of_field(info: FieldInfo | None) -> str:
    """Return the SI unit of a field; empty for tables, names and switches."""
    extra = info.json_schema_extra if info is not None else None
    return str(extra.get("unit", "")) if isinstance(extra, dict) else ""


def bounds_of(info: FieldInfo | None) -> dict[str, float]:
    """Return the ends of a field's range, as `motionlab.errors.SIGNS` calls them."""
    ends: dict[str, Any] = {}
    for entry in info.metadata if info is not None else ():
        ends |= {name: end for name in _ENDS if (end := getattr(entry, name, None)) is not None}
    return ends_of(ends)


def ends_of(ends: Mapping[str, Any]) -> dict[str, float]:
    """Return the ends among pydantic's names of them, as `motionlab.errors.SIGNS` calls them."""
    return {key: ends[name] for name, key in _ENDS.items() if name in ends}


def choices_of(info: FieldInfo | None) -> str:
    """Return the values that a field may take, in words; empty where it is no choice."""
    annotation = strip(info.annotation) if info is not None else None
    if typing.get_origin(annotation) is not typing.Literal:
        return ""
    return "one of " + ", ".join(str(choice) for choice in typing.get_args(annotation))
