"""Changes of a session since its scenario was loaded; the latest can be undone."""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel, Field

from motionlab.config.changes import apply_changes, check_schedulable, labelled
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError

CHANGES_MAX = 100
"""Changes that can be undone; those before them stay in effect."""


class Change(BaseModel):
    """A change of parameters during a session."""

    tick: int = Field(description="First tick at which it holds; 0 after a reset")
    set: dict[str, Any] = Field(description="Dotted path to new value")
    previous: dict[str, Any] = Field(description="Dotted path to the value before")


class ChangeLog:
    """The changes of a session.

    Parameters
    ----------
    start : Scenario
        The scenario before the changes.

    Attributes
    ----------
    latest : tuple of Change
        Oldest first.
    """

    def __init__(self, start: Scenario) -> None:
        self.latest: tuple[Change, ...] = ()
        self._start = start

    def keep(self, change: Change) -> None:
        """Add a change that is in effect; the oldest beyond CHANGES_MAX becomes part of the start.

        Parameters
        ----------
        change : Change
            From `changed`.
        """
        oldest, *others = *self.latest, change
        if len(others) < CHANGES_MAX:
            self.latest = (oldest, *others)
        else:
            self._start = _with(self._start, oldest) or self._start
            self.latest = tuple(others)

    def replayed(self) -> tuple[Scenario, tuple[Change, ...]]:
        """Return the start with all changes from tick 0 on, and those of them that fit it."""
        scenario = _with(self._start, *self.latest)
        kept = self.latest
        if scenario is None:  # find those that do not fit
            scenario, kept = self._start, ()
            for change in self.latest:
                changed = _with(scenario, change)
                if changed is not None:
                    scenario, kept = changed, (*kept, change)
        return scenario, tuple(change.model_copy(update={"tick": 0}) for change in kept)


def changed(scenario: Scenario, wanted: Mapping[str, Any], tick: int) -> tuple[Scenario, Change]:
    """Return a scenario with changes from a tick on, and the changes.

    Raises
    ------
    ConfigError
        If a value is refused or the field cannot change during a run.
    """
    check_schedulable(wanted, "set")
    wanted = labelled(wanted)
    before = scenario.model_dump(mode="json")
    after = validate(apply_changes(before, wanted))
    if list(after.variants) != list(scenario.variants):
        raise ConfigError(FieldError(loc="set", message="adds or takes away a variant"))
    previous = {}
    for path in wanted:
        with contextlib.suppress(LookupError, TypeError, ValueError):  # it came with the change
            previous[path] = _value_at(before, path.removesuffix(".base"))
    return after, Change(tick=tick, set=dict(wanted), previous=previous)


def _with(scenario: Scenario, *changes: Change) -> Scenario | None:
    """Return a scenario with changes from its first tick on, or None where they do not fit."""
    if not changes:
        return scenario
    document = scenario.model_dump(mode="json")
    try:
        for change in changes:
            document = apply_changes(document, change.set)
        return validate(document)
    except ConfigError:
        return None


def _value_at(tables: Any, path: str) -> Any:
    """Return the value at a dotted path."""
    for key in path.split("."):
        tables = tables[int(key)] if isinstance(tables, list) else tables[key]
    return tables
