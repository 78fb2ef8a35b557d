"""What was done in a run: its scenario, differences and events."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.library.description import differing
from motionlab.library.run import Difference, Event, RunDetail
from motionlab.reports.markup import Markup, joined
from motionlab.reports.quantities import (
    change_of,
    digits,
    field_at,
    quantity,
    value_markup,
)

EVENTS_MAX = 200
"""Rows of the table of events."""
_FIELDS_MAX = 24


class Happened(NamedTuple):
    """An event with its time, s, and the number it has in table and plots."""

    number: str
    time: float
    kind: str
    what: Markup


def scenario_of(run: RunDetail) -> Scenario | None:
    """Return the scenario of a run; None for a measurement, or if it is no longer valid."""
    if run.scenario_document is None:
        return None
    try:
        return load_scenario(run.scenario_document)
    except ConfigError:
        return None


def events(run: RunDetail) -> list[Happened]:
    """Return changes, pushes, stop, gaps and the schedule, by time from the first sample on."""
    begun = run.first_tick * run.period
    entries = [
        (event.tick * run.period - begun, event.kind, _by(event, _what(event, run.period)))
        for event in run.events
    ]
    schedule = (run.scenario_document or {}).get("schedule") or ()
    entries += [(each["time"] - begun, "scheduled", _set(each["set"], {})) for each in schedule]
    entries.sort(key=lambda each: each[0])
    return [
        Happened(str(i), time, kind, what)
        for i, (time, kind, what) in enumerate(entries[:EVENTS_MAX], start=1)
    ]


def event_count(run: RunDetail) -> int:
    """Return the number of all events, those left out of a table too."""
    return len(run.events) + len((run.scenario_document or {}).get("schedule") or ())


def differences(first: RunDetail, second: RunDetail) -> list[Difference] | None:
    """Return the differences between the scenarios of two runs; None if one has no scenario."""
    if first.scenario_document is None or second.scenario_document is None:
        return None
    entries = differing(first.scenario_document, second.scenario_document)
    if first.scenario == second.scenario:
        return entries
    return [Difference(path="name", shipped=first.scenario, value=second.scenario), *entries]


def trajectory_rows(tables: dict[str, Any]) -> list[tuple[Markup | str, Any]]:
    """Return the fields of a trajectory that are no lists, with their values."""
    rows: list[tuple[Markup | str, Any]] = [("kind", tables.get("kind", "\u2013"))]
    rows += [
        (field_at(path).name, value_markup(path, value))
        for path, value in _scalars(tables, "trajectory")
        if value is not None and path != "trajectory.kind"
    ][:_FIELDS_MAX]
    return rows


def _scalars(tables: dict[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
    for key, value in tables.items():
        path = f"{prefix}.{key}"
        if isinstance(value, dict):
            yield from _scalars(value, path)
        elif isinstance(value, list):
            yield path, f"{len(value)} entries"
        else:
            yield path, value


def _what(event: Event, period: float) -> Markup:
    long = f"{digits((event.ticks or 0) * period * 1e3)} ms"
    match event.kind:
        case "change":
            return _set(event.set, event.previous)
        case "push":
            return joined([f"{event.axis}, {quantity(event.force or 0.0, 'N')} for {long}"])
        case "stop":
            return joined([event.reason or "brakes to rest"])
        case "gap":
            reason = f": {event.reason}" if event.reason else ""
            return joined([f"missing samples: {event.ticks or 0}, {long}{reason}"])
        case "law":
            return joined([f"a new version of law {event.law}: {event.reason or 'taken'}"])
        case "play" | "pause" | "speed" | "reset":
            return joined([f"{digits(event.speed)} times real time"] if event.speed else [])


def _by(event: Event, what: Markup) -> Markup:
    return joined([what, f" (by {event.by})"]) if event.by else what


def _set(values: dict[str, Any], previous: dict[str, Any]) -> Markup:
    parts = [
        joined(
            [
                field_at(path).name,
                " ",
                change_of(path, previous[path], value)
                if path in previous
                else value_markup(path, value),
            ]
        )
        for path, value in values.items()
    ]
    return joined(parts, ", ")
