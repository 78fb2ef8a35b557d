"""Checking, slowing down and keeping trajectories over REST."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.config.load import epochs, load_scenario
from motionlab.config.named_configs import names
from motionlab.library import named_documents
from motionlab.simulation.loop_check import run_loops
from motionlab.simulation.prepare import limit_sets
from motionlab.trajectories.trajectory_check import examine
from tests.server.live import API

PATH: dict[str, Any] = {
    "kind": "path",
    "points": [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]],
    "closed": True,
    "v_max": 0.08,
    "a_max": 0.8,
}
TOO_HARD = PATH | {"v_max": 0.5, "a_max": 6.0}
OUTSIDE = PATH | {"points": [[0.09, 0.01], [0.0, 0.03], [-0.03, 0.0]]}


@pytest.fixture(autouse=True)
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    return tmp_path


def check(
    client: httpx.Client, trajectory: dict[str, Any], **more: Any
) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    answer = client.post(f"{API}/trajectories/check", json={"trajectory": trajectory} | more)
    assert answer.status_code == 200, answer.text
    length, zero = struct.unpack("<II", answer.content[:8])
    assert (length % 8, zero) == (0, 0)
    head = json.loads(answer.content[8 : 8 + length])
    values = np.frombuffer(answer.content, "<f4", offset=8 + length)
    count = head["time"]["count"]
    outline = head["outline"] or {"count": 0}
    assert len(values) == 2 * count * len(head["columns"]) + 3 * outline["count"]
    columns = {
        f"{column['name']} {end}": values[column[end] : column[end] + count]
        for column in head["columns"]
        for end in ("minimum", "maximum")
    }
    for name in ("x", "y", "edge") if head["outline"] else ():
        columns[f"outline {name}"] = values[outline[name] :][: outline["count"]]
    return head, columns


def test_a_feasible_path_is_described(client: httpx.Client) -> None:
    head, columns = check(client, PATH | {"laps": 3}, points=200)
    assert head["feasible"] is True
    assert head["violations"] == []
    assert head["duration"] == pytest.approx(3 * head["examined"])
    assert head["length"] == pytest.approx(0.1697, rel=1e-3)
    assert head["time"]["count"] <= 200
    assert columns["x.position maximum"].max() == pytest.approx(0.03)
    assert columns["speed maximum"].max() == pytest.approx(0.08, rel=1e-2)


def test_the_outline_of_a_smooth_path_is_what_runs(client: httpx.Client) -> None:
    assert check(client, PATH)[0]["outline"] is None
    head, columns = check(client, PATH | {"geometry": "spline"})
    curve = np.column_stack([columns[f"outline {name}"] for name in "xy"])
    assert np.hypot(*np.diff(curve, axis=0).T).sum() == pytest.approx(head["length"], rel=1e-3)
    starts = [list(columns["outline edge"]).index(k) for k in range(4)]
    assert curve[starts] == pytest.approx(np.array(PATH["points"]), abs=1e-8)


def test_a_figure_is_given_as_a_path_of_points(client: httpx.Client) -> None:
    assert check(client, PATH)[0]["drawn"] is None
    figure = {"kind": "polygon", "vertices": PATH["points"], "frequency": 0.5, "laps": 2}
    path = check(client, figure)[0]["drawn"]
    assert (path["kind"], path["lap_time"], path["laps"]) == ("path", 2.0, 2)
    assert path["points"] == PATH["points"]
    assert check(client, path)[0]["duration"] == pytest.approx(4.0, rel=0.01)
    assert check(client, {"kind": "dwell"})[0]["drawn"] is None


def test_an_infeasible_path_is_described_too(client: httpx.Client) -> None:
    head, columns = check(client, OUTSIDE)
    assert head["feasible"] is False
    worst = head["violations"][0]
    assert (worst["quantity"], worst["axis"], worst["unit"]) == ("position", "x", "m")
    assert (worst["value"], worst["limit"]) == (0.09, 0.085)
    assert worst["place"] == pytest.approx([0.09, 0.01])
    assert columns["violated maximum"].max() == 1.0


def test_the_motor_of_the_scenario_decides(client: httpx.Client) -> None:
    assert check(client, PATH)[0]["feasible"]
    heavy = {"plant.y.mass": 200.0}
    found = check(client, PATH, set=heavy)[0]
    assert {each["quantity"] for each in found["violations"]} == {"thrust"}
    scenario = client.get(f"{API}/scenarios/circle").json()
    assert check(client, PATH, scenario=scenario, set=heavy)[0] == found


@pytest.mark.parametrize(
    ("change", "loc"),
    [
        ({"points": [[0.0, 0.0], ["a", 0.0], [0.0, 0.01]]}, "trajectory.points.1.0"),
        ({"v_max": -1.0}, "trajectory.v_max"),
        ({"color": "red"}, "trajectory.color"),
        ({"kind": "paht"}, "trajectory.kind"),
    ],
)
def test_bad_input_names_its_field(client: httpx.Client, change: dict[str, Any], loc: str) -> None:
    for method, path, body in (
        ("POST", "/trajectories/check", {"trajectory": PATH | change}),
        ("POST", "/trajectories/slow", {"trajectory": PATH | change}),
        ("PUT", "/trajectories/mine", PATH | change),
    ):
        answer = client.request(method, API + path, json=body)
        assert answer.status_code == 422
        assert [field["loc"] for field in answer.json()["errors"]] == [loc]


def test_the_check_runs_the_loops_if_asked(client: httpx.Client) -> None:
    asked = {"loops": None, "loops_window": None, "loops_not_run": "not asked for"}
    assert asked.items() <= check(client, PATH)[0].items()
    refused, _ = check(client, TOO_HARD, loops=True)
    assert refused["loops"] is None
    assert refused["loops_not_run"] == "the motor cannot follow the motion"
    head, _ = check(client, PATH, loops=True)
    scenario = load_scenario("circle", {"trajectory": PATH})
    found = examine(scenario.trajectory, limit_sets(tuple(epochs(scenario))), bins=10)
    expected = json.loads(json.dumps(run_loops(scenario, found).document()))
    assert {key: head[key] for key in expected} == expected
    assert [each["variant"] for each in head["loops"]] == ["A", "B"]
    answer = client.post(f"{API}/trajectories/slow", json={"trajectory": PATH, "loops": True})
    assert answer.status_code == 422


def test_slowing_down_makes_it_feasible(client: httpx.Client) -> None:
    answer = client.post(f"{API}/trajectories/slow", json={"trajectory": TOO_HARD}).json()
    assert answer["stretch"] > 1.0
    head, _ = check(client, answer["trajectory"])
    assert head["feasible"]
    assert head["duration"] == pytest.approx(answer["duration"])


def test_no_stretch_helps_outside_the_stroke(client: httpx.Client) -> None:
    answer = client.post(f"{API}/trajectories/slow", json={"trajectory": OUTSIDE})
    assert answer.status_code == 422
    assert "position on x is 0.09 m" in answer.json()["detail"]


def test_a_trajectory_is_saved_listed_loaded_and_deleted(client: httpx.Client, data: Path) -> None:
    put = client.put(f"{API}/trajectories/mine", json=PATH)
    assert put.status_code == 200
    assert (data / "trajectories" / "mine.toml").is_file()
    entries = client.get(f"{API}/trajectories").json()
    assert [entry["name"] for entry in entries if entry["shipped"]] == names("trajectories")
    assert [entry for entry in entries if not entry["shipped"]] == [
        {"name": "mine", "shipped": False, "kind": "path"}
    ]
    kept = client.get(f"{API}/trajectories/mine").json()
    assert kept == put.json()
    assert kept["trajectory"]["points"] == PATH["points"]
    run = {"scenario": "circle", "set": {"trajectory": kept["trajectory"]}}
    assert client.post(f"{API}/simulate", json=run).status_code == 200
    assert client.delete(f"{API}/trajectories/mine").status_code == 204
    assert client.delete(f"{API}/trajectories/mine").status_code == 404
    assert client.get(f"{API}/trajectories/mine").status_code == 404


def test_a_damaged_file_does_not_hide_the_others(client: httpx.Client, data: Path) -> None:
    assert client.put(f"{API}/trajectories/mine", json=PATH).status_code == 200
    (data / "trajectories" / "damaged.toml").write_bytes(b"kind = \xff")
    (data / "trajectories" / "folder.toml").mkdir()
    entries = client.get(f"{API}/trajectories").json()
    assert [(entry["name"], entry["kind"]) for entry in entries if not entry["shipped"]] == [
        ("damaged", ""),
        ("mine", "path"),
    ]
    answer = client.get(f"{API}/trajectories/damaged")
    assert answer.status_code == 422
    assert "is not UTF-8 text" in answer.json()["detail"]
    assert client.get(f"{API}/trajectories/folder").status_code == 404
    assert client.delete(f"{API}/trajectories/damaged").status_code == 204


def test_one_deleted_while_it_is_listed_is_left_out(
    client: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(named_documents, "own_names", lambda _: ["gone"])
    assert all(entry["shipped"] for entry in client.get(f"{API}/trajectories").json())
    assert client.get(f"{API}/trajectories/gone").status_code == 404


def test_a_line_in_no_time_is_not_feasible(client: httpx.Client) -> None:
    line = {"kind": "path", "points": [[0.0, 0.0], [0.01, 0.0]], "lap_time": 1e-9}
    head, _ = check(client, line)
    assert head["feasible"] is False


def test_shipped_ones_are_read_and_not_changed(client: httpx.Client) -> None:
    assert client.get(f"{API}/trajectories/rhombus").json()["trajectory"]["kind"] == "polygon"
    assert client.put(f"{API}/trajectories/rhombus", json=PATH).status_code == 409
    assert client.delete(f"{API}/trajectories/rhombus").status_code == 409


@pytest.mark.parametrize("name", ["UP", "a.b", "a" * 65, "%2e%2e%2fx"])
def test_only_names_are_taken(client: httpx.Client, name: str) -> None:
    assert client.put(f"{API}/trajectories/{name}", json=PATH).status_code in {404, 405, 422}


def test_a_folder_that_cannot_be_written_is_told(client: httpx.Client, data: Path) -> None:
    (data / "trajectories").write_text("a file where the folder should be")
    answer = httpx.put(f"{client.base_url}{API}/trajectories/mine", json=PATH)
    assert answer.status_code == 503
    assert "mine cannot be saved" in answer.json()["detail"]
    assert (data / "trajectories").read_text().startswith("a file")


def test_a_time_optimal_path_is_exported_as_its_motor_runs_it(client: httpx.Client) -> None:
    fast = {"law": "time_optimal", "v_max": 1.0, "a_max": 50.0, "j_max": 5000.0}
    points = [[0.0, 0.0], [0.05, 0.0]]
    body = {"trajectory": {"kind": "path", "points": points} | fast, "format": "csv"}
    answer = client.post(f"{API}/trajectories/export", json=body)
    assert answer.status_code == 200, answer.text
    heavy = body | {"set": {"plant.x.mass": 20.0}}
    slower = client.post(f"{API}/trajectories/export", json=heavy)
    assert len(slower.text.splitlines()) > len(answer.text.splitlines()) > 100
