"""The only parser of scenarios: names and tables in, a validated scenario out.

A part of a scenario (``plant``, ``trajectory``, a variant's ``controller``, a controller's
``model``, the scenario itself) is a table, the name of a shipped one, or a table with
``base = "name"`` whose other keys replace those of the shipped one.
"""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from motionlab.config.complaints import field_errors
from motionlab.config.scenario import Scenario
from motionlab.config.shipped import Kind, is_name, parse, read
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.errors import ConfigError, FieldError

_ITEM = re.compile("0|[1-9][0-9]{0,8}")
_MODEL_KEYS = ("mass", "friction", "force_map")
_SCHEDULABLE = ("plant", "variants", "load")
_DEEPEST_BASE = 8


def load_scenario(
    source: str | Path | Mapping[str, Any], changes: Mapping[str, Any] | None = None
) -> Scenario:
    """Return the scenario that `source` describes, with `changes` applied.

    Parameters
    ----------
    source : str, Path or mapping
        Name of a shipped scenario, a TOML file, or the tables themselves. Text is never a path, so
        that a remote caller cannot name files.
    changes : mapping of str to value, optional
        Dotted path to value, such as ``{"variants.B.controller.x.k_p": 312000.0}``; all are
        applied together, parts before what lies inside them, and then validated.

    Returns
    -------
    Scenario
        Fully resolved and validated.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    try:
        document = resolve(_read_source(source))
        if changes:
            document = apply_changes(_with_defaults(document), changes)
        return validate(document)
    except RecursionError:
        raise ConfigError(FieldError(loc="scenario", message="is nested too deeply")) from None


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


def resolve(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scenario's tables with every name and ``base`` replaced by what it stands for."""
    tables = _resolve_part("scenarios", document, "scenario", 0)
    if "plant" in tables:
        tables["plant"] = _resolve_part("motors", tables["plant"], "plant", 0)
    if "trajectory" in tables:
        tables["trajectory"] = _resolve_part("trajectories", tables["trajectory"], "trajectory", 0)
    variants = tables.get("variants")
    for name, variant in variants.items() if isinstance(variants, dict) else ():
        if not isinstance(variant, dict) or "controller" not in variant:
            continue
        loc = f"variants.{name}.controller"
        controller = _resolve_part("controllers", variant["controller"], loc, 0)
        if isinstance(controller, dict) and "model" in controller:
            controller["model"] = _resolve_model(controller["model"], f"{loc}.model")
        variant["controller"] = controller
    return tables


def apply_changes(document: dict[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a copy of resolved tables with dotted paths set, shallow paths first."""
    tables = copy.deepcopy(document)
    for path, value in sorted(changes.items(), key=lambda item: item[0].count(".")):
        if path == "base":
            raise ConfigError(FieldError(loc="base", message="is not a field: name the scenario"))
        _set_path(tables, path.removesuffix(".base"), value)
        if isinstance(value, str | dict):  # it may name a part, or hold one with a base
            tables = resolve(tables)
    return tables


def validate(document: Mapping[str, Any]) -> Scenario:
    """Return resolved tables as a scenario whose schedule can be carried out.

    Raises
    ------
    ConfigError
        Naming every field that is wrong.
    """
    scenario = _validate(document)
    for index, event in enumerate(scenario.schedule):
        check_schedulable(event.set, f"schedule.{index}.set")
    phases(scenario)
    return scenario


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
            range="paths that begin with " + ", ".join(_SCHEDULABLE),
        )
        for path in changes
        if path.split(".")[0] not in _SCHEDULABLE
    ]
    if refused:
        raise ConfigError(*refused)


def phases(scenario: Scenario, start: int = 0) -> list[tuple[int, Scenario]]:
    """Return the parameter sets of a run: from which tick on each holds, in order of time.

    Parameters
    ----------
    scenario : Scenario
        Parameters at `start`.
    start : int
        First tick; events up to it are taken to be in the scenario already.

    Raises
    ------
    ConfigError
        If an event leads to a scenario that is not valid, or two events share a tick.
    """
    document = scenario.model_dump(mode="json")
    result = [(start, scenario)]
    order = sorted(enumerate(scenario.schedule), key=lambda item: item[1].time)
    for index, event in order:
        tick = to_ticks(event.time)
        if 0 < tick <= start:
            continue
        if tick <= result[-1][0]:
            raise ConfigError(
                FieldError(
                    loc=f"schedule.{index}.time",
                    message="needs a control period of its own after the start and other events",
                    value=event.time,
                    range=f">= {(result[-1][0] + 1) * CONTROL_PERIOD:g}",
                    unit="s",
                )
            )
        try:
            document = apply_changes(document, event.set)
            changed = _validate(document)
        except ConfigError as error:
            raise ConfigError(
                *(
                    FieldError(
                        loc=f"schedule.{index}.set.{e.loc}",
                        message=e.message,
                        value=e.value,
                        range=e.range,
                        unit=e.unit,
                    )
                    for e in error.errors
                )
            ) from None
        if changed.variants.keys() != scenario.variants.keys():
            raise ConfigError(
                FieldError(loc=f"schedule.{index}.set", message="adds a variant during the run")
            )
        result.append((tick, changed))
    return result


def _read_source(source: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(source, Mapping):
        return copy.deepcopy(dict(source))
    if isinstance(source, Path):
        named = {"name": source.stem} if is_name(source.stem) else {}
        return named | parse(source)
    return {"name": source} | read("scenarios", source, loc="scenario")


def _parse_value(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):  # also a number of thousands of digits, or deep nesting
        return text
    return parsed["value"] if len(parsed) == 1 else text


def _with_defaults(document: dict[str, Any]) -> dict[str, Any]:
    """Return tables with every default filled in, so that a change can reach inside of one."""
    try:
        return Scenario.model_validate(document).model_dump(mode="json")
    except ValidationError:
        return document  # the changes may yet make it valid


def _resolve_part(kind: Kind, part: Any, loc: str, depth: int) -> Any:
    """Replace a name, or a table's ``base``, by the shipped table; leave anything else alone."""
    if isinstance(part, str):
        part = {"base": part}
    if not isinstance(part, Mapping) or "base" not in part:
        return part
    name = part["base"]
    if not isinstance(name, str) or depth > _DEEPEST_BASE:
        raise ConfigError(
            FieldError(loc=f"{loc}.base", message="must be the name of a shipped part", value=name)
        )
    shipped = read(kind, name, loc=loc)
    if kind != "trajectories":
        shipped = {"name": name} | shipped
    base = _resolve_part(kind, shipped, loc, depth + 1)
    own = {key: value for key, value in part.items() if key != "base"}
    return _merge(base, own)


def _resolve_model(part: Any, loc: str) -> Any:
    """Replace the name of a motor by what a controller may know of it."""
    name = part if isinstance(part, str) else part.get("base") if isinstance(part, dict) else None
    if name is None:
        return part
    motor = _resolve_part("motors", {"base": name}, loc, 0)
    model = {axis: {key: motor[axis][key] for key in _MODEL_KEYS} for axis in ("x", "y")}
    own = {} if isinstance(part, str) else {k: v for k, v in part.items() if k != "base"}
    return _merge(model, own)


def _merge(base: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the keys of `own` put in, table by table.

    A table of its own base or kind replaces what was there; upon a name, a table changes that part.
    """
    merged = copy.deepcopy(base)
    for key, value in own.items():
        below = merged.get(key)
        whole = not isinstance(value, Mapping) or "base" in value or "kind" in value
        if not whole and isinstance(below, str):
            below = {"base": below}
        mergeable = not whole and isinstance(below, Mapping)
        merged[key] = _merge(below, value) if mergeable else copy.deepcopy(value)
    return merged


def _set_path(tables: dict[str, Any], path: str, value: Any) -> None:
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


def _validate(document: Mapping[str, Any]) -> Scenario:
    try:
        return Scenario.model_validate(document)
    except ValidationError as error:
        raise ConfigError(*field_errors(error, Scenario)) from None
