"""``motionlab fields``, ``laws`` and ``new``: what a scenario can say, and a file to say it in."""

from __future__ import annotations

import json
import os
import re
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.controller import CompensationConfig
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.template import template
from motionlab.config.trajectory import KINDS, example
from motionlab.laws import LAWS
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.paths import ROOT


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> str:
    assert main(arguments) == 0
    return capsys.readouterr().out


def value_at(tables: Any, path: str) -> Any:
    for key in path.split("."):
        tables = tables[int(key)] if isinstance(tables, list) else tables[key]
    return tables


@pytest.mark.parametrize("name", names("scenarios"))
def test_every_field_of_a_scenario_is_listed_with_its_value(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    listed = json.loads(printed(capsys, "fields", "--scenario", name, "--json"))
    tables = load_scenario(name).model_dump(mode="json")
    assert len(listed) > 100
    for field in listed:
        assert value_at(tables, field["path"]) == field["value"]


def test_a_field_has_unit_range_and_meaning(capsys: pytest.CaptureFixture[str]) -> None:
    (line,) = printed(capsys, "fields", "plant.x.mass").splitlines()[1:]
    assert line.split(maxsplit=8) == [
        *["plant.x.mass", "5.9", "kg", ">=", "0.001", "and", "<=", "1000"],
        "Moving mass",
    ]
    meant = printed(capsys, "fields", "coulomb").splitlines()[1:]
    assert len(meant) == 6
    assert all(".friction.F_c " in line for line in meant)
    two = printed(capsys, "fields", "variants.*.controller.x.k_p", "--set", "plant.x.mass=6")
    assert [line.split()[1] for line in two.splitlines()[1:]] == ["200300", "200300"]


def test_every_law_is_listed_with_its_parameters(capsys: pytest.CaptureFixture[str]) -> None:
    laws = json.loads(printed(capsys, "laws", "--json"))
    assert {law["name"] for law in laws} == set(LAWS)
    text = printed(capsys, "laws")
    for law in laws:
        assert law["description"] in text
        assert [each["path"] for each in law["parameters"]] == [
            each.name for each in LAWS[law["name"]].parameters
        ]


@pytest.mark.parametrize("law", [law for law in LAWS if law != "off"])
def test_a_law_uses_its_parameters_and_no_other(law: str) -> None:
    """Another value of a parameter changes the run where the law is said to use it, only there."""
    other = {"velocity": "reference", "bristle_limit": 0.01, "gain": 30.0} | {
        "residual_bandwidth": 90.0,
        "regularisation": 3.0,
        "k_d_share": 0.5,
        "attraction": 100.0,
        "smoothing_velocity": 1e-3,
    }
    assert set(other) == set(CompensationConfig.model_fields) - {"law", "enabled"}
    place = "variants.B.controller.compensation"
    short = {"trajectory.laps": 1, "trajectory.lead_in": 0.1, "trajectory.frequency": 1.0}
    short |= {"thrust_reserve": 0.0}  # fast enough for every law to show

    def error(**changes: Any) -> bytes:
        changed = {f"{place}.{name}": value for name, value in changes.items()}
        recording = run(prepare(load_scenario("circle", {**short, f"{place}.law": law, **changed})))
        return np.ascontiguousarray(recording.variants["B"].channel("thrust", "x")).tobytes()

    plain = error()
    used = {name for name, value in other.items() if error(**{name: value}) != plain}
    assert used == {each.name for each in LAWS[law].parameters}


@pytest.mark.parametrize("base", names("scenarios"))
def test_a_new_scenario_is_its_base(
    base: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "mine.toml"
    assert main(["new", str(file), "--base", base]) == 0
    assert capsys.readouterr().err.startswith(f"motionlab: wrote {file}, ")
    own = {"name": "mine", "title": f"My {base}"}
    expected = load_scenario(base).model_copy(update=own)
    assert load_scenario(file) == expected
    assert "#:schema" not in file.read_text()  # its path would hold here alone
    # Without their #, all fields say what the base says.
    text = re.sub(r"^# (?=[a-z_.]+\w* = )", "", file.read_text(), flags=re.MULTILINE)
    text = re.sub(r"^# ((?:[\w.]+) = )", r"\1", text, flags=re.MULTILINE)
    assert len(tomllib.loads(text)["trajectory"]) >= 1
    file.write_text(text)
    assert load_scenario(file).model_dump(exclude={"variants"}) == expected.model_dump(
        exclude={"variants"}
    )


def test_a_new_scenario_in_a_checkout_names_its_schema() -> None:
    folder = ROOT / "examples" / "mine"  # need not be there
    schema = re.match(r"#:schema (.*)\n", template(load_scenario("circle"), folder))
    assert schema is not None
    assert not Path(schema[1]).is_absolute()
    path = Path(os.path.normpath(folder / schema[1]))
    assert json.loads(path.read_text())["type"] == "object"


@pytest.mark.parametrize("kind", KINDS)
def test_a_kind_of_trajectory_has_its_fields_and_an_example(
    kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    text = printed(capsys, "fields", "--kind", kind)
    motion = tomllib.loads(text.splitlines()[-1])["trajectory"]
    assert motion["kind"] == kind
    assert load_scenario("circle", {"trajectory": motion}).trajectory == example(kind)
    assert prepare(load_scenario("circle", {"trajectory": motion})).reference.ticks > 1
    for name in KINDS[kind].model_fields:
        assert f"trajectory.{name}" in text


def test_an_unknown_kind_is_refused_with_those_that_are(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fields", "--kind", "waypoint"]) == 2
    assert "did you mean 'waypoints'" in capsys.readouterr().err
