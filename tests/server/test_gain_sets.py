"""Gain sets: saved with what they achieve, listed, exported, deleted, refused."""

from __future__ import annotations

import tomllib
from pathlib import Path

import httpx
import pytest

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

K_P = "variants.B.controller.x.k_p"
SET = {"scenario": "circle", "values": {K_P: 312000.0}, "note": "stiffer"}


@pytest.fixture
def sets(client: httpx.Client) -> httpx.Client:
    for each in client.get("/api/v1/gain-sets").json():  # also those of other tests
        client.delete(f"/api/v1/gain-sets/{each['name']}")
    return client


def test_a_set_is_saved_with_the_metrics_of_the_scenario_that_it_makes(sets: httpx.Client) -> None:
    saved = sets.put("/api/v1/gain-sets/stiff 2", json=SET)
    assert saved.status_code == 200, saved.text
    prepared = prepare(load_scenario("circle", {K_P: 312000.0}))
    axes = document(prepared, run(prepared))["variants"]["B"]["axes"]
    expected = axes["x"]["max_abs_following_error"]
    assert saved.json()["metrics"]["B.x.max_abs_following_error"] == expected
    loop = sets.post("/api/v1/loop", json={"scenario": "circle", "set": SET["values"]}).json()
    found = saved.json()["margins"]["B.x"]["phase_margin"]
    assert found == loop["variants"]["B"]["axes"]["x"]["phase_margin"]
    assert [each["name"] for each in sets.get("/api/v1/gain-sets").json()] == ["stiff 2"]


def test_its_file_is_a_scenario_with_the_same_numbers(sets: httpx.Client, tmp_path: Path) -> None:
    saved = sets.put("/api/v1/gain-sets/stiff", json=SET).json()
    answer = sets.get("/api/v1/gain-sets/stiff/scenario.toml")
    assert tomllib.loads(answer.text)["base"] == "circle"
    path = tmp_path / "stiff.toml"
    path.write_text(answer.text)
    prepared = prepare(load_scenario(path))
    axes = document(prepared, run(prepared))["variants"]["B"]["axes"]
    expected = saved["metrics"]["B.y.max_abs_following_error"]
    assert axes["y"]["max_abs_following_error"] == expected


def test_a_set_of_the_same_name_is_replaced(sets: httpx.Client) -> None:
    sets.put("/api/v1/gain-sets/stiff", json=SET)
    sets.put("/api/v1/gain-sets/stiff", json=SET | {"values": {K_P: 250000.0}})
    (only,) = sets.get("/api/v1/gain-sets").json()
    assert only["values"] == {K_P: 250000.0}


@pytest.mark.parametrize(
    ("name", "body", "loc"),
    [
        ("a", SET | {"values": {"plant.x.mass": 9.0}}, "values.plant.x.mass"),
        ("a", SET | {"values": {K_P: -1.0}}, K_P),
        ("a", SET | {"values": {}}, "values"),
        ("-a", SET, "name"),
    ],
)
def test_what_is_no_set_is_refused(
    sets: httpx.Client, name: str, body: dict[str, object], loc: str
) -> None:
    answer = sets.put(f"/api/v1/gain-sets/{name}", json=body)
    assert answer.status_code == 422
    assert answer.json()["errors"][0]["loc"] == loc
    assert sets.get("/api/v1/gain-sets").json() == []


def test_a_set_that_is_not_there_is_not_found(sets: httpx.Client) -> None:
    assert sets.delete("/api/v1/gain-sets/none").status_code == 404
    assert sets.get("/api/v1/gain-sets/none/scenario.toml").status_code == 404
