"""No answer names a folder of the server, whatever goes wrong there."""

from __future__ import annotations

import errno
import os
import shutil
import sys
from collections.abc import Iterator
from pathlib import Path

import httpx
import pytest

from motionlab import files
from motionlab.config.named_configs import config_root, data_root
from motionlab.motor_design import kept_maps as maps
from motionlab.server.settings import Settings
from motionlab.server.view3d.processes import Scenes
from tests.server.live import API
from tests.server.servers import PATIENCE, Server

TABLE = {"kind": "circle", "radius": 0.015, "frequency": 0.3333, "laps": 3}


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """Return a server whose folder of data holds a damaged file of each kind."""
    data = tmp_path_factory.mktemp("data")
    for folder, name in (("trajectories", "bad.toml"), ("maps", "bad.json")):
        (data / folder).mkdir()
        (data / folder / name).write_text("damaged")
    (data / "jobs").mkdir()
    (data / "jobs" / f"{'A' * 12}.jsonl").write_text("damaged\ndamaged\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(data))
        server = Server(Settings())
        yield server
        server.stop()


@pytest.fixture
def client(server: Server) -> Iterator[httpx.Client]:
    """Return a client that refuses any answer with a path of the server in it."""
    hidden = [str(data_root()), str(config_root()), sys.prefix, "/tmp/", str(Path.home())]

    def check(response: httpx.Response) -> None:
        told = response.read().decode("utf-8", "replace")
        assert [path for path in hidden if path in told] == [], told

    hooks = {"response": [check]}
    with httpx.Client(base_url=server.url, event_hooks=hooks, timeout=PATIENCE) as client:
        yield client


def status(response: httpx.Response) -> int:
    return response.status_code


def test_damaged_files(client: httpx.Client) -> None:
    assert status(client.get(f"{API}/trajectories/bad")) == 422
    assert status(client.get(f"{API}/trajectories")) == 200
    assert status(client.get(f"{API}/maps/bad")) == 422
    assert status(client.get(f"{API}/maps/bad/file")) == 422
    assert status(client.get(f"{API}/maps/bad/fit")) == 422
    assert status(client.get(f"{API}/maps")) == 200
    assert status(client.get(f"{API}/jobs")) == 200
    assert status(client.get(f"{API}/jobs/{'A' * 12}")) == 404
    simulated = client.post(f"{API}/simulate", json={"set": {"plant.force_map": "bad"}})
    assert status(simulated) == 422


def test_damaged_configs(
    client: httpx.Client, monkeypatch: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory
) -> None:
    copy = tmp_path_factory.mktemp("other") / "configs"
    shutil.copytree(config_root(), copy)
    (copy / "scenarios" / "bad.toml").write_text("damaged")
    (copy / "trajectories" / "worse.toml").write_text("damaged")
    monkeypatch.setenv("MOTIONLAB_CONFIGS", str(copy))
    for path in ("scenarios/bad", "trajectories/worse", "scenarios"):
        response = client.get(f"{API}/{path}")
        assert response.status_code == 422
        assert str(copy) not in response.text


@pytest.mark.parametrize(
    ("code", "answer"), [(errno.ENOSPC, 507), (errno.EROFS, 503), (errno.EACCES, 503)]
)
def test_a_folder_that_cannot_be_written(
    client: httpx.Client, monkeypatch: pytest.MonkeyPatch, code: int, answer: int
) -> None:
    def refuse(*_: object, **__: object) -> None:
        raise OSError(code, os.strerror(code), str(data_root() / "here"))

    client.put(f"{API}/trajectories/mine", json=TABLE)
    monkeypatch.setattr(files.tempfile, "mkstemp", refuse)
    assert status(client.put(f"{API}/trajectories/mine", json=TABLE)) == answer
    monkeypatch.setattr(Path, "unlink", refuse)
    assert status(client.delete(f"{API}/trajectories/mine")) == answer
    assert status(client.delete(f"{API}/maps/bad")) == answer


def test_no_room_for_maps(client: httpx.Client) -> None:
    large = data_root() / "maps" / "large.json"
    with large.open("wb") as file:
        file.truncate(maps.FOLDER_MOST)
    assert status(client.post(f"{API}/maps", json={"preset": "preview"})) == 507
    large.unlink()


def test_a_stage_that_cannot_be_loaded(server: Server, client: httpx.Client) -> None:
    missing = (
        "import runpy, sys, types; sys.modules['viser'] = types.ModuleType('viser'); "
        f"sys.modules['viser'].__file__ = {sys.prefix + '/viser.py'!r}; "
        "runpy.run_module('motionlab.scene3d', run_name='__main__')"
    )
    for command in ((sys.executable, "-c", missing), ("/tmp/nowhere/python",)):
        server.app.state.scenes = Scenes(most=1, command=command)
        assert status(client.get("/scene/")) == 503
