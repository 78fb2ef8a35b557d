"""Whether Fig. 5 follows from friction that grows with the normal force, without fitted factors.

Friction is identified in uniform motions, where a part by normal force is in what is identified: so
the motor's own friction is taken smaller by the factor that leaves the force of a uniform motion as
it was. The circle accelerates besides, and there the normal force adds friction that no identified
model has. Run with ``.venv/bin/python examples/fig5_by_load.py``; the table is in docs/paper.md.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

PAPER = 20.5, 17.4, 10.4, 11.6
"""Largest following errors of Fig. 5, um: x and y without compensation, then with it."""

SLOW = 0.01  # m/s, of the uniform motion
PITCH = 0.0144  # m
SCALED = "F_s", "F_c", "sigma_0", "sigma_1", "sigma_2"


def friction_by_load(motor: str, mu: float, factor: dict[str, float]) -> dict[str, Any]:
    """Return changes: LuGre friction of a motor divided by a factor, and mu times normal force."""
    changes: dict[str, Any] = {"plant": motor}
    for axis, k in factor.items():
        own = getattr(load_scenario("circle", {"plant": motor}).plant, axis).friction
        values = {name: getattr(own, name) / k for name in SCALED}
        changes[f"plant.{axis}.effects"] = [{"effect": "lugre", "mu": mu, **values}]
        changes[f"plant.{axis}.friction.enabled"] = False
    return changes


def uniform_force(changes: dict[str, Any], axis: str) -> float:
    """Return the mean force of a slow uniform motion over a pole pitch, N."""
    motion = {
        "kind": "ramp",
        "velocity": {axis: SLOW},
        "lead_in": 0.2,
        "duration": PITCH / SLOW + 0.6,
    }
    recording = run(prepare(load_scenario("circle", changes | {"trajectory": motion})))
    force = recording.variants["A"].channel("force_realised", axis)
    return float(force[-round(PITCH / SLOW / 0.5e-3) :].mean())


def as_identified(motor: str, mu: float) -> dict[str, Any]:
    """Return changes with which uniform motions have the same force as without mu."""
    factor = {"x": 1.0, "y": 1.0}
    plain = {axis: uniform_force({"plant": motor}, axis) for axis in factor}
    for _ in range(5):
        for axis in factor:
            changes = friction_by_load(motor, mu, factor)
            factor[axis] *= uniform_force(changes, axis) / plain[axis]
    return friction_by_load(motor, mu, factor)


def errors(changes: dict[str, Any]) -> list[float]:
    """Return the four largest following errors of the circle, um, as in `PAPER`."""
    prepared = prepare(load_scenario("circle", changes))
    recording = run(prepared)
    window = slice(*prepared.reference.window)
    channels = (
        recording.variants[variant].channel("following_error", axis)[window]
        for variant in "AB"
        for axis in "xy"
    )
    return [1e6 * float(np.abs(each).max()) for each in channels]


print("| motor | mu | off x | off y | on x | on y | worst |")
print("|---|---|---|---|---|---|---|")
print(f"| paper | | {' | '.join(f'{each:.1f}' for each in PAPER)} | |")
for motor in ("nominal", "as-measured"):
    for mu in (0.0, 0.01, 0.02, 0.03, 0.04, 0.05):
        four = errors(as_identified(motor, mu) if mu else {"plant": motor})
        worst = max(abs(ours / theirs - 1.0) for ours, theirs in zip(four, PAPER, strict=True))
        cells = " | ".join(f"{each:.1f}" for each in four)
        print(f"| {motor} | {mu:g} | {cells} | {100.0 * worst:.0f} % |")
