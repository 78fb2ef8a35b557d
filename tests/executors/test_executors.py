"""Executors: the same results in the same order wherever tasks are computed; refusals."""

from __future__ import annotations

import contextlib
import json
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.cli import main
from motionlab.errors import ConfigError, FieldError
from motionlab.executors.executor import Progress, WorkerLost, current, executing, opened
from motionlab.service.settings import Settings
from motionlab.studies.table import BY_KIND
from tests.dask_cluster import Lab, cluster
from tests.processes import runs
from tests.service.live import API, until
from tests.service.servers import PATIENCE, Server

SET = {"trajectory.frequency": 4.0, "trajectory.radius": 0.002}
STUDIES: dict[str, dict[str, Any]] = {
    "monte-carlo": {"cases": 40, "set": SET},
    "sweep": {
        "set": SET,
        "grid": [{"path": "trajectory.frequency", "values": [4.0, 50.0, 3.0]}],
    },
    "landscape": {"points": 8, "set": SET},
}
COMMAND = ["sweep", "circle", "--json", "--grid", "plant.x.mass=5:7:3"]
COMMAND += [part for path, value in SET.items() for part in ("--set", f"{path}={value}")]


def needs_dask() -> None:
    pytest.importorskip("distributed", reason="no Dask: pip install 'motionlab[cluster]'")


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    needs_dask()
    with cluster(folder=tmp_path_factory.mktemp("dask")) as lab:
        yield lab


@pytest.fixture
def own(tmp_path: Path) -> Iterator[Lab]:
    """Return a cluster whose workers may be ended."""
    needs_dask()
    with cluster(folder=tmp_path) as lab:
        yield lab


def document(kind: str, scheduler: str) -> str:
    study = BY_KIND[kind]
    with executing(scheduler):
        return study.run(study.plan(STUDIES[kind]), lambda *_: None).model_dump_json()


@pytest.mark.parametrize("kind", STUDIES)
def test_every_executor_finds_the_same(kind: str, lab: Lab) -> None:
    here = document(kind, "threads")
    assert document(kind, "processes:2") == here
    assert document(kind, lab.address) == here


def slow(number: int, progress: Progress) -> int:
    """Return a square after a while."""
    for step in range(10):
        progress(step / 10)
        time.sleep(0.03)
    return number * number


def test_a_lost_worker_costs_no_result_and_none_comes_twice(own: Lab) -> None:
    shares: list[float] = []
    with executing(own.address):
        found = []
        for result in current().map(slow, range(30), shares.append):
            found.append(result)
            if len(found) == 4:
                own.workers[0].kill()
    assert found == [number * number for number in range(30)]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


class Enough(Exception):
    """Raised by a progress function."""


@pytest.mark.parametrize("scheduler", ["threads", "processes:2", "cluster"])
def test_progress_cancels(scheduler: str, lab: Lab) -> None:
    def cancel(share: float) -> None:
        if share > 0:
            raise Enough

    with executing(lab.address if scheduler == "cluster" else scheduler):
        with pytest.raises(Enough):
            list(current().map(slow, range(200), cancel))
        before = time.monotonic()
        assert list(current().map(slow, [3, 4])) == [9, 16]
        assert time.monotonic() - before < 20.0  # 200 tasks would take 30 s


def broken(number: int, progress: Progress) -> int:
    """Fail for every other task, the later the sooner."""
    time.sleep(0.05 * (4 - number))
    if number % 2:
        raise ConfigError(FieldError(f"task {number}", "is odd", number, "even"))
    return number


@pytest.mark.parametrize("scheduler", ["threads", "processes:2", "cluster"])
def test_the_first_task_that_fails_is_told(scheduler: str, lab: Lab) -> None:
    with executing(lab.address if scheduler == "cluster" else scheduler):
        with pytest.raises(ConfigError) as caught:
            list(current().map(broken, range(4)))
    assert caught.value.errors == (FieldError("task 1", "is odd", 1, "even"),)


def test_a_map_of_the_user_goes_along(
    lab: Lab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motionlab.store.maps import map_file, save
    from motionlab.store.maps import named_map as named

    assert map_file("mine") is None
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    (tmp_path / "maps").mkdir()
    save(named("previous-design"), tmp_path / "maps" / "mine.json")
    study = BY_KIND["sweep"]
    request = {"set": SET, "grid": [{"path": "plant.x.force_map", "values": ["mine"]}]}
    found = {}
    for scheduler in ("threads", lab.address):
        with executing(scheduler):
            found[scheduler] = study.run(study.plan(request), lambda *_: None)
    assert found["threads"] == found[lab.address]
    assert not found["threads"].infeasible


OTHER = """\
from motionlab.executors import code
code.model_hash = lambda: "0123456789abcdef"
"""


def test_a_worker_with_another_model_is_refused(tmp_path: Path) -> None:
    needs_dask()
    preload = tmp_path / "other.py"
    preload.write_text(OTHER)
    with cluster(1, "--preload", str(preload), folder=tmp_path) as lab, executing(lab.address):
        with pytest.raises(Exception, match=r"worker tcp://127\S+ runs another.*0123456789abcdef"):
            list(current().map(slow, [1]))


@pytest.mark.parametrize(
    ("scheduler", "said"),
    [
        ("tcp://10.0.0.1:8786", "is not encrypted"),
        ("tcp://example.org:8786", "is not encrypted"),
        ("tcp://0.0.0.0:8786", "is not encrypted"),
        ("tcp://127.0.0.1", "needs host and port"),
        ("tls://scheduler", "needs host and port"),
        ("tcp://127.0.0.1:port", "needs host and port"),
        ("processes:0", "threads, processes"),
        ("dask", "threads, processes"),
        ("ucx://127.0.0.1:1", "threads, processes"),
    ],
)
def test_what_is_no_scheduler_is_refused(
    scheduler: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ConfigError, match=said):
        opened(scheduler)
    assert main([*COMMAND, "--scheduler", scheduler]) == 2
    assert said in capsys.readouterr().err


def test_tls_asks_for_certificates() -> None:
    needs_dask()
    with pytest.raises(ConfigError, match="set DASK_DISTRIBUTED__COMM__TLS__CA_FILE, DASK_"):
        opened("tls://example.org:8786")


def test_a_cluster_behind_a_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    config = pytest.importorskip("dask", reason="no Dask: pip install 'motionlab[cluster]'").config
    if shutil.which("openssl") is None:
        pytest.skip("no openssl to make a certificate")
    key, certificate = str(tmp_path / "cluster.key"), str(tmp_path / "cluster.pem")
    made = ("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-subj", "/CN=motionlab")
    files = ("-keyout", key, "-out", certificate)
    subprocess.run((*made, *files), check=True, capture_output=True)
    settings = {"require-encryption": True, "tls.ca-file": certificate}
    for who in ("client", "scheduler", "worker"):
        settings |= {f"tls.{who}.cert": certificate, f"tls.{who}.key": key}
    for name, value in settings.items():
        variable = name.upper().replace(".", "__").replace("-", "_")
        monkeypatch.setenv(f"DASK_DISTRIBUTED__COMM__{variable}", str(value))
    with (
        config.set({f"distributed.comm.{name}": value for name, value in settings.items()}),
        cluster(1, folder=tmp_path, protocol=("--protocol", "tls")) as lab,
        executing(lab.address),
    ):
        assert lab.address.startswith("tls://")
        assert list(current().map(slow, [1, 2])) == [1, 4]


def test_without_dask_a_line_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(ConfigError, match=r"pip install 'motionlab\[cluster\]'"):
        opened("tcp://127.0.0.1:8786")


def test_no_scheduler_and_no_workers_are_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs_dask()
    monkeypatch.setattr("motionlab.executors.cluster._SECONDS", 1.0)
    with (
        executing("tcp://127.0.0.1:1"),
        pytest.raises(WorkerLost, match="no Dask scheduler answers"),
    ):
        list(current().map(slow, [1]))
    with cluster(0, folder=tmp_path) as lab, executing(lab.address):
        with pytest.raises(WorkerLost, match="has no workers"):
            list(current().map(slow, [1]))


@pytest.mark.parametrize("says", [b"", b"HTTP/1.1 400 Bad Request\r\n\r\n"])
def test_a_port_without_dask_is_told(says: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    needs_dask()
    monkeypatch.setattr("motionlab.executors.cluster._SECONDS", 1.0)
    ended = threading.Event()
    with socket.create_server(("127.0.0.1", 0)) as server, contextlib.ExitStack() as stack:
        greeter = threading.Thread(target=_greet, args=(server, says, ended))
        greeter.start()
        stack.callback(greeter.join)
        stack.callback(ended.set)
        address = f"tcp://127.0.0.1:{server.getsockname()[1]}"
        with executing(address), pytest.raises(WorkerLost, match="no Dask scheduler answers"):
            list(current().map(slow, [1]))


def _greet(server: socket.socket, says: bytes, ended: threading.Event) -> None:
    connection, _ = server.accept()
    with connection, contextlib.suppress(OSError):
        connection.sendall(says)
        ended.wait(PATIENCE)


@pytest.mark.parametrize("lost", ["workers", "scheduler stopped", "scheduler killed"])
def test_a_study_ends_without_workers_or_scheduler(
    lost: str, own: Lab, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("motionlab.executors.cluster._LOST_SECONDS", 3.0)

    def lose(share: float) -> None:
        if share > 0.0 and not gone:
            gone.extend(own.workers if lost == "workers" else [own.scheduler])
            for process in gone:
                process.send_signal(signal.SIGSTOP if lost.endswith("stopped") else signal.SIGKILL)

    gone: list[subprocess.Popen[str]] = []
    said = "has no workers left" if lost == "workers" else "does not answer|was lost"
    with pytest.raises(WorkerLost, match=said), executing(own.address):
        list(current().map(slow, range(200), lose))
    assert capfd.readouterr().err == ""


def test_commands_and_jobs_are_computed_there(
    own: Lab, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(COMMAND) == 0
    here = json.loads(capsys.readouterr().out)
    monkeypatch.setenv("MOTIONLAB_SCHEDULER", own.address)
    assert main(COMMAND) == 0
    assert json.loads(capsys.readouterr().out) == here
    monkeypatch.delenv("MOTIONLAB_SCHEDULER")

    server = Server(Settings(scheduler=own.address))
    with (
        contextlib.ExitStack() as stopped,
        httpx.Client(base_url=server.url, timeout=PATIENCE) as client,
    ):
        stopped.callback(server.stop)
        body = {"grid": [{"path": "plant.x.mass", "start": 5, "stop": 7, "count": 3}], "set": SET}
        at = client.post(f"{API}/sweep", json=body).headers["location"]
        until(lambda: client.get(at).json()["state"] in {"done", "failed"})
        assert client.get(at).json()["result"] == here
        long = client.post(f"{API}/montecarlo", json={"cases": 3000})
        at = long.headers["location"]
        until(lambda: client.get(at).json()["progress"] > 0.0)
        client.delete(at)
        until(lambda: client.get(at).json()["state"] == "cancelled")
        before = time.monotonic()
        again = client.post(f"{API}/sweep", json=body | {"set": SET | {"seed": 3}})
        at = again.headers["location"]
        until(lambda: client.get(at).json()["state"] == "done")
        assert time.monotonic() - before < 20.0  # the rest of 3000 plants would take longer
    assert all(runs(worker.pid) for worker in own.workers)
