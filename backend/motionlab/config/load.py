"""The only parser of scenarios: names and tables in, a validated scenario out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from motionlab.config.changes import apply_changes, check_schedulable
from motionlab.config.hints import hinted
from motionlab.config.includes import resolve
from motionlab.config.quantity import Config
from motionlab.config.scenario import Scenario
from motionlab.config.shipped import copied, is_name, parse, read
from motionlab.config.timing import CONTROL_PERIOD, to_ticks
from motionlab.config.toml_lines import located
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError, FieldError


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

    Returns
    -------
    Scenario
        Fully resolved and validated.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    changes = changes or {}
    try:
        with located(source, elsewhere=changes) if isinstance(source, Path) else nullcontext():
            document = _resolved(source)
            if changes:
                document = _with_defaults(document)
                with hinted(document, changes):
                    return validate(apply_changes(document, changes))
            with hinted(document):
                return validate(document)
    except RecursionError:
        raise ConfigError(FieldError(loc="scenario", message="is nested too deeply")) from None


def _resolved(source: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    """Return the tables of a source; beside names that lead nowhere, all else that is wrong."""
    errors: list[FieldError] = []
    folder = source.parent if isinstance(source, Path) else None
    document = resolve(_read_source(source), folder=folder, errors=errors)
    if errors:
        places = ["" if error.loc == "scenario" else error.loc for error in errors]
        try:
            with hinted(document):
                validate(document)
        except ConfigError as error:
            errors += (each for each in error.errors if not _is_missing_below(each, places))
        raise ConfigError(*errors)
    return document


def _is_missing_below(error: FieldError, places: Sequence[str]) -> bool:
    """Return whether a field may be missing for want of the base of one of some parts."""
    loc = f"{error.loc}."
    return error.message == "is missing" and any(
        not place or loc.startswith(f"{place}.") for place in places
    )


def validate(document: Mapping[str, Any]) -> Scenario:
    """Return resolved tables as a scenario whose schedule can be carried out.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, those of the schedule too.
    """
    found: list[FieldError] = []
    scenario = None
    try:
        scenario = _validate(document)
    except ConfigError as error:
        found += error.errors
    found += _errors_of_events(document, found)
    if scenario is None or found:
        raise ConfigError(*found)
    epochs(scenario)
    return scenario


def _errors_of_events(document: Mapping[str, Any], known: Sequence[FieldError]) -> list[FieldError]:
    """Return what is wrong with the changes of each event by itself, beside `known` errors."""
    found: list[FieldError] = []
    schedule = document.get("schedule")
    for index, event in enumerate(schedule if isinstance(schedule, list | tuple) else ()):
        changes: Any = event.get("set") if isinstance(event, Mapping) else None
        if not isinstance(changes, dict) or not all(isinstance(path, str) for path in changes):
            continue  # an error of the scenario
        place = f"schedule.{index}.set"
        try:
            check_schedulable(changes, place)
            if known:  # else `epochs` applies one event after another
                _validate(apply_changes(dict(document), changes))
        except ConfigError as error:
            new = [e for e in error.errors if e not in known]
            found += [e if e.loc.startswith(place) else _below(place, e) for e in new]
    return found


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


def epochs(scenario: Scenario, start: int = 0) -> list[tuple[int, Scenario]]:
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
    result = [(start, scenario)]
    if not scenario.schedule:
        return result
    found: list[FieldError] = []
    document = scenario.model_dump(mode="json")
    order = sorted(enumerate(scenario.schedule), key=lambda item: item[1].time)
    for index, event in order:
        tick = to_ticks(event.time)
        if 0 < tick <= start:
            continue
        if tick <= result[-1][0]:
            found.append(
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
            found += [_below(f"schedule.{index}.set", e) for e in error.errors]
            continue
        if changed.variants.keys() != scenario.variants.keys():
            found.append(FieldError(f"schedule.{index}.set", "adds a variant during the run"))
            continue
        document = after
        result.append((tick, changed))
    if found:
        raise ConfigError(*found)
    return result


def _read_source(source: str | Path | Mapping[str, Any]) -> dict[str, Any]:
    if isinstance(source, Mapping):
        return copied(dict(source))
    if isinstance(source, Path):
        named = {"name": source.stem} if is_name(source.stem) else {}
        return named | parse(source)
    return {"name": source} | read("scenarios", source, loc="scenario")


def _with_defaults(document: dict[str, Any]) -> dict[str, Any]:
    """Return tables with every default filled in, so that a change can reach inside of one."""
    try:
        return Scenario.model_validate(document).model_dump(mode="json")
    except ValidationError:
        return document  # the changes may yet make it valid


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
        compensation = variant.controller.compensation
        if compensation.gain is None:  # chosen within its limit
            continue
        refusal = variant.controller.refusal_of_gain(compensation.gain, compensation.regularisation)
        if refusal is not None:
            reason, limit = refusal
            path = f"variants.{name}.controller.compensation.gain"
            ends = {"minimum": 0.0, "exclusive_maximum": limit}
            errors.append(FieldError(path, reason, compensation.gain, unit="1/s", bounds=ends))
    return errors
