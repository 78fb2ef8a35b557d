"""How to simulate a scenario again: command, request and file, each checked to give the same."""

from __future__ import annotations

import json
import shlex
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from motionlab.config.changes import as_tables
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError

_SET_MAX = 40
"""Most settings of a command line; of more there is the file alone."""


@dataclass(frozen=True)
class Recipe:
    """Ways to simulate a scenario again.

    Attributes
    ----------
    toml : str or None
        A file that ``motionlab run`` takes; None where TOML cannot say it.
    command, request : str or None
        Command line and curl; None where only the file holds all of it.
    """

    toml: str | None
    command: str | None
    request: str | None


def recipe(scenario: Scenario) -> Recipe:
    """Return how a scenario is simulated again.

    The file names the shipped scenario and what differs from it where that gives the same
    scenario, and has all tables otherwise.
    """
    import tomli_w

    settings = _settings(scenario)
    if settings is None:
        tables = scenario.model_dump(mode="json", exclude_none=True)
        same = _plain(load_scenario(tables)) == _plain(scenario)
        return Recipe(tomli_w.dumps(tables) if same else None, None, None)
    toml = tomli_w.dumps({"base": scenario.name} | as_tables(settings))
    texts = {path: _text(value) for path, value in settings.items()}
    if len(settings) > _SET_MAX or None in texts.values():
        return Recipe(toml, None, None)
    words = [f" --set {shlex.quote(f'{path}={text}')}" for path, text in texts.items()]
    body = json.dumps({"scenario": scenario.name} | ({"set": settings} if settings else {}))
    return Recipe(
        toml,
        f"motionlab run {scenario.name}{''.join(words)}",
        "curl -s -H 'Content-Type: application/json' "
        f'-d {shlex.quote(body)} "$MOTIONLAB/api/v1/simulate"',
    )


def _settings(scenario: Scenario) -> dict[str, Any] | None:
    """Return what differs from the shipped scenario; None where settings cannot say it."""
    if scenario.name not in names("scenarios"):
        return None
    shipped = load_scenario(scenario.name).model_dump(mode="json")
    tables = scenario.model_dump(mode="json")
    settings = dict(_leaves(shipped, tables, ""))
    if any(_lacks(value) for value in settings.values()):
        return None
    try:
        same = _plain(load_scenario(scenario.name, settings)) == _plain(scenario)
        same &= _plain(load_scenario({"base": scenario.name} | as_tables(settings))) == _plain(
            scenario
        )
    except ConfigError:
        return None
    return settings if same else None


def _leaves(shipped: Any, tables: Any, path: str) -> Iterator[tuple[str, Any]]:
    for key, value in tables.items():
        before = shipped.get(key)
        place = f"{path}.{key}" if path else key
        if before == value or (not path and key in {"name", "title", "description"}):
            continue
        if isinstance(before, dict) and isinstance(value, dict):
            yield from _leaves(before, value, place)
        else:
            yield place, value


def _lacks(value: Any) -> bool:
    """Return whether something in a value is none, for which TOML has no word."""
    if isinstance(value, dict):
        return any(_lacks(each) for each in value.values())
    if isinstance(value, list):
        return any(_lacks(each) for each in value)
    return value is None


def _plain(scenario: Scenario) -> dict[str, Any]:
    return scenario.model_dump(mode="json", exclude={"name", "title", "description"})


def _text(value: Any) -> str | None:
    """Return a value in one line of TOML; None of tables within lists."""
    if isinstance(value, list) and any(isinstance(item, dict | list) for item in value):
        return None
    return json.dumps(value)
