"""A run of drives against its simulation: identified, and the simulated motor fitted to it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.library.motors import Motors
from motionlab.simulation.prepare import prepare
from motionlab.telemetry.channels import CHANNELS
from motionlab.telemetry.recording import Recording, VariantRecord
from tests.drive.link.lockstep import Lockstep
from tests.studies.identify.measured_runs import SLOW_AND_FAST, kept_of_drives

STRONGER = 1.1
"""Thrust of x over that of the map in control."""

MACHINE = {
    "x": {"F_c": 0.66, "F_s": 3.08, "v_s": 0.03, "sigma_2": 17.6, "sigma_0": 99000.0},
    "y": {"F_c": 1.2, "F_s": 3.4, "v_s": 0.03, "sigma_2": 20.0, "sigma_0": 90000.0},
}


class Told(NamedTuple):
    """What the command printed, and about which run."""

    run: str
    document: dict[str, Any]


@pytest.fixture(scope="module")
def told(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Told]:
    """The sines on drives in lockstep, identified, the motor saved as rig-7."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        run, out = measured(), tmp_path_factory.mktemp("out") / "found.json"
        arguments = ["identify", "--run", run, "--motor", "rig-7", "--out", str(out)]
        assert main(arguments) == 0
        yield Told(run, json.loads(out.read_text()))


def measured() -> str:
    """Return the kept run of the sines under PD control, on a machine that is not the nominal."""
    machine = {f"plant.{a}.friction.{k}": v for a, f in MACHINE.items() for k, v in f.items()}
    drives = Lockstep(changes=machine | {"plant.x.force_map.F_pk": STRONGER * 34.1})
    scenario = on_drives(load_scenario("circle", {"trajectory": SLOW_AND_FAST}), "A")
    prepared = prepare(scenario)
    drives.put(held_parameters(scenario))
    drives.arm()
    reference = prepared.reference
    motion = (reference.position, reference.velocity, reference.acceleration)
    drives.follow(np.stack(motion, axis=1))
    drives.cycle(reference.ticks)
    samples = drives.shared.samples[: reference.ticks, : len(CHANNELS)].transpose(1, 2, 0)
    shared = np.stack([column.T for column in (*motion, prepared.load)])
    recording = Recording(shared, {"A": VariantRecord(samples.copy())})
    return kept_of_drives(recording, scenario, "sines A on Virtual drive")


def true(axis: str) -> dict[str, float]:
    """Return what a controller with the nominal map sees of the machine."""
    scale = STRONGER if axis == "x" else 1.0
    nominal = getattr(load_scenario("circle").plant, axis)
    known = MACHINE[axis] | {"sigma_1": nominal.friction.sigma_1, "M": nominal.mass}
    return {name: v if name == "v_s" else v / scale for name, v in known.items()}


@pytest.mark.parametrize("axis", AXES)
def test_the_friction_of_the_machine_is_found(told: Told, axis: str) -> None:
    found = told.document["axes"][axis]
    assert found["record"]["force"] == "currents"
    assert found["record"]["lag"] == pytest.approx(0.25e-3, abs=30e-6)  # thrust amid two samples
    parameters = found["sliding"]["parameters"] | found["presliding"]["parameters"]
    for name, value in true(axis).items():
        parameter = parameters[name]
        assert parameter["true"] is None, "nobody knows it of a machine"
        assert parameter["value"] == pytest.approx(value, rel=0.005), name
        if name not in {"sigma_0", "sigma_1"}:
            assert parameter["low"] <= value <= parameter["high"], name


@pytest.mark.parametrize("axis", AXES)
def test_with_the_fitted_motor_the_simulation_is_the_run(told: Told, axis: str) -> None:
    residual = told.document["motor"]["origin"]["residual"][axis]
    assert residual["before"] > 1e-6
    assert residual["after"] < 30e-9  # a count of the encoder is 50 nm
    assert residual["after"] < residual["before"] / 50.0


def test_the_fitted_motor_is_saved_with_its_origin(told: Told) -> None:
    kept = Motors().get("rig-7")
    assert kept.origin is not None
    assert kept.origin.run == told.run
    fit = kept.origin.fits["x.mass"]
    assert fit.low < fit.value < fit.high < fit.before == 5.9
    plant = load_scenario("circle", {"plant": "rig-7"}).plant
    assert plant.name == "rig-7"
    assert plant.x.mass == fit.value
    assert (
        plant.y.friction.F_s == told.document["axes"]["y"]["sliding"]["parameters"]["F_s"]["value"]
    )
    assert f"({told.run})" in plant.description
