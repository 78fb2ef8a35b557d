"""Jobs run in processes: how they end, are cancelled, fail, and are interrupted."""

from __future__ import annotations

import json
import logging
import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.server import kernel_compiler
from motionlab.server.jobs import Jobs, JobTask
from motionlab.server.settings import Settings
from motionlab.server.workers import fork_client
from motionlab.simulation import precompile
from tests.library.served import Served
from tests.processes import runs
from tests.server import calls
from tests.server.conftest import MakeServer
from tests.server.live import API, until
from tests.server.servers import PATIENCE, Server

SEARCH: dict[str, Any] = {"scenario": "circle", "evaluations": 2000, "starts": 8}
LONG_SEARCH = SEARCH | {"starts": 16, "plants": ["matched"]}
"""Goes on for longer than from one record of its progress to the next, 5 s, on any machine."""


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    return tmp_path


@pytest.fixture
def server(make_server: MakeServer, data: Path) -> Server:
    return make_server(Settings(jobs_at_once=1))


def submit(server: Server, function: Callable[..., Any], size: int = 0, **request: Any) -> str:
    jobs: Jobs = server.app.state.jobs
    work = JobTask("tune", function, json.dumps(request).encode(), size)
    return server.call(jobs.submit(work))[0]


def ended(server: Server, job_id: str) -> dict[str, Any]:
    """Return the last report of a job, as it is recorded."""
    jobs: Jobs = server.app.state.jobs
    until(lambda: jobs.report(job_id) is None)
    report = jobs.records.read(job_id)
    assert report is not None
    return json.loads(report)


def test_a_job_is_done_once_its_record_is(server: Server, data: Path) -> None:
    job = submit(server, calls.job, say="so far")
    report = ended(server, job)
    assert report["state"] == "done"
    assert report["request"] == report["result"] == {"say": "so far"}
    assert report["partial"] == {"said": "so far"}  # also where the end came right after it
    assert (report["progress"], report["error"], report["unrecorded"]) == (1.0, None, None)
    assert [file.name for file in (data / "jobs").iterdir()] == [f"{job}.jsonl"]


def test_a_job_has_a_process_of_low_priority_without_the_token(
    make_server: MakeServer, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_TOKEN", "x" * 16)
    server = make_server(Settings())
    seen = ended(server, submit(server, calls.job_in_its_place))["result"]
    assert "MOTIONLAB_TOKEN" not in seen["names"]
    assert "MOTIONLAB_DATA" in seen["names"]
    assert seen["nice"] > 0


def test_an_unforeseen_error_is_in_the_log_and_not_in_the_report(
    server: Server, caplog: pytest.LogCaptureFixture
) -> None:
    with caplog.at_level(logging.ERROR):
        job = submit(server, calls.job_fails)
        report = ended(server, job)
    assert report["state"] == "failed"
    assert report["error"] == f"an unexpected error; the server's log has it (job {job})"
    (logged,) = caplog.records
    assert job in logged.getMessage()
    assert logged.exc_info is not None
    assert "in job_fails" in "".join(logged.exc_info[1].__notes__)  # pyright: ignore


def test_an_error_that_a_user_can_act_on_is_told(server: Server) -> None:
    report = ended(server, submit(server, calls.job_fails, say="the motor diverged"))
    assert (report["state"], report["error"]) == ("failed", "the motor diverged")


def test_too_much_memory_fails_the_job_alone(server: Server) -> None:
    report = ended(server, submit(server, calls.job_takes_memory, bytes=3_000_000_000))
    assert report["error"] == "this takes more memory than one job may have"
    assert ended(server, submit(server, calls.job, say="next"))["state"] == "done"


def deaf(server: Server, data: Path) -> tuple[str, int]:
    """Return a job that hears nothing, and its process."""
    file = data / "process"
    job = submit(server, calls.job_is_deaf, size=1000, file=str(file))
    until(lambda: file.exists() and file.read_text() != "")
    assert server.app.state.memory._taken == 1000
    return job, int(file.read_text())


def test_a_process_that_is_killed_fails_its_job_and_blocks_nothing(
    server: Server, data: Path
) -> None:
    job, process = deaf(server, data)
    after = submit(server, calls.job, say="next")
    os.kill(process, signal.SIGKILL)
    report = ended(server, job)
    assert report["state"] == "failed"
    assert report["error"] == (
        "the job was not finished: its process was ended by SIGKILL; is there enough memory?"
    )
    assert ended(server, after)["state"] == "done"
    assert server.app.state.memory._taken == 0


def test_a_job_that_does_not_answer_is_killed_when_it_is_cancelled(
    server: Server, data: Path
) -> None:
    job, process = deaf(server, data)
    after = submit(server, calls.job, say="next")
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        assert client.delete(f"{API}/jobs/{job}").json()["state"] == "cancelled"
    until(lambda: not runs(process))
    assert ended(server, after)["state"] == "done"
    assert ended(server, job)["state"] == "cancelled"
    assert server.app.state.memory._taken == 0


def test_jobs_end_where_no_process_can_be_started(
    make_server: MakeServer, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fork_client, "_COMMAND", (sys.executable, "-c", "raise SystemExit(3)"))
    server = make_server(Settings())
    report = ended(server, submit(server, calls.job, say="never"))
    assert report["state"] == "failed"
    assert "cannot be started: its process ended with status 3" in report["error"]
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        answer = client.post(f"{API}/tune", json={})
        assert answer.status_code == 503
        assert "cannot be started" in answer.json()["detail"]


_COLD = """\
from motionlab.server import preload
from motionlab.server.workers import forkserver
preload.warm_up = lambda done: 1 / 0
forkserver.main()"""


def test_a_failed_warm_up_is_named_by_jobs_that_it_may_have_ended(
    make_server: MakeServer, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fork_client, "_COMMAND", (sys.executable, "-c", _COLD))
    server = make_server(Settings())
    assert ended(server, submit(server, calls.job, say="needs nothing"))["state"] == "done"
    report = ended(server, submit(server, calls.job_fails))
    assert report["error"].endswith("not everything could be loaded when the server started")


_LUKEWARM = """\
import time
from motionlab.server import preload
from motionlab.server.workers import forkserver
def warm_up(done):
    done(0.4)
    time.sleep(99)
preload.warm_up = warm_up
forkserver.main()"""


def test_health_tells_how_much_is_compiled(
    make_server: MakeServer, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(precompile, "mark", lambda: data / "batches")
    monkeypatch.setattr(fork_client, "_COMMAND", (sys.executable, "-c", _LUKEWARM))
    server = make_server(Settings())
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        until(lambda: client.get(f"{API}/health").json()["compiled_share"] > 0.0)
        health = client.get(f"{API}/health").json()
        assert (health["compiling"], health["compiled_share"]) == (True, 0.4)
        (data / "batches").touch()
        health = client.get(f"{API}/health").json()
        assert (health["compiling"], health["compiled_share"]) == (False, 1.0)


def test_a_job_that_waits_for_kernels_lets_others_pass(
    make_server: MakeServer, data: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    mark = data / "batches"
    monkeypatch.setattr(precompile, "mark", lambda: mark)
    monkeypatch.setattr(
        kernel_compiler, "COMMAND", (sys.executable, "-c", "import time; time.sleep(99)")
    )
    server = make_server(Settings(jobs_at_once=1))
    jobs: Jobs = server.app.state.jobs
    batch = JobTask("tune", calls.job, b'{"say": "compiled"}', batches=True)
    waiting = server.call(jobs.submit(batch))[0]
    assert ended(server, submit(server, calls.job, say="passes"))["state"] == "done"
    assert json.loads(jobs.report(waiting) or b"")["state"] == "queued"
    mark.touch()
    assert ended(server, waiting)["result"] == {"say": "compiled"}


def recorded(data: Path, location: str) -> dict[str, Any]:
    """Return the summary of a job in the folder of its server."""
    (path,) = data.rglob(f"{location.rpartition('/')[2]}.jsonl")
    return json.loads(path.read_text().splitlines()[0])


@pytest.mark.parametrize("name", [signal.SIGKILL, signal.SIGTERM])
def test_a_job_is_interrupted_by_the_end_of_its_server(
    make_server: MakeServer, data: Path, name: signal.Signals
) -> None:
    served = Served(data)
    try:
        client = served.client
        answer = client.post(f"{API}/tune", json=LONG_SEARCH)
        location = answer.headers["location"]
        until(lambda: client.get(location).json()["progress"] > 0)
        seen = client.get(location).json()["progress"]
        if name is signal.SIGKILL:  # then nothing but the latest record stays
            until(lambda: recorded(data, location)["progress"] > 0)
            seen = recorded(data, location)["progress"]
        served.process.send_signal(name)
        served.process.wait(PATIENCE)
    finally:
        served.kill()
    with httpx.Client(base_url=make_server(Settings()).url, timeout=PATIENCE) as client:
        (listed,) = client.get(f"{API}/jobs").json()
        report = client.get(location).json()
        for told in (listed, report, client.delete(location).json()):
            assert told["state"] == "interrupted"
            assert told["progress"] >= seen > 0
            assert (told["remaining"], told["waits_for"]) == (None, None)
            assert told["error"] == "the server ended before this job did; ask for it again"
            assert told["created"] == answer.json()["created"]
            assert told["request"] == LONG_SEARCH
