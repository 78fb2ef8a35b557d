"""Jobs: what takes long, or is asked to, is answered later; the queue is bounded."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.lanes import model_hash
from motionlab.server.job_reports import subject_of
from motionlab.server.settings import Settings
from tests.server.conftest import MakeServer
from tests.server.live import API, until
from tests.server.servers import PATIENCE

ASYNC = {"prefer": "respond-async"}
QUICK: dict[str, Any] = {"set": {"trajectory.laps": 1, "trajectory.lead_in": 0.5}}
LONG: dict[str, Any] = {"set": {"trajectory.laps": 300}}  # 15 minutes of simulated time


def state(client: httpx.Client, location: str) -> str:
    return client.get(location).json()["state"]


def submit(client: httpx.Client, body: dict[str, Any]) -> str:
    response = client.post(f"{API}/simulate", json=body, headers=ASYNC)
    assert response.status_code == 202
    assert response.json()["state"] == "queued"
    assert response.headers["location"] == f"{API}/jobs/{response.json()['id']}"
    return response.headers["location"]


def test_a_job_ends_with_the_direct_result(client: httpx.Client) -> None:
    location = submit(client, QUICK)
    until(lambda: state(client, location) == "done")
    report = client.get(location).json()
    assert report["progress"] == 1.0
    assert report["error"] is None
    assert report["result"] == client.post(f"{API}/simulate", json=QUICK).json()
    # what is done stays done
    assert client.delete(location).json() == report
    assert client.get(location).json() == report


def test_a_long_run_becomes_a_job_and_can_be_cancelled(client: httpx.Client) -> None:
    response = client.post(f"{API}/simulate", json=LONG)
    assert response.status_code == 202
    location = response.headers["location"]
    seen = []

    def advances() -> bool:
        report = client.get(location).json()
        seen.append(report["progress"])
        return report["state"] != "queued" and report["progress"] > 0

    until(advances)
    assert seen == sorted(seen)
    assert seen[-1] < 1.0
    assert client.delete(location).json()["state"] == "cancelled"
    report = client.get(location).json()
    assert report["state"] == "cancelled"
    assert report["result"] is None
    # the queue goes on
    after = submit(client, QUICK)
    until(lambda: state(client, after) == "done")
    assert state(client, location) == "cancelled"


def test_a_run_just_short_enough_is_answered_at_once(make_server: MakeServer) -> None:
    server = make_server(Settings(direct_max=3.5))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        assert client.post(f"{API}/simulate", json=QUICK).status_code == 200
        longer = {"set": {"trajectory.laps": 1, "trajectory.lead_in": 0.501}}
        assert client.post(f"{API}/simulate", json=longer).status_code == 202


def test_many_variants_count_as_time(make_server: MakeServer) -> None:
    server = make_server(Settings(direct_work_max=7.0))
    third = QUICK["set"] | {"variants.C": {"label": "C", "controller": "pd"}}
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        assert client.post(f"{API}/simulate", json=QUICK).status_code == 200
        assert client.post(f"{API}/simulate", json={"set": third}).status_code == 202


def test_bad_input_becomes_no_job(client: httpx.Client) -> None:
    body = {"set": {"plant.x.mass": -1.0}}
    response = client.post(f"{API}/simulate", json=body, headers=ASYNC)
    assert response.status_code == 422


def test_a_job_that_is_not_there(client: httpx.Client) -> None:
    assert client.get(f"{API}/jobs/nowhere").status_code == 404
    assert client.delete(f"{API}/jobs/nowhere").status_code == 404


def test_a_full_queue(make_server: MakeServer) -> None:
    server = make_server(Settings(jobs_at_once=1, jobs_max=2))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        running, waiting = submit(client, LONG), submit(client, LONG)
        until(lambda: state(client, running) == "running")
        assert state(client, waiting) == "queued"
        refused = client.post(f"{API}/simulate", json=QUICK, headers=ASYNC)
        assert refused.status_code == 429
        assert refused.headers["content-type"] == "application/problem+json"
        # what is answered at once does not queue
        assert client.post(f"{API}/simulate", json=QUICK).status_code == 200
        # one that waits can be cancelled, and makes room
        assert client.delete(waiting).json()["state"] == "cancelled"
        third = submit(client, QUICK)
        client.delete(running)
        until(lambda: state(client, third) == "done")
        assert [state(client, each) for each in (running, waiting)] == ["cancelled", "cancelled"]


def test_the_jobs_of_now_are_listed_with_what_they_are_of_and_wait_for(
    make_server: MakeServer,
) -> None:
    server = make_server(Settings(jobs_at_once=1))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:

        def now() -> list[dict[str, Any]]:
            return client.get(f"{API}/jobs/now").raise_for_status().json()

        assert now() == []
        running, waiting = submit(client, LONG), submit(client, QUICK)
        until(lambda: [job["state"] for job in now()] == ["running", "queued"])
        until(lambda: now()[1]["waits_for"] == "jobs")
        first, second = now()
        assert [f"{API}/jobs/{job['id']}" for job in (first, second)] == [running, waiting]
        assert first["waits_for"] is None
        assert {first["subject"], second["subject"]} == {"circle"}
        assert {"request", "result", "partial"}.isdisjoint(first)
        client.delete(running)
        until(lambda: [job["state"] for job in now()] == ["done", "cancelled"])
        assert client.get(waiting).json()["model"] == now()[0]["model"] == model_hash()


@pytest.mark.parametrize(
    ("body", "subject"),
    [
        ({"scenario": "circle", "set": {}}, "circle"),
        ({"scenario": {"name": "own", "plant": {}}}, "own"),
        ({"scenario": "circle", "run": "abc"}, "run abc"),
        ({"preset": "reference", "geometry": {}}, "reference"),
        ({"only": ["a", "b", "c", "d"]}, "a, b, c, …"),
        ({}, ""),
    ],
)
def test_a_job_says_what_it_is_of(body: dict[str, Any], subject: str) -> None:
    assert subject_of(body) == subject


def test_jobs_are_listed_and_recorded(
    make_server: MakeServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    server = make_server(Settings())
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        first, second = submit(client, QUICK), submit(client, {"set": QUICK["set"] | {"seed": 2}})
        until(lambda: state(client, first) == "done" and state(client, second) == "done")
        cancelled = submit(client, LONG)
        client.delete(cancelled)
        until(lambda: not server.app.state.jobs._jobs)  # all are recorded
        report = client.get(first).json()
        assert report["kind"] == "simulate"
        assert report["request"] == {"scenario": "circle", **QUICK}
        assert report["elapsed"] > 0.0
        assert report["remaining"] is None
        listed = client.get(f"{API}/jobs").json()
        ids = [f"{API}/jobs/{job['id']}" for job in listed]
        assert ids == [cancelled, second, first]  # the newest first
        assert {"result", "partial"}.isdisjoint(listed[0])
        assert client.get(f"{API}/jobs?kind=map").json() == []
        assert client.get(f"{API}/jobs?kind=nothing").status_code == 422
    # a file that is no record harms nothing
    (tmp_path / "jobs" / "AAAAAAAAAAAA.jsonl").write_text("{}\n{}\n")
    summary = next(line for line in listed if f"{API}/jobs/{line['id']}" == first)
    for letter, damage in (("B", {"created": "2026-01-01T00:00:00"}), ("C", {"elapsed": math.nan})):
        line = json.dumps(summary | {"id": letter * 12} | damage)
        (tmp_path / "jobs" / f"{letter * 12}.jsonl").write_text(f"{line}\n{line}\n")
    with httpx.Client(base_url=make_server(Settings()).url, timeout=PATIENCE) as client:
        assert client.get(first).json() == report
        assert client.delete(first).json() == report
        ids = [f"{API}/jobs/{job['id']}" for job in client.get(f"{API}/jobs").json()]
        assert ids == [cancelled, second, first]
        assert client.get(f"{API}/jobs/AAAAAAAAAAAA").status_code == 404
        assert client.get(cancelled).json()["state"] == "cancelled"


def test_a_full_disk_loses_the_record_and_not_the_result(
    make_server: MakeServer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "jobs").write_text("where the folder should be")
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    server = make_server(Settings(jobs_kept=2))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        locations: list[str] = []
        report: dict[str, Any] = {}
        for _ in range(3):
            location = submit(client, QUICK)
            until(lambda location=location: state(client, location) == "done")
            report = client.get(location).json()
            assert report["result"]["scenario"] == "circle"
            assert report["unrecorded"] == "the record cannot be written: File exists"
            locations.append(location)
        # only so many are kept, and the oldest goes first
        listed = client.get(f"{API}/jobs").json()
        assert [f"{API}/jobs/{job['id']}" for job in listed] == locations[:0:-1]
        assert listed[0]["request"] == report["request"]
        assert listed[0]["unrecorded"] == report["unrecorded"]
        assert client.get(locations[0]).status_code == 404
