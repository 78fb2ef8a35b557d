"""Compare controllers on every trajectory of the paper, on three motors.

Run with ``.venv/bin/python examples/compare_controllers.py``; prints the tables of
docs/compensation.md: largest following error, and where the motion has holds the largest of their
last fifth, in um. All but the best controller have the gains of Table 1 for the trajectory. Last,
the margins on the circle while it slides at four Stribeck velocities, in brackets the least over
velocities from half of one to four, and those at standstill; ``--margins`` prints these alone.
"""

from __future__ import annotations

import math
import sys
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.loop.family import SPEEDS
from motionlab.loop.linearise import Loop, linearise
from motionlab.loop.margins import margins
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

PLANTS = ("nominal", "matched", "matched-resonant")
TRAJECTORIES = (
    ("circle", "xy"),
    ("rhombus", "xy"),
    ("pentagram", "xy"),
    ("stair-x-500nm", "x"),
    ("stair-y-500nm", "y"),
    ("stair-y-50mm", "y"),
    ("trapezoid-y", "y"),
)
LETTERS = "ABCDEFG"
BEST = "lugre-reference-notch"
GAINS = {"x": {"k_p": 200300.0, "k_d": 1530.0}, "y": {"k_p": 280500.0, "k_d": 1080.0}}
CONTROLLERS = {
    "off": "off",
    "lugre-observer": "the paper's observer, K = 0",
    "published-k": "K as published",
    "reversed-k": "K reversed",
    "lugre-full": "lugre-full",
    "lugre-reference": "lugre-reference",
    BEST: BEST,
}
OTHER_LAWS = {
    "residual-k": "K from the explicit residual",
    "canudas-de-wit": "Canudas de Wit, K = 300/s e",
}
"""Of whose loops the margins alone are printed."""


def compare(scenario: str, plant: str) -> dict[str, dict[str, Any]]:
    """Return the metrics per axis of every controller on one trajectory; null where it diverges."""
    tables = load_scenario(scenario).model_dump(mode="json")
    gains = {axis: tables["variants"]["A"]["controller"][axis] for axis in "xy"}
    variants = {}
    for letter, name in zip(LETTERS, CONTROLLERS, strict=True):
        base = "pd" if name == "off" else name
        own = {} if name == BEST else gains
        variants[letter] = {"label": name, "controller": {"base": base} | own}
    prepared = prepare(load_scenario({"base": scenario, "plant": plant, "variants": variants}))
    (segment,) = document(prepared, run(prepared))["segments"]
    return {
        name: segment["variants"][letter]["axes"]
        for letter, name in zip(LETTERS, CONTROLLERS, strict=True)
    }


def cell(name: str, metrics: dict[str, float | None]) -> str:
    """Return the largest error, and that of the holds where there are any, um."""
    largest, holds = metrics["max_abs_following_error"], metrics["steady_state_error"]
    if largest is None:
        return "diverges"
    if name == "published-k":
        return f"{largest * 1e6:.1g}"  # chaotic: its order of magnitude only
    text = f"{largest * 1e6:.3g}"
    return text if holds is None else f"{text} ({holds * 1e6:.2f})"


def loops(plant: str, controller: str, axis: str, speeds: tuple[float, ...]) -> list[Loop]:
    """Return the loops on the circle at velocities in Stribeck velocities; none for a quotient."""
    base = "pd" if controller == "off" else controller
    own = {} if controller == BEST else GAINS
    scenario = load_scenario(
        {"base": "circle", "plant": plant, "variants": {"A": {"controller": {"base": base} | own}}}
    )
    v_s = getattr(scenario.plant, axis).friction.v_s
    try:
        return [linearise(scenario, "A", axis, v=factor * v_s) for factor in speeds]
    except ConfigError:
        return []


def figures(loop: Loop) -> tuple[float, float]:
    """Return gain margin, up or down, dB, and phase margin, degrees."""
    found = margins(loop.open)
    factor = min(found.gain_margin or math.inf, 1.0 / (found.gain_reduction or 1e-9))
    return 20.0 * math.log10(factor), math.degrees(found.phase_margin or math.pi)


def sliding(plant: str, controller: str, axis: str) -> str:
    """Return the margins at four Stribeck velocities, and the least."""
    known = loops(plant, controller, axis, SPEEDS)
    if not known:
        return "none: K is a quotient"
    if not known[-1].stable:
        return "unstable"
    decibels, phase = zip(*map(figures, known), strict=True)
    least = f"{min(decibels):.1f} dB, {min(phase):.0f} deg"
    within = least if all(each.stable for each in known) else "unstable"
    return f"{decibels[-1]:.1f} dB, {phase[-1]:.0f} deg ({within})"


def at_rest(plant: str, controller: str, axis: str) -> str:
    """Return the margins of the axis that is stuck."""
    known = loops(plant, controller, axis, (0.0,))
    if not known:
        return "none: K is a quotient"
    if not known[0].stable:
        return "unstable"
    decibels, phase = figures(known[0])
    return f"{decibels:.1f} dB, {phase:.0f} deg".replace(", 180 deg", "")


def print_margins() -> None:
    """Print the two tables of margins."""
    for head, cell_of in (("sliding", sliding), ("at standstill", at_rest)):
        places = [(plant, axis) for plant in PLANTS[1:] for axis in "xy"]
        print(f"\n| {head} | " + " | ".join(f"{axis} {plant}" for plant, axis in places) + " |")
        print("|---|---|---|---|---|")
        for name, title in (CONTROLLERS | OTHER_LAWS).items():
            cells = [cell_of(plant, name, axis) for plant, axis in places]
            print(f"| {title} | " + " | ".join(cells) + " |")


if __name__ == "__main__":
    for plant in () if "--margins" in sys.argv else PLANTS:
        print(f"\n| on `{plant}` | " + " | ".join(CONTROLLERS.values()) + " |")
        print("|---|" + "---|" * len(CONTROLLERS))
        for scenario, axes in TRAJECTORIES:
            found = compare(scenario, plant)
            for axis in axes:
                cells = [cell(name, found[name][axis]) for name in CONTROLLERS]
                print(f"| {scenario}, {axis} | " + " | ".join(cells) + " |")
    print_margins()
