"""What was done in a run: scenario, differences, events; how to do it again; its record."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from typing import Any, NamedTuple

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.config.shipped import names
from motionlab.errors import ConfigError
from motionlab.library.description import DIFFERENCES_MAX, differing
from motionlab.library.run import Difference, Event, RunDetail
from motionlab.reports.markup import Markup, element, joined, pairs, section, table
from motionlab.reports.quantities import (
    change_of,
    digits,
    field_at,
    quantity,
    value_at,
)
from motionlab.reports.recipe import recipe

KINDS = {
    "simulation": "simulated",
    "live": "live session",
    "drive": "on drives",
    "measurement": "measured",
}

EVENTS_MAX = 200
"""Rows of the table of events."""
_FIELDS_MAX = 24
_DASH = "\u2013"
_PRINTED_LINES = 150  # of a file; a longer one stands in the report alone


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


def heading(run: RunDetail) -> Markup:
    """Return title, time, and what is missing of a run."""
    line = f"Run {run.id}, {KINDS[run.kind]}, {instant(run.created)}, {length(run.duration)}"
    return joined(
        [
            element("h1", run.name),
            element("p", line, class_="quiet"),
            partial(run),
        ]
    )


def partial(run: RunDetail) -> Markup | None:
    """Return what is missing of a run; None if nothing is."""
    if run.state != "partial":
        return None
    reason = run.reason or "the recording ended before the run did"
    return element("p", element("b", "Partial run: "), f"{reason}.", class_="warning")


def what_was_done(run: RunDetail, happened: Sequence[Happened]) -> Markup:
    """Return the section on scenario, differences, variants, trajectory and events."""
    document = run.scenario_document
    return section(
        "What was done",
        about(run),
        joined([element("h3", "Differences from the shipped scenario"), _shipped(run)])
        if document is not None
        else None,
        joined([element("h3", "Trajectory"), _trajectory(document["trajectory"])])
        if document is not None and "trajectory" in document
        else None,
        element("h3", "Events"),
        happened_table(run, happened),
    )


def about(run: RunDetail) -> Markup:
    """Return scenario, motor, seed, variants, note and tags."""
    document = run.scenario_document or {}
    rows: list[tuple[object, object]] = []
    if run.kind == "measurement":
        rows.append(("scenario", "none: a measurement of a real machine"))
    else:
        rows.append(("scenario", run.scenario))
        rows.append(("about it", document.get("description") or _DASH))
        plant = document.get("plant") or {}
        motor = ": ".join(filter(None, [plant.get("name"), plant.get("description")]))
        rows.append(("motor", motor or _DASH))
        rows.append(("seed", _DASH if run.seed is None else run.seed))
    rows += [(f"variant {name}", run.labels.get(name, "")) for name in run.variants]
    if run.tags:
        rows.append(("tags", ", ".join(run.tags)))
    if run.note:
        rows.append(("note", element("span", run.note, class_="note")))
    return pairs(rows)


def events(run: RunDetail) -> list[Happened]:
    """Return changes, pushes, stop, gaps and the schedule, by time from the first sample on."""
    begun = run.first_tick * run.period
    entries = [
        (event.tick * run.period - begun, event.kind, _what(event, run.period))
        for event in run.events
    ]
    schedule = (run.scenario_document or {}).get("schedule") or ()
    entries += [(each["time"] - begun, "scheduled", _set(each["set"], {})) for each in schedule]
    entries.sort(key=lambda each: each[0])
    return [
        Happened(str(i), time, kind, what)
        for i, (time, kind, what) in enumerate(entries[:EVENTS_MAX], start=1)
    ]


def happened_table(run: RunDetail, happened: Sequence[Happened]) -> Markup:
    """Return events with their numbers and times."""
    if not happened:
        return element("p", "None: no change, push or stop.")
    rows = [[each.number, f"{digits(each.time, 5)} s", each.kind, each.what] for each in happened]
    total = len(run.events) + len((run.scenario_document or {}).get("schedule") or ())
    more = f"The first {len(rows)} of {total}." if total > len(rows) else None
    shown = table(["", "time", "what", ""], rows)
    return joined([shown, element("p", more, class_="quiet") if more else ""])


def difference_table(differences: Sequence[Difference], before: str, after: str) -> Markup:
    """Return differences of two scenarios as a table."""
    rows = [
        [
            joined([field_at(each.path).name, " ", element("code", each.path)]),
            value_at(each.path, each.shipped),
            value_at(each.path, each.value),
        ]
        for each in differences
    ]
    more = f"The first {DIFFERENCES_MAX} differences." if len(rows) >= DIFFERENCES_MAX else None
    shown = table(["field", before, after], rows)
    return joined([shown, element("p", more, class_="quiet") if more else ""])


def between(first: RunDetail, second: RunDetail) -> Markup:
    """Return the differences between the scenarios of two runs."""
    if first.scenario_document is None or second.scenario_document is None:
        return element("p", "A measurement has no scenario: there is nothing to compare.")
    differences = differing(first.scenario_document, second.scenario_document)
    if first.scenario != second.scenario:
        names = Difference(path="name", shipped=first.scenario, value=second.scenario)
        differences = [names, *differences]
    if not differences:
        return element("p", "None: the same scenario.")
    return difference_table(differences, "run 1", "run 2")


def again(run: RunDetail, scenario: Scenario | None) -> Markup:
    """Return how a run is simulated again."""
    if run.kind == "measurement":
        return element("p", "A measurement: it cannot be simulated again.")
    measured = run.kind == "drive"
    replay = (
        element("p", "Measured on drives: what follows simulates the same scenario.")
        if measured
        else _code("Every sample, compared bit for bit:", f"motionlab replay {run.id}")
    )
    if scenario is None:
        invalid = "Its scenario is not valid in this version; the version that kept it can replay."
        return joined([element("p", invalid), replay])
    made = recipe(scenario)
    file = f"{run.scenario}.toml"
    live = None
    if run.kind == "live" and run.events:
        live = element(
            "p",
            "A live session: what follows simulates its scenario as it began, without the events "
            "above. Only the replay has them at their ticks.",
        )
    return joined(
        [
            replay,
            live or "",
            _code("Command line:", made.command) if made.command else "",
            _code("Request to a lab at the address $MOTIONLAB:", made.request)
            if made.request
            else "",
            _code(f"File, for motionlab run {file}:", made.toml) if made.toml else "",
        ]
    )


def record(run: RunDetail, digest: str) -> Markup:
    """Return hashes, version and size of a run."""
    samples = "1 sample" if run.ticks == 1 else f"{run.ticks:,} samples"
    maps = [
        (f"force map at {place}", f"{entry.get('name', '')} {entry.get('digest', '')}")
        for place, entry in run.maps.items()
        if isinstance(entry, dict)
    ]
    rate = quantity(1.0 / run.period, "Hz")
    return pairs(
        [
            ("run", run.id),
            ("version", f"motionlab {run.version}"),
            ("model", run.model or "none: measured"),
            ("processor", run.processor or _DASH),
            *maps,
            ("telemetry", f"{samples} of {len(run.columns)} channels at {rate}"),
            ("its Parquet file", f"{run.size:,} bytes, SHA-256 {digest}"),
            *_imported(run.result.get("import")),
        ]
    )


def instant(seconds: float) -> str:
    """Return an instant since 1970 as date and time."""
    try:
        return datetime.fromtimestamp(seconds, UTC).strftime("%Y-%m-%d %H:%M:%S UTC")
    except (OverflowError, ValueError, OSError):
        return "at an unknown time"


def length(seconds: float) -> str:
    """Return a length of time."""
    if seconds < 120.0:
        return f"{digits(seconds, 4)} s"
    return f"{int(seconds // 60)} min {digits(seconds % 60, 3)} s"


def _shipped(run: RunDetail) -> Markup:
    if run.scenario not in names("scenarios"):
        return element(
            "p", f"{run.scenario} is a scenario of its own: none is shipped of its name."
        )
    if not run.differences:
        return element("p", "None: as shipped.")
    return difference_table(run.differences, "shipped", "this run")


def _trajectory(tables: dict[str, Any]) -> Markup:
    rows: list[tuple[object, object]] = [("kind", tables.get("kind", _DASH))]
    rows += [
        (field_at(path).name, value_at(path, value))
        for path, value in _scalars(tables, "trajectory")
        if value is not None and path != "trajectory.kind"
    ][:_FIELDS_MAX]
    return pairs(rows)


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


def _set(values: dict[str, Any], previous: dict[str, Any]) -> Markup:
    parts = [
        joined(
            [
                field_at(path).name,
                " ",
                change_of(path, previous[path], value)
                if path in previous
                else value_at(path, value),
            ]
        )
        for path, value in values.items()
    ]
    return joined(parts, ", ")


def _code(what: str, text: str) -> Markup:
    if (lines := text.count("\n")) > _PRINTED_LINES:
        note = element("div", f"{lines:,} lines, which are not printed.", class_="printed")
        return element("div", element("div", what), note, element("pre", text, class_="long"))
    return element("div", element("div", what), element("pre", text), class_="together")


def _imported(origin: Any) -> list[tuple[object, object]]:
    if not isinstance(origin, dict):
        return []
    source = f"{origin.get('format', '')}, {origin.get('rows', 0):,} rows"
    return [("imported from", source)]
