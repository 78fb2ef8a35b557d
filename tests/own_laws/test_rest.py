"""A law of one's own over REST: its state as channels, everywhere, and the studies that take it."""

from __future__ import annotations

import csv
import io
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.library.served import API, PATIENCE
from tests.own_laws.looking_ahead import LAW, STATES, TEXT
from tests.own_laws.with_laws import serving
from tests.server.test_run_comparison import unpacked

SHORT = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}
PHASE = "B.x.law_phase"
NONE = "A.x.law_phase"
BODY = {"scenario": "circle", "set": LAW | SHORT}


@pytest.fixture(scope="module")
def client(tmp_path_factory: pytest.TempPathFactory) -> Iterator[httpx.Client]:
    folder = tmp_path_factory.mktemp("laws")
    (folder / "preview.py").write_text(TEXT)
    with serving(folder, tmp_path_factory.mktemp("data")) as client:
        yield client


def post(client: httpx.Client, path: str, body: dict[str, Any]) -> Any:
    """Return the answer, of a job its result."""
    answer = client.post(API + path, json=body)
    assert answer.is_success, answer.text
    if answer.status_code != 202:
        return answer
    end = time.monotonic() + PATIENCE
    while True:
        job = client.get(answer.headers["location"]).raise_for_status().json()
        if job["state"] not in {"queued", "running"}:
            assert job["state"] == "done", job
            return job["result"]
        assert time.monotonic() < end
        time.sleep(0.05)


@pytest.fixture(scope="module")
def kept(client: httpx.Client) -> str:
    return post(client, "/simulate", BODY | {"keep": True}).json()["run"]


def column(text: str, name: str) -> NDArray[np.float64]:
    """Return the numbers of a column of a CSV file; NaN where it has none."""
    rows = list(csv.reader(io.StringIO(text)))
    place = next(k for k, header in enumerate(rows[0]) if header.startswith(name))
    return np.array([float(row[place] or "nan") for row in rows[1:]])


def test_a_kept_run_has_its_state_as_channels(client: httpx.Client, kept: str) -> None:
    run = client.get(f"{API}/runs/{kept}").json()
    own = {each["name"]: each for each in run["columns"] if "law_" in each["name"]}
    assert list(own) == [f"B.{axis}.law_{name}" for axis in "xy" for name in STATES]
    assert own["B.x.law_v_1"]["unit"] == "m/s"
    assert own["B.x.law_p_1"]["meaning"] == "position a period ahead"
    assert client.post(f"{API}/runs/{kept}/replay").json()["identical"]


@pytest.mark.parametrize("format", ["csv", "parquet", "mat", "mcap"])
def test_files_have_them(client: httpx.Client, kept: str, format: str, tmp_path: Path) -> None:
    query = {"format": format, "columns": f"{PHASE},B.x.following_error"}
    answer = client.get(f"{API}/runs/{kept}/telemetry", params=query).raise_for_status()
    assert b"law_phase" in answer.content.replace(b"/", b".") or format == "mat"
    if format == "csv":
        phase = column(answer.text, PHASE)
        assert phase.min() == 0.0 and 0.999 < phase.max() < 1.0


def test_a_what_if_draws_them_and_nothing_where_a_law_has_none(client: httpx.Client) -> None:
    body = BODY | {"columns": [PHASE, NONE], "points": 100, "exact": True}
    head, values = unpacked(post(client, "/whatif", body).content)
    low = [values[each["minimum"] :][: head["time"]["count"]] for each in head["columns"]]
    assert [each["unit"] for each in head["columns"]] == ["1", "1"]
    assert np.nanmax(low[0]) > 0.9
    assert np.isnan(low[1]).all()


def test_a_session_has_them_and_so_have_its_files_and_captures(client: httpx.Client) -> None:
    path = client.post(f"{API}/sessions", json={"scenario": "circle"}).headers["location"]
    client.post(f"{path}/step", json={"ticks": 1000}).raise_for_status()
    client.patch(f"{path}/parameters", json={"set": LAW}).raise_for_status()
    client.post(f"{path}/step", json={"ticks": 1000}).raise_for_status()
    text = client.get(f"{path}/telemetry", params={"format": "csv"}).raise_for_status().text
    phase = column(text, PHASE)
    assert np.isnan(phase[:1000]).all() and not np.isnan(phase[1000:]).any()
    assert "A.x.law_phase" not in text.splitlines()[0]  # a law that it never had
    expression = {"format": "csv", "columns": f"twice=2 * {PHASE}"}
    twice = client.get(f"{path}/telemetry", params=expression).raise_for_status().text
    np.testing.assert_allclose(column(twice, "twice")[1000:], 2.0 * phase[1000:], rtol=1e-6)
    body = {"from_tick": 900, "to_tick": 1100, "columns": [PHASE]}
    run = client.post(f"{path}/captures", json=body).raise_for_status().json()
    columns = client.get(f"{API}/runs/{run['id']}").raise_for_status().json()["columns"]
    assert PHASE in [each["name"] for each in columns]
    assert client.delete(path).is_success


def test_a_recorded_session_replays_with_them(client: httpx.Client) -> None:
    made = client.post(f"{API}/sessions", json=BODY)
    path = made.headers["location"]
    client.post(f"{path}/step", json={"ticks": 700}).raise_for_status()
    client.post(f"{path}/push", json={"axis": "x", "force": 2.0, "duration": 0.01})
    client.post(f"{path}/step", json={"ticks": 700}).raise_for_status()
    run = client.get(path).json()["run"]
    assert client.delete(path).is_success
    end = time.monotonic() + PATIENCE
    while client.get(f"{API}/runs/{run}").json().get("state") == "recording":
        assert time.monotonic() < end
        time.sleep(0.05)
    assert PHASE in [each["name"] for each in client.get(f"{API}/runs/{run}").json()["columns"]]
    answer = client.post(f"{API}/runs/{run}/replay").raise_for_status().json()
    assert answer["identical"], answer


STUDIES: dict[str, dict[str, Any]] = {
    "/tune": {"axis": "x", "variant": "B", "starts": 1, "evaluations": 20},
    "/montecarlo": {"cases": 20, "seed": 1},
    "/sweep": {
        "grid": [{"path": "variants.B.controller.compensation.advance", "values": [0.0, 1.0]}]
    },
    "/loop/sweep": {"variant": "B", "axis": "x", "frequencies": [20.0]},
}


@pytest.mark.parametrize("path", STUDIES)
def test_studies_take_it(client: httpx.Client, path: str) -> None:
    result = post(client, path, BODY | STUDIES[path])
    if path == "/sweep":
        without, whole = [post(client, "/simulate", case).json() for case in _cases()]
        assert _error(without) != _error(whole)
        assert _errors(result) == pytest.approx([_error(without), _error(whole)], rel=1e-6)


ADVANCE = "compensation.advance"


def test_its_own_parameter_is_tuned_within_its_bounds(client: httpx.Client) -> None:
    effort = {"starts": 1, "evaluations": 30, "constraints": {"gain_margin": 1.5}}
    result = post(client, "/tune", BODY | effort | {"also": {ADVANCE: [0.05, 0.5]}})
    (group,) = result["groups"]
    assert group["axes"] == ["x", "y"]
    assert group["present"]["also"] == {ADVANCE: 1.0}
    (found,) = group["candidates"]
    assert 0.05 <= found["also"][ADVANCE] <= 0.5
    assert len(set(group["starts"][0]["gains"][ADVANCE])) > 10
    assert found["set"][f"variants.B.controller.{ADVANCE}"] == found["also"][ADVANCE]
    tuned = BODY | {"set": LAW | SHORT | found["set"]}
    axes = post(client, "/simulate", tuned).json()["variants"]["B"]["axes"]
    rms = sum(axes[axis]["rms_following_error"] for axis in group["axes"])
    assert rms * 1e6 == pytest.approx(found["cost"], rel=1e-3)


@pytest.mark.parametrize(
    ("also", "range_"),
    [
        ({ADVANCE: [0.1, 3.0]}, ">= 0 and <= 2"),
        ({ADVANCE: [0.0, 1.0]}, "> 0 and <= 1000000000"),
        ({"compensation.gain": [1.0, 2.0]}, f"one of {ADVANCE}"),
        ({"compensation.law": [1.0, 2.0]}, f"one of {ADVANCE}"),
    ],
)
def test_what_it_cannot_be_tuned_by_is_refused(
    client: httpx.Client, also: dict[str, Any], range_: str
) -> None:
    answer = client.post(f"{API}/tune", json=BODY | {"also": also})
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert error["loc"].startswith(f"also.{next(iter(also))}")
    assert error["range"] == range_


def test_a_law_is_compared_with_another_by_a_sweep(client: httpx.Client) -> None:
    """Cases beside each other, of which some look ahead and others do not."""
    law = "variants.B.controller.compensation.law"
    grid = [{"path": law, "values": ["off", "preview"]}]
    result = post(client, "/sweep", {"scenario": "circle", "set": SHORT, "grid": grid})
    bodies = [{"scenario": "circle", "set": SHORT | {law: name}} for name in ("off", "preview")]
    alone = [_error(post(client, "/simulate", body).json()) for body in bodies]
    assert alone[0] != alone[1]
    assert _errors(result) == pytest.approx(alone, rel=1e-6)  # seven digits


def _cases() -> Iterator[dict[str, Any]]:
    for value in (0.0, 1.0):
        change = {"variants.B.controller.compensation.advance": value}
        yield {"scenario": "circle", "set": LAW | SHORT | change}


def _errors(sweep: dict[str, Any]) -> list[float]:
    return sweep["variants"]["B"]["axes"]["x"]["metrics"]["rms_following_error"]


def _error(document: dict[str, Any]) -> float:
    return document["variants"]["B"]["axes"]["x"]["rms_following_error"]
