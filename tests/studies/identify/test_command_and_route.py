"""``motionlab identify`` and ``POST /identify``: one document, files, jobs, and what is refused."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.cli import main
from motionlab.studies.identify.documents import (
    IdentificationDocument,
    PartialIdentification,
    read_request,
)
from motionlab.studies.identify.experiment import identify, plan
from tests.server.live import API, until

SPEEDS = ["0.002", "0.01", "0.02", "0.04", "0.06", "0.1"]
COMMAND = ["identify", "--axis", "x", "--speeds", *SPEEDS]
BODY: dict[str, Any] = {"axis": "x", "speeds": [float(v) for v in SPEEDS]}


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    assert main([*COMMAND, *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def submitted(client: httpx.Client, body: dict[str, Any]) -> str:
    response = client.post(f"{API}/identify", json=body)
    assert response.status_code == 202, response.text
    report = response.json()
    assert response.headers["location"] == f"{API}/jobs/{report['id']}"
    assert report["partial"] is None
    return response.headers["location"]


def test_the_job_ends_with_what_the_command_prints(
    client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    location = submitted(client, BODY | {"set": {"plant": "as-measured"}, "compare": True})
    until(lambda: client.get(location).json()["state"] in {"done", "failed"})
    report = client.get(location).json()
    assert report["error"] is None
    assert report["progress"] == 1.0
    document = printed(capsys, "--set", "plant=as-measured", "--compare")
    assert report["result"] == document
    found = IdentificationDocument.model_validate(document)
    partial = PartialIdentification.model_validate(report["partial"])
    assert partial.axes == {"x": found.axes["x"].points}
    assert partial.found == found.axes
    assert found.comparison is not None
    ratio = found.comparison.model_dump()["comparison"]["x"]["max_abs_following_error_ratio"]
    assert ratio < 0.7


def test_a_plan_is_answered_at_once_and_checked_the_same(client: httpx.Client) -> None:
    planned = client.post(f"{API}/identify/plan", json=BODY | {"time_max": 5.0})
    assert planned.status_code == 200, planned.text
    motions = planned.json()["axes"]["x"]
    assert [motion["speed"] for motion in motions] == BODY["speeds"]
    assert [motion["pitches"] for motion in motions[:3]] == [1, 6, 13]  # of 7.2 mm
    longer = client.post(f"{API}/identify/plan", json=BODY | {"time_max": 10.0}).json()
    assert longer["simulated_time"] > planned.json()["simulated_time"]
    # too long a plan is told, so that it can be shortened
    slow = {"axis": "x", "speeds": [1e-4 * (1 + k) for k in range(200)], "time_max": 3600.0}
    told = client.post(f"{API}/identify/plan", json=slow).json()
    assert told["simulated_time"] > told["simulated_time_max"]
    refused = client.post(f"{API}/identify/plan", json={"speeds": [0.01]})
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["loc"] == "speeds"


def test_points_arrive_while_it_goes_on_and_it_can_be_cancelled(client: httpx.Client) -> None:
    slow = {"axis": "both", "speeds": [0.001 + 0.0005 * k for k in range(60)], "time_max": 30.0}
    location = submitted(client, slow)
    seen: list[tuple[float, int]] = []

    def has_points() -> bool:
        report = client.get(location).json()
        partial = report["partial"]
        seen.append((report["progress"], len(partial["axes"]["x"]) if partial else 0))
        return seen[-1][1] >= 6

    until(has_points)
    assert seen == sorted(seen)
    assert 0.0 < seen[-1][0] < 1.0
    assert client.delete(location).json()["state"] == "cancelled"
    stopped = client.get(location).json()
    assert stopped["result"] is None
    # what had been measured stays, and the queue goes on
    assert len(stopped["partial"]["axes"]["x"]) >= 6
    after = submitted(client, BODY | {"presliding": {"enabled": False}})
    until(lambda: client.get(after).json()["state"] == "done")
    assert client.get(location).json()["state"] == "cancelled"


def test_a_failed_experiment_is_a_failed_job(client: httpx.Client) -> None:
    location = submitted(client, BODY | {"set": {"divergence_error": 1e-6}})
    until(lambda: client.get(location).json()["state"] == "failed")
    assert "diverged" in client.get(location).json()["error"]


@pytest.mark.parametrize(
    ("body", "loc"),
    [
        ({"speeds": [0.01]}, "speeds"),
        ({"speeds": "many"}, "speeds"),
        ({"axis": "z"}, "axis"),
        ({"scenario": "../../etc/passwd"}, "scenario"),
        ({"scenario": "my.toml"}, "scenario"),
        ({"set": {"plant.x.stroke": 0.015}}, "speeds.31"),
        ({"presliding": {"rates": []}}, "presliding.rates"),
        ({"speeds": [1e-4 * (1 + k) for k in range(200)], "time_max": 3600.0}, "speeds"),
    ],
)
def test_wrong_input_becomes_no_job(client: httpx.Client, body: dict[str, Any], loc: str) -> None:
    response = client.post(f"{API}/identify", json=body)
    assert response.status_code == 422, response.text
    assert [error["loc"] for error in response.json()["errors"]][:1] == [loc]


def test_the_table_and_the_points_as_a_file(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    points = tmp_path / "points.csv"
    assert main([*COMMAND, "--out", str(points)]) == 0
    text = capsys.readouterr().out
    for word in ("F_c", "F_s", "v_s", "sigma_2", "sigma_0", "sigma_1", "N s/m", "ratio"):
        assert word in text
    assert "--set variants.B.controller.model.x.friction.F_s=3.59" in text
    with points.open(newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["axis", "velocity [m/s]", "force [N]", "deviation [N]", "pitches [1]"]
    assert len(rows) == 2 * len(SPEEDS)
    assert {row[0] for row in rows} == {"x"}
    assert float(rows[1][1]) == pytest.approx(-0.002, rel=1e-3)


def test_the_document_as_a_file_and_progress_on_stderr_alone(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    target = tmp_path / "found.json"
    assert main([*COMMAND, "--json", "--out", str(target)]) == 0
    output = capsys.readouterr()
    assert json.loads(target.read_text()) == json.loads(output.out)
    told = [line for line in output.err.splitlines() if line.startswith("motionlab: identif")]
    assert told == [f"motionlab: identification {10 * k} %" for k in range(len(told))]
    assert len(told) >= 9


def test_the_flags_are_the_fields_of_the_request(capsys: pytest.CaptureFixture[str]) -> None:
    flags = [
        "--time-max",
        "0.3",
        "--pitches-max",
        "2",
        "--rates",
        "50",
        "--share",
        "0.4",
        "--places",
        "4",
    ]
    fewer = printed(capsys, *flags, "--variant", "B", "--apply-to", "A")
    asked = read_request(
        BODY
        | {
            "time_max": 0.3,
            "pitches_max": 2,
            "presliding": {"rates": [50.0], "share": 0.4, "places": 4},
        }
        | {"variant": "B", "apply_to": "A"}
    )
    assert fewer == identify(plan(asked)).model_dump()
    assert len(fewer["axes"]["x"]["ramps"]) == 1
    assert {point["pitches"] for point in fewer["axes"]["x"]["points"]} == {1, 2}
    without = printed(capsys, "--time-max", "0.1", "--no-presliding")
    assert without["axes"]["x"]["presliding"] is None


def test_a_scenario_of_ones_own(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    own = tmp_path / "mine.toml"
    own.write_text('base = "circle"\nplant = "as-measured"\n')
    quick = ["--time-max", "0.1", "--no-presliding"]
    assert main(["identify", str(own), *COMMAND[1:], *quick, "--compare", "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["plant"] == "as-measured"
    assert document["comparison"]["plant"] == "as-measured"


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--out", "points.parquet"], "names ending in .csv or .json"),
        (["--speeds", "0.1"], "speeds: has too few items; got 1; allowed 5 or more"),
        (["--set", "plant.x.stroke=0.005"], "speeds.3: needs"),
        (["--time-max", "0"], "time_max: "),
        (["--places", "6"], "places = 6 all see the same part"),
        (["--apply-to", "Z"], "apply_to: is no variant of the scenario; got 'Z'"),
        (["--set", "plant.x.stroke"], "needs KEY=VALUE"),
    ],
)
def test_bad_input_ends_with_two(
    capsys: pytest.CaptureFixture[str], arguments: list[str], complaint: str
) -> None:
    assert main([*COMMAND, *arguments]) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert complaint in output.err


def test_an_experiment_that_fails_ends_with_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([*COMMAND, "--set", "divergence_error=1e-6"]) == 1
    assert "diverged" in capsys.readouterr().err
