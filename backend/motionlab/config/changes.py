"""Changes of a scenario: dotted paths and new values, as ``--set`` and REST give them."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping
from typing import Any

from motionlab.config.parts import controller_name, resolve
from motionlab.errors import ConfigError, FieldError

SCHEDULABLE = ("plant", "variants", "load")
"""Tables that can change during a run."""

_CONTROLLER = re.compile(r"(variants\.[A-Z])\.controller(?:\.base)?")
_ITEM = re.compile("0|[1-9][0-9]{0,8}")


def parse_assignments(assignments: Iterable[str]) -> dict[str, Any]:
    """Return ``key=value`` texts as a mapping; a value is TOML, or else plain text.

    Raises
    ------
    ConfigError
        If there is no key or no equals sign, or a key comes twice.
    """
    changes: dict[str, Any] = {}
    for text in assignments:
        key, separator, value = text.partition("=")
        key = key.strip()
        if not separator or not key:
            raise ConfigError(FieldError(loc="--set", message="needs key=value", value=text))
        if key in changes:
            raise ConfigError(FieldError(loc=key, message="is set twice", value=value))
        changes[key] = _parse_value(value.strip())
    return changes


def apply_changes(document: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of resolved tables with dotted paths set, shallow paths first."""
    tables = copy.deepcopy(document)
    changes = labelled(changes)
    for path, value in sorted(changes.items(), key=lambda item: item[0].count(".")):
        if path == "base":
            raise ConfigError(FieldError(loc="base", message="is not a field: name the scenario"))
        set_path(tables, path.removesuffix(".base"), value)
        if isinstance(value, str | dict):  # it may name a part, or hold one with a base
            tables = resolve(tables)
    return tables


def labelled(changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return changes with a label for each variant whose controller is swapped for another one.

    The label of a variant tells of the controller that it had. Changes that set one keep theirs.
    """
    labels = {}
    for path, value in changes.items():
        swapped = _CONTROLLER.fullmatch(path)
        name = controller_name(value) if swapped else None
        if swapped and name is not None:
            labels[f"{swapped[1]}.label"] = name
    return labels | dict(changes)


def check_schedulable(changes: Mapping[str, Any], loc: str) -> None:
    """Refuse changes of what cannot change during a run.

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


def set_path(tables: dict[str, Any], path: str, value: Any) -> None:
    """Set what stands at a dotted path, making the tables on the way that are not there.

    Raises
    ------
    ConfigError
        If the path leads into a single value, or to an item that a list does not have.
    """
    keys = path.split(".")
    here: Any = tables
    for depth, key in enumerate(keys):
        last = depth == len(keys) - 1
        if isinstance(here, list) and _ITEM.fullmatch(key) and int(key) < len(here):
            index = int(key)
            if last:
                here[index] = value
            else:
                here = here[index]
        elif isinstance(here, dict):
            if last:
                here[key] = value
            else:
                if here.get(key) is None:
                    here[key] = {}
                here = here[key]
        else:
            parent = ".".join(keys[:depth])
            message, allowed = f"{parent} is a single value, it has no such field", ""
            if isinstance(here, list):
                message, allowed = f"{parent} has no such item", f"0 to {len(here) - 1}"
            raise ConfigError(
                FieldError(".".join(keys[: depth + 1]), message, value, allowed if here else "none")
            )


def _parse_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # also a number of thousands of digits, or deep nesting
        return text
    return parsed["value"] if len(parsed) == 1 else text
