"""A server process on a folder of data, which can be killed."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import httpx

API = "/api/v1"
PATIENCE = 120.0


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
        command = [sys.executable, "-m", "motionlab", "serve", "--port", "0"]
        environment = os.environ | {"MOTIONLAB_DATA": str(data)} | variables
        told = data / "stderr.txt"
        with told.open("wb") as stderr:
            self.process = subprocess.Popen(command, stderr=stderr, env=environment)
        end = time.monotonic() + PATIENCE
        while not (found := re.search(r"^Serving (\S+?)/? \(", told.read_text(), re.MULTILINE)):
            assert self.process.poll() is None, told.read_text()
            assert time.monotonic() < end, told.read_text()
            time.sleep(0.02)
        url = re.sub(r"/docs$", "", found[1])
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
