"""Resolution of names and ``base`` references to shipped parts of a scenario.

A part of a scenario (``plant``, ``trajectory``, a variant's ``controller``, a controller's
``model``, the scenario itself) is a table, the name of a shipped one, or a table with
``base = "name"`` whose other keys replace those of the shipped one. A ``force_map`` is a table or
the name of a map; on the level of ``x`` and ``y`` it applies to both axes. In a file on this
machine the path of a ``.toml`` file, relative to its folder, does for a name.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from motionlab.config.named_configs import ORIGIN, Kind, is_name, names, nearest, parse, read
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError

_MODEL_KEYS = ("mass", "friction", "force_map")
_DEEPEST_BASE = 8
_FILED: dict[str, Kind] = {
    "plant": "motors",
    "trajectory": "trajectories",
    r"variants\.[A-Z]\.controller": "controllers",
}
"""Parts that a change may name by the path of a file, beside a model."""
_MODEL = re.compile(r"variants\.[A-Z]\.controller\.model")


class _Names(NamedTuple):
    """Resolver of names of parts."""

    folder: Path | None = None
    """What paths of files are relative to; None where only names may be given."""
    errors: list[FieldError] | None = None
    """Takes names that lead nowhere; None: the first one is raised."""


def resolve(
    document: Mapping[str, Any],
    *,
    folder: Path | None = None,
    errors: list[FieldError] | None = None,
) -> dict[str, Any]:
    """Return a scenario's tables with all names and ``base`` references resolved.

    What no name changes is shared with `document`, which stays as it is. In `folder`, that of the
    scenario's file, a part may be the path of a ``.toml`` file; without one text is never a path,
    so that a remote caller cannot name files. `errors` takes names that lead nowhere, so that the
    rest can be checked too: with the closest name, or without a base.

    Raises
    ------
    ConfigError
        If a part is not there and `errors` is left out.
    """
    at = _Names(folder, errors)
    tables = dict(_resolve_part("scenarios", document, "scenario", at))
    if "plant" in tables:
        tables["plant"] = _with_maps(_resolve_part("motors", tables["plant"], "plant", at))
    if "trajectory" in tables:
        part = _resolve_part("trajectories", tables["trajectory"], "trajectory", at)
        tables["trajectory"] = part
    if isinstance(variants := tables.get("variants"), dict):
        tables["variants"] = {
            name: _resolve_variant(variant, f"variants.{name}.controller", at)
            for name, variant in variants.items()
        }
    return tables


def part_of_file(path: str, value: Any, folder: Path) -> Any:
    """Return the tables of the file that a change names, such as ``plant = "stage.toml"``.

    A value that is no path of a file, relative to `folder`, comes back.

    Raises
    ------
    ConfigError
        If the file, or a part that it names, is not there.
    """
    if not _is_file(value.get("base") if isinstance(value, Mapping) else value):
        return value
    loc, at = path.removesuffix(".base"), _Names(folder)
    for form, kind in _FILED.items():
        if re.fullmatch(form, loc):
            return _resolve_part(kind, value, loc, at)
    return _with_maps(_resolve_model(value, loc, at)) if _MODEL.fullmatch(loc) else value


def _is_file(name: Any) -> bool:
    return isinstance(name, str) and name.endswith(".toml")


def _resolve_part(kind: Kind, part: Any, loc: str, at: _Names, depth: int = 0) -> Any:
    """Replace a name, or a table's ``base``, by the named table; leave anything else alone."""
    if isinstance(part, str):
        part = {"base": part}
    if not isinstance(part, Mapping) or "base" not in part:
        return part
    name = part["base"]
    own = {key: value for key, value in part.items() if key != "base"}
    try:
        if not isinstance(name, str) or depth > _DEEPEST_BASE:
            message = "must be the name of a shipped part"
            raise ConfigError(FieldError(loc=f"{loc}.base", message=message, value=name))
        tables, below = _read(kind, name, loc, at)
    except ConfigError as error:
        if at.errors is None:
            raise
        at.errors.extend(error.errors)
        near = nearest(name, names(kind)) if isinstance(name, str) else None
        if near is None:
            return own
        name, (tables, below) = near, _read(kind, near, loc, at)
    if kind != "trajectories" and is_name(stem := name.rpartition("/")[2].removesuffix(".toml")):
        tables = {"name": stem} | tables
    base = _resolve_part(kind, tables, loc, below, depth + 1)
    return _merge(base, _labelled(own) if kind == "scenarios" else own)


def _read(kind: Kind, name: str, loc: str, at: _Names) -> tuple[dict[str, Any], _Names]:
    """Return the tables that a name stands for, and where the names in them lead."""
    if at.folder is None or not _is_file(name):
        return read(kind, name, loc=loc), at
    path = at.folder / name
    tables = parse(path)
    tables.pop(ORIGIN, None)
    return tables, at._replace(folder=path.parent)


def controller_name(part: Any) -> str | None:
    """Return the name of a controller that is given whole; None where one is only changed."""
    if isinstance(part, Mapping):
        part = part.get("base", part.get("name"))
    return part if isinstance(part, str) else None


def _labelled(own: dict[str, Any]) -> dict[str, Any]:
    """Label each variant by its controller if that differs from the base and has no label."""
    variants = own.get("variants")
    if not isinstance(variants, Mapping):
        return own
    labelled = dict(variants)
    for key, variant in variants.items():
        if isinstance(variant, Mapping):
            own_controller = variant.get("controller")
            whole = isinstance(own_controller, str) or "base" in (own_controller or ())
            name = controller_name(own_controller) if whole else None
            labelled[key] = ({} if name is None else {"label": name}) | dict(variant)
    return own | {"variants": labelled}


def _resolve_variant(variant: Any, loc: str, at: _Names) -> Any:
    if not isinstance(variant, dict) or "controller" not in variant:
        return variant
    controller = _resolve_part("controllers", variant["controller"], loc, at)
    if isinstance(controller, dict) and "model" in controller:
        model = _resolve_model(controller["model"], f"{loc}.model", at)
        controller = controller | {"model": _with_maps(model)}
    return variant | {"controller": controller}


def _resolve_model(part: Any, loc: str, at: _Names) -> Any:
    """Replace a motor's name by the parameters that a controller's model has."""
    name = part if isinstance(part, str) else part.get("base") if isinstance(part, dict) else None
    if name is None:
        return part
    motor = _resolve_part("motors", {"base": name}, loc, at)
    axes = {axis: motor[axis] for axis in AXES if isinstance(motor.get(axis), Mapping)}
    model = {axis: {k: each[k] for k in _MODEL_KEYS if k in each} for axis, each in axes.items()}
    if "force_map" in motor:
        model["force_map"] = motor["force_map"]
    own = {} if isinstance(part, str) else {k: v for k, v in part.items() if k != "base"}
    return _merge(model, own)


def _with_maps(part: Any) -> Any:
    """Apply the common force map to both axes and resolve map names to tables."""
    if not isinstance(part, Mapping):
        return part
    both = {"force_map": part["force_map"]} if "force_map" in part else {}
    tables = {key: value for key, value in part.items() if key != "force_map"}
    for axis in AXES:
        if isinstance(tables.get(axis), Mapping):
            tables[axis] = _merge(tables[axis], both)
            if isinstance(name := tables[axis].get("force_map"), str):
                tables[axis]["force_map"] = {"kind": "table", "name": name}
    return tables


def _merge(base: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the keys of `own` put in, table by table.

    A table of its own base or kind replaces what was there; upon a name, a table changes that part.
    """
    merged = dict(base)
    for key, value in own.items():
        below = merged.get(key)
        whole = not isinstance(value, Mapping) or "base" in value or "kind" in value
        if not whole and isinstance(below, str):
            below = {"base": below}
        mergeable = not whole and isinstance(below, Mapping)
        merged[key] = _merge(below, value) if mergeable else value
    return merged
