"""Arguments of the calls of a lab, checked, and in types of JSON."""

from __future__ import annotations

import operator
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from motionlab.config.changes import with_files
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, naming_extras

Source = str | Path | Mapping[str, Any] | Scenario
"""A scenario: name of a shipped one, a ``.toml`` file, its tables, or one that was loaded."""

Changes = Mapping[str, Any] | None
"""Dotted path to value, SI, such as ``{"variants.B.controller.x.k_p": 312e3}``."""


def present(request: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a request that are not left out."""
    return {name: value for name, value in request.items() if value is not None}


def readable(scenario: Source) -> str | Path | dict[str, Any]:
    """Return a scenario as `load_scenario` takes it; text that ends with ``.toml`` is a path."""
    match scenario:
        case Scenario():
            return scenario.model_dump(mode="json")
        case Mapping():
            return tables(scenario, "scenario")
        case str() | Path():
            return path_of(scenario, "scenario")
    kinds = "a name, a .toml file, tables or a Scenario"
    raise ConfigError(FieldError("scenario", f"must be {kinds}", scenario))


def path_of(text: str | Path, loc: str) -> str | Path:
    """Return text that ends with ``.toml`` as a path."""
    if "\0" in str(text):
        raise ConfigError(FieldError(loc, "holds a zero byte", str(text)))
    return Path(text) if str(text).endswith(".toml") else text


def changes_of(value: object) -> dict[str, Any]:
    """Return changes in types of JSON, the files that they name for a part read."""
    return with_files(tables(value, "set"))


def tables(value: object, loc: str) -> dict[str, Any]:
    """Return a mapping in types of JSON; None is an empty one.

    Raises
    ------
    ConfigError
        If it is no mapping of names, or nested too deeply.
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise ConfigError(FieldError(loc, "is no mapping of names to values", value))
    try:
        return _with_motion(plain(value))
    except RecursionError:
        raise ConfigError(FieldError(loc, "is nested too deeply")) from None


def _with_motion(value: dict[str, Any]) -> dict[str, Any]:
    """Return a table in which samples of a kept run stand in its place."""
    own = value.get("kind") == "samples"
    motion = value if own else value.get("trajectory")
    if not (isinstance(motion, dict) and motion.get("kind") == "samples" and "run" in motion):
        return value
    with naming_extras("the motion of a kept run"):
        from motionlab.exchange.run_motion import motion_of_run

    others = {key: item for key, item in motion.items() if key != "run"}
    table = motion_of_run(str(motion["run"]), "trajectory.run") | others
    return table if own else value | {"trajectory": table}


def plain(value: Any) -> Any:
    """Return a value in types of JSON: arrays and numbers of numpy become Python's."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple | range):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


_HOLDS = {
    "minimum": operator.ge,
    "exclusive_minimum": operator.gt,
    "maximum": operator.le,
    "exclusive_maximum": operator.lt,
}


def check_number(
    loc: str, value: object, *, unit: str = "", whole: bool = False, **bounds: float
) -> None:
    """Check a number that no request does.

    Raises
    ------
    ConfigError
        If it is none, or beyond its bounds.
    """
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
    if not isinstance(value, kinds) or isinstance(value, bool):
        message = "must be a whole number" if whole else "must be a number"
    elif not all(_HOLDS[name](value, bound) for name, bound in bounds.items()):
        message = "is out of range"
    else:
        return
    raise ConfigError(FieldError(loc, message, value, unit=unit, bounds=bounds))


def check_words(loc: str, value: object) -> None:
    """Check text that no request does.

    Raises
    ------
    ConfigError
        If it is something else.
    """
    if not isinstance(value, str):
        raise ConfigError(FieldError(loc, "must be text", value))
