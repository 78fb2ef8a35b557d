"""The only parser of scenarios: names and tables in, a validated scenario out."""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from motionlab.config.changes import apply_changes, check_schedulable
from motionlab.config.hints import add_hints
from motionlab.config.includes import resolve
from motionlab.config.named_configs import is_name, parse, read
from motionlab.config.quantity import Config
from motionlab.config.scenario import Scenario
from motionlab.config.toml_lines import add_places
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.config.validation_errors import field_errors
from motionlab.declarations import Parameter, allows
from motionlab.errors import ConfigError, FieldError
from motionlab.laws import PARAMETERS
from motionlab.timing import CONTROL_PERIOD, to_ticks

Epochs = tuple[tuple[int, Scenario], ...]
"""Parameter sets of a run, and the tick from which on each holds."""


class _Holder(Config):
    """Wraps a trajectory, so that its errors have their location in a scenario."""

    trajectory: TrajectoryConfig


def load_scenario(
    source: str | Path | Mapping[str, Any], changes: Mapping[str, Any] | None = None
) -> Scenario:
    """Return the scenario that `source` describes, with `changes` applied.

    Parameters
    ----------
    source : str, Path or mapping
        Name of a shipped scenario, a TOML file, or the tables themselves. Text is never a path, so
        that a remote caller cannot name files.
    changes : mapping of str to value, optional
        Dotted path to value, such as ``{"variants.B.controller.x.k_p": 312000.0}``; all are
        applied together, parts before what lies inside them, and then validated.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    changes = changes or {}
    folder = source.parent if isinstance(source, Path) else None
    tables: dict[str, Any] = {}
    nowhere: list[FieldError] = []
    try:
        tables = resolve(read_source(source), folder=folder, errors=nowhere)
        if nowhere:
            raise ConfigError(*nowhere, *_others(tables, nowhere))
        return validate(apply_changes(tables, changes) if changes else tables)
    except ConfigError as error:
        errors: Sequence[FieldError] = add_hints(error.errors, tables, changes)
        if isinstance(source, Path):
            errors = add_places(errors, source, changes)
        raise ConfigError(*errors) from None
    except RecursionError:
        raise ConfigError(FieldError(loc="scenario", message="is nested too deeply")) from None


def read_source(source: str | Path | Mapping[str, Any]) -> Mapping[str, Any]:
    """Return the tables of a shipped name, a TOML file, or the tables themselves, unresolved."""
    if isinstance(source, Mapping):
        return source
    if isinstance(source, Path):
        named = {"name": source.stem} if is_name(source.stem) else {}
        return named | parse(source)
    return {"name": source} | read("scenarios", source, loc="scenario")


def _others(tables: Mapping[str, Any], nowhere: Sequence[FieldError]) -> list[FieldError]:
    """Return the further errors of tables in which some names are unknown."""
    places = ["" if error.loc == "scenario" else f"{error.loc}." for error in nowhere]
    try:
        validate(tables)
    except ConfigError as error:
        return [
            each
            for each in error.errors
            # It may be missing for want of a base.
            if not (each.message == "is missing" and f"{each.loc}.".startswith(tuple(places)))
        ]
    return []


def validate(document: Mapping[str, Any]) -> Scenario:
    """Return resolved tables as a scenario whose schedule can be carried out.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, those of the schedule too.
    """
    try:
        scenario = _validate(document)
    except ConfigError as error:
        errors = [*error.errors, *_errors_of_events(document, error.errors)]
        raise ConfigError(*errors) from None
    if errors := _errors_of_events(document, ()):
        raise ConfigError(*errors)
    epochs(scenario)
    return scenario


def redeclared(scenario: Scenario, former: Mapping[str, Parameter]) -> Scenario:
    """Return a scenario of other declarations of laws as one of the present ones.

    A new parameter has its default; so has one whose former default is no longer allowed, where it
    had that. Other values stay.

    Parameters
    ----------
    scenario : Scenario
        As it was validated when laws declared other parameters.
    former : mapping of str to Parameter
        Those by name.

    Raises
    ------
    ConfigError
        Naming every value that is no longer allowed.
    """
    document = scenario.model_dump(mode="json")
    for variant in document["variants"].values():
        values = variant["controller"]["compensation"]
        for name in former.keys() & PARAMETERS.keys() & values.keys():
            untouched = values[name] == former[name].default
            if untouched and not allows(PARAMETERS[name], values[name]):
                del values[name]
    return validate(document)


def _errors_of_events(document: Mapping[str, Any], known: Sequence[FieldError]) -> list[FieldError]:
    """Return the errors of each event's own changes, beside `known` ones."""
    errors: list[FieldError] = []
    schedule = document.get("schedule")
    for index, event in enumerate(schedule if isinstance(schedule, list | tuple) else ()):
        changes: Any = event.get("set") if isinstance(event, Mapping) else None
        if not isinstance(changes, dict) or not all(isinstance(path, str) for path in changes):
            continue  # an error of the scenario
        place = f"schedule.{index}.set"
        try:
            check_schedulable(changes, place)
            if known:  # else `epochs` applies one event after another
                _validate(apply_changes(document, changes))
        except ConfigError as error:
            new = [e for e in error.errors if e not in known]
            errors += [e if e.loc.startswith(place) else _below(place, e) for e in new]
    return errors


def _below(place: str, error: FieldError) -> FieldError:
    return replace(error, loc=f"{place}.{error.loc}")


def validate_trajectory(tables: Mapping[str, Any]) -> TrajectoryConfig:
    """Return tables as a trajectory of any kind.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, as in a scenario.
    """
    try:
        return _Holder.model_validate({"trajectory": tables}).trajectory
    except ValidationError as error:
        raise ConfigError(*field_errors(error, _Holder)) from None


class _Same:
    """A scenario as the key of a cache: frozen, so that the same one stays what it was."""

    def __init__(self, scenario: Scenario) -> None:
        self.scenario = scenario

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Same) and self.scenario is other.scenario

    def __hash__(self) -> int:
        return id(self.scenario)


def epochs(scenario: Scenario, start: int = 0) -> Epochs:
    """Return the parameter sets of a run: from which tick on each holds, in order of time.

    Parameters
    ----------
    scenario : Scenario
        Parameters at `start`.
    start : int
        First tick; events up to it are taken to be in the scenario already.

    Raises
    ------
    ConfigError
        If an event leads to a scenario that is not valid, or two events share a tick.
    """
    return _epochs(_Same(scenario), start) if scenario.schedule else ((start, scenario),)


# A scenario that has been validated is prepared next; a what-if has two.
@functools.lru_cache(maxsize=4)
def _epochs(same: _Same, start: int) -> Epochs:
    scenario = same.scenario
    result = [(start, scenario)]
    errors: list[FieldError] = []
    document = scenario.model_dump(mode="json")
    order = sorted(enumerate(scenario.schedule), key=lambda item: item[1].time)
    for index, event in order:
        tick = to_ticks(event.time)
        if 0 < tick <= start:
            continue
        if tick <= result[-1][0]:
            errors.append(
                FieldError(
                    loc=f"schedule.{index}.time",
                    message="needs a control period of its own after the start and other events",
                    value=event.time,
                    bounds={"minimum": (result[-1][0] + 1) * CONTROL_PERIOD},
                    unit="s",
                )
            )
            continue
        try:
            after = apply_changes(document, event.set)
            changed = _validate(after)
        except ConfigError as error:
            errors += [_below(f"schedule.{index}.set", e) for e in error.errors]
            continue
        if changed.variants.keys() != scenario.variants.keys():
            errors.append(FieldError(f"schedule.{index}.set", "adds a variant during the run"))
            continue
        document = after
        result.append((tick, changed))
    if errors:
        raise ConfigError(*errors)
    return tuple(result)


def _validate(document: Mapping[str, Any]) -> Scenario:
    try:
        scenario = Scenario.model_validate(document)
    except ValidationError as error:
        raise ConfigError(*field_errors(error, Scenario)) from None
    unstable = _unstable_gains(scenario)
    if unstable:
        raise ConfigError(*unstable)
    return scenario


def _unstable_gains(scenario: Scenario) -> list[FieldError]:
    """Return the gains with which a law is unstable by itself, whatever the loop about it."""
    errors = []
    for name, variant in scenario.variants.items():
        refused = variant.controller.refusal()
        if refused is None:
            continue
        axis, refusal = refused
        parameter = PARAMETERS[refusal.parameter]
        path = f"variants.{name}.controller.compensation.{parameter.name}"
        reason = f"is unstable on {axis}: {refusal.reason}"
        ends = {"minimum": parameter.ge, "exclusive_maximum": refusal.limit}
        errors.append(FieldError(path, reason, refusal.value, unit=parameter.unit, bounds=ends))
    return errors
