"""Comparison and replay of runs over REST."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.analysis.comparison_options import Comparing
from motionlab.analysis.run_comparison import compare
from motionlab.cli.main import main
from motionlab.library.columns import of_run
from motionlab.library.library import library
from motionlab.library.replay import again
from motionlab.library.replays import demand, replay_all
from motionlab.library.run import RunDetail
from motionlab.library.search import parse
from tests.library.test_replay import altered, keep, rewrite
from tests.server.live import API, until

ERROR = "B.x.following_error"
HOW = {"exact": True, "channels": {ERROR: {"absolute": 1e-7, "time": 0.001}}}


@pytest.fixture(scope="module")
def runs() -> tuple[RunDetail, RunDetail]:
    return keep(), keep({"variants.B.controller.x.k_p": 210_000.0})


def ends(runs: tuple[RunDetail, RunDetail]) -> dict[str, Any]:
    return {"a": runs[0].id, "b": runs[1].id}


def test_the_document_is_that_of_the_library(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail]
) -> None:
    answer = client.post(f"{API}/runs/compare", json=ends(runs) | HOW)
    assert answer.status_code == 200, answer.text
    first, second = (of_run(run.id) for run in runs)
    wanted = compare(first, second, Comparing.model_validate(HOW))
    assert answer.json() == wanted.model_dump(mode="json")
    assert not wanted.holds
    assert 0 < wanted.within < 108


@pytest.mark.parametrize(
    ("body", "status", "said"),
    [
        ({"b": "r-aaaaaaaaaaaa"}, 404, "no run"),
        ({"align": "place"}, 422, "align"),
        ({"tolerance": {"absolute": -1.0}}, 422, "tolerance.absolute"),
        ({"channels": {"C.*": {}}}, 422, "fits no channel"),
        ({"align": "index", "offset": 1.0}, 422, "offset"),
        ({"unknown": 1}, 422, "unknown"),
        ({"start": 2.0, "end": 1.0}, 422, "is before the start"),
    ],
)
def test_refusals(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail], body: Any, status: int, said: str
) -> None:
    answer = client.post(f"{API}/runs/compare", json=ends(runs) | body)
    assert answer.status_code == status, answer.text
    assert said in answer.text


@pytest.mark.parametrize(
    ("variants", "loc", "message", "allowed"),
    [
        ({"M": "B"}, "variants.M", "is no variant of the candidate", "A, B"),
        ({"A": "Z"}, "variants.A", "is no variant of the baseline", "A, B"),
        ({"m": "B"}, "variants.m", "is not of the allowed form", "one capital letter"),
        ({"A": "BB"}, "variants.A", "is not of the allowed form", "one capital letter"),
        (["A"], "variants", "must be a table", ""),
        ({"A": 1}, "variants.A", "must be text", ""),
    ],
)
def test_refused_variants(
    client: httpx.Client,
    runs: tuple[RunDetail, RunDetail],
    variants: Any,
    loc: str,
    message: str,
    allowed: str,
) -> None:
    answer = client.post(f"{API}/runs/compare", json=ends(runs) | {"variants": variants})
    assert answer.status_code == 422, answer.text
    error = answer.json()["errors"][0]
    assert (error["loc"], error["message"], error["range"]) == (loc, message, allowed)


def test_exchanged_variants_in_a_range(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail]
) -> None:
    body = ends(runs) | {"b": runs[0].id, "variants": {"A": "B", "B": "A"}, "only": [ERROR]}
    body |= {"start": 0.25, "end": 0.5}
    found = client.post(f"{API}/runs/compare", json=body).json()
    assert found["instants"] == 501
    assert found["channels"][0]["verdict"] == "out-of-tolerance"
    curves = client.post(f"{API}/runs/compare/window", json=body | {"channel": ERROR})
    head, values = unpacked(curves.content)
    assert (head["instants"]["total"], head["axis"]["start"]) == (501, pytest.approx(0.25))
    (difference,) = (c for c in head["columns"] if c["name"] == "difference")
    largest = np.abs(values[difference["maximum"] :][:501]).max()
    assert largest == pytest.approx(abs(found["channels"][0]["largest"])) != 0.0
    page = client.post(f"{API}/runs/compare/report", json=body).text
    assert "variant A of run 2" in page
    assert "from 250.0 ms to 500.0 ms of run 1" in page


def unpacked(content: bytes) -> tuple[dict[str, Any], NDArray[np.float32]]:
    length, _ = struct.unpack_from("<II", content)
    return json.loads(content[8 : 8 + length]), np.frombuffer(content[8 + length :], dtype="<f4")


@pytest.mark.parametrize("align", ["time", "reference", "index"])
def test_the_curves_of_a_channel(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail], align: str
) -> None:
    body = ends(runs) | HOW | {"align": align, "channel": ERROR, "from": 100, "to": 1100}
    answer = client.post(f"{API}/runs/compare/window", json=body | {"points": 1000})
    assert answer.status_code == 200, answer.text
    head, values = unpacked(answer.content)
    assert head["instants"]["count"] == 1000
    found = {c["name"]: values[c["minimum"] : c["minimum"] + 1000] for c in head["columns"]}
    difference = found["candidate"].astype(float) - found["baseline"]
    np.testing.assert_allclose(found["difference"], difference, rtol=1e-6, atol=1e-11)
    assert set(np.unique(found["tolerance"])) == {np.float32(1e-7)}
    assert 0.0 < found["beyond"].mean() < 1.0
    axis = head["axis"]["start"] + values[head["axis"]["values"] :][:1000]
    match align:
        case "time":
            np.testing.assert_allclose(axis, 0.05 + 0.0005 * np.arange(1000), atol=1e-7)
        case "index":
            np.testing.assert_array_equal(axis, 100 + np.arange(1000))
        case _:
            assert (np.diff(axis) >= 0).all()
            assert head["axis"]["lap_length"] == pytest.approx(2 * np.pi * 0.015, rel=1e-4)
    few = client.post(f"{API}/runs/compare/window", json=body | {"points": 10})
    head, values = unpacked(few.content)
    (column,) = (c for c in head["columns"] if c["name"] == "baseline")
    lows, highs = (values[column[end] : column[end] + 10] for end in ("minimum", "maximum"))
    np.testing.assert_array_equal(lows, found["baseline"].reshape(10, 100).min(axis=1))
    np.testing.assert_array_equal(highs, found["baseline"].reshape(10, 100).max(axis=1))


def test_curves_that_cannot_be_compared(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail]
) -> None:
    for body, said in (
        ({"channel": "A.z"}, "channel"),
        ({"channel": ERROR, "offset": 100.0}, "do not overlap"),
        ({"channel": ERROR, "from": 1_000_000}, "behind the end"),
    ):
        answer = client.post(f"{API}/runs/compare/window", json=ends(runs) | body)
        assert answer.status_code == 422, answer.text
        assert said in answer.text


def test_a_replay(client: httpx.Client) -> None:
    run = keep({"seed": 11})
    answer = client.post(f"{API}/runs/{run.id}/replay")
    assert answer.status_code == 200, answer.text
    assert answer.json()["identical"] is True
    rewrite(run, lambda table: altered(table, 321, "A.y.thrust", 7.0))
    accepted = client.post(f"{API}/runs/{run.id}/replay", headers={"prefer": "respond-async"})
    assert accepted.status_code == 202, accepted.text
    job = accepted.headers["location"]
    until(lambda: client.get(job).json()["state"] == "done")
    report = client.get(job).json()
    assert report["kind"] == "replay"
    assert report["request"] == {"run": run.id}
    assert report["result"]["first"]["tick"] == 321
    assert client.post(f"{API}/runs/r-aaaaaaaaaaaa/replay").status_code == 404


def test_runs_of_a_search_are_replayed_by_a_job(client: httpx.Client) -> None:
    same, moved, _ = (keep({"seed": seed}) for seed in (13, 14, 16))
    rewrite(moved, lambda table: altered(table, 321, "A.y.thrust", 7.0))
    for run in (same, moved):
        library().change(run.id, {"tags": ["by-rest"]})
    q = "tag:by-rest scenario:circle"
    accepted = client.post(f"{API}/runs/replay", json={"q": q})
    assert accepted.status_code == 202, accepted.text
    job = accepted.headers["location"]
    until(lambda: client.get(job).json()["state"] == "done")
    report = client.get(job).json()
    assert (report["kind"], report["request"], report["subject"]) == ("replays", {"q": q}, q)
    assert (report["progress"], report["error"], report["partial"]) == (1.0, None, None)
    assert report["result"] == replay_all(library(), parse(q)).model_dump(mode="json")
    assert [run["run"] for run in report["result"]["runs"]] == [moved.id, same.id]
    assert report["result"]["runs"][0]["first"]["tick"] == 321


def test_long_runs_are_replayed_within_the_memory_of_a_job(client: httpx.Client) -> None:
    """Of more than a row group of samples; Arrow's own pool would reserve 1 GiB at once."""
    long = keep({"seed": 18, "trajectory.laps": 8})
    library().change(long.id, {"tags": ["long-replay"]})
    accepted = client.post(f"{API}/runs/replay", json={"q": "tag:long-replay"})
    job = accepted.headers["location"]
    until(lambda: client.get(job).json()["state"] not in {"queued", "running"})
    report = client.get(job).json()
    assert (report["state"], report["error"]) == ("done", None)
    assert [run["outcome"] for run in report["result"]["runs"]] == ["identical"]


@pytest.mark.parametrize("q", ["kind:bogus", "B.x.max<3kg", "after:soon", 31 * "a ", 1001 * "a"])
def test_a_search_is_refused_as_by_the_list(client: httpx.Client, q: str) -> None:
    listed = client.get(f"{API}/runs", params={"q": q})
    answer = client.post(f"{API}/runs/replay", json={"q": q})
    assert answer.status_code == listed.status_code == 422
    assert answer.json()["errors"] == listed.json()["errors"]
    assert [error["loc"] for error in answer.json()["errors"]] == ["q"]


def test_bounds_of_a_job_that_replays(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail]
) -> None:
    """Simulated time is bounded as that of other jobs, memory is that of the largest run."""
    for run in runs:
        library().change(run.id, {"tags": ["bounded"]})
    nothing = {"id": "r-measurement3", "kind": "measurement", "scenario_document": None}
    other = runs[0].model_copy(update=nothing | {"tags": ["bounded"]})
    library().index.put(other)
    needed = demand(library(), parse("tag:bounded"))
    assert needed.work == sum(2 * run.duration for run in runs)
    assert 0 < needed.size < max(again(run).size for run in runs)
    longer = {"id": "r-muchtoolonga", "duration": 1e6, "tags": ["too-long"]}
    long = runs[0].model_copy(update=longer)
    library().index.put(long)
    answer = client.post(f"{API}/runs/replay", json={"q": "tag:too-long"})
    library().delete(long.id)
    assert answer.status_code == 422, answer.text
    (error,) = answer.json()["errors"]
    assert (error["loc"], error["value"], error["unit"]) == ("q", 2e6, "s")
    assert error["bounds"] == {"maximum": 1e6}


def test_a_job_that_replays_can_be_cancelled(client: httpx.Client) -> None:
    run = keep({"seed": 15, "trajectory.laps": 60})
    library().change(run.id, {"tags": ["cancelled"]})
    accepted = client.post(f"{API}/runs/replay", json={"q": "tag:cancelled"})
    job = accepted.headers["location"]
    until(lambda: client.get(job).json()["state"] == "running")
    report = client.delete(job).json()
    assert (report["state"], report["result"]) == ("cancelled", None)
    until(lambda: job.rpartition("/")[2] in {each["id"] for each in ended_jobs(client)})


def ended_jobs(client: httpx.Client) -> list[dict[str, Any]]:
    jobs = client.get(f"{API}/jobs/now").json()
    return [job for job in jobs if job["state"] not in {"queued", "running"}]


def test_a_measurement_cannot_be_replayed(client: httpx.Client) -> None:
    nothing = {"id": "r-measurement2", "kind": "measurement", "scenario_document": None}
    library().index.put(keep({"seed": 12}).model_copy(update=nothing))
    answer = client.post(f"{API}/runs/r-measurement2/replay")
    assert answer.status_code == 409, answer.text
    assert "measurement" in answer.json()["detail"]


def test_reports_are_those_of_the_command(
    client: httpx.Client, runs: tuple[RunDetail, RunDetail], tmp_path: Path
) -> None:
    first, second = (run.id for run in runs)
    options = ["--tolerance", "1e-9,1e-3", "--only", ERROR, "--variant", "A=B", "--variant", "B=A"]
    options += ["--from", "0.1"]
    body = ends(runs) | {"tolerance": {"absolute": 1e-9, "relative": 1e-3}, "only": [ERROR]}
    body |= {"variants": {"A": "B", "B": "A"}, "start": 0.1}
    one, two = tmp_path / "one.html", tmp_path / "two.html"
    assert main(["report", first, "--out", str(one)]) == 0
    assert main(["report", first, second, "--out", str(two), *options]) == 0
    for answer, file, name in (
        (client.get(f"{API}/runs/{first}/report"), one, first),
        (client.post(f"{API}/runs/compare/report", json=body), two, f"{first}-{second}"),
    ):
        assert answer.status_code == 200, answer.text
        assert answer.content == file.read_bytes()
        assert answer.headers["content-type"] == "text/html; charset=utf-8"
        assert answer.headers["content-disposition"] == f'attachment; filename="{name}.html"'
    assert client.get(f"{API}/runs/r-aaaaaaaaaaaa/report").status_code == 404
