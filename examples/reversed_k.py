"""Compare K of eq. (25) with its sign reversed against K = 0, on circles.

Run with ``.venv/bin/python examples/reversed_k.py``; prints the table of docs/compensation.md:
largest following error in um, x / y, of each reading of the denominator's k_d.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

LAWS: dict[str, dict[str, Any]] = {
    "off": {"law": "off"},
    "K = 0": {"law": "lugre-observer"},
    "(25), sign reversed": {"law": "reversed-k", "k_d_share": 1.0},
    "the same, e k_d/1000": {"law": "reversed-k", "k_d_share": 1e-3},
    "`reversed-k`": {"law": "reversed-k"},
}
RHOMBUS = {"x": {"k_p": 400e3, "k_d": 1480.0}, "y": {"k_p": 501.6e3, "k_d": 1570.0}}
PITCH, PLACES = 7.2e-3, 8
Errors = dict[str, tuple[float, float]]


def largest_errors(
    plant: str, changes: dict[str, Any] | None = None, gains: dict[str, Any] | None = None
) -> Errors:
    """Return the largest following errors of every law on the circle, um: x, y."""
    variants = {
        letter: {"controller": {"base": "pd", "compensation": law} | (gains or {})}
        for letter, law in zip("ABCDE", LAWS.values(), strict=True)
    }
    scenario = load_scenario({"base": "circle", "plant": plant, "variants": variants}, changes)
    prepared = prepare(scenario)
    records = run(prepared).variants
    window = slice(*prepared.reference.window)
    errors = {}
    for letter, name in zip("ABCDE", LAWS, strict=True):
        x, y = (records[letter].channel("following_error", axis)[window] for axis in "xy")
        errors[name] = (float(np.abs(x).max()) * 1e6, float(np.abs(y).max()) * 1e6)
    return errors


def worst_over_the_pitch(plant: str) -> Errors:
    """Return the largest of `largest_errors` over places of the circle's centre, um."""
    places = [k * PITCH / PLACES for k in range(PLACES)]
    found = [
        largest_errors(plant, {"trajectory.center.x": p, "trajectory.center.y": p}) for p in places
    ]
    return {
        name: (max(each[name][0] for each in found), max(each[name][1] for each in found))
        for name in LAWS
    }


def _row(title: str, plant: str, errors: Errors) -> str:
    cells = [f"{x:.3g} / {y:.3g}" for x, y in errors.values()]
    return f"| {title}, {plant} | " + " | ".join(cells) + " |"


if __name__ == "__main__":
    print("| circle | " + " | ".join(LAWS) + " |")
    print("|---|" + "---|" * len(LAWS))
    for motor in ("nominal", "matched"):
        print(_row("1/3 Hz", motor, largest_errors(motor)))
        print(_row(f"worst of {PLACES} places in the pitch", motor, worst_over_the_pitch(motor)))
        for hertz in (0.1, 0.5):
            frequency = {"trajectory.frequency": hertz}
            print(_row(f"{hertz} Hz", motor, largest_errors(motor, frequency)))
        print(_row("1/3 Hz, the rhombus's gains", motor, largest_errors(motor, None, RHOMBUS)))
        slow = largest_errors(motor, {"trajectory.frequency": 0.1}, RHOMBUS)
        print(_row("0.1 Hz, the rhombus's gains", motor, slow))
