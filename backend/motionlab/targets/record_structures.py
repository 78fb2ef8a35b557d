"""NamedTuples while lane functions are recorded: structures whose fields are expressions."""

from __future__ import annotations

import functools
from typing import Any, get_type_hints

from motionlab.targets.record_values import (
    DOUBLE,
    Constant,
    Expression,
    Member,
    Structure,
    number_or_lanes,
)


def expression_of(value: Any) -> Expression:
    """Return a value of a recorded function as one expression: a NamedTuple as a structure."""
    known = getattr(value, "_expression", None)
    if known is not None:
        return known
    if hasattr(value, "_fields"):
        fields = {
            name: expression_of(each) for name, each in zip(value._fields, value, strict=True)
        }
        made = Structure(class_of(value), fields)
        copied = _copied(made)
        return made if copied is None else copied
    return number_or_lanes(value)


def _copied(made: Structure) -> Expression | None:
    """Return the structure of which one has every field, if there is such."""
    base = None
    for name, each in made.fields.items():
        if not isinstance(each, Member) or each.name != name:
            return None
        if base is not None and each.base is not base:
            return None
        base = each.base
    return base if base is not None and base.kind is made.kind else None


def class_of(value: Any) -> Any:
    """Return the NamedTuple class of a value as its author wrote it.

    Where fields that are lanes in the class hold structures, it is a class of its own.
    """
    written = getattr(type(value), "_written", None)
    if written is not None:
        return written
    kind = type(value)
    inner = {
        name: class_of(each)
        for name, each in zip(kind._fields, value, strict=True)
        if hasattr(each, "_fields")
    }
    declared = {name for name, hint in get_type_hints(kind).items() if hasattr(hint, "_fields")}
    return kind if set(inner) <= declared else _class_with(kind, tuple(inner.items()))


@functools.cache
def _class_with(kind: Any, inner: tuple[tuple[str, Any], ...]) -> Any:
    """Return a NamedTuple class like another, with structures in some fields."""
    names = "_".join(dict.fromkeys(each.__name__.lstrip("_") for _, each in inner))
    body = {"__annotations__": dict(inner), "__doc__": kind.__doc__, "_like": kind}
    return type(f"{kind.__name__}_of_{names}", (kind,), body)


def structure(kind: Any, base: Expression, like: Any) -> Any:
    """Return a NamedTuple of the fields of a structure `base`.

    Fields of which `like`, a value of the same class, knows the structural constants stay known.
    """
    values = []
    for name, each in zip(like._fields, like, strict=True):
        if hasattr(each, "_fields"):
            inner = class_of(each)
            values.append(structure(inner, Member(base, name, inner), each))
        elif isinstance(each, Constant) and each.kept:
            values.append(Member(base, name, DOUBLE, each.value))
        elif is_structural(each):
            values.append(each)
        else:
            compared = each.compared if isinstance(each, Member) else None
            values.append(Member(base, name, expression_of(each).kind, compared))
    # A tuple has no room for the expression that it is; one of a subclass has.
    made = type(kind.__name__, (kind,), {"_written": kind})(*values)
    made._expression = base
    return made


def is_structural(value: Any) -> bool:
    """Tell whether a value is fixed for what is exported, and so no variable's."""
    if isinstance(value, Expression):
        return isinstance(value, Constant) and value.structural
    return not isinstance(value, (bool, int, float)) and not hasattr(value, "_fields")


def snake(kind: Any) -> str:
    """Return the name of a class in lower case: MotorMap is motor_map, LuGre is lugre."""
    name = kind.__name__.lstrip("_")
    parts: list[str] = []
    for letter in name:
        whole = parts and parts[-1][-3:].islower() and len(parts[-1]) > 2
        if letter.isupper() and (not parts or whole):
            parts.append(letter)
        elif parts:
            parts[-1] += letter
        else:
            parts.append(letter)
    return "_".join(part.strip("_") for part in parts).lower()
