"""Resolution of names and ``base`` references to shipped parts of a scenario.

A part of a scenario (``plant``, ``trajectory``, a variant's ``controller``, a controller's
``model``, the scenario itself) is a table, the name of a shipped one, or a table with
``base = "name"`` whose other keys replace those of the shipped one. A ``force_map`` is a table or
the name of a map; on the level of ``x`` and ``y`` it applies to both axes.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from motionlab.config.planar import AXES
from motionlab.config.shipped import Kind, copied, read
from motionlab.errors import ConfigError, FieldError

_MODEL_KEYS = ("mass", "friction", "force_map")
_DEEPEST_BASE = 8


def resolve(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return a scenario's tables with all names and ``base`` references resolved."""
    tables = _resolve_part("scenarios", document, "scenario", 0)
    if "plant" in tables:
        tables["plant"] = _with_maps(_resolve_part("motors", tables["plant"], "plant", 0))
    if "trajectory" in tables:
        tables["trajectory"] = _resolve_part("trajectories", tables["trajectory"], "trajectory", 0)
    variants = tables.get("variants")
    for name, variant in variants.items() if isinstance(variants, dict) else ():
        if not isinstance(variant, dict) or "controller" not in variant:
            continue
        loc = f"variants.{name}.controller"
        controller = _resolve_part("controllers", variant["controller"], loc, 0)
        if isinstance(controller, dict) and "model" in controller:
            controller["model"] = _with_maps(_resolve_model(controller["model"], f"{loc}.model"))
        variant["controller"] = controller
    return tables


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
    return _merge(base, _labelled(own) if kind == "scenarios" else own)


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
    found = dict(variants)
    for key, variant in variants.items():
        if isinstance(variant, Mapping):
            own_controller = variant.get("controller")
            whole = isinstance(own_controller, str) or "base" in (own_controller or ())
            name = controller_name(own_controller) if whole else None
            found[key] = ({} if name is None else {"label": name}) | dict(variant)
    return own | {"variants": found}


def _resolve_model(part: Any, loc: str) -> Any:
    """Replace a motor's name by the parameters that a controller's model has."""
    name = part if isinstance(part, str) else part.get("base") if isinstance(part, dict) else None
    if name is None:
        return part
    motor = _resolve_part("motors", {"base": name}, loc, 0)
    model = {axis: {key: motor[axis][key] for key in _MODEL_KEYS} for axis in AXES}
    own = {} if isinstance(part, str) else {k: v for k, v in part.items() if k != "base"}
    return _merge(model, own)


def _with_maps(part: Any) -> Any:
    """Apply the common force map to both axes and resolve map names to tables."""
    if not isinstance(part, Mapping):
        return part
    both = {"force_map": part["force_map"]} if "force_map" in part else {}
    found = {key: value for key, value in part.items() if key != "force_map"}
    for axis in AXES:
        if isinstance(found.get(axis), Mapping):
            found[axis] = _merge(found[axis], both)
            if isinstance(found[axis].get("force_map"), str):
                found[axis]["force_map"] = {"kind": "table", "name": found[axis]["force_map"]}
    return found


def _merge(base: Any, own: Mapping[str, Any]) -> dict[str, Any]:
    """Return `base` with the keys of `own` put in, table by table.

    A table of its own base or kind replaces what was there; upon a name, a table changes that part.
    """
    merged = copied(base)
    for key, value in own.items():
        below = merged.get(key)
        whole = not isinstance(value, Mapping) or "base" in value or "kind" in value
        if not whole and isinstance(below, str):
            below = {"base": below}
        mergeable = not whole and isinstance(below, Mapping)
        merged[key] = _merge(below, value) if mergeable else copied(value)
    return merged
