"""Draw the figures of docs/physics.md and docs/compensation.md from runs of the simulation.

Run with ``.venv/bin/python docs/plots.py [FOLDER]``; writes physics-*.png beside this file, or into
the folder, and prints the numbers that the pages quote.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from numpy.typing import NDArray

mpl.use("agg")

from matplotlib import pyplot as plt

from motionlab.config.load import load_scenario
from motionlab.force_sharing.pole_pitch import forces_over, share_over
from motionlab.kernel.force_maps import force_model
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.telemetry.recording import Recording
from motionlab.timing import CONTROL_PERIOD

A, B, REFERENCE, FULL = "#D55E00", "#0072B2", "#777777", "#CC79A7"
PHASES = {"a": "#009E73", "b": "#E69F00", "c": "#56B4E9"}
UM = 1e6
MM = 1e3

STYLE: dict[str, Any] = {
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#dddddd",
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "figure.constrained_layout.use": True,
}


def window(recording: Recording, seconds: float) -> tuple[slice, NDArray[np.float64]]:
    """Return the last ticks of a run, and their times from the first of them on, s."""
    ticks = round(seconds / CONTROL_PERIOD)
    return slice(recording.ticks - ticks, recording.ticks), np.arange(ticks) * CONTROL_PERIOD


def record(changes: dict[str, Any]) -> Recording:
    """Return a run of the circle with changes."""
    return run(prepare(load_scenario("circle", changes)))


def friction() -> plt.Figure:
    """Draw the Stribeck curves and the loop of presliding."""
    scenario = load_scenario("circle")
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3))
    speed = np.linspace(0.0, 0.15, 600)
    for axis, colour, style in (("x", A, "-"), ("y", B, "--")):
        f = getattr(scenario.plant, axis).friction
        force = f.F_c + (f.F_s - f.F_c) * np.exp(-((speed / f.v_s) ** 2)) + f.sigma_2 * speed
        left.plot(speed * MM, force, style, color=colour, label=axis)
    left.set(xlabel="velocity, mm/s", ylabel="friction, N", title="Sliding (Stribeck curve)")
    left.set_ylim(bottom=0.0)
    left.legend()
    trajectory = {"kind": "sine", "amplitude": {"x": 20e-6, "y": 20e-6}, "frequency": 0.5}
    recording = record({"trajectory": trajectory, "variants.A.controller.x.k_p": 3.2e6})
    here, _ = window(recording, 2.0)
    sample = recording.variants["A"]
    position = sample.channel("position", "x")[here]
    right.plot(position * UM, sample.channel("friction", "x")[here], color=A)
    right.set(xlabel="position, um", ylabel="friction, N", title="Presliding, x, 20 um at 0.5 Hz")
    return figure


def thrust() -> plt.Figure:
    """Draw the thrust of each phase over a pole pitch, what force sharing reaches, and currents."""
    controller = load_scenario("circle").variants["B"].controller
    m = controller.model.x.force_map
    model = force_model(m, controller.sharing, m.I_pk)
    position = np.linspace(0.0, m.tau, 721)
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3))
    for k, (phase, colour) in enumerate(PHASES.items()):
        current = np.where(np.arange(3)[:, None] == k, m.I_pk, np.zeros(len(position)))
        force = forces_over(model.map, position=position, current=current).thrust
        left.plot(position * MM, force, color=colour, label=f"phase {phase}")
    left.set(xlabel="position, mm", ylabel="thrust at 10 A, N", title="One phase at a time")
    left.set_ylim(-38.0, 52.0)
    left.legend(loc="upper center", ncols=3)
    for command, style in ((20.0, "-"), (27.3, "--"), (40.0, ":")):
        force = share_over(model, position=position, force=command).force
        right.plot(position * MM, force, style, color=B, label=f"{command:g} N commanded")
        print(f"{command:g} N commanded: {force.min():.2f} to {force.max():.2f} N")
    right.set(xlabel="position, mm", ylabel="thrust, N", title="Shared, currents within 10 A")
    right.set_ylim(0.0, 42.0)
    right.legend(loc="lower right")
    return figure


def circle() -> plt.Figure:
    """Draw the following error over a lap under three laws, on two motors."""
    figure, panels = plt.subplots(1, 2, figsize=(8, 3), sharey=True)
    both = {"feedforward": True, "disturbance_observer.enabled": True}
    for panel, plant in zip(panels, ("nominal", "matched"), strict=True):
        observer = record({"plant": plant})
        more = {f"variants.B.controller.{key}": value for key, value in both.items()}
        full = record({"plant": plant} | more)
        here, time = window(observer, 3.0)
        for recording, variant, colour, style, label in (
            (observer, "A", A, "-", "off"),
            (observer, "B", B, "--", "LuGre observer"),
            (full, "B", FULL, "-", "and feedforward, disturbance observer"),
        ):
            error = recording.variants[variant].channel("following_error", "x")[here] * UM
            panel.plot(time, error, style, color=colour, label=label)
            print(f"{plant}, {label}: largest {np.abs(error).max():.3g} um on x")
        panel.set(xlabel="time in the lap, s", title=f"{plant} motor")
    panels[0].set_ylabel("following error on x, um")
    panels[0].legend(loc="lower left", fontsize=7)
    return figure


def published_k() -> plt.Figure:
    """Draw the denominator of (25) along a sound run, and what K as published makes of the loop."""
    scenario = load_scenario("circle")
    quiet = record({})
    broken = record({"variants.B.controller.compensation.law": "published-k"})
    here, time = window(quiet, 3.0)
    f = scenario.plant.x.friction
    k_d = scenario.variants["A"].controller.x.k_d
    sample = quiet.variants["B"]
    u, error, v = (
        sample.channel(name, "x")[here].astype(np.float64)
        for name in ("pd_force", "following_error", "velocity_measured")
    )
    steady = f.F_c + (f.F_s - f.F_c) * np.exp(-((v / f.v_s) ** 2))
    rate = f.sigma_0 * np.abs(v) / steady
    denominator = f.sigma_1 * u + error * k_d * (f.sigma_1 * rate - f.sigma_0)
    crossings = np.flatnonzero(np.diff(np.sign(denominator)) != 0)
    print(f"denominator of (25): {len(crossings) / 3.0:.1f} changes of sign a second")
    figure, (left, right) = plt.subplots(1, 2, figsize=(8, 3))
    left.plot(time, denominator, color=A)
    left.plot(time[crossings], np.zeros(len(crossings)), "o", color="black", markersize=3)
    left.set(
        xlabel="time in the lap, s",
        ylabel="denominator of (25), N^2 s/m",
        title="LuGre observer, K = 0, x: it crosses zero",
    )
    left.set_yscale("symlog", linthresh=100.0)
    for variant, colour, style, label in (("B", B, "-", "K as published"), ("A", A, "-", "off")):
        errors = broken.variants[variant].channel("following_error", "x")[here] * UM
        right.plot(time, errors, style, color=colour, label=label, linewidth=0.7)
        print(f"{label}: largest {np.abs(errors).max():.3g} um on x")
    right.set(
        xlabel="time in the lap, s", ylabel="following error on x, um", title="What K does to it"
    )
    right.legend(loc="lower left")
    return figure


def main() -> None:
    """Write every figure."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    with mpl.rc_context(STYLE):
        for draw in (friction, thrust, circle, published_k):
            figure = draw()
            name = draw.__name__.replace("_", "-")
            figure.savefig(folder / f"physics-{name}.png", dpi=150)
            plt.close(figure)


if __name__ == "__main__":
    main()
