"""What runs record is bounded: refused for ever, for now, or waited for."""

from __future__ import annotations

import threading
from pathlib import Path

import httpx
import pytest

from motionlab.config.load import load_scenario
from motionlab.server import memory_budget
from motionlab.server.memory_budget import MemoryBudget
from motionlab.server.settings import Settings
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.server.conftest import MakeServer
from tests.server.live import API, until
from tests.server.servers import PATIENCE

CIRCLE = prepare(load_scenario("circle"))


def test_the_size_is_that_of_what_is_kept() -> None:
    recording = run(CIRCLE)
    kept = recording.references.nbytes + sum(v.samples.nbytes for v in recording.variants.values())
    motion = CIRCLE.reference
    arrays = (motion.position, motion.velocity, motion.acceleration, CIRCLE.load)
    assert CIRCLE.recording_size() == kept + sum(array.nbytes for array in arrays)


@pytest.mark.parametrize("call", ["simulate", "whatif"])
def test_what_never_fits_is_refused_by_name(make_server: MakeServer, call: str) -> None:
    size = CIRCLE.recording_size()
    server = make_server(Settings(memory_max=size))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        assert client.post(f"{API}/{call}", json={}).status_code == 200
        jobs = client.get(f"{API}/jobs").json()  # records of other tests
        body = {"set": {"trajectory.laps": 5}}
        for headers in ({}, {"prefer": "respond-async"}):
            answer = client.post(f"{API}/{call}", json=body, headers=headers)
            assert answer.status_code == 422
            (error,) = answer.json()["errors"]
            assert "memory_max" in error["message"]
            assert (error["range"], error["unit"]) == (f"<= {size}", "bytes")
            assert error["value"] > size
        assert client.get(f"{API}/jobs").json() == jobs
        assert client.post(f"{API}/{call}", json={}).status_code == 200  # all was given back


def test_what_does_not_fit_now_is_told_to_come_again(make_server: MakeServer) -> None:
    size = CIRCLE.recording_size()
    server = make_server(Settings(memory_max=size, jobs_at_once=1))
    held: MemoryBudget = server.app.state.memory
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        with held.hold(1):
            for call in ("simulate", "whatif"):
                answer = client.post(f"{API}/{call}", json={})
                assert answer.status_code == 429
                assert f"1 of {size} bytes" in answer.json()["detail"]
            asks = {"prefer": "respond-async"}
            job = client.post(f"{API}/simulate", json={}, headers=asks).json()["id"]
            other = client.post(f"{API}/simulate", json={}, headers=asks).json()["id"]
            # while they wait for memory others have their turn
            direct = client.post(f"{API}/loop/sweep", json={"frequencies": [40.0]})
            location = direct.headers["location"]
            until(lambda: client.get(location).json()["state"] == "done")
            assert client.get(f"{API}/jobs/{job}").json()["state"] == "queued"
            assert client.delete(f"{API}/jobs/{other}").json()["state"] == "cancelled"
        until(lambda: client.get(f"{API}/jobs/{job}").json()["state"] == "done")
        assert client.get(f"{API}/jobs/{other}").json()["state"] == "cancelled"
        until(lambda: held._taken == 0)


def test_sessions_take_theirs_and_give_it_back(make_server: MakeServer) -> None:
    server = make_server(Settings(memory_max=60_000_000))
    variants = {f"variants.{name}": {"controller": "pd"} for name in "CDEFGH"}
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        for _ in range(2):
            ids = [client.post(f"{API}/sessions", json={}).json()["id"] for _ in range(2)]
            answer = client.post(f"{API}/sessions", json={})
            assert answer.status_code == 429
            assert "60000000 bytes" in answer.json()["detail"]
            for session in ids:
                assert client.delete(f"{API}/sessions/{session}").status_code == 204
        answer = client.post(f"{API}/sessions", json={"set": variants})
        assert answer.status_code == 422
        assert "memory_max" in answer.json()["detail"]


def test_no_two_take_the_last_byte() -> None:
    room, taken, begin = MemoryBudget(5), [], threading.Barrier(8)

    def take() -> None:
        begin.wait()
        taken.append(room.try_to_take(1))

    threads = [threading.Thread(target=take) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sum(taken) == 5


@pytest.mark.parametrize(
    ("groups", "limits", "expected"),
    [
        ("0::/\n", {"memory.max": "6000"}, 3000),
        ("0::/a.slice/lab.service\n", {"a.slice/lab.service/memory.max": "4000"}, 2000),
        (
            "0::/a.slice/lab.service\n",
            {"a.slice/lab.service/memory.max": "max", "a.slice/memory.max": "5000"},
            2500,
        ),
        (
            "3:cpu,cpuacct:/x\n4:memory:/docker/abc\n0::/\n",
            {"memory/docker/abc/memory.limit_in_bytes": "8000", "cpu/x/memory.max": "1"},
            4000,
        ),
        ("4:memory:/docker/abc\n", {"memory/memory.limit_in_bytes": "2000"}, 1000),  # a container
        ("0::/nowhere\n", {}, 10_000),
    ],
)
def test_the_limit_of_any_group_counts(
    groups: str,
    limits: dict[str, str],
    expected: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    own = tmp_path / "own"
    own.write_text(groups)
    root = tmp_path / "cgroup"
    for name, limit in limits.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(f"{limit}\n")
    monkeypatch.setattr(memory_budget, "_OWN_CGROUPS", own)
    monkeypatch.setattr(memory_budget, "_CGROUPS", root)
    assert memory_budget.recordable(10_000) == expected
