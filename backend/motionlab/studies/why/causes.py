"""Causes of a following error, and changes of a controller that may reduce it.

A cause is the changes of a scenario that remove it on one axis: data, which a page without a server
reads as well (docs/demo.md).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

from motionlab.config.controller import ControllerConfig
from motionlab.config.scenario import Scenario

_FRICTION = ("sigma_0", "sigma_1", "sigma_2", "F_c", "F_s", "v_s")
_OF_PLANT, _OF_MODEL = "plant.{axis}.friction", "{controller}.model.{axis}.friction"
_COMPENSATION = "{controller}.compensation"
_NO_FRICTION: dict[str, Any] = {f"{_OF_PLANT}.enabled": False}
_NO_COMPENSATION: dict[str, Any] = {
    f"{_COMPENSATION}.enabled": False,
    f"{_COMPENSATION}.law": "off",
}


class Change(NamedTuple):
    """A field of a scenario, and what it becomes. Paths have {controller} and {axis} in them."""

    path: str
    """With ``*`` every entry of a list."""
    value: Any = None
    copied: str = ""
    """The field whose value it gets, in place of `value`; empty for none."""
    unless: Mapping[str, Any] = {}
    """Path to value: where one of these holds, nothing is changed."""


class CauseKind(NamedTuple):
    """A cause: what it is called, what taking it away means, and the changes that do so."""

    id: str
    label: str
    meaning: str
    changes: tuple[Change, ...]


CAUSES = (
    CauseKind(
        "mismatch",
        "friction model mismatch",
        "the controller's friction model made equal to the motor's friction",
        tuple(
            Change(
                f"{_OF_MODEL}.{name}",
                copied=f"{_OF_PLANT}.{name}",
                unless=_NO_FRICTION | _NO_COMPENSATION,
            )
            for name in _FRICTION
        ),
    ),
    CauseKind(
        "stribeck",
        "Stribeck effect",
        "stiction made equal to Coulomb friction",
        tuple(
            Change(f"{owner}.F_s", copied=f"{owner}.F_c", unless=_NO_FRICTION)
            for owner in (_OF_PLANT, _OF_MODEL)
        ),
    ),
    CauseKind(
        "friction",
        "friction as a whole",
        "no friction, and none compensated",
        (
            Change(f"{_OF_PLANT}.enabled", value=False),
            Change(f"{_COMPENSATION}.enabled", value=False, unless=_NO_FRICTION | _NO_COMPENSATION),
        ),
    ),
    CauseKind(
        "inertia",
        "inertia not fed forward",
        "the motor's mass times the planned acceleration added to the force",
        (
            Change("{controller}.feedforward", value=True),
            Change("{controller}.model.{axis}.mass", copied="plant.{axis}.mass"),
        ),
    ),
    CauseKind(
        "offset",
        "amplifier offsets",
        "no current at zero command",
        (Change("plant.{axis}.amplifiers.offset", value=[0.0, 0.0, 0.0]),),
    ),
    CauseKind(
        "gain",
        "gain error",
        "amplifier gains of 1, and the controller's force constant that of the motor",
        (
            Change("plant.{axis}.amplifiers.gain", value=[1.0, 1.0, 1.0]),
            Change(
                "{controller}.model.{axis}.force_map.F_pk", copied="plant.{axis}.force_map.F_pk"
            ),
        ),
    ),
    CauseKind(
        "map",
        "force sharing and ripple",
        "the controller's force map made equal to the motor's, offset and harmonics included",
        (Change("{controller}.model.{axis}.force_map", copied="plant.{axis}.force_map"),),
    ),
    CauseKind(
        "bandwidth",
        "amplifier bandwidth",
        "currents that follow their command at once",
        (Change("plant.{axis}.amplifiers.bandwidth", value=None),),
    ),
    CauseKind(
        "delay",
        "delay",
        "no control period between measurement and command",
        (Change("{controller}.delay", value=0),),
    ),
    CauseKind(
        "encoder",
        "encoder counts",
        "an encoder without counts and subdivisional error",
        (
            Change("plant.{axis}.encoder.resolution", value=0.0),
            Change("plant.{axis}.encoder.sde_amplitude", value=0.0),
        ),
    ),
    CauseKind(
        "noise",
        "noise",
        "no noise, and no ripple of the amplifiers",
        (
            Change("plant.{axis}.encoder.noise", value=0.0),
            Change("plant.{axis}.amplifiers.noise", value=0.0),
            Change("plant.{axis}.amplifiers.ripple_amplitude", value=0.0),
            Change("load.noise", value=0.0),
        ),
    ),
    CauseKind(
        "resonance",
        "resonance",
        "a rigid machine",
        (Change("plant.{axis}.resonance.coupling", value=0.0),),
    ),
    CauseKind(
        "load",
        "external load",
        "no external load",
        (
            Change("load.{axis}", value=0.0),
            Change("load.steps.*.{axis}", value=0.0),
        ),
    ),
    CauseKind(
        "compensation",
        "friction compensation",
        "friction compensation switched off: below 0, it helps",
        (Change(f"{_COMPENSATION}.enabled", value=False, unless=_NO_COMPENSATION),),
    ),
)
"""Every cause that is looked for."""


MISSING = "missing"
"""Stands for a field that a scenario does not have, such as the peak force of a tabulated map."""


def look_up(tables: Any, path: str) -> Any:
    """Return the value at a dotted path; `MISSING` where there is none."""
    for key in path.split("."):
        if key not in tables:
            return MISSING
        tables = tables[key]
    return tables


def compensates(controller: ControllerConfig) -> bool:
    """Return whether friction is compensated."""
    return controller.compensation.law != "off" and controller.compensation.enabled


def changes_of(kind: CauseKind, scenario: Scenario, variant: str, axis: str) -> dict[str, Any]:
    """Return dotted path to value of a cause; what changes nothing is left out."""
    tables = scenario.model_dump(mode="json")

    def whole(path: str) -> str:
        return path.format(controller=f"variants.{variant}.controller", axis=axis)

    changes: dict[str, Any] = {}
    for change in kind.changes:
        if any(look_up(tables, whole(path)) == value for path, value in change.unless.items()):
            continue
        path, _, entry = whole(change.path).partition(".*.")
        now = look_up(tables, path)
        to = look_up(tables, whole(change.copied)) if change.copied else change.value
        if entry:
            to = [each | {entry: to} for each in now]
        if MISSING not in (now, to) and to != now:
            changes[path] = to
    return changes


def causes_table() -> list[dict[str, Any]]:
    """Return `CAUSES` in types of JSON."""
    return [
        kind._asdict() | {"changes": [change._asdict() for change in kind.changes]}
        for kind in CAUSES
    ]


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
    beside: Trial | None = None
    """The other change of a pair."""

    @property
    def size(self) -> float:
        """Size of the change: abs(log(factor)), `SWITCH` for a switch; the sum of a pair."""
        own = SWITCH if self.factor is None else abs(math.log(self.factor))
        return own + (0.0 if self.beside is None else self.beside.size)

    @property
    def label(self) -> str:
        """What is changed; of a pair with the factors."""
        if self.beside is None:
            return self.knob.label
        return " and ".join(
            each.knob.label + ("" if each.factor is None else f" \u00d7 {each.factor:.3g}")
            for each in (self, self.beside)
        )


def pair(one: Trial, other: Trial) -> Trial | None:
    """Return two changes together; None where both change the same."""
    if one.set.keys() & other.set.keys():
        return None
    return one._replace(set=one.set | other.set, beside=other)


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
