"""A scenario's file to begin with: all as in a shipped one, its fields in comments."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import tomli_w

from motionlab.config.fields import FieldValue, values_of
from motionlab.config.named_configs import config_root, names
from motionlab.config.scenario import Scenario

_SKIPPED = {"kind", "name", "description", "planned_for"}
_WHOLE = ("seed", "settling_band", "divergence_error", "thrust_reserve")
_MOTOR = ("mass", "friction.", "encoder.noise", "resonance.coupling")
_CONTROLLER = ("x.k_", "y.k_", "compensation.", "feedforward", "disturbance_observer.", "delay")


def template(scenario: Scenario, folder: Path) -> str:
    """Return the text of a file that is `scenario`, a shipped one, and says how to change it.

    Every field is in a comment with its value, unit and range; without its ``#`` it counts. Of a
    file in a `folder` of a checkout the first line names the schema, for editors.
    """
    fields = list(values_of(scenario))
    lines = [
        *_schema(folder.resolve()),
        f"# A scenario of your own: whatever it does not set is as in {scenario.name}.",
        "# Remove the # before a field to set it. Values are SI.",
        "# `motionlab fields` lists all fields; `motionlab check` and `run` take this file.",
        "",
        f"base = {_toml(scenario.name)}",
        f"title = {_toml(f'My {scenario.name}')}",
        *_comments(_of(fields, "", _WHOLE)),
        "",
        "[trajectory]",
        *_comments(_of(fields, "trajectory.")),
        "",
        "[plant]",
        f"# base = {_toml(scenario.plant.name)}  # another motor: {', '.join(names('motors'))}",
    ]
    for axis in ("x", "y"):
        lines += ["", f"[plant.{axis}]", *_comments(_of(fields, f"plant.{axis}.", _MOTOR))]
    lines += ["", "[load]", *_comments(_of(fields, "load."))]
    for letter, variant in scenario.variants.items():
        place = f"variants.{letter}.controller"
        others = ", ".join(names("controllers"))
        lines += [
            "",
            f"[{place}]",
            f"# base = {_toml(variant.controller.name)}  # another controller: {others}",
            *_comments(_of(fields, f"{place}.", _CONTROLLER)),
        ]
    return "\n".join(lines) + "\n"


def _schema(folder: Path) -> list[str]:
    """Return the line that names the schema by a path that holds wherever the checkout is."""
    root = config_root().resolve()
    if not folder.is_relative_to(root.parent):
        return []
    return [f"#:schema {os.path.relpath(root / 'scenario.schema.json', folder)}", "#"]


def _of(fields: list[FieldValue], prefix: str, begins: tuple[str, ...] = ()) -> list[FieldValue]:
    """Return the fields with a value below a prefix, their paths without it."""
    below = [
        each._replace(path=each.path.removeprefix(prefix))
        for each in fields
        if each.path.startswith(prefix) and _is_value(each.value)
    ]
    return [
        each
        for each in below
        if each.path.rpartition(".")[2] not in _SKIPPED
        and (each.path.startswith(begins) if begins else True)
    ]


def _is_value(value: Any) -> bool:
    return value is not None and not isinstance(value, list | dict)


def _comments(fields: list[FieldValue]) -> list[str]:
    comments = []
    for each in fields:
        unit = f"{each.unit}, " if each.unit else ""
        meaning = "; ".join(filter(None, (each.description, f"{unit}{each.range}".strip(", "))))
        comments.append(f"# {each.path} = {_toml(each.value)}  # {meaning}".rstrip(" #"))
    return comments


def _toml(value: Any) -> str:
    """Return a value as TOML."""
    return tomli_w.dumps({"v": value}).partition("=")[2].strip()
