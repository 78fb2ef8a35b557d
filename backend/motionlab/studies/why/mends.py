"""Changes of a controller that may mend a peak, by their size."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from motionlab.config.scenario import Scenario
from motionlab.studies.why.causes import compensates

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
        """How large the change is: abs(log(factor)), `SWITCH` for a switch."""
        return SWITCH if self.factor is None else abs(math.log(self.factor))


def knobs(scenario: Scenario, variant: str, axis: str) -> list[Knob]:
    """Return what can be changed of the controller of one axis."""
    controller = scenario.variants[variant].controller
    path = f"variants.{variant}.controller"
    gains = f"{path}.{axis}"
    found = [
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
        found += [
            Knob(f"{label}, {axis}", {f"{model}.{name}": 1.0}, most, {})
            for name, label, most in _NUMBERS
        ]
    else:
        on: dict[str, Any] = {f"{path}.compensation.enabled": True}
        if controller.compensation.law == "off":
            on[f"{path}.compensation.law"] = "lugre-observer"
        found.append(Knob("friction compensation on", {}, 1.0, on))
    if controller.disturbance_observer.enabled:
        paths = {f"{path}.{_DOB}.bandwidth": 1.0}
        found.append(Knob("bandwidth of the disturbance observer", paths, 8.0, {}))
    else:
        found.append(Knob("disturbance observer on", {}, 1.0, {f"{path}.{_DOB}.enabled": True}))
    if not controller.feedforward:
        found.append(Knob("feedforward on", {}, 1.0, {f"{path}.feedforward": True}))
    return found


def trials(knob: Knob, values: dict[str, float], steps: int = _STEPS) -> list[Trial]:
    """Return changes of a knob, up and down, evenly spaced in the logarithm of their factor.

    Parameters
    ----------
    knob : Knob
        What is changed.
    values : dict of str to float
        Present value of each of its paths.
    steps : int
        How many either way.
    """
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
