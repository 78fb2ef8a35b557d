"""What each effect of the plant costs on the circle, for the paper's law and the best shipped one.

Run with ``.venv/bin/python examples/effects.py``; prints the table of docs/own-effect.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

CONTROLLERS = "lugre-observer", "lugre-reference-notch"
"""The paper's law with K = 0, and the best controller that ships."""


def effect(name: str, **values: float) -> dict[str, Any]:
    """Return changes that give both axes an effect in place of the motor's own friction."""
    return {
        "plant.x.effects": [{"effect": name, **values}],
        "plant.y.effects": [{"effect": name, **values}],
        "plant.x.friction.enabled": name == "cogging",
        "plant.y.friction.enabled": name == "cogging",
    }


def jitter(rms: float) -> dict[str, Any]:
    """Return changes that let both encoders sample late or early."""
    return {f"plant.{axis}.encoder.jitter": rms for axis in "xy"}


ROWS: list[tuple[str, dict[str, Any]]] = [
    ("static Stribeck friction, tanh(v/0.2 mm/s)", effect("static-stribeck")),
    ("Maxwell slip, C = 1000 N/s", effect("gms")),
    ("Maxwell slip, C = 100 N/s", effect("gms", attraction=100.0)),
    ("Dahl friction at F_c", effect("dahl")),
    ("normal force, mu = 0.03", effect("lugre", mu=0.03)),
    ("normal force, mu = 0.01", effect("lugre", mu=0.01)),
    ("normal force, mu = 0.003", effect("lugre", mu=0.003)),
    ("20 % over 60 mm of stroke", effect("lugre", position_amplitude=0.2, position_period=0.06)),
    ("20 % over 10 mm of stroke", effect("lugre", position_amplitude=0.2, position_period=0.01)),
    ("cogging, 0.1 N over the pole pitch", effect("cogging")),
    ("sampling jitter 20 us rms", jitter(20e-6)),
    ("sampling jitter 5 us rms", jitter(5e-6)),
    ("sampling jitter 1 us rms", jitter(1e-6)),
]


def errors(controller: str, changes: dict[str, Any]) -> list[float]:
    """Return the largest following errors on x and y, um."""
    scenario = load_scenario("circle-resonant", {"variants.B.controller": controller} | changes)
    prepared = prepare(scenario)
    recording = run(prepared)
    window = slice(*prepared.reference.window)
    errors = (recording.variants["B"].channel("following_error", axis)[window] for axis in "xy")
    return [1e6 * float(np.abs(each).max()) for each in errors]


NONE = [error for controller in CONTROLLERS for error in errors(controller, {})]
print("| effect | x K = 0 | y K = 0 | x best | y best |")
print("|---|---|---|---|---|")
print("| none: um | " + " | ".join(f"{each:.2f}" for each in NONE) + " |")
for title, changes in ROWS:
    found = [error for controller in CONTROLLERS for error in errors(controller, changes)]
    added = (f"{each - none:+.2f}" for each, none in zip(found, NONE, strict=True))
    print(f"| {title} | " + " | ".join(added) + " |")
