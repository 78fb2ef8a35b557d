"""``motionlab export-controller -o FILE.fmu``: the controller as a co-simulation unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.export.controller_fmu import export_controller_fmu
from motionlab.export.plant import export_plant
from motionlab.export.vectors import simulated_vectors
from motionlab.laws import LAWS
from motionlab.simulation.prepare import prepare
from motionlab.timing import CONTROL_PERIOD
from tests.export.controller_unit import CURRENTS, INPUTS, current_error, names
from tests.export.unit import Unit

SHORT = {"trajectory.lead_in": 0.1}
TOLERANCE = 1e-12 * 10.0  # of full scale, A
CONTROLLER = "variants.B.controller"
TABLES = {f"{CONTROLLER}.model.{axis}.force_map": "new-design" for axis in "xy"}


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("unit") / "controller.fmu"
    words = ["export-controller", "circle", "-o", str(path), "--variant", "B"]
    change = f"{CONTROLLER}.compensation.law=residual-k"
    assert main([*words, "--set", change]) == 0
    return path


def test_it_keeps_the_standard(written: Path) -> None:
    assert validate_fmu(str(written)) == []


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {f"{CONTROLLER}.delay": 1, f"{CONTROLLER}.compensation.law": "residual-k"},
        {f"{CONTROLLER}.sharing.law": "force-per-ampere", **TABLES},
    ],
    ids=["as shipped", "with delay", "with tables"],
)
def test_its_currents_are_those_of_the_simulation(
    changes: dict[str, object], tmp_path: Path
) -> None:
    assert current_error(tmp_path / "unit.fmu", SHORT | changes, 1.0) <= TOLERANCE


@pytest.mark.parametrize("law", LAWS)
def test_every_law_has_a_unit(law: str, tmp_path: Path) -> None:
    changes = SHORT | {f"{CONTROLLER}.compensation.law": law}
    assert current_error(tmp_path / "unit.fmu", changes, 0.3) <= TOLERANCE


def test_it_closes_the_loop_around_the_plant(tmp_path: Path) -> None:
    scenario = load_scenario("circle", SHORT)
    export_controller_fmu(scenario, "B", tmp_path / "controller.fmu")
    export_plant(scenario, tmp_path / "plant.fmu")
    controller, plant = Unit(tmp_path / "controller.fmu"), Unit(tmp_path / "plant.fmu")
    rows = simulated_vectors(prepare(scenario), "B", 1.0)
    measured = [f"{axis}.position_measured" for axis in "xy"]
    worst = 0.0
    for row in rows:
        positions = plant.get(measured)
        worst = max(worst, float(np.abs(positions - row[:, 3]).max()))
        inputs = np.column_stack([row[:, :3], positions]).ravel()
        controller.set(dict(zip(names(INPUTS), inputs.tolist(), strict=True)))
        controller.step(CONTROL_PERIOD)
        plant.set(dict(zip(CURRENTS, controller.get(CURRENTS), strict=True)))
        plant.step(CONTROL_PERIOD)
    assert worst <= 2.1 * scenario.plant.x.encoder.resolution


def test_gains_and_parameters_of_the_law_are_tunable(written: Path) -> None:
    unit = Unit(written)
    gain = unit.variables["x.gain"]
    assert (gain.variability, gain.unit) == ("tunable", "1/s")
    assert unit.variables["y.k_p"].min == "0.0"
    start = {"x.position_reference": 1e-6}
    unit.set(start)
    unit.step(CONTROL_PERIOD)
    before = unit.get(["x.pd_force"])[0]
    unit.set({"x.k_p": 2.0 * float(unit.variables["x.k_p"].start)})
    unit.step(CONTROL_PERIOD)
    assert unit.get(["x.pd_force"])[0] == pytest.approx(2.0 * before)
    with pytest.raises(FMICallException):
        unit.set({"x.k_p": -1.0})
    assert "x.k_p = -1 is not from 0" in unit.messages[-1]


def test_it_has_no_test_vectors(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "controller.fmu"
    assert main(["export-controller", "circle", "-o", str(path), "--seconds", "1"]) == 2
    assert "--seconds" in capsys.readouterr().err
    assert not path.exists()


def test_a_file_in_capitals_is_one_file(tmp_path: Path) -> None:
    path = tmp_path / "CONTROLLER.FMU"
    assert main(["export-controller", "circle", "-o", str(path)]) == 0
    assert path.is_file()


def test_a_step_is_a_whole_number_of_periods(written: Path) -> None:
    unit = Unit(written)
    with pytest.raises(FMICallException):
        unit.step(0.7 * CONTROL_PERIOD)
    assert "multiple of the control period" in unit.messages[-1]
    unit.step(3.0 * CONTROL_PERIOD)
