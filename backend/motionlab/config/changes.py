"""Changes of a scenario: dotted paths and new values, as ``--set`` and REST give them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

from pydantic import BaseModel
from pydantic_core import PydanticUndefined, to_jsonable_python

from motionlab.config.bounds import DEPTH_MAX
from motionlab.config.includes import controller_name, part_of_file, resolve
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import item_of, model_of
from motionlab.errors import ConfigError, FieldError

SCHEDULABLE = ("plant", "variants", "load")
"""Tables that can change during a run."""

_CONTROLLER = re.compile(r"(variants\.[A-Z])\.controller(?:\.base)?")
_PART_PARTS = 8  # parts of the path of what may be a name: variants.A.controller.model.x.force_map
_ITEM = re.compile("0|[1-9][0-9]{0,8}")


def split_pairs(texts: Iterable[str], option: str, form: str = "KEY=VALUE") -> dict[str, str]:
    """Return ``key=value`` texts as a mapping of texts.

    Errors name `option`, of the command line, and the `form` in which its help has such a text.

    Raises
    ------
    ConfigError
        If there is no key or no equals sign, or a key comes twice.
    """
    pairs: dict[str, str] = {}
    for text in texts:
        key, separator, value = (part.strip() for part in text.partition("="))
        if not separator or not key:
            raise ConfigError(FieldError(loc=option, message=f"needs {form}", value=text))
        if key in pairs:
            raise ConfigError(FieldError(loc=option, message=f"sets {key} twice", value=value))
        pairs[key] = value
    return pairs


def parse_assignments(assignments: Iterable[str], option: str = "--set") -> dict[str, Any]:
    """Return ``key=value`` texts as a mapping; a value is TOML, or else plain text.

    Of ``--set`` the path of a ``.toml`` file stands for the part that is in it.

    Raises
    ------
    ConfigError
        If there is no key or no equals sign, or a key comes twice.
    """
    pairs = split_pairs(assignments, option)
    values = {key: _parse_value(value) for key, value in pairs.items()}
    return with_files(values) if option == "--set" else values


def with_files(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes of a caller on this machine, the files of parts that they name read.

    Raises
    ------
    ConfigError
        If a file, or a part that it names, is not there.
    """
    return {path: part_of_file(path, value, Path()) for path, value in changes.items()}


def apply_changes(document: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return resolved tables with dotted paths set, shallow paths first; `document` stays.

    A path may lead into what the tables leave to a default. Names of parts are resolved once for
    all paths of the same depth.

    Raises
    ------
    ConfigError
        If a path has too many parts or leads nowhere, two name one field, or a part is not there.
    """
    too_long = [path for path in changes if path.count(".") >= DEPTH_MAX]
    if too_long:
        most: dict[str, float] = {"maximum": DEPTH_MAX}
        raise ConfigError(*(FieldError(p, "has too many parts", bounds=most) for p in too_long))
    indexed = [path for path in changes if "[" in path]
    if indexed:
        message = "unknown key: an item of a list is written as .0, not as [0]"
        raise ConfigError(*(FieldError(path, message, changes[path]) for path in indexed))
    for path, other in twice(changes):
        raise ConfigError(FieldError(path, f"is set twice, also as {other}", changes[path]))
    tables = dict(document)
    for dots, group in groupby(sorted(labelled(changes).items(), key=_dots), key=_dots):
        names_parts = False
        for path, value in group:
            if path == "base":
                raise ConfigError(FieldError("base", "is not a field: name the scenario"))
            set_path(tables, _field(path), value, Scenario)
            # It may name a part, or hold one with a base.
            names_parts |= isinstance(value, str | dict) and dots < _PART_PARTS
        if names_parts:
            tables = resolve(tables)
    return tables


def twice(paths: Iterable[str]) -> Iterator[tuple[str, str]]:
    """Yield each path that names the field of an earlier one, such as ``plant.base``, and that."""
    first: dict[str, str] = {}
    for path in paths:
        if _field(path) in first:
            yield path, first[_field(path)]
        first.setdefault(_field(path), path)


def reapplied(shared: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes together with those of earlier ones that they would overwrite.

    Applied to tables that `shared` has been applied to already, they give what all changes give
    at once: a part that `changes` swaps keeps what `shared` sets inside it. Of a field in both,
    `changes` wins.
    """
    depth = {path.split(".")[0]: DEPTH_MAX for path in changes}
    for path in changes:
        root = path.split(".")[0]
        depth[root] = min(depth[root], _field(path).count("."))
    swept = {_field(path) for path in changes}
    kept = {
        path: value
        for path, value in shared.items()
        if _field(path).count(".") >= depth.get(path.split(".")[0], DEPTH_MAX)
        and _field(path) not in swept
    }
    return kept | dict(changes)


def as_tables(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return dotted paths and values, such as ``{"requirements.n": 4}``, as nested tables.

    Raises
    ------
    ConfigError
        If one path lies inside of another that is set to a single value.
    """
    tables: dict[str, Any] = {}
    for path in sorted(changes, key=lambda path: path.count(".")):
        set_path(tables, path, changes[path])
    return tables


def labelled(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes with a label for each variant whose controller is swapped for another one.

    A label describes the controller before the change. Labels set by the changes are kept.
    """
    labels = {}
    for path, value in changes.items():
        swapped = _CONTROLLER.fullmatch(path)
        name = controller_name(value) if swapped else None
        if swapped and name is not None:
            labels[f"{swapped[1]}.label"] = name
    return labels | dict(changes)


def check_schedulable(changes: Mapping[str, Any], loc: str) -> None:
    """Refuse scheduled changes of fields that are fixed during a run.

    Raises
    ------
    ConfigError
        Naming every such path, below `loc`.
    """
    refused = [
        FieldError(
            loc=f"{loc}.{path}",
            message="cannot change during a run",
            range="paths that begin with " + ", ".join(SCHEDULABLE),
        )
        for path in changes
        if path.split(".")[0] not in SCHEDULABLE
    ]
    if refused:
        raise ConfigError(*refused)


def set_path(
    tables: dict[str, Any], path: str, value: Any, model: type[BaseModel] | None = None
) -> None:
    """Set the value at a dotted path of `tables`; those inside of them are copied, not changed.

    A table on the way that is not there begins with the default of its field in `model`, or empty.

    Raises
    ------
    ConfigError
        If the path leads into a single value, or to an item that a list does not have.
    """
    *parents, last = path.split(".")
    table: Any = tables
    for depth, key in enumerate(parents):
        slot = _slot(table, key, parents[:depth], value)
        inner = table[slot] if isinstance(table, list) else table.get(slot)
        if inner is None:
            inner = _default(model, tables, parents[: depth + 1])
        table[slot] = inner.copy() if isinstance(inner, dict | list) else inner
        table = table[slot]
    table[_slot(table, last, parents, value)] = value


def _slot(table: Any, key: str, path: Sequence[str], value: Any) -> Any:
    """Return the key of a value in the table, or its index in the list, at some path."""
    if isinstance(table, dict):
        return key
    parent = ".".join(path)
    if not isinstance(table, list):
        message, allowed = f"{parent} is a single value, it has no such field", ""
    elif _ITEM.fullmatch(key) and int(key) < len(table):
        return int(key)
    else:
        message = f"{parent} has no such item"
        allowed = f"0 to {len(table) - 1}" if table else "none"
    raise ConfigError(FieldError(f"{parent}.{key}", message, value, allowed))


def _default(model: Any, tables: Any, path: Sequence[str]) -> Any:
    """Return the default at a path of a model's tables, as JSON has it; {} where there is none."""
    annotation, default = model, None
    for key in path:
        fields = getattr(model_of(annotation, tables), "model_fields", {})
        info = fields.get(key)
        annotation = info.annotation if info else None if fields else item_of(annotation)
        default = info.default if info else None
        tables = tables[int(key)] if isinstance(tables, list) else tables.get(key)
    return {} if default is None or default is PydanticUndefined else to_jsonable_python(default)


def _field(path: str) -> str:
    """Return the path of a field, which ``.base`` names too."""
    return path.removesuffix(".base")


def _dots(change: tuple[str, Any]) -> int:
    return _field(change[0]).count(".")


def _parse_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # also a number of thousands of digits, or deep nesting
        return text
    return parsed["value"] if len(parsed) == 1 else text
