"""``motionlab serve`` as a process of its own, watched from outside."""

from __future__ import annotations

import contextlib
import os
import re
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import httpx

API = "/api/v1"
_PATIENCE = 30.0  # s
_UNUSUAL = {"MOTIONLAB_TOKEN", "PYTHONDONTWRITEBYTECODE"}
"""Variables that would have it ask for a token, or compile its own sources at every start."""


class Serving:
    """A server process on a free loopback port; ends with the ``with`` block.

    Parameters
    ----------
    program : str
        The module that is run.
    **variables : str
        Of its environment.

    Attributes
    ----------
    begun : float
        When the process was started, s of ``time.perf_counter()``.
    port : int
        Where it listens.
    client : httpx.Client
        Talks to its REST interface.
    """

    def __init__(self, program: str = "motionlab", **variables: str) -> None:
        environment = {k: v for k, v in os.environ.items() if k not in _UNUSUAL} | variables
        if program != "motionlab":  # two servers cannot share a folder of data
            self._data = tempfile.TemporaryDirectory()
            environment["MOTIONLAB_DATA"] = self._data.name
        command = (sys.executable, "-m", program, "serve", "--port", "0")
        self.begun = time.perf_counter()
        self._process = subprocess.Popen(
            command, stderr=subprocess.PIPE, text=True, env=environment
        )
        assert self._process.stderr is not None
        line = self._process.stderr.readline()
        found = re.search(r":(\d+)/", line)
        if found is None:
            self._process.kill()
            raise RuntimeError(f"the server did not start: {line}")
        self.port = int(found[1])
        self.client = httpx.Client(base_url=self.url, timeout=_PATIENCE, trust_env=False)

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://127.0.0.1:{self.port}"

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.client.close()
        self._process.terminate()
        self._process.wait(_PATIENCE)
        assert self._process.stderr is not None
        self._process.stderr.close()

    def post(self, path: str, **body: Any) -> dict[str, Any]:
        """Ask for something that has to succeed, and return the answer."""
        return self.client.post(f"{API}{path}", json=body).raise_for_status().json()

    def warm(self) -> None:
        """Return once what a simulation needs is loaded."""
        self.post("/simulate", scenario="circle")

    def cpu(self) -> float:
        """Return the processor time that it has used, user and system, s."""
        return _cpu(self._process.pid)

    def tree_cpu(self) -> float:
        """Return the processor time of it and its child processes that live, s."""
        return sum(map(_cpu, (self._process.pid, *_children(self._process.pid))))

    def resident(self) -> int:
        """Return its resident memory, bytes."""
        return int(_proc(self._process.pid, "statm").split()[1]) * os.sysconf("SC_PAGE_SIZE")

    def tree(self) -> int:
        """Return the resident memory of it and its child processes, shared pages once, bytes."""
        return sum(map(_proportional, (self._process.pid, *_children(self._process.pid))))


def _cpu(pid: int) -> float:
    """Return the processor time that a process has used, user and system, s; 0 if it has ended."""
    with contextlib.suppress(OSError):
        fields = _proc(pid, "stat").rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
    return 0.0


def _proportional(pid: int) -> int:
    """Return a process's resident memory, its part of what it shares with others, bytes."""
    with contextlib.suppress(OSError):  # it has ended
        found = re.search(r"^Pss:\s+(\d+) kB", _proc(pid, "smaps_rollup"), re.MULTILINE)
        return 0 if found is None else int(found[1]) * 1024
    return 0


def _children(pid: int) -> list[int]:
    """Return the processes below one."""
    found: list[int] = []
    with contextlib.suppress(OSError):
        for task in Path("/proc", str(pid), "task").iterdir():
            for child in map(int, (task / "children").read_text(encoding="ascii").split()):
                found += [child, *_children(child)]
    return found


def _proc(pid: int, name: str) -> str:
    return Path("/proc", str(pid), name).read_text(encoding="ascii")
