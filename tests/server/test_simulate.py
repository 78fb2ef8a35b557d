"""Simulate over REST: the same document as the command line prints."""

from __future__ import annotations

import json
import struct
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.server.settings import Settings
from motionlab.telemetry.channels import stream_columns
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import MakeServer
from tests.server.live import API
from tests.simulated import play

QUICK: dict[str, Any] = {"trajectory.laps": 1, "trajectory.lead_in": 0.5}
GAIN: dict[str, Any] = {"variants.B.controller.x.k_p": 312000.0, "seed": 7}
NOISY: dict[str, Any] = {
    "load.noise": 0.2,
    "plant.x.encoder.noise": 2e-7,
    "plant.y.amplifiers.noise": 0.02,
}
PARTS: dict[str, Any] = {"plant": "matched", "trajectory": "rhombus", "trajectory.laps": 1}
LIMP: dict[str, Any] = {
    "variants.B.controller.x.k_p": 0.0,
    "variants.B.controller.x.k_d": 0.0,
    "variants.B.controller.compensation.law": "off",
}

RUNS = [
    ("circle", {}),
    ("circle", QUICK | GAIN),
    ("circle", QUICK | NOISY),
    ("circle", PARTS),
    ("circle", QUICK | LIMP),
    ("circle", QUICK | {"schedule": [{"time": 1.0, "set": {"plant.x.mass": 7.0}}]}),
    ("circle-matched", QUICK),
    ("circle-published-k", QUICK),
    ("fig5", {}),
    ("stair-x-500nm", {}),
    ("trapezoid-y", {"settling_band": 1e-5}),
]


def from_command_line(
    capsys: pytest.CaptureFixture[str], scenario: str, changes: dict[str, Any]
) -> dict[str, Any]:
    arguments = ["run", scenario, "--json"]
    for path, value in changes.items():
        text = value if isinstance(value, str) else json.dumps(value)
        if isinstance(value, list):
            text = '[{ time = 1.0, set = { "plant.x.mass" = 7.0 } }]'
        arguments += ["--set", f"{path}={text}"]
    main(arguments)
    return json.loads(capsys.readouterr().out)


@pytest.mark.parametrize(("scenario", "changes"), RUNS)
def test_simulate_answers_what_the_command_line_prints(
    client: httpx.Client,
    capsys: pytest.CaptureFixture[str],
    scenario: str,
    changes: dict[str, Any],
) -> None:
    response = client.post(f"{API}/simulate", json={"scenario": scenario, "set": changes})
    assert response.status_code == 200
    expected = from_command_line(capsys, scenario, changes)
    assert response.json() == expected
    assert list(response.json()) == list(expected)


def test_a_change_changes_the_answer(client: httpx.Client) -> None:
    first, second = (
        client.post(f"{API}/simulate", json={"set": QUICK | changes}).json()
        for changes in ({}, GAIN)
    )
    assert first["variants"]["B"]["axes"]["x"] != second["variants"]["B"]["axes"]["x"]
    assert first["variants"]["A"]["axes"]["x"] == second["variants"]["A"]["axes"]["x"]


def test_an_empty_request_is_the_circle(client: httpx.Client) -> None:
    named = client.post(f"{API}/simulate", json={"scenario": "circle"})
    assert client.post(f"{API}/simulate", json={}).json() == named.json()


@pytest.mark.parametrize("name", ["circle", "fig5", "trapezoid-y"])
def test_a_resolved_scenario_runs_as_its_name_does(client: httpx.Client, name: str) -> None:
    resolved = client.get(f"{API}/scenarios/{name}").json()
    assert resolved == load_scenario(name).model_dump(mode="json")
    by_name, by_tables = (
        client.post(f"{API}/simulate", json={"scenario": scenario}).json()
        for scenario in (name, resolved)
    )
    assert by_tables == by_name


def test_a_diverged_variant_is_told_of(client: httpx.Client) -> None:
    response = client.post(f"{API}/simulate", json={"set": QUICK | LIMP})
    assert response.status_code == 200
    B = response.json()["variants"]["B"]
    assert B["diverged"]["channel"] == "x.following_error"
    assert all(value is None for axis in B["axes"].values() for value in axis.values())


# -- what-if --------------------------------------------------------------------------------------


def parse(answer: bytes) -> tuple[dict[str, Any], np.ndarray]:
    length, zero = struct.unpack_from("<II", answer)
    assert zero == 0
    assert length % 8 == 0
    return json.loads(answer[8 : 8 + length]), np.frombuffer(answer[8 + length :], dtype="<f4")


COLUMNS = ["A.x.following_error", "B.y.current_a", "x.position_reference", "y.load_force"]


@pytest.mark.parametrize("points", [10, 1500, 20_000])
def test_what_if_is_simulate_with_curves(client: httpx.Client, points: int) -> None:
    body = {"scenario": "circle", "set": QUICK | GAIN}
    more = {"columns": COLUMNS, "points": points}
    response = client.post(f"{API}/whatif", json=body | more)
    assert response.status_code == 200
    head, values = parse(response.content)
    assert head["result"] == client.post(f"{API}/simulate", json=body).json()
    assert head["how"] == "whole"
    played = play("circle", QUICK | GAIN)
    start, stop = played.prepared.reference.window
    ticks = -(-(stop - start) // points)
    count = head["time"]["count"]
    assert head["time"]["start"] == start * CONTROL_PERIOD
    assert head["time"]["step"] == ticks * CONTROL_PERIOD
    assert count == -(-(stop - start) // ticks) <= points
    assert [column["name"] for column in head["columns"]] == COLUMNS
    assert len(values) == 2 * count * len(COLUMNS)
    references = played.recording.references
    expected = [
        played.recording.variants["A"].channel("following_error", "x"),
        played.recording.variants["B"].channel("current_a", "y"),
        references[0, 0].astype(np.float32),
        references[3, 1].astype(np.float32),
    ]
    units = {name: channel.unit for name, channel in stream_columns(["A", "B"])}
    for column, samples in zip(head["columns"], expected, strict=True):
        assert column["unit"] == units[column["name"]]
        bins = [
            samples[a : min(a + ticks, stop)] for a in range(start, start + count * ticks, ticks)
        ]
        low = values[column["minimum"] : column["minimum"] + count]
        high = values[column["maximum"] : column["maximum"] + count]
        assert low.tolist() == [part.min() for part in bins]
        assert high.tolist() == [part.max() for part in bins]


def test_what_if_without_columns_is_the_result(client: httpx.Client) -> None:
    head, values = parse(client.post(f"{API}/whatif", json={"set": QUICK}).content)
    assert head["columns"] == []
    assert len(values) == 0


def test_what_if_of_a_diverged_variant(client: httpx.Client) -> None:
    body = {"set": QUICK | LIMP, "columns": ["B.x.position", "A.x.position"]}
    head, values = parse(client.post(f"{API}/whatif", json=body).content)
    assert head["result"]["variants"]["B"]["diverged"] is not None
    count = head["time"]["count"]
    assert np.isnan(values[count - 1])
    assert np.isfinite(values[2 * count :]).all()


@pytest.mark.parametrize(
    ("more", "loc"),
    [
        ({"columns": ["A.x.nothing"]}, "columns.0"),
        ({"columns": ["A.x.position", "C.x.position"]}, "columns.1"),
        ({"columns": ["A.x.position", "B.x.position", "A.x.position"]}, "columns.2"),
        ({"points": 0}, "points"),
        ({"points": 1e9}, "points"),
        ({"columns": "A.x.position"}, "columns"),
        ({"set": {"plant.x.mass": -1.0}}, "plant.x.mass"),
    ],
)
def test_what_if_refuses(client: httpx.Client, more: dict[str, Any], loc: str) -> None:
    response = client.post(f"{API}/whatif", json={"set": QUICK} | more)
    assert response.status_code == 422
    assert response.json()["errors"][0]["loc"] == loc


def test_the_size_of_an_answer_is_bounded(make_server: MakeServer) -> None:
    body = {"set": QUICK, "columns": COLUMNS[:2], "points": 1000}
    with httpx.Client(base_url=make_server(Settings(answer_max=16_000)).url, timeout=60) as client:
        assert client.post(f"{API}/whatif", json=body).status_code == 200
        answer = client.post(f"{API}/whatif", json=body | {"columns": COLUMNS[:3]})
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert (error["loc"], error["value"], error["range"]) == ("columns", 24_000, "<= 16000")
    assert error["unit"] == "bytes"
