"""What computes runs in workers, and large bodies are read beside the event loop."""

from __future__ import annotations

import json
import threading
from typing import Any

import httpx
import pytest

from motionlab.server.http import strict_json
from motionlab.server.settings import Settings
from tests.server.conftest import MakeServer
from tests.server.live import API
from tests.server.servers import PATIENCE, Server

CIRCLE = {"kind": "circle", "radius": 0.015, "frequency": 0.3333, "laps": 1}
COMPUTING: list[tuple[str, str, Any]] = [
    ("GET", "/jobs", None),
    ("GET", "/maps", None),
    ("GET", "/maps/new-design", None),
    ("GET", "/maps/new-design/file", None),
    ("GET", "/maps/new-design/fit", None),
    ("GET", "/paper", None),
    ("POST", "/design", {}),
    ("POST", "/design/platform", {}),
    ("POST", "/design/sharing", {}),
    ("POST", "/identify", {"axis": "q"}),
    ("POST", "/identify/plan", {"axis": "x"}),
    ("POST", "/landscape", {"points": 0}),
    ("POST", "/loop", {}),
    ("POST", "/loop/accuracy", {}),
    ("POST", "/loop/response", {}),
    ("POST", "/loop/sweep", {"frequencies": [-1.0]}),
    ("POST", "/maps", {"geometry": {"g": -1.0}}),
    ("POST", "/maps/field", {}),
    ("POST", "/maps/preview", {}),
    ("POST", "/montecarlo", {"cases": 0}),
    ("POST", "/reproduce", {"only": ["nothing"]}),
    ("POST", "/scenarios/parse", None),
    ("POST", "/simulate", {}),
    ("POST", "/trajectories/check", {"trajectory": CIRCLE}),
    ("POST", "/trajectories/slow", {"trajectory": CIRCLE}),
    ("POST", "/tune", {"starts": 0}),
    ("POST", "/whatif", {}),
]


@pytest.fixture(scope="module")
def deserted() -> Any:
    """Return a server whose workers cannot be asked."""
    server = Server(Settings(waiting_max=0))
    workers = server.app.state.workers
    workers._dispatch = lambda: None
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        yield client
    server.stop()


@pytest.mark.parametrize(("method", "path", "body"), COMPUTING)
def test_nothing_is_computed_without_a_worker(
    deserted: httpx.Client, method: str, path: str, body: Any
) -> None:
    answer = deserted.request(method, f"{API}{path}", json=body)
    assert answer.status_code == 429
    assert answer.json()["detail"] == "0 calls wait already"


@pytest.mark.parametrize(("size", "beside"), [(1000, False), (100_000, True)])
def test_large_bodies_are_read_beside_the_event_loop(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch, size: int, beside: bool
) -> None:
    server, threads = make_server(Settings()), []
    read = strict_json._read

    def noted(body: bytes) -> Any:
        threads.append(threading.current_thread().name)
        return read(body)

    monkeypatch.setattr(strict_json, "_read", noted)
    body = json.dumps({"set": {"title": "x" * size}})
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        headers = {"content-type": "application/json"}
        client.post(f"{API}/simulate", content=body, headers=headers)
    assert [name != "server" for name in threads] == [beside]
