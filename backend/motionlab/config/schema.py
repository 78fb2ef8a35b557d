"""JSON schemas of scenarios and their parts, as files give them and with all names resolved.

``python -m motionlab.config.schema`` writes those of files, for editors.
"""

from __future__ import annotations

import json
import sys
from typing import Any

from motionlab.config.drive import DriveConfig
from motionlab.config.named_configs import ORIGIN, OWN, Kind, config_root, names
from motionlab.config.scenario import Scenario

FILES = ("scenario", "motor", "controller", "trajectory", "drive")
"""Kinds of files, the parts of a scenario among them."""

_DIALECT = {"$schema": "https://json-schema.org/draft/2020-12/schema"}

_WHOLE = ["plant", "variants", "trajectory"]
"""Required keys of a scenario without a base."""


def scenario_schema() -> dict[str, Any]:
    """Return the JSON schema of a resolved scenario, with unit and source of every number."""
    return Scenario.model_json_schema() | _DIALECT


def source_schema() -> dict[str, Any]:
    """Return the JSON schema of a scenario as a file gives it.

    A part is a table, the name of a shipped one, or a table whose keys replace those of its
    ``base``, or of the scenario's base: so no key but a motion's ``kind`` is required.
    """
    schema = _either(scenario_schema())
    tables = schema["$defs"]
    for table in (schema, *tables.values()):
        table.pop("required", None)
    bases: list[tuple[dict[str, Any], Kind]] = [
        (schema, "scenarios"),
        (tables["PlantConfig"], "motors"),
        (tables["ModelConfig"], "motors"),
        (tables["ControllerConfig"], "controllers"),
    ]
    for table, kind in bases:
        table["properties"]["base"] = _name(kind)
    parts: list[tuple[dict[str, Any], str, Kind]] = [
        (schema, "plant", "motors"),
        (tables["VariantConfig"], "controller", "controllers"),
        (tables["ControllerConfig"], "model", "motors"),
    ]
    for table, field, kind in parts:
        table["properties"][field] = {"anyOf": [_name(kind), table["properties"][field]]}
    schema["properties"]["variants"]["additionalProperties"] = False
    force_map = tables["AxisConfig"]["properties"]["force_map"]
    force_map["anyOf"].append({"type": "string", "description": "Name of a force map"})
    for table in ("AxisModelConfig", "PlantConfig", "ModelConfig"):
        tables[table]["properties"]["force_map"] = force_map
    trajectory = schema["properties"]["trajectory"]
    motions = [tables[choice["$ref"].rsplit("/", 1)[1]] for choice in trajectory["anyOf"]]
    trajectory["anyOf"] += [_name("trajectories"), _changed(motions)]
    for motion in motions:
        motion["required"] = ["kind"]
    return schema | {"anyOf": [{"required": ["base"]}, {"required": _WHOLE}]}


def file_schema(kind: str) -> dict[str, Any]:
    """Return the JSON schema of a kind of file, one of `FILES`."""
    if kind == "drive":
        return DriveConfig.model_json_schema() | _DIALECT
    whole = source_schema()
    tables: dict[str, Any] = whole["$defs"]
    match kind:
        case "motor":
            part = tables.pop("PlantConfig")
            part["properties"][ORIGIN] = {
                "type": "object",
                "description": "Where the motor's numbers come from",
            }
        case "controller":
            part = tables.pop("ControllerConfig")
        case "trajectory":
            *motions, _, changed = whole["properties"]["trajectory"]["anyOf"]
            part = {"anyOf": [*motions, changed | {"required": ["base"]}]}
        case _:
            return whole
    return part | {"$defs": _used(part, tables)} | _DIALECT


def schema_text(kind: str) -> str:
    """Return the schema of a kind of file as text."""
    return json.dumps(file_schema(kind), indent=2, ensure_ascii=False) + "\n"


def _used(part: dict[str, Any], tables: dict[str, Any]) -> dict[str, Any]:
    """Return the tables that a part refers to, and those that they refer to."""
    definitions: dict[str, Any] = {}
    waiting: list[Any] = [part]
    while waiting:
        node = waiting.pop()
        if isinstance(node, dict):
            name = str(node.get("$ref", "")).rpartition("/")[2]
            if name and name not in definitions:
                definitions[name] = tables[name]
                waiting.append(tables[name])
            waiting += node.values()
        elif isinstance(node, list):
            waiting += node
    return dict(sorted(definitions.items()))


def _either(node: Any) -> Any:
    """Return a copy in which alternatives may overlap, as tables without a kind do."""
    if isinstance(node, list):
        return [_either(item) for item in node]
    if not isinstance(node, dict):
        return node
    kept = {key: _either(value) for key, value in node.items() if key != "discriminator"}
    return {"anyOf" if key == "oneOf" else key: value for key, value in kept.items()}


def _name(kind: Kind) -> dict[str, Any]:
    """Return the schema of the name of a shipped part, of one's own, or of the path of a file."""
    shipped = ", ".join(names(kind))
    if kind == "scenarios":
        return {"type": "string", "enum": names(kind), "description": "One of the shipped"}
    own = " or one's own" if kind in OWN else ""
    return {
        "type": "string",
        "pattern": r"^[a-z0-9-]{1,64}$|\.toml$",
        "description": f"One of the shipped{own}, or the path of a .toml file: {shipped}",
    }


def _changed(motions: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the schema of a table that changes a trajectory whose kind it does not repeat."""
    fields: dict[str, list[Any]] = {"base": [_name("trajectories")]}
    for motion in motions:
        for field, schema in motion["properties"].items():
            choices = fields.setdefault(field, [])
            if field != "kind" and schema not in choices:
                choices.append(schema)
    del fields["kind"]
    return {
        "type": "object",
        "description": "Changes of a shipped trajectory, or of the base's",
        "properties": {
            field: choices[0] if len(choices) == 1 else {"anyOf": choices}
            for field, choices in fields.items()
        },
        "additionalProperties": False,
    }


if __name__ == "__main__":
    for kind in FILES:
        path = config_root() / f"{kind}.schema.json"
        path.write_text(schema_text(kind), encoding="utf-8")
        print(f"wrote {path.name}", file=sys.stderr)
