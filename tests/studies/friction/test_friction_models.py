"""Which friction model a record supports, against machines that the lab does not know."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import motionlab
from motionlab.cli import main
from motionlab.errors import ConfigError, ExperimentFailed
from motionlab.library.library import library
from motionlab.studies.friction.documents import FrictionModelsDocument, FrictionModelsRequest
from motionlab.studies.friction.record import plan
from motionlab.studies.friction.report import report
from motionlab.studies.friction.select import select
from tests.studies.friction import lab_motor
from tests.studies.friction.one_axis_machine import PERIOD, Machine, recorded, sines
from tests.studies.identify.measured_runs import imported

Array = NDArray[np.float64]
Record = dict[str, Array]

OWN = ("slide=", "push=", "preload=")
COLUMNS = {
    "position_column": "slide",
    "force_column": "push",
    "normal_force_column": "preload",
}
SINES = [(0.03, 0.3, 2), (0.015, 0.9, 3), (0.003, 0.4, 2), (2e-4, 0.6, 2), (4e-5, 1.2, 3)]
KINDS = ("coulomb", "stribeck", "lugre", "lugre-load", "gms")


@pytest.fixture(scope="module", autouse=True)
def _data(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(tmp_path_factory.mktemp("data")))
        yield


def machine(kind: str, **more: float) -> Machine:
    return Machine(kind, mu=0.03 if kind == "lugre-load" else 0.0)._replace(**more)


def judged(folder: Path, record: Record, *mapping: str, **request: Any) -> FrictionModelsDocument:
    run = imported(folder, record, *mapping)
    return select(plan(FrictionModelsRequest.model_validate({"run": run} | request)))


def own(folder: Path, record: Record, **request: Any) -> FrictionModelsDocument:
    return judged(folder, record, *OWN, **COLUMNS | request)


def numbers(result: FrictionModelsDocument, name: str) -> dict[str, float]:
    (model,) = (each for each in result.models if each.name == name)
    return {key: each.value for key, each in model.parameters.items()}


@pytest.mark.parametrize("kind", KINDS)
def test_each_friction_is_selected(tmp_path: Path, kind: str) -> None:
    result = own(tmp_path, recorded(machine(kind), sines(SINES)))
    assert result.selected == kind, result.reasons
    assert (result.reasons, result.notes, result.describes) == ([], [], True)
    assert numbers(result, kind)["M"] == pytest.approx(5.0, rel=0.02)
    assert numbers(result, kind)["F_c"] == pytest.approx(1.0, rel=0.06)
    errors = {model.name: model.error for model in result.models}
    assert errors[kind] < 0.05
    assert max(errors.values()) > 3.0 * errors[kind]


@pytest.mark.parametrize(
    ("parts", "words"),
    [
        ({"cogging": 0.3, "pitch": 9e-3}, "depends on the position with a period of 9 mm"),
        ({"tight": 0.4, "pitch": 45e-3}, "depends on the position:"),
        ({"cable": 0.4}, "depends on the position:"),
        ({"warming": 0.4}, "changes over time"),
        ({"hump": 0.4}, "depends on the velocity"),
        ({"skew": 0.4}, "differs between the directions"),
        ({"memory": 0.5}, "depends on the distance since a reversal"),
    ],
)
def test_what_no_model_has_is_noted(tmp_path: Path, parts: dict[str, float], words: str) -> None:
    result = own(tmp_path, recorded(machine("stribeck", **parts), sines(SINES)))
    assert result.selected == "stribeck", result.reasons
    note = result.notes[0]
    assert f"what Stribeck leaves over {words}" in note
    force, total = (float(word) for word in note.split(": ")[1].split()[:3:2])
    assert 0.8 * total < force <= total
    assert total == pytest.approx(result.models[1].error, rel=0.1)
    assert result.describes == ("hump" in parts)  # 4 % of the friction, the others more than 5 %
    verdict = (
        "Stribeck" if result.describes else "Stribeck; none of the models describes this friction"
    )
    assert report(result).splitlines()[0].endswith(f"reversals: {verdict}")


@pytest.mark.parametrize(("cogging", "notes", "describes"), [(0.005, 0, True), (0.05, 1, True)])
def test_a_small_rest_is_no_lack(
    tmp_path: Path, cogging: float, notes: int, describes: bool
) -> None:
    result = own(tmp_path, recorded(machine("lugre", cogging=cogging), sines(SINES)))
    assert (len(result.notes), result.describes) == (notes, describes)


def test_parameters_of_models_that_are_not_told_apart_are_marked(tmp_path: Path) -> None:
    result = own(tmp_path, recorded(machine("lugre", cogging=0.3), sines(SINES)))
    assert (result.selected, result.among) == (None, ["lugre", "gms"])
    text = report(result)
    marked = text.index("which model holds cannot be told:")
    for label, name in (("LuGre ", "sigma_1"), ("GMS ", "C ")):
        table = text.index(f"\n{label}", marked)
        assert table < text.index(f"\n{name}", table)
    assert text.count("sigma_0") == 2


def test_parameters_have_intervals_that_hold_the_truth(tmp_path: Path) -> None:
    result = own(tmp_path, recorded(machine("lugre", resonance=400.0), sines(SINES)))
    (model,) = (each for each in result.models if each.name == "lugre")
    true = {"F_c": 1.0, "F_s": 2.0, "v_s": 0.01, "sigma_0": 1.5e5, "sigma_2": 15.0}
    for name, value in true.items():
        estimate = model.parameters[name]
        assert estimate.low is not None
        half = 2.0 * (estimate.value - estimate.low)  # one record: twice the 95 % interval
        assert estimate.value == pytest.approx(value, abs=half, rel=0.005), name


def test_the_normal_force_of_the_labs_motor_comes_from_its_currents(tmp_path: Path) -> None:
    friction = {"F_c": 0.6, "F_s": 1.8, "v_s": 0.01, "sigma_0": 1.5e5, "sigma_1": 900.0}
    motor = friction | {"sigma_2": 12.0, "mu": 0.02, "M": 5.7}
    record = lab_motor.recorded("lugre-load", motor, SINES, seed=3)
    result = judged(tmp_path, record)
    assert (result.force, result.normal_force) == ("currents", "currents")
    assert result.selected == "lugre-load", result.reasons
    assert numbers(result, "lugre-load")["mu"] == pytest.approx(0.02, rel=0.05)


def one_way() -> Array:
    """Return a reference that moves one way at speeds that change."""
    t = np.arange(12_000) * PERIOD
    return 0.01 * t - 0.004 * np.cos(2.0 * np.pi * 0.3 * t)


def test_without_reversals_only_sliding_can_be_compared(tmp_path: Path) -> None:
    result = own(tmp_path, recorded(machine("lugre"), one_way()))
    assert result.selected is None
    assert {model.name for model in result.models} == {"coulomb", "stribeck"}
    assert {"lugre", "gms", "lugre-load"} <= set(result.among)
    assert any("reversals" in reason for reason in result.reasons)


def test_a_coarse_encoder_does_not_show_a_bristle(tmp_path: Path) -> None:
    record = recorded(machine("lugre", sigma_0=6e5, sigma_1=2000.0), sines(SINES[:3]))
    record["slide [mm]"] = 0.02 * np.rint(record["slide [mm]"] / 0.02)
    result = own(tmp_path, record)
    assert result.selected is None
    assert {"stribeck", "lugre", "gms"} <= set(result.among)
    assert "encoder" in result.reasons[0]


def test_one_speed_does_not_show_stiction(tmp_path: Path) -> None:
    t = np.arange(16_000) * PERIOD
    triangle = 0.02 * np.arcsin(np.sin(2.0 * np.pi * 0.5 * t)) * 2.0 / np.pi
    result = own(tmp_path, recorded(machine("coulomb"), triangle))
    assert result.selected is None
    assert set(result.among) >= {"coulomb", "stribeck"}
    assert any("stiction" in reason for reason in result.reasons)


@pytest.mark.parametrize("constant", [False, True])
def test_friction_by_load_needs_a_normal_force_that_changes(tmp_path: Path, constant: bool) -> None:
    record = recorded(machine("lugre"), sines(SINES))
    request: dict[str, Any] = {"position_column": "slide", "force_column": "push"}
    if constant:
        record["preload [N]"] = 0.0 * record["preload [N]"] + 20.0
        request["normal_force_column"] = "preload"
    result = judged(tmp_path, record, *OWN, **request)
    assert result.selected == "lugre"
    assert "lugre-load" not in {model.name for model in result.models}
    (note,) = result.notes
    assert ("hardly changes" if constant else "no normal force") in note


@pytest.mark.parametrize(("unit", "mass"), [("Nm", "kg m^2"), ("A", "A s^2/rad")])
def test_a_rotary_axis_by_torque_or_current(tmp_path: Path, unit: str, mass: str) -> None:
    linear = recorded(machine("lugre"), sines(SINES))
    record = {
        "time [s]": linear["time [s]"],
        "angle [deg]": np.rad2deg(1e-3 * linear["slide [mm]"] / 0.1),
        f"effort [{unit}]": 0.5 * linear["push [N]"],
    }
    mapping = ("angle=", "effort=")
    result = judged(tmp_path, record, *mapping, position_column="angle", force_column="effort")
    assert result.selected == "lugre", result.reasons
    (model,) = (each for each in result.models if each.name == "lugre")
    effort = "N m" if unit == "Nm" else "A"
    assert result.force_unit == effort
    units = {name: each.unit for name, each in model.parameters.items()}
    assert (units["M"], units["v_s"], units["F_c"]) == (mass, "rad/s", effort)
    assert model.parameters["v_s"].value == pytest.approx(0.1, rel=0.05)  # 10 mm/s at 100 mm
    assert model.parameters["F_c"].value == pytest.approx(0.5, rel=0.05)
    assert model.parameters["M"].value == pytest.approx(0.5 * 5.0 * 0.1, rel=0.02)
    assert model.parameters["sigma_2"].value == pytest.approx(0.5 * 15.0 * 0.1, rel=0.1)


def test_noise_is_explained_by_no_model(tmp_path: Path) -> None:
    record = recorded(machine("coulomb"), sines(SINES[:3]))
    rng = np.random.default_rng(1)
    kernel = np.ones(200) / 200.0
    record["push [N]"] += np.convolve(
        40.0 * rng.standard_normal(len(kernel) + len(record["push [N]"]) - 1), kernel, "valid"
    )
    result = own(tmp_path, record)
    assert result.selected is None
    assert any("no model explains" in reason for reason in result.reasons)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_constant_force_has_no_parameters(tmp_path: Path, noise: float) -> None:
    record = recorded(machine("lugre"), sines(SINES[:3]))
    rng = np.random.default_rng(0)
    record["push [N]"] = 3.0 + noise * rng.standard_normal(len(record["push [N]"]))
    if noise == 0.0:
        with pytest.raises(ExperimentFailed, match=r"the force is 3 N throughout"):
            own(tmp_path, record)
        return
    result = own(tmp_path, record)
    assert result.selected is None
    assert [reason.split(":")[0] for reason in result.reasons] == ["no model explains the force"]
    assert all(model.parameters == {} for model in result.models)
    assert "v_s" not in report(result)


@pytest.mark.parametrize("mass", [None, 5.0])
def test_a_force_of_the_other_sign_is_refused(tmp_path: Path, mass: float | None) -> None:
    record = recorded(machine("stribeck"), sines(SINES[:3]))
    record["push [N]"] = -record["push [N]"]
    with pytest.raises(ConfigError, match=r"sign is reversed.*\[-1 N\]") as error:
        own(tmp_path, record, mass=mass)
    (each,) = error.value.errors
    assert (each.loc, each.value) == ("force_column", "push")


def test_an_effect_is_compared_with_its_parameters(tmp_path: Path) -> None:
    """Elements that yield at one force, as Dahl has them, in a record of static friction."""
    record = recorded(machine("coulomb"), sines(SINES))
    result = own(tmp_path, record, effects=["dahl", "static-stribeck"])
    assert result.selected == "coulomb", result.reasons
    (stribeck,) = (each for each in result.models if each.name == "static-stribeck")
    assert stribeck.error < 1.1 * min(each.error for each in result.models)
    smoothing = stribeck.parameters["smoothing_velocity"]
    assert (smoothing.unit, stribeck.complexity) == ("m/s", 8)
    assert smoothing.value == pytest.approx(1e-4, rel=0.1)
    assert [each.complexity for each in result.models] == sorted(
        each.complexity for each in result.models
    )


@pytest.fixture(scope="module")
def run(_data: None, tmp_path_factory: pytest.TempPathFactory) -> str:
    record = recorded(machine("stribeck"), sines(SINES[:3]))
    record["warmth [K]"] = 0.0 * record["push [N]"]
    return imported(tmp_path_factory.mktemp("rig"), record, *OWN, "warmth=")


@pytest.mark.parametrize(
    ("request_", "loc"),
    [
        ({"run": "r-aaaaaaaaaaaa"}, "run"),
        ({"position_column": "nothing"}, "position_column"),
        ({"position_column": "push"}, "position_column"),
        ({"force_column": "warmth"}, "force_column"),
        ({"normal_force_column": "slide"}, "normal_force_column"),
        ({"variant": "B"}, "variant"),
        ({"start": 1e6}, "start"),
        ({"start": 1.0, "end": 1.01}, "end"),
        ({"bandwidth": 400.0}, "bandwidth"),
        ({"effects": ["nothing"]}, "effects.0"),
        ({"effects": ["dahl", "cogging"]}, "effects.1"),
        ({"effects": ["gms"]}, "effects.0"),
        ({"effects": ["dahl", "dahl"]}, "effects.1"),
    ],
)
def test_wrong_input_is_refused(run: str, request_: dict[str, Any], loc: str) -> None:
    request = FrictionModelsRequest.model_validate({"run": run} | COLUMNS | request_)
    with pytest.raises(ConfigError) as error:
        plan(request)
    assert [each.loc for each in error.value.errors] == [loc]


def test_columns_must_be_named_where_none_is_known(run: str) -> None:
    with pytest.raises(ConfigError) as error:
        plan(FrictionModelsRequest(run=run))
    assert error.value.errors[0].loc == "position_column"


@pytest.mark.parametrize(("samples", "refused"), [(1_000_000, False), (1_000_001, True)])
def test_as_many_samples_are_read_as_by_other_studies(
    run: str, samples: int, refused: bool
) -> None:
    identifier = "r-manysamples" + ("b" if refused else "a")
    kept = library().get(run).model_copy(update={"id": identifier, "ticks": samples})
    library().index.put(kept)
    request = FrictionModelsRequest.model_validate({"run": identifier} | COLUMNS)
    if not refused:
        plan(request)
        return
    with pytest.raises(ConfigError, match="choose a part by start and end") as error:
        plan(request)
    assert error.value.errors[0].bounds == {"maximum": 1000.0}


def test_the_command_and_python_say_the_same(run: str, capsys: pytest.CaptureFixture[str]) -> None:
    columns = [f"--{field.replace('_', '-')}={name}" for field, name in COLUMNS.items()]
    assert main(["friction-models", run, *columns]) == 0
    text = capsys.readouterr().out
    assert "Stribeck" in text
    assert "held-out error, N" in text
    assert main(["friction-models", run, *columns, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["selected"] == "stribeck"
    request: dict[str, Any] = {"run": run} | COLUMNS
    again = motionlab.study("friction-models", **request).document
    assert again.model_dump(mode="json") == document
