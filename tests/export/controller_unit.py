"""A controller's FMU beside its simulation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.export.controller_fmu import export_controller_fmu
from motionlab.export.vectors import simulated_vectors
from motionlab.simulation.prepare import prepare
from motionlab.timing import CONTROL_PERIOD
from tests.export.unit import Unit

INPUTS = ("position_reference", "velocity_reference", "acceleration_reference", "position_measured")
CURRENTS = [f"{axis}.current_command_{phase}" for axis in "xy" for phase in "abc"]


def names(inputs: tuple[str, ...]) -> list[str]:
    """Return variables of x, then of y."""
    return [f"{axis}.{name}" for axis in "xy" for name in inputs]


def current_error(
    path: Path, changes: dict[str, Any], seconds: float, inputs: tuple[str, ...] = INPUTS
) -> float:
    """Return the largest difference of the unit's currents from those of a simulation, A."""
    scenario = load_scenario("circle", changes)
    export_controller_fmu(scenario, "B", path)
    rows = simulated_vectors(prepare(scenario), "B", seconds)
    unit, worst = Unit(path), 0.0
    places, count = unit.references(names(inputs)), len(inputs)
    for row in rows:
        unit.fmu.setFloat64(places, row[:, :count].ravel().tolist())
        unit.step(CONTROL_PERIOD)
        expected: NDArray[np.float64] = row[:, count : count + 3].ravel()
        worst = max(worst, float(np.abs(unit.get(CURRENTS) - expected).max()))
    return worst
