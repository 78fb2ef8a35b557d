"""What each effect of the plant costs on the circle, for the paper's law and the best shipped one.

Run with ``.venv/bin/python examples/effects.py``; prints the table of docs/own-effect.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.laws import LAWS
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


def errors(controller: dict[str, Any], changes: dict[str, Any]) -> list[float]:
    """Return the largest following errors on x and y, um; infinite where it diverges."""
    prepared = prepare(load_scenario("circle-resonant", controller | changes))
    recording = run(prepared)
    record = recording.variants["B"]
    if record.diverged is not None:
        return [np.inf, np.inf]
    window = slice(*prepared.reference.window)
    channels = (record.channel("following_error", axis)[window] for axis in "xy")
    return [1e6 * float(np.abs(each).max()) for each in channels]


def best_with(law: str) -> dict[str, Any]:
    """Return the best controller that ships with another law, as variant B."""
    return {
        "variants.B.controller": "lugre-reference-notch",
        "variants.B.controller.compensation.law": law,
    }


def shown(error: float) -> str:
    """Return an error in um, or that there is none."""
    return f"{error:.2f}" if np.isfinite(error) else "diverges"


def of_two_controllers() -> None:
    """Print what each effect adds with the paper's controller and with the best."""
    two = [{"variants.B.controller": name} for name in CONTROLLERS]
    none = [error for controller in two for error in errors(controller, {})]
    print("| effect | x K = 0 | y K = 0 | x best | y best |")
    print("|---|---|---|---|---|")
    print("| none: um | " + " | ".join(f"{each:.2f}" for each in none) + " |")
    for title, changes in ROWS:
        found = [error for controller in two for error in errors(controller, changes)]
        added = (f"{each - plain:+.2f}" for each, plain in zip(found, none, strict=True))
        print(f"| {title} | " + " | ".join(added) + " |")


def of_every_law() -> None:
    """Print the errors under each kind of friction with every law that ships."""
    kinds: dict[str, dict[str, Any]] = {
        "LuGre": {},
        "static Stribeck": effect("static-stribeck"),
        "Dahl": effect("dahl"),
        "Maxwell slip": effect("gms"),
        "LuGre, mu = 0.01": effect("lugre", mu=0.01),
    }
    print(f"| law | {' | '.join(kinds)} |")
    print("|---|" + "---|" * len(kinds))
    for law in LAWS:
        cells = (errors(best_with(law), changes) for changes in kinds.values())
        row = " | ".join(f"{shown(x)}, {shown(y)}" for x, y in cells)
        print(f"| `{law}` | {row} |")


of_two_controllers()
print()
of_every_law()
