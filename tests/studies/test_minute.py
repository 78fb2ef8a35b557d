"""What another controller would have done in a recorded stretch."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motionlab
from motionlab.cli.main import main
from motionlab.config.force_map import ForceMapConfig
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.kernel.force_maps import force_model
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.minute.documents import MinuteRequest
from motionlab.studies.minute.motor_fit import Motor, fit_motor
from motionlab.studies.minute.predict import Prediction, inside, predict
from motionlab.studies.minute.recorded import MinutePlan, plan
from motionlab.telemetry.recording import Recording

CHANGES = {"plant.x.amplifiers.noise": 0.01, "plant.y.amplifiers.noise": 0.01}
STIFF = {"variants.B.controller": {"base": "lugre-reference"}}


def kept(changes: dict[str, Any], name: str = "circle-matched") -> tuple[str, Recording]:
    prepared = prepare(load_scenario(name, changes))
    recording = run(prepared)
    return library().keep(prepared, recording, {}, name="a minute").id, recording


@pytest.fixture(scope="module")
def minute() -> tuple[str, Recording]:
    """A run with a load that neither controller knows of."""
    steps = [
        {"time": 3.3, "x": 0.4, "y": -0.3},
        {"time": 3.35, "x": -0.4, "y": 0.3},
        {"time": 7.1, "x": 0.2, "y": 0.5},
    ]
    return kept(CHANGES | {"load": {"x": 0.2, "y": -0.1, "steps": steps}})


def planned(run_id: str, **more: Any) -> MinutePlan:
    return plan(MinuteRequest.model_validate({"run": run_id, "members": 8} | more))


@pytest.fixture(scope="module")
def observer(minute: tuple[str, Recording]) -> Prediction:
    return predict(planned(minute[0], members=24))


def error(recording: Recording, variant: str, axis: str) -> Any:
    return recording.variants[variant].channel("following_error", axis).astype(np.float64)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_another_law_does_what_was_predicted(
    minute: tuple[str, Recording], observer: Prediction, axis: str
) -> None:
    true = inside(error(minute[1], "B", axis))
    curves = {name: inside(observer.curves[f"{axis}.{name}"]) for name in ("low", "high")}
    held = np.mean((true >= curves["low"]) & (true <= curves["high"]))
    assert held > 0.9
    document = observer.document.axes[axis]
    assert document.max_predicted.low <= np.abs(true).max() <= document.max_predicted.high
    assert document.max_predicted.value == pytest.approx(np.abs(true).max(), rel=0.03)
    assert document.max_recorded == pytest.approx(
        np.abs(inside(error(minute[1], "A", axis))).max(), rel=1e-3
    )
    assert document.miss < 0.02 * document.rms_recorded


def test_a_stiff_law_that_the_run_never_had(minute: tuple[str, Recording]) -> None:
    """Its errors are a tenth of those that were recorded, and hang on the motor that is fitted."""
    run_id, recording = minute
    predicted = predict(planned(run_id, set=STIFF)).document
    scenario = load_scenario("circle-matched", CHANGES | STIFF)
    prepared = prepare(scenario)
    load = recording.references[3].T.astype(np.float64)
    true = run(replace(prepared, load=load))
    for axis in ("x", "y"):
        peak = np.abs(inside(error(true, "B", axis))).max()
        of_max = predicted.axes[axis].max_predicted
        assert peak < 0.2 * predicted.axes[axis].max_recorded
        assert 0.9 * of_max.low <= peak <= 1.1 * of_max.high
    assert predicted.other_label == "lugre-reference"


def test_a_fit_finds_mass_friction_and_amplifiers(minute: tuple[str, Recording]) -> None:
    stretch = planned(minute[0])
    controller = stretch.then.variants["A"].controller
    model = controller.model.y
    thrust = force_model(model.force_map, controller.sharing, controller.current_limit)
    fit = fit_motor(stretch.axes["y"], model, thrust, 0.5e-3 / 2)
    motor, true = Motor.of(fit.values), stretch.then.plant.y
    assert isinstance(model.force_map, ForceMapConfig)
    assert isinstance(true.force_map, ForceMapConfig)
    scale = model.force_map.F_pk / true.force_map.F_pk  # what the map takes for a newton
    assert motor.mass == pytest.approx(scale * true.mass, rel=0.05)
    assert motor.friction.v_s == pytest.approx(true.friction.v_s, rel=0.2)
    assert motor.friction.F_s == pytest.approx(scale * true.friction.F_s, rel=0.2)
    assert np.diff(motor.currents) == pytest.approx(np.diff(true.amplifiers.offset), abs=0.1)
    deviation = np.sqrt(np.diag(fit.covariance))
    assert (deviation > 0).all()
    assert np.isfinite(fit.disturbance(fit.values)).all()


def test_without_currents_the_motor_has_no_amplifiers() -> None:
    run_id, _ = kept({"plant.force": "ideal"})
    document = predict(planned(run_id)).document
    assert set(document.axes["x"].motor) == {
        *("M", "sigma_0", "sigma_1", "sigma_2", "F_c", "F_s", "v_s", "f_0")
    }


def test_the_same_request_has_the_same_answer(
    minute: tuple[str, Recording], observer: Prediction
) -> None:
    assert predict(planned(minute[0], members=24)).document == observer.document


def refusal(run_id: str, **more: Any) -> str:
    with pytest.raises(ConfigError) as raised:
        planned(run_id, **more)
    return str(raised.value)


@pytest.mark.parametrize(
    ("more", "why"),
    [
        ({"variant": "C"}, "variant: is no variant of the run; got 'C'; allowed one of A, B"),
        ({"other": "A"}, "other: is the controller that was recorded"),
        ({"start": 5.0, "end": 6.0}, "end: leaves too short a part; got 1.0; allowed >= 3 s"),
        ({"start": 99.0}, "start: lies after the end of the run; got 99.0"),
        ({"start": 5.0, "end": 4.0}, "end: is before the start; got 4.0; allowed > 5 s"),
        ({"set": {"variants.B.controller.learnt": True}}, "adds a learnt force"),
        ({"set": {"variants.B.controller.x.k_p": -1}}, "variants.B.controller.x.k_p"),
        ({"run": "r-aaaaaaaaaaaa"}, "no run 'r-aaaaaaaaaaaa'"),
    ],
)
def test_what_cannot_be_predicted_is_refused(
    minute: tuple[str, Recording], more: dict[str, Any], why: str
) -> None:
    run_id = more.pop("run", minute[0])
    assert why in refusal(run_id, **more)


def test_a_stretch_without_reversals_is_refused() -> None:
    line = {"kind": "sine", "amplitude": {"x": 0.02, "y": 0.0}, "frequency": 0.05, "cycles": 1}
    run_id, _ = kept({"trajectory": line})
    assert "reverses too seldom" in refusal(run_id, start=6.0, end=14.0)


def test_a_stretch_at_its_limit_is_refused() -> None:
    run_id, _ = kept({}, "trapezoid-y")  # its corners ask for more than the motor has
    assert "at their limit" in refusal(run_id)


def test_a_measurement_is_refused(
    monkeypatch: pytest.MonkeyPatch, minute: tuple[str, Recording]
) -> None:
    run = library().complete(minute[0])
    bare = run.model_copy(update={"scenario_document": None, "kind": "measurement"})
    monkeypatch.setattr(type(library()), "complete", lambda *_: bare)
    assert "a measurement without controllers" in refusal(minute[0])


def test_the_command(
    minute: tuple[str, Recording], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "minute.csv"
    options = ["--members", "8", "--from", "1", "--out", str(out)]
    assert main(["minute", minute[0], *options]) == 0
    text = capsys.readouterr().out
    assert "recorded under A, no compensation; predicted for B" in text
    with out.open() as file:
        rows = list(csv.reader(file))
    assert rows[0][:3] == ["time [s]", "x.recorded [m]", "x.again [m]"]
    assert float(rows[1][0]) == pytest.approx(1.0)
    assert main(["minute", minute[0], "--members", "8", "--json"]) == 0
    axes = json.loads(capsys.readouterr().out)["axes"]
    assert len(axes["x"]["errors"]["time"]) == len(axes["x"]["errors"]["low"]) <= 2000


def test_from_python(minute: tuple[str, Recording], tmp_path: Path) -> None:
    found = motionlab.study("minute", run=minute[0], set=STIFF, members=8)
    assert found.document.other_label == "lugre-reference"
    assert "predicted for B, lugre-reference" in str(found)
    rows = found.save(tmp_path / "minute.csv").read_text().splitlines()
    assert rows[0].startswith("time [s],x.recorded [m]")
    with pytest.raises(ConfigError, match="kind: is no study; got 'nothing'"):
        motionlab.study("nothing")
