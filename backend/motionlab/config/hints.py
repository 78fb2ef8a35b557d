"""Hints in errors of a scenario: the fields that a wrong path may mean."""

from __future__ import annotations

import itertools
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import item_of, model_of
from motionlab.errors import SHOWN_MAX, FieldError

_INDEX = re.compile(r"\[([0-9]{1,9})\]")
_UNKNOWN = "unknown key"
_HINTS_MAX = 4
_PATHS_MAX = 5000
_ERRORS_MAX = 10 * SHOWN_MAX


def add_hints(
    errors: Sequence[FieldError], document: Mapping[str, Any], changes: Mapping[str, Any]
) -> list[FieldError]:
    """Return errors of a scenario; those of unknown keys name the fields of that name.

    Which fields there are depends on the document's kind of motion, its variants and its lists.
    """
    if not any(each.message.startswith(_UNKNOWN) for each in errors):
        return list(errors)
    paths = list(itertools.islice(_paths(Scenario, document, ""), _PATHS_MAX))
    hints = [_hinted(each, paths, changes) for each in errors[:_ERRORS_MAX]]
    return [*hints, *errors[_ERRORS_MAX:]]


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
    if model := model_of(annotation, value):
        for name, info in model.model_fields.items():
            if isinstance(value, Mapping):
                inner = value.get(name, info.default)
            else:
                inner = getattr(value, name, info.default)
            yield from _paths(info.annotation, inner, below + name)
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _paths(item_of(annotation), inner, f"{below}{key}")
    elif isinstance(value, list | tuple) and len(value) <= _HINTS_MAX:
        for index, inner in enumerate(value):
            yield from _paths(item_of(annotation), inner, f"{below}{index}")
