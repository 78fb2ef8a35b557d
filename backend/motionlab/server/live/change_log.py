"""Changes of a session since its scenario was loaded; the latest can be undone."""

from __future__ import annotations

from collections.abc import Mapping

from motionlab.config.changes import apply_changes
from motionlab.config.load import redeclared, validate
from motionlab.config.scenario import Scenario
from motionlab.declarations import Parameter
from motionlab.errors import ConfigError
from motionlab.simulation.change import Change

CHANGES_MAX = 100
"""Changes that can be undone; those before them stay in effect."""


class ChangeLog:
    """The changes of a session."""

    def __init__(self, start: Scenario) -> None:
        self.latest: tuple[Change, ...] = ()
        self._start = start

    def redeclared(self, former: Mapping[str, Parameter]) -> Scenario:
        """Return the start as `motionlab.config.load.redeclared`, for `begin`."""
        return redeclared(self._start, former)

    def begin(self, start: Scenario) -> None:
        """Have another start."""
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
