"""Sensitivities: each slope is that of two runs, and what cannot be changed is named."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run as run_alone
from motionlab.studies.sensitivity.documents import SensitivityDocument, SensitivityRequest
from motionlab.studies.sensitivity.run import plan, run

SHORT = {"trajectory.laps": 1}
PEAK = "max_abs_following_error"


def sensitivity(**request: Any) -> SensitivityDocument:
    return run(plan(SensitivityRequest.model_validate({"set": SHORT} | request)))


def peak_alone(changes: dict[str, Any]) -> float:
    prepared = prepare(load_scenario("circle", SHORT | changes))
    return document(prepared, run_alone(prepared))["variants"]["B"]["axes"]["x"][PEAK]


def test_a_slope_is_that_of_two_runs() -> None:
    found = sensitivity(fields=["plant.x.friction", "variants.B.controller.x.k_p"], step=0.05)
    paths = [field.path for field in found.fields]
    assert paths[-1] == "variants.B.controller.x.k_p" and "plant.x.friction.F_s" in paths
    effect = found.variants["B"]["x"][PEAK]
    for path in ("plant.x.friction.F_s", "variants.B.controller.x.k_p"):
        index = paths.index(path)
        field = found.fields[index]
        assert field.low is not None and field.high is not None
        assert field.low == pytest.approx(0.95 * field.value)
        low, high = (peak_alone({path: value}) for value in (field.low, field.high))
        assert effect.low[index] == pytest.approx(low, rel=1e-6)
        slope = effect.slope[index]
        assert slope == pytest.approx((high - low) / (field.high - field.low), rel=1e-4)


def test_all_numbers_are_changed_but_zeros_and_whole_ones() -> None:
    planned = plan(SensitivityRequest.model_validate({"set": SHORT}))
    paths = {field.path for field in planned.fields}
    left = {each.path: each.why for each in planned.left}
    assert len(paths) > 100
    assert left["plant.x.encoder.noise"].startswith("is zero")
    assert paths.isdisjoint({"seed", "trajectory.laps", "divergence_error"})
    assert len(planned.cases) == 1 + sum(
        (field.low is not None) + (field.high is not None) for field in planned.fields
    )


def test_a_side_that_the_scenario_refuses_is_left_out() -> None:
    path = "plant.x.force_map.h_2"
    found = sensitivity(fields=[path], step=0.5, set=SHORT | {path: 0.24})
    (field,) = found.fields
    assert field.low == pytest.approx(0.12) and field.high is None
    effect = found.variants["B"]["x"][PEAK]
    assert effect.base is not None and effect.low[0] is not None
    assert effect.slope == [pytest.approx((effect.base - effect.low[0]) / 0.12, rel=1e-4)]


def test_margins_are_metrics_if_asked_for() -> None:
    found = sensitivity(fields=["variants.B.controller.x.k_d"], margins=True)
    (slope,) = found.variants["B"]["x"]["gain_margin"].slope
    assert slope is not None and slope < 0.0
    (of_y,) = found.variants["B"]["y"]["gain_margin"].slope
    assert of_y == 0.0


@pytest.mark.parametrize(
    ("request_", "said"),
    [
        ({"fields": ["plant.x.mas"]}, "is no number of the scenario"),
        ({"fields": ["plant.x.encoder.noise"]}, "has no number that could be changed"),
        ({"fields": ["seed"]}, "is no number of the scenario"),
    ],
)
def test_what_cannot_be_changed_is_refused(request_: dict[str, Any], said: str) -> None:
    with pytest.raises(ConfigError, match=said):
        sensitivity(**request_)


def test_the_command_names_what_matters_most(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "slopes.csv"
    words = ["sensitivity", "circle", "--set", "trajectory.laps=1", "--field", "plant.x"]
    assert main([*words, "--out", str(file)]) == 0
    out = capsys.readouterr().out
    assert out.index("plant.x.force_map.tau") < out.index("plant.x.mass")
    rows = {row["field"]: row for row in csv.DictReader(file.read_text().splitlines())}
    assert rows["plant.x.mass"]["unit"] == "kg"
    assert float(rows["plant.x.friction.F_s"][f"d(B.x.{PEAK})"]) != 0.0
