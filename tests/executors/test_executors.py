"""Executors: the same results in the same order wherever tasks are computed; refusals."""

from __future__ import annotations

import contextlib
import json
import shutil
import signal
import socket
import struct
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
from motionlab.executors.executor import WorkerLost, current, executing, opened
from motionlab.server.settings import Settings
from motionlab.studies.table import BY_KIND
from tests.dask_cluster import Lab, cluster
from tests.executors.tasks import broken, slow
from tests.processes import runs
from tests.server.live import API, until
from tests.server.servers import PATIENCE, Server

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
    pytest.importorskip("distributed", reason="no Dask: pip install distributed")


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    needs_dask()
    with cluster(folder=tmp_path_factory.mktemp("dask")) as lab:
        yield lab


def documents(scheduler: str) -> dict[str, str]:
    """Return what each study finds, all of them with the same workers."""
    with executing(scheduler):
        return {
            kind: BY_KIND[kind].run(BY_KIND[kind].plan(asked), lambda *_: None).model_dump_json()
            for kind, asked in STUDIES.items()
        }


def test_every_executor_finds_the_same(lab: Lab) -> None:
    here = documents("threads")
    assert documents("processes:2") == here
    assert documents(lab.address) == here


def test_processes_tell_how_far_their_tasks_are_before_one_has_ended() -> None:
    shares: list[float] = []
    with opened("processes:2") as executor:
        assert list(executor.map(slow, [1, 2, 3, 4], shares.append)) == [1, 4, 9, 16]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0
    assert any(0.0 < share < 0.25 for share in shares)


class Enough(Exception):
    """Raised by a progress function."""


@pytest.mark.parametrize("scheduler", ["threads", "processes:2", "cluster"])
def test_progress_cancels_and_the_first_task_that_fails_is_told(scheduler: str, lab: Lab) -> None:
    def cancel(share: float) -> None:
        if share > 0:
            raise Enough

    with executing(lab.address if scheduler == "cluster" else scheduler):
        with pytest.raises(Enough):
            list(current().map(slow, range(200), cancel))
        before = time.monotonic()
        assert list(current().map(slow, [3, 4])) == [9, 16]
        assert time.monotonic() - before < 20.0  # 200 tasks would take 30 s
        with pytest.raises(ConfigError) as caught:
            list(current().map(broken, range(4)))
    assert caught.value.errors == (FieldError("task 1", "is odd", 1, "even"),)


def test_a_map_of_the_user_goes_along(
    lab: Lab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from motionlab.motor_design.kept_maps import map_file, save
    from motionlab.motor_design.kept_maps import named_map as named

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
    config = pytest.importorskip("dask", reason="no Dask: pip install distributed").config
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
    with pytest.raises(ConfigError, match=r"needs the extra cluster: "):
        opened("tcp://127.0.0.1:8786")


def test_no_scheduler_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    needs_dask()
    monkeypatch.setattr("motionlab.executors.cluster._SECONDS", 1.0)
    with (
        executing("tcp://127.0.0.1:1"),
        pytest.raises(WorkerLost, match="no Dask scheduler answers"),
    ):
        list(current().map(slow, [1]))


def _frames(*frames: bytes) -> bytes:
    """Return a message as Dask sends it: its length, its frames' number and lengths, its frames."""
    head = struct.pack(f"<{1 + len(frames)}Q", len(frames), *map(len, frames))
    body = head + b"".join(frames)
    return struct.pack("<Q", len(body)) + body


@pytest.mark.parametrize(
    "says",
    [
        b"",
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        struct.pack("<Q", 64) + bytes(64),
        struct.pack("<Q", 64) + b"x" * 64,
        struct.pack("<Q", 8) + struct.pack("<Q", 10**9),
        _frames(b"\xc0"),
        _frames(b"\x80"),
        _frames(b"\x93\x01\x02\x03"),
    ],
)
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
    """Greet whoever connects, and read nothing."""
    server.settimeout(0.1)
    with contextlib.ExitStack() as stack:
        while not ended.is_set():
            with contextlib.suppress(OSError):
                connection, _ = server.accept()
                stack.enter_context(connection).sendall(says)


def test_a_study_ends_without_its_scheduler(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """One that is stopped for a while, which serves again later, and one that is killed."""
    needs_dask()
    monkeypatch.setattr("motionlab.executors.cluster._LOST_SECONDS", 3.0)
    with cluster(1, folder=tmp_path) as lab:
        for name in (signal.SIGSTOP, signal.SIGKILL):
            lost: list[signal.Signals] = []

            def lose(share: float, name: signal.Signals = name, lost: Any = lost) -> None:
                if share > 0.0 and not lost:
                    lost.append(name)
                    lab.scheduler.send_signal(name)

            with (
                pytest.raises(WorkerLost, match=r"does not answer|was lost"),
                executing(lab.address),
            ):
                list(current().map(slow, range(200), lose))
            assert capfd.readouterr().err == ""
            lab.scheduler.send_signal(signal.SIGCONT)


def tasks_at_work(client: Any) -> bool:
    """Tell whether a worker of a cluster is carrying out a task of ours."""
    stacks = client.call_stack().values()
    return any(key.startswith("motionlab-") for tasks in stacks for key in tasks)


def test_commands_and_jobs_are_computed_there(
    lab: Lab, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    import distributed

    assert main(COMMAND) == 0
    here = json.loads(capsys.readouterr().out)
    monkeypatch.setenv("MOTIONLAB_SCHEDULER", lab.address)
    assert main(COMMAND) == 0
    assert json.loads(capsys.readouterr().out) == here
    monkeypatch.delenv("MOTIONLAB_SCHEDULER")

    server = Server(Settings(scheduler=lab.address))
    with (
        contextlib.ExitStack() as stopped,
        httpx.Client(base_url=server.url, timeout=PATIENCE) as client,
    ):
        stopped.callback(server.stop)
        body = {"grid": [{"path": "plant.x.mass", "start": 5, "stop": 7, "count": 3}], "set": SET}
        at = client.post(f"{API}/sweep", json=body).headers["location"]
        until(lambda: client.get(at).json()["state"] in {"done", "failed"})
        assert client.get(at).json()["result"] == here
        with distributed.Client(lab.address, set_as_default=False) as look:
            long = client.post(f"{API}/montecarlo", json={"cases": 3000})
            at = long.headers["location"]
            until(lambda: tasks_at_work(look))
            client.delete(at)
            until(lambda: client.get(at).json()["state"] == "cancelled")
        before = time.monotonic()
        again = client.post(f"{API}/sweep", json=body | {"set": SET | {"seed": 3}})
        at = again.headers["location"]
        until(lambda: client.get(at).json()["state"] == "done")
        assert time.monotonic() - before < 20.0  # the rest of 3000 plants would take longer
    assert all(runs(worker.pid) for worker in lab.workers)


def test_a_lost_worker_costs_no_result_and_the_last_one_ends_a_study(
    lab: Lab, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """The last test: it takes the workers of all others."""
    shares: list[float] = []
    with executing(lab.address):
        found = []
        for result in current().map(slow, range(30), shares.append):
            found.append(result)
            if len(found) == 4:
                lab.workers[0].kill()
    assert found == [number * number for number in range(30)]  # and none comes twice
    assert shares == sorted(shares)
    assert shares[-1] == 1.0

    monkeypatch.setattr("motionlab.executors.cluster._LOST_SECONDS", 3.0)

    def lose(share: float) -> None:
        if share > 0.0:
            lab.workers[1].kill()

    with pytest.raises(WorkerLost, match="has no workers left"), executing(lab.address):
        list(current().map(slow, range(200), lose))
    assert capfd.readouterr().err == ""

    monkeypatch.setattr("motionlab.executors.cluster._SECONDS", 1.0)
    with executing(lab.address), pytest.raises(WorkerLost, match="has no workers"):
        list(current().map(slow, [1]))
