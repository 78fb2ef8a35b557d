"""SIGTERM ends the server within its grace, whatever runs."""

from __future__ import annotations

import os
import signal
import urllib.request
from pathlib import Path

import pytest

from tests.library.served import address
from tests.server.forkservers import LOADED

SERVE = """
import threading, time
from motionlab.server import app, serve
from motionlab.server.settings_sources import load

serve._GRACE_SECONDS, serve._CLOSING_SECONDS = 1, 1.0
make = app.create_app

async def stuck():
    time.sleep(600)

def create_app(settings):
    made = make(settings)
    made.add_api_route("/thread", lambda: time.sleep(600))
    made.add_api_route("/loop", stuck)
    made.router.routes[:0] = [made.router.routes.pop(), made.router.routes.pop()]
    return made

serve.create_app = create_app
serve.serve(load({"port": 0}))
"""


@pytest.mark.parametrize(
    ("stuck", "code"),
    [(None, -signal.SIGTERM), ("thread", -signal.SIGTERM), ("loop", 128 + signal.SIGTERM)],
)
def test_sigterm_ends_it(tmp_path: Path, stuck: str | None, code: int) -> None:
    environment = os.environ | {"MOTIONLAB_DATA": str(tmp_path)}
    told = tmp_path / "stderr.txt"
    with told.open("wb") as stderr:
        server = LOADED.run(("-c", SERVE), environment, tmp_path, [0, 1, stderr.fileno()])
    try:
        url = address(server, told)
        urllib.request.urlopen(f"{url}/api/v1/health", timeout=60.0).close()
        if stuck:
            with pytest.raises(TimeoutError):
                urllib.request.urlopen(f"{url}/{stuck}", timeout=0.5)
        server.send_signal(signal.SIGTERM)
        assert server.wait(60.0) == code
    finally:
        server.kill()
        server.wait()
