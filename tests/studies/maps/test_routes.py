"""``/maps``: computed as a job and found again, listed, read, deleted; previews and the field."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.cli import main
from motionlab.motor_design.fem import compute as computing
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.kept_maps import FOLDER_MOST
from motionlab.paper.registry import quantities
from motionlab.server.settings import Settings
from tests.processes import children_of, runs, workers_of
from tests.server.live import API, until
from tests.server.openapi import Contract
from tests.server.servers import PATIENCE, Server

MAPS = f"{API}/maps"
SMALL: dict[str, Any] = {"n": 1, "limb": 3e-3, "coil": 2.4e-3}


@pytest.fixture(scope="module")
def server() -> Iterator[Server]:
    server = Server(Settings())
    yield server
    server.stop()


@pytest.fixture
def client(
    server: Server, contract: Contract, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[httpx.Client]:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    with httpx.Client(base_url=server.url, event_hooks=hooks, timeout=PATIENCE) as client:
        yield client


def computed(client: httpx.Client, geometry: dict[str, Any]) -> dict[str, Any]:
    response = client.post(MAPS, json={"preset": "preview", "geometry": geometry})
    assert response.status_code == 202, response.text
    location = response.headers["location"]
    until(lambda: client.get(location).json()["state"] in {"done", "failed"})
    report = client.get(location).json()
    assert report["error"] is None
    assert report["kind"] == "map"
    assert report["progress"] == 1.0
    return report["result"]


def test_the_map_of_a_known_geometry_is_the_shipped_one(client: httpx.Client) -> None:
    answer = client.post(MAPS, json={"preset": "default", "geometry": {}})
    assert answer.status_code == 200
    assert (answer.json()["name"], answer.json()["shipped"]) == ("new-design", True)


def test_a_map_is_computed_once_then_listed_read_and_deleted(
    client: httpx.Client, capsys: pytest.CaptureFixture[str]
) -> None:
    assert client.get(MAPS).status_code == 200
    entry = computed(client, SMALL)
    again = client.post(MAPS, json={"preset": "preview", "geometry": SMALL})
    assert again.status_code == 200
    assert again.json() == entry
    assert entry["published"] == []  # the paper has three teeth a limb
    name = entry["name"]
    assert entry in client.get(MAPS).json()

    tables = client.get(f"{MAPS}/{name}", params={"positions": 73, "currents": 3}).json()
    assert {key: tables[key] for key in entry} == entry
    assert np.array(tables["thrust"]).shape == (73, 3)
    assert tables["currents"] == [0, 5, 10]
    assert np.max(tables["thrust"]) == pytest.approx(entry["peaks"]["peak_thrust"], rel=0.01)
    assert np.max(tables["normal_force"]) == pytest.approx(
        entry["peaks"]["normal_force_aligned"], rel=1e-3
    )

    file = client.get(f"{MAPS}/{name}/file").json()
    arguments = [word for key, value in SMALL.items() for word in ("--set", f"{key}={value}")]
    assert main(["map", "--json", "--preset", "preview", *arguments]) == 0
    assert json.loads(capsys.readouterr().out) == file

    assert client.delete(f"{MAPS}/{name}").status_code == 204
    assert client.delete(f"{MAPS}/{name}").status_code == 404
    assert client.get(f"{MAPS}/{name}").status_code == 404
    assert entry not in client.get(MAPS).json()


def test_a_shipped_map_is_listed_and_stays(
    client: httpx.Client, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    configs = tmp_path / "configs"
    (configs / "maps").mkdir(parents=True)
    text = computing.compute(Geometry(), "preview").text()
    (configs / "maps" / "ours.json").write_text(text)
    (configs / "maps" / "damaged.json").write_text("{")
    monkeypatch.setenv("MOTIONLAB_CONFIGS", str(configs))
    (entry,) = client.get(MAPS).json()
    assert (entry["name"], entry["shipped"]) == ("ours", True)
    computed, measured = entry["published"]
    assert (computed["normal_force"], computed["not_comparable"]) == (380.1, "")
    assert (measured["normal_force"], measured["not_comparable"]) == (
        427.4,
        next(row.reason for row in quantities() if row.id == "normal-measured"),
    )
    assert client.get(f"{MAPS}/ours").json()["peaks"] == entry["peaks"]
    assert client.delete(f"{MAPS}/ours").status_code == 409
    assert client.get(f"{MAPS}/..%2Fours").status_code in {404, 422}


def test_no_room_is_told_before_anything_is_computed(client: httpx.Client, tmp_path: Path) -> None:
    (tmp_path / "maps").mkdir()
    with (tmp_path / "maps" / "large.json").open("wb") as file:
        file.truncate(FOLDER_MOST + 1)
    with httpx.Client(base_url=client.base_url, timeout=PATIENCE) as unchecked:
        response = unchecked.post(MAPS, json={"geometry": {"g": 0.31e-3}})
    assert response.status_code == 507
    detail = response.json()["detail"]
    told = f"force maps take {FOLDER_MOST + 1} bytes, {FOLDER_MOST} are the most; delete some"
    assert told in detail


def test_a_preview_comes_at_once_and_is_not_kept(client: httpx.Client, tmp_path: Path) -> None:
    response = client.post(f"{MAPS}/preview", json={"g": 0.4e-3}, params={"currents": 2})
    found = response.json()
    assert found["geometry"]["g"] == 0.4e-3
    assert found["preset"] == "preview"
    assert found["uncertainty"]["thrust"] == 0.4
    for crowded in ({"p": 2.16e-3}, {"g": 0.1e-3}, {"i": 30.0}):
        rough = client.post(f"{MAPS}/preview", json=crowded, params={"currents": 2}).json()
        assert rough["uncertainty"]["thrust"] == 0.6
    assert not (tmp_path / "maps").exists()
    wider = np.max(found["thrust"])
    paper = np.max(client.post(f"{MAPS}/preview", json={}, params={"currents": 2}).json()["thrust"])
    assert 5 < wider < paper - 2


@pytest.mark.parametrize(
    ("path", "body", "loc"),
    [
        ("", {"geometry": {"g": 0}}, "geometry.g"),
        ("", {"preset": "best"}, "preset"),
        ("", {"geometry": {"tau": 1e-3, "p": 5e-4, "g": 5e-5, "window": 0.5}}, "geometry"),
        ("/preview", {"p": 7.2e-3}, "geometry"),
        ("/preview", {"g": 0}, "g"),
        ("/field", {"current": 11.0}, "field"),
        ("/field", {"geometry": {"coil": 11e-3}}, "geometry"),
        ("/field", {"columns": 10_000}, "columns"),
    ],
)
def test_bad_input_is_refused(
    client: httpx.Client, path: str, body: dict[str, Any], loc: str
) -> None:
    response = client.post(MAPS + path, json=body)
    assert response.status_code == 422, response.text
    assert [error["loc"] for error in response.json()["errors"]] == [loc]


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core has no workers")
def test_a_cancelled_map_leaves_no_worker_and_no_file(
    server: Server, client: httpx.Client, tmp_path: Path
) -> None:
    def workers() -> list[int]:
        jobs = children_of(server.app.state.workers.forks.pid, "forkserver")
        return [worker for job in jobs for worker in workers_of(job)]

    response = client.post(MAPS, json={"geometry": {"g": 0.31e-3}})  # 40 s on four cores
    location = response.headers["location"]
    until(lambda: len(workers()) > 1)
    started = workers()
    assert client.delete(location).json()["state"] == "cancelled"
    until(lambda: not any(map(runs, started)))
    assert client.get(location).json()["result"] is None
    assert list(tmp_path.glob("maps/*")) == []


def test_the_field_is_that_of_the_position(client: httpx.Client) -> None:
    response = client.post(f"{MAPS}/field", json={"position": -2.12e-3, "columns": 96})
    found = response.json()
    assert found["position"] == pytest.approx(-2.1e-3)  # the nearest node
    assert found["thrust"] == pytest.approx(38.8, abs=0.2)
    density = np.array(found["flux_density"])
    assert density.shape == (found["y"]["count"], found["x"]["count"])
    x = found["x"]["start"] + found["x"]["step"] * np.arange(96)
    y = found["y"]["start"] + found["y"]["step"] * np.arange(len(density))
    yoke = np.ix_((y > 30e-3) & (y < 35e-3), np.abs(x) < 8e-3)
    air = np.ix_(y > 36.5e-3, np.abs(x) > 25e-3)
    assert density[yoke].min() > 1.3
    assert density[air].max() < 0.02
    flux = np.array([line["flux"] for line in found["lines"]])
    steps = np.round((flux - flux[0]) / found["flux_step"])
    assert flux == pytest.approx(flux[0] + found["flux_step"] * steps, rel=1e-9)
    assert len(np.unique(steps)) == 24
    parts = [outline["part"] for outline in found["outlines"]]
    assert parts == ["stator", "mover", "coil_in", "coil_out", "coil_in", "coil_out"]
    # the mover's edge has the area of its iron
    g, (px, py) = Geometry(), np.array(found["outlines"][1]["points"]).T
    area = abs(np.sum(px * np.roll(py, -1) - py * np.roll(px, -1))) / 2
    iron = (
        2 * (g.n * g.p * g.tooth_depth + g.shoe_width * g.shoe + g.limb * g.window)
        + g.width * g.yoke
    )
    assert area == pytest.approx(iron, rel=1e-4)
