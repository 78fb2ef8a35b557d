"""A change of parameters while a simulation runs."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, Field

from motionlab.config.changes import apply_changes, check_schedulable, labelled
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError


class Change(BaseModel):
    """A change of parameters during a session."""

    tick: int = Field(description="First tick at which it holds; 0 after a reset")
    set: dict[str, Any] = Field(description="Dotted path to new value")
    previous: dict[str, Any] = Field(description="Dotted path to the value before")


def changed(scenario: Scenario, changes: Mapping[str, Any], tick: int) -> tuple[Scenario, Change]:
    """Return a scenario with changes from a tick on, and the changes.

    Raises
    ------
    ConfigError
        If a value is refused or the field cannot change during a run.
    """
    check_schedulable(changes, "set")
    changes = labelled(changes)
    before = scenario.model_dump(mode="json")
    after = validate(apply_changes(before, changes))
    if list(after.variants) != list(scenario.variants):
        raise ConfigError(FieldError(loc="set", message="adds or takes away a variant"))
    previous = {}
    for path in changes:
        with contextlib.suppress(LookupError, TypeError, ValueError):  # it came with the change
            previous[path] = _value_at(before, path.removesuffix(".base"))
    return after, Change(tick=tick, set=dict(changes), previous=previous)


def _value_at(tables: Any, path: str) -> Any:
    """Return the value at a dotted path."""
    for key in path.split("."):
        tables = tables[int(key)] if isinstance(tables, list) else tables[key]
    return tables
