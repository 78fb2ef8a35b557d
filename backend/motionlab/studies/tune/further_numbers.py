"""Numbers of a controller that a search takes beside its gains, and the ranges that they allow."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product
from typing import Any

from motionlab.config.controller import ControllerConfig
from motionlab.config.scenario import Scenario
from motionlab.config.validation_errors import checked
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.build import lane
from motionlab.kernel.law_calls import law_parameters
from motionlab.laws import LAWS, PARAMETERS
from motionlab.studies.tune.documents import TuneRequest

_OBSERVER = "disturbance_observer.bandwidth"
_OF_LAW = "compensation."


def further_numbers(controller: ControllerConfig) -> list[str]:
    """Return the numbers that a controller uses beside its gains, by path below it.

    They are those that its law declares, and the bandwidth of a disturbance observer that is on.
    """
    declared = LAWS[controller.compensation.law].parameters
    numbers = [f"{_OF_LAW}{each.name}" for each in declared if not each.choices]
    return numbers + [_OBSERVER] * controller.disturbance_observer.enabled


def value_of(
    scenario: Scenario, controller: ControllerConfig, axis: str, path: str
) -> float | None:
    """Return a number of a controller, or what its law takes in place of one that is left out.

    None where the law makes something else of it, or sets no bound.
    """
    part, field = path.split(".")
    value = getattr(getattr(controller, part), field)
    if value is None:
        value = getattr(law_parameters(lane(scenario, controller, axis)), field, math.inf)
    return value if math.isfinite(value) else None


def check_further(request: TuneRequest, scenario: Scenario, variant: str) -> None:
    """Check which further numbers are searched, and between which ends.

    Raises
    ------
    ConfigError
        Naming those that the controller does not use, ends beyond what a number may be, and ranges
        in which the law refuses to work.
    """
    controller = scenario.variants[variant].controller
    known = further_numbers(controller)
    errors = [_unknown(path, controller, known) for path in request.also if path not in known]
    if not errors:
        errors = [
            error
            for path, ends in request.also.items()
            for error in _beyond(path, ends, controller)
        ]
    if not errors:
        errors = [
            FieldError(
                f"also.{path}",
                f"is left to the law: set variants.{variant}.controller.{path} first, where the "
                "search begins",
            )
            for path in request.also
            if value_of(scenario, controller, "x", path) is None
        ]
    if not errors:
        errors = _refused(request, controller)
    if errors:
        raise ConfigError(*errors)


def _unknown(path: str, controller: ControllerConfig, known: list[str]) -> FieldError:
    observer = "on" if controller.disturbance_observer.enabled else "off"
    return FieldError(
        f"also.{path}",
        f"is no number that this controller uses: its law is {controller.compensation.law}, and "
        f"its disturbance observer is {observer}",
        range="one of " + ", ".join(known) if known else "none",
    )


def _beyond(path: str, ends: tuple[float, float], controller: ControllerConfig) -> list[FieldError]:
    """Return what the field has against the ends of its range."""
    part, field = path.split(".")
    config = getattr(controller, part)
    for end in ends:
        try:
            checked(type(config), config.model_dump() | {field: end}, part)
        except ConfigError as error:
            return [replace(each, loc=f"also.{path}") for each in error.errors]
    return []


def _refused(request: TuneRequest, controller: ControllerConfig) -> list[FieldError]:
    """Return why the law does not work somewhere in the ranges, of all corners the strictest."""
    ranges = {
        path.removeprefix(_OF_LAW): ends
        for path, ends in request.also.items()
        if path.startswith(_OF_LAW)
    }
    corners = [dict(zip(ranges, corner, strict=True)) for corner in product(*ranges.values())]
    refusals = [each for corner in corners if (each := controller.refusal(corner)) is not None]
    if not ranges or not refusals:
        return []
    axis, refusal = min(refusals, key=lambda each: each[1].limit)
    name = refusal.parameter
    unit = PARAMETERS[name].unit
    reason = f"is unstable on {axis}: {refusal.reason}"
    bounds: dict[str, Any] = {"exclusive_maximum": refusal.limit}
    if name not in ranges:
        name = next(iter(ranges))
        reason = f"its {refusal.parameter} of {refusal.value:g} {unit} {reason}"
        unit, bounds = "", {}
    low, high = ranges[name]
    loc = f"also.{_OF_LAW}{name}"
    return [FieldError(loc, reason, f"{low:g} to {high:g}", unit=unit, bounds=bounds)]
