"""A server process on a folder of data, which can be killed."""

from __future__ import annotations

import os
import re
import subprocess
import time
from pathlib import Path
from typing import Any, BinaryIO

import httpx

from tests.server.forkservers import LOADED

API = "/api/v1"
SERVE = ("-m", "motionlab", "serve", "--port", "0")
PATIENCE = 120.0


def address(server: subprocess.Popen[bytes], told: Path) -> str:
    """Return where a server listens, once the file of its stderr says so."""
    end = time.monotonic() + PATIENCE
    while not (found := re.search(r"^Serving (\S+?)/? \(", told.read_text(), re.MULTILINE)):
        assert server.poll() is None, told.read_text()
        assert time.monotonic() < end, told.read_text()
        time.sleep(0.02)
    return re.sub(r"/docs$", "", found[1])


def serve(environment: dict[str, str], stderr: BinaryIO) -> subprocess.Popen[bytes]:
    """Start ``motionlab serve`` on a free port, without what an interpreter takes to load it."""
    return LOADED.run(SERVE, environment, Path.cwd(), [0, 1, stderr.fileno()])


class Served:
    """``motionlab serve`` on a free loopback port.

    Parameters
    ----------
    data : Path
        Folder of its data, and of what it writes to stderr.
    **variables : str
        Of its environment.
    """

    def __init__(self, data: Path, **variables: str) -> None:
        data.mkdir(parents=True, exist_ok=True)
        environment = os.environ | {"MOTIONLAB_DATA": str(data)} | variables
        told = data / "stderr.txt"
        with told.open("wb") as stderr:
            self.process = serve(environment, stderr)
        url = address(self.process, told)
        self.client = httpx.Client(base_url=url, timeout=PATIENCE, trust_env=False)

    def kill(self) -> None:
        """End it as a lack of memory does."""
        self.process.kill()
        self.process.wait()
        self.client.close()

    def end(self) -> None:
        """End it as Ctrl-C does."""
        self.process.terminate()
        self.process.wait(PATIENCE)
        self.client.close()

    def play(self, speed: float = 1.0, **changes: Any) -> str:
        """Begin a session that plays, and return its path."""
        answer = self.client.post(f"{API}/sessions", json={"set": changes}).raise_for_status()
        path = answer.headers["location"]
        self.client.post(f"{path}/play", json={"speed": speed}).raise_for_status()
        return path

    def session(self, path: str) -> dict[str, Any]:
        """Return what is known of a session."""
        return self.client.get(path).raise_for_status().json()

    def runs(self, query: str = "") -> list[dict[str, Any]]:
        """Return the runs that a search finds."""
        parameters = {"q": query, "limit": 200}
        return self.client.get(f"{API}/runs", params=parameters).raise_for_status().json()["runs"]

    def settled(self) -> list[dict[str, Any]]:
        """Return all runs once none is being recorded."""
        end = time.monotonic() + PATIENCE
        while "recording" in [run["state"] for run in self.runs()]:
            assert time.monotonic() < end
            time.sleep(0.05)
        return self.runs()
