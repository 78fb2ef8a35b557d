"""Fit the matched motor: two friction factors per axis to the two errors of the paper's Fig. 5.

Run with ``.venv/bin/python examples/fit_matched.py``; configs/motors/matched.toml holds its output.
Needs scipy, which ``make setup`` installs. Two parameters fitted to two numbers: this shows that
model error of a plausible size explains the paper's figures, and proves nothing.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import minimize

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

PAPER = {"x": (20.5e-6, 10.4e-6), "y": (17.4e-6, 11.6e-6)}  # off, on: Fig. 5
START = {"x": (1.041, 0.503), "y": (0.689, 0.425)}


def errors(axis: str, factors: np.ndarray) -> np.ndarray:
    """Return the largest following errors without and with compensation, m."""
    identified = load_scenario("circle").plant.model_dump()[axis]["friction"]
    scenario = load_scenario(
        "circle-matched",
        {
            f"plant.{axis}.friction.F_s": float(factors[0]) * identified["F_s"],
            f"plant.{axis}.friction.v_s": float(factors[1]) * identified["v_s"],
        },
    )
    prepared = prepare(scenario)
    recording = run(prepared)
    window = slice(*prepared.reference.window)
    return np.array(
        [
            np.abs(variant.channel("following_error", axis)[window]).max()
            for variant in recording.variants.values()
        ]
    )


def misfit(factors: np.ndarray, axis: str) -> float:
    """Return the squared distance to the paper's two errors, um^2; peaks move in encoder counts."""
    return float(np.sum((errors(axis, factors) - PAPER[axis]) ** 2)) * 1e12


for axis in PAPER:
    fit = minimize(misfit, START[axis], args=(axis,), method="Nelder-Mead", bounds=[(0.2, 5.0)] * 2)
    off, on = errors(axis, fit.x) * 1e6
    print(f"{axis}: F_s x {fit.x[0]:.4f}, v_s x {fit.x[1]:.4f} -> {off:.2f} um off, {on:.2f} um on")
