"""Causes of a following error, and changes of a controller that may reduce it.

A cause is the changes of a scenario that remove it on one axis.
"""

from __future__ import annotations

import math
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


LARGEST = 32.0
"""Largest factor of a gain, up or down."""
_STEPS = 14
SWITCH = math.log(2.0)
"""Size of a switch: that of a doubled number."""
_NUMBERS = (
    ("F_s", "stiction F_s of the friction model", 2.0),
    ("F_c", "Coulomb friction F_c of the friction model", 4.0),
    ("v_s", "Stribeck velocity v_s of the friction model", 4.0),
    ("sigma_2", "viscous friction \u03c3_2 of the friction model", 4.0),
)
_DOB = "disturbance_observer"


class Knob(NamedTuple):
    """Something of a controller that can be changed: numbers by a factor, or a switch."""

    label: str
    paths: dict[str, float]
    """Dotted path to the exponent of the factor; empty for a switch."""
    most: float
    """Largest factor, up or down."""
    switch: dict[str, Any]


class Trial(NamedTuple):
    """One change of a knob."""

    knob: Knob
    factor: float | None
    set: dict[str, Any]

    @property
    def size(self) -> float:
        """Size of the change: abs(log(factor)), `SWITCH` for a switch."""
        return SWITCH if self.factor is None else abs(math.log(self.factor))


def knobs(scenario: Scenario, variant: str, axis: str) -> list[Knob]:
    """Return the knobs of the controller of one axis."""
    controller = scenario.variants[variant].controller
    path = f"variants.{variant}.controller"
    gains = f"{path}.{axis}"
    knob_list = [
        Knob(f"k_p {axis}", {f"{gains}.k_p": 1.0}, LARGEST, {}),
        Knob(f"k_d {axis}", {f"{gains}.k_d": 1.0}, LARGEST, {}),
        Knob(
            f"k_p {axis}, and k_d {axis} by its root",
            {f"{gains}.k_p": 1.0, f"{gains}.k_d": 0.5},
            LARGEST,
            {},
        ),
    ]
    if compensates(controller):
        model = f"{path}.model.{axis}.friction"
        knob_list += [
            Knob(f"{label}, {axis}", {f"{model}.{name}": 1.0}, most, {})
            for name, label, most in _NUMBERS
        ]
    else:
        on: dict[str, Any] = {f"{path}.compensation.enabled": True}
        if controller.compensation.law == "off":
            on[f"{path}.compensation.law"] = "lugre-observer"
        knob_list.append(Knob("friction compensation on", {}, 1.0, on))
    if controller.disturbance_observer.enabled:
        paths = {f"{path}.{_DOB}.bandwidth": 1.0}
        knob_list.append(Knob("bandwidth of the disturbance observer", paths, 8.0, {}))
    else:
        knob_list.append(Knob("disturbance observer on", {}, 1.0, {f"{path}.{_DOB}.enabled": True}))
    if not controller.feedforward:
        knob_list.append(Knob("feedforward on", {}, 1.0, {f"{path}.feedforward": True}))
    return knob_list


def trials(knob: Knob, values: dict[str, float], steps: int = _STEPS) -> list[Trial]:
    """Return changes of a knob, up and down, evenly spaced in the logarithm of their factor."""
    if not knob.paths:
        return [Trial(knob, None, knob.switch)]
    if all(values[path] == 0.0 for path in knob.paths):
        return []
    exponents = [sign * k / steps for k in range(1, steps + 1) for sign in (1.0, -1.0)]
    return [trial(knob, values, knob.most**exponent) for exponent in exponents]


def trial(knob: Knob, values: dict[str, float], factor: float) -> Trial:
    """Return a knob's numbers multiplied by a factor, to four digits."""
    changed = {
        path: float(f"{values[path] * factor**exponent:.4g}")
        for path, exponent in knob.paths.items()
    }
    return Trial(knob, factor, changed)
