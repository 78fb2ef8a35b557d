"""The exported motor moves as the simulation's."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.export.plant import export_plant
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.layout import Inputs, state_row
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDTH
from motionlab.lanes.bank import TABLES
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.simulation import Simulation, sample_page
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD
from tests.export.compilers import compiler
from tests.export.unit import Unit

QUIET = {
    f"plant.{axis}.{field}": 0.0
    for axis in AXES
    for field in ("encoder.noise", "amplifiers.noise", "amplifiers.ripple_amplitude")
} | {"load.noise": 0.0}
EXACT_ENCODER = {f"plant.{axis}.encoder.resolution": 0.0 for axis in AXES}
SOON = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}
"""The circle soon at its full speed."""
TABLES_OF_MAPS = {
    f"plant.{axis}.force_map": {"kind": "table", "name": "new-design", "offset": 3e-5, "gain": 0.9}
    for axis in AXES
}
MOTORS: dict[str, dict[str, Any]] = {
    "nominal": SOON,
    "matched": {"plant": "matched"} | SOON,
    "resonant": {"plant": "matched-resonant", "load.x": 1.5, "load.y": -0.5} | SOON,
    "table": TABLES_OF_MAPS | SOON,
    "frictionless": {f"plant.{axis}.friction.enabled": False for axis in AXES} | SOON,
}
COMMANDS = [f"{axis}.current_command_{phase}" for axis in AXES for phase in "abc"]
STATES = {"position": "p", "velocity": "v", "bristle": "z"}
SAMPLES = ("friction", "thrust", "normal_force")


def quiet(changes: Mapping[str, Any]) -> Scenario:
    scenario = load_scenario("circle", dict(changes))
    return load_scenario(scenario.model_dump(exclude_none=True), QUIET)


def loaded(unit: Unit, scenario: Scenario) -> None:
    unit.set({"x.load_force": scenario.load.x, "y.load_force": scenario.load.y})


class Simulated:
    """Of the last variant of a scenario: states, single-precision samples and commands."""

    def __init__(self, prepared: Prepared, ticks: int) -> None:
        self.place = len(prepared.scenario.variants) - 1
        lanes = slice(2 * self.place, 2 * self.place + 2)
        simulation = Simulation(prepared)
        page = sample_page(self.place + 1)[:, :1].copy()
        acting = [state_row(f"acting.current_{phase}") for phase in "abc"]
        rows = [state_row(f"plant.{row}") for row in STATES.values()]
        columns = [Sample._fields.index(name) for name in SAMPLES]
        self.states = np.empty((ticks, len(STATES), 2))
        self.samples = np.empty((ticks, len(SAMPLES), 2))
        self.measured = np.empty((ticks, 2))
        self.commands = np.empty((ticks, 3, 2))
        for tick in range(ticks):
            self.states[tick] = simulation.snapshot().state[0][rows, lanes]
            simulation.advance(page)
            state = simulation.snapshot().state[0]
            self.samples[tick] = page[0, 0, columns, lanes]
            self.measured[tick] = state[state_row("memory.p_last"), lanes]
            self.commands[tick] = state[acting, lanes]


@pytest.mark.parametrize("motor", MOTORS)
def test_in_a_closed_loop_it_follows_the_simulation_over_the_whole_circle(
    motor: str, tmp_path: Path
) -> None:
    """The controller is the simulation's; noise 0, exact encoder."""
    compiler("gcc")
    prepared = prepare(quiet(MOTORS[motor] | EXACT_ENCODER))
    reference, ticks = prepared.reference, prepared.reference.ticks
    simulated = Simulated(prepared, ticks)
    export_plant(prepared.scenario, tmp_path / "motor.fmu")
    unit = Unit(tmp_path / "motor.fmu")
    names = [f"{axis}.{n}" for n in (*STATES, *SAMPLES, "position_measured") for axis in AXES]
    given, wanted = unit.references(COMMANDS), unit.references(names)
    found = np.empty((ticks, len(names)))

    with TABLES.lease():
        parameters = lane_parameters(prepared.scenario)[0]
    x, y = reference.position[0]
    state = initial_state(1, (float(x), float(y)))[0]
    inputs = np.zeros((1, len(Inputs._fields), 2))
    loaded(unit, prepared.scenario)
    asked = np.stack([reference.position, reference.velocity, reference.acceleration], axis=1)
    lanes = slice(2 * simulated.place, 2 * simulated.place + 2)
    acting = [state_row(f"acting.current_{phase}") for phase in "abc"]
    for tick in range(ticks):
        found[tick] = unit.fmu.getFloat64(wanted)
        inputs[0, :3] = asked[tick]
        p_meas = np.tile(found[tick, -2:], (1, WIDTH // 2))
        control_once(parameters, state, inputs, p_meas, laws_of(parameters))
        state[state_row("age")] += 1.0
        unit.fmu.setFloat64(given, state[acting, lanes].T.ravel().tolist())
        unit.fmu.doStep(tick * CONTROL_PERIOD, CONTROL_PERIOD)

    found = found.reshape(ticks, -1, 2)
    differences = np.abs(found[:, :3] - simulated.states).max(axis=(0, 2))
    assert np.abs(simulated.states[:, 1]).max() > 0.03  # m/s: it moved
    assert (differences <= [1e-15, 1e-12, 1e-14]).all(), differences
    assert agree(found[:, 3:6], simulated.samples)


def agree(found: np.ndarray, samples: np.ndarray) -> bool:
    """Tell whether forces are those that the simulation keeps in single precision."""
    scale = np.abs(samples).max(axis=0)
    return bool((np.abs(found - samples).max(axis=0) <= 1.2e-7 * scale + 1e-12).all())


def test_recorded_currents_give_the_motion_and_the_counts(tmp_path: Path) -> None:
    """Only a while: nothing corrects it, and an unstable equilibrium is never far."""
    compiler("gcc")
    scale_error = {f"plant.{axis}.encoder.sde_amplitude": 80e-9 for axis in AXES}
    prepared = prepare(quiet(MOTORS["resonant"] | scale_error))
    simulated = Simulated(prepared, ticks := 300)
    export_plant(prepared.scenario, tmp_path / "motor.fmu")
    unit = Unit(tmp_path / "motor.fmu")
    names = (*STATES, *SAMPLES, "position_measured")
    found = np.empty((ticks, len(names), 2))
    loaded(unit, prepared.scenario)
    for tick in range(ticks):
        found[tick] = np.reshape(unit.get([f"{a}.{n}" for n in names for a in AXES]), (-1, 2))
        unit.set(dict(zip(COMMANDS, simulated.commands[tick].T.ravel().tolist(), strict=True)))
        unit.step(CONTROL_PERIOD)
    differences = np.abs(found[:, :3] - simulated.states).max(axis=(0, 2))
    assert np.abs(simulated.states[:, 1]).max() > 1e-3
    assert (differences <= [1e-15, 1e-13, 1e-16]).all(), differences
    assert (found[:, -1] == simulated.measured).all()
    assert agree(found[:, 3:6], simulated.samples)
