"""The causes of an error, each as the changes of a scenario that take it away on one axis."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from motionlab.config.controller import ControllerConfig
from motionlab.config.scenario import Scenario

_FRICTION = ("sigma_0", "sigma_1", "sigma_2", "F_c", "F_s", "v_s")


class CauseKind(NamedTuple):
    """A cause: what it is called, what taking it away means, and the changes that do so."""

    id: str
    label: str
    meaning: str
    changes: Callable[[Scenario, str, str], dict[str, Any]]
    """Takes scenario, variant and axis; returns dotted path to value, of which those that change
    nothing are left out."""


def compensates(controller: ControllerConfig) -> bool:
    """Return whether friction is compensated."""
    return controller.compensation.law != "off" and controller.compensation.enabled


def _mismatch(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    controller = scenario.variants[variant].controller
    plant = getattr(scenario.plant, axis).friction
    if not compensates(controller) or not plant.enabled:
        return {}
    model = f"variants.{variant}.controller.model.{axis}.friction"
    return {f"{model}.{name}": getattr(plant, name) for name in _FRICTION}


def _stribeck(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    if not getattr(scenario.plant, axis).friction.enabled:
        return {}
    model = getattr(scenario.variants[variant].controller.model, axis).friction
    return {
        f"plant.{axis}.friction.F_s": getattr(scenario.plant, axis).friction.F_c,
        f"variants.{variant}.controller.model.{axis}.friction.F_s": model.F_c,
    }


def _friction(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    if not getattr(scenario.plant, axis).friction.enabled:
        return {}
    off = {f"plant.{axis}.friction.enabled": False}
    if compensates(scenario.variants[variant].controller):
        off[f"variants.{variant}.controller.compensation.enabled"] = False
    return off


def _inertia(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    return {
        f"variants.{variant}.controller.feedforward": True,
        f"variants.{variant}.controller.model.{axis}.mass": getattr(scenario.plant, axis).mass,
    }


def _offset(_scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    return {f"plant.{axis}.amplifiers.offset": [0.0, 0.0, 0.0]}


def _gain(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    changes: dict[str, Any] = {f"plant.{axis}.amplifiers.gain": [1.0, 1.0, 1.0]}
    real = getattr(scenario.plant, axis).force_map
    model = getattr(scenario.variants[variant].controller.model, axis).force_map
    if hasattr(real, "F_pk") and hasattr(model, "F_pk"):
        path = f"variants.{variant}.controller.model.{axis}.force_map.F_pk"
        changes[path] = real.F_pk
    return changes


def _map(scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    real = getattr(scenario.plant, axis).force_map
    return {f"variants.{variant}.controller.model.{axis}.force_map": real.model_dump(mode="json")}


def _bandwidth(_scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    return {f"plant.{axis}.amplifiers.bandwidth": None}


def _delay(_scenario: Scenario, variant: str, _axis: str) -> dict[str, Any]:
    return {f"variants.{variant}.controller.delay": 0}


def _encoder(_scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    encoder = f"plant.{axis}.encoder"
    return {f"{encoder}.resolution": 0.0, f"{encoder}.sde_amplitude": 0.0}


def _noise(_scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    return {
        f"plant.{axis}.encoder.noise": 0.0,
        f"plant.{axis}.amplifiers.noise": 0.0,
        f"plant.{axis}.amplifiers.ripple_amplitude": 0.0,
        "load.noise": 0.0,
    }


def _resonance(_scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    return {f"plant.{axis}.resonance.coupling": 0.0}


def _load(scenario: Scenario, _variant: str, axis: str) -> dict[str, Any]:
    steps = [
        step.model_dump(mode="json") | {axis: 0.0}
        for step in scenario.load.steps
        if getattr(step, axis) != 0.0
    ]
    others = [
        step.model_dump(mode="json") for step in scenario.load.steps if getattr(step, axis) == 0.0
    ]
    return {
        f"load.{axis}": 0.0,
        "load.steps": sorted([*steps, *others], key=lambda step: step["time"]),
    }


def _alone(scenario: Scenario, variant: str, _axis: str) -> dict[str, Any]:
    if not compensates(scenario.variants[variant].controller):
        return {}
    return {f"variants.{variant}.controller.compensation.enabled": False}


CAUSES = (
    CauseKind(
        "mismatch",
        "friction model mismatch",
        "the controller's friction model made equal to the motor's friction",
        _mismatch,
    ),
    CauseKind("stribeck", "Stribeck effect", "stiction made equal to Coulomb friction", _stribeck),
    CauseKind("friction", "friction as a whole", "no friction, and none compensated", _friction),
    CauseKind(
        "inertia",
        "inertia not fed forward",
        "the motor's mass times the planned acceleration added to the force",
        _inertia,
    ),
    CauseKind("offset", "amplifier offsets", "no current at zero command", _offset),
    CauseKind(
        "gain",
        "gain error",
        "amplifier gains of 1, and the controller's force constant that of the motor",
        _gain,
    ),
    CauseKind(
        "map",
        "force sharing and ripple",
        "the controller's force map made equal to the motor's, offset and harmonics included",
        _map,
    ),
    CauseKind(
        "bandwidth", "amplifier bandwidth", "currents that follow their command at once", _bandwidth
    ),
    CauseKind("delay", "delay", "no control period between measurement and command", _delay),
    CauseKind(
        "encoder", "encoder counts", "an encoder without counts and subdivisional error", _encoder
    ),
    CauseKind("noise", "noise", "no noise, and no ripple of the amplifiers", _noise),
    CauseKind("resonance", "resonance", "a rigid machine", _resonance),
    CauseKind("load", "external load", "no external load", _load),
    CauseKind(
        "compensation",
        "friction compensation",
        "friction compensation switched off: below 0, it helps",
        _alone,
    ),
)
"""Every cause that is looked for."""
