"""Measurements whose friction is known to the test alone."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.telemetry.recording import Recording
from tests.simulated import Played, play

PERIOD = 0.5e-3
ENCODER_NOISE = 50e-9  # m rms
CURRENT_NOISE = 5e-3  # A rms
FORCE_NOISE = 0.02  # N rms

Array = NDArray[np.float64]


def sine(amplitude: float, frequency: float, cycles: int) -> dict[str, Any]:
    return {
        "kind": "sine",
        "amplitude": {"x": amplitude, "y": 0.0},
        "frequency": frequency,
        "cycles": cycles,
    }


SINES = (sine(0.03, 0.3, 2), sine(0.02, 1.0, 6), sine(0.01, 1.5, 6), sine(0.002, 2.0, 6))
STAIRS = tuple(
    {
        "kind": "trapezoid",
        "start": {"x": 0.0, "y": 0.0},
        "end": {"x": -0.03, "y": 0.0},
        "v_max": speed,
        "a_max": 1.0,
        "dwell": 0.2,
    }
    for speed in (0.02, 0.05, 0.12)
)
FRICTION = {
    "F_c": 0.31,
    "F_s": 3.1,
    "v_s": 0.039,
    "sigma_2": 12.0,
    "sigma_0": 101000.0,
    "sigma_1": 1050.0,
}
"""Of the motor; every number differs from the old model's."""

MASS = 5.6


@functools.cache
def simulated() -> Played:
    """Return the motor moved by sines and at steady speeds, 29 s."""
    return moved(FRICTION, MASS)


def moved(friction: Mapping[str, float], mass: float) -> Played:
    """Return a motor moved so."""
    changes = {f"plant.x.friction.{name}": value for name, value in friction.items()}
    trajectory = {"kind": "sequence", "parts": [*SINES, *STAIRS]}
    return play("circle", {"trajectory": trajectory, "plant.x.mass": mass, **changes})


def channels(seed: int = 0, played: Played | None = None) -> dict[str, Array]:
    """Return what a rig logs of it: time, position, currents, force command; with noise."""
    played, rng = played or simulated(), np.random.default_rng(seed)
    position = played.channel("A", "position_measured", "x")
    count = len(position)
    columns = {
        "time [s]": np.arange(count) * PERIOD,
        "x_act [mm]": 1e3 * (position + ENCODER_NOISE * rng.standard_normal(count)),
        "force_command_x [N]": played.channel("A", "force_command", "x")
        + FORCE_NOISE * rng.standard_normal(count),
    }
    for phase in "abc":
        current = played.channel("A", f"current_{phase}", "x")
        columns[f"i_{phase} [A]"] = current + CURRENT_NOISE * rng.standard_normal(count)
    return columns


def imported(folder: Path, columns: dict[str, Array], *mapping: str) -> str:
    """Write columns as CSV and import them; return the run."""
    path = folder / "rig.csv"
    text = ",".join(columns)
    np.savetxt(path, np.column_stack([*columns.values()]), "%.9g", ",", header=text, comments="")
    options = ImportOptions(mapping=mapping)
    document, run = import_file(path, options, library=library(), name="rig")
    assert run is not None, document.problems
    return run.id


def logged(speeds: Array, ways: tuple[float, ...]) -> dict[str, Array]:
    """Return position and force at steady speeds one after another, by the static curve."""
    rng = np.random.default_rng(7)
    count = round(0.5 / PERIOD)
    rise = np.linspace(0.0, 1.0, count // 2)
    steps = np.concatenate([[0.0], [way * v for v in speeds for way in ways]])
    parts = [
        np.concatenate([a + (b - a) * rise, np.full(count, b)])
        for a, b in itertools.pairwise(steps)
    ]
    velocity = np.concatenate(parts).astype(np.float64)
    position: Array = (np.cumsum(velocity) * PERIOD).astype(np.float64)
    f = FRICTION
    level = f["F_c"] + (f["F_s"] - f["F_c"]) * np.exp(-((velocity / f["v_s"]) ** 2))
    force: Array = np.sign(velocity) * level + f["sigma_2"] * velocity
    force += MASS * np.gradient(velocity, PERIOD)
    noise = rng.standard_normal((2, len(position)))
    return {
        "time [s]": (np.arange(len(position)) * PERIOD).astype(np.float64),
        "x_act [mm]": (1e3 * (position + ENCODER_NOISE * noise[0])).astype(np.float64),
        "force_command_x [N]": (force + FORCE_NOISE * noise[1]).astype(np.float64),
    }


SLOW_AND_FAST: dict[str, Any] = {
    "kind": "sequence",
    "parts": [
        {"kind": "sine", "amplitude": {"x": a, "y": a}, "frequency": f, "cycles": n}
        for a, f, n in ((0.01, 0.4, 1), (0.03, 0.8, 2))
    ],
}
"""Sines of both axes, with reversals: 6.9 s."""


def kept_of_drives(recording: Recording, scenario: Scenario, name: str) -> str:
    """Return a run of drives that is kept: a recording of a machine, and the scenario it followed.

    Parameters
    ----------
    recording : Recording
        Of any machine.
    scenario : Scenario
        As `motionlab.drive.motion.on_drives` returns it, with the motor that is assumed.
    name : str
        Of the run.
    """
    run = library().keep(prepare(scenario), recording, {}, name=name)
    library().index.put(run.model_copy(update={"kind": "drive"}))
    return run.id
