"""Hints in errors of a scenario: the fields that a wrong path may mean."""

from __future__ import annotations

import contextlib
import re
import typing
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, TypeGuard

from pydantic import BaseModel

from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import members, strip
from motionlab.errors import SHOWN_MAX, ConfigError, FieldError

_INDEX = re.compile(r"\[([0-9]{1,9})\]")
_UNKNOWN = "unknown key"
_HINTS_MAX = 4
_PATHS_MAX = 5000
_ERRORS_MAX = 10 * SHOWN_MAX


@contextlib.contextmanager
def hinted(document: Mapping[str, Any], changes: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Add to errors of unknown keys the paths of the fields of that name.

    Parameters
    ----------
    document : mapping
        Resolved tables of the scenario; which fields there are depends on its kind of motion, its
        variants and its lists.
    changes : mapping of str to value, optional
        Changes of it, by dotted path.
    """
    try:
        yield
    except ConfigError as error:
        if not any(each.message.startswith(_UNKNOWN) for each in error.errors):
            raise
        paths = list(_paths(Scenario, document, ""))[:_PATHS_MAX]
        hints = [_hinted(each, paths, changes or {}) for each in error.errors[:_ERRORS_MAX]]
        raise ConfigError(*hints, *error.errors[_ERRORS_MAX:]) from None


def _hinted(error: FieldError, paths: list[str], changes: Mapping[str, Any]) -> FieldError:
    if not error.message.startswith(_UNKNOWN):
        return error
    parent = error.loc.rpartition(".")[0]
    # Of a change the rest of its path says more: the x of x.k_p is not plant.x.
    whole = next((path for path in changes if f"{path}.".startswith(f"{error.loc}.")), error.loc)
    if "did you mean" in error.message and whole == error.loc:
        return error
    tail = _INDEX.sub(r".\1", whole.removeprefix(f"{parent}.") if parent else whole)
    near = [path for path in paths if path == tail or path.endswith(f".{tail}")]
    # Those inside the table that the path names, if there are any.
    near = [path for path in near if parent and path.startswith(f"{parent}.")] or near
    if not near or len(near) > 2 * _HINTS_MAX:
        return error
    names = [f"'{path}'" for path in near[:_HINTS_MAX]]
    if len(near) > _HINTS_MAX:
        text = ", ".join(names) + ", ..."
    else:
        text = " or ".join([", ".join(names[:-1]), names[-1]] if len(names) > 1 else names)
    return replace(error, message=f"{_UNKNOWN}, did you mean {text}?")


def _paths(annotation: Any, value: Any, path: str) -> Iterator[str]:
    """Yield the path of every field that a value of some type has or may have."""
    if path:
        yield path
    below = f"{path}." if path else ""
    kind = value.get("kind") if isinstance(value, Mapping) else None
    models = [each for each in members(annotation) if _is_model(each)]
    if len(models) > 1:
        models = [
            each
            for each in models
            if each.model_fields.get("kind") and each.model_fields["kind"].default == kind
        ]
    if models:
        for name, info in models[0].model_fields.items():
            key = info.alias or name
            inner = value.get(key) if isinstance(value, Mapping) else None
            yield from _paths(info.annotation, inner, below + key)
    elif isinstance(value, Mapping):
        item = _item(annotation)
        for key, inner in value.items():
            yield from _paths(item, inner, f"{below}{key}")
    elif isinstance(value, list | tuple) and len(value) <= _HINTS_MAX:
        item = _item(annotation)
        for index, inner in enumerate(value):
            yield from _paths(item, inner, f"{below}{index}")


def _item(annotation: Any) -> Any:
    """Return the type of the items of a list, or of the values of a mapping."""
    arguments = typing.get_args(strip(annotation))
    return next((each for each in reversed(arguments) if each is not ...), Any)


def _kind_of(model: type[BaseModel]) -> Any:
    field = model.model_fields.get("kind")
    return None if field is None else field.default


def _is_model(annotation: Any) -> TypeGuard[type[BaseModel]]:
    return isinstance(annotation, type) and issubclass(annotation, BaseModel)
