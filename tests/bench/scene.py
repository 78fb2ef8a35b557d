"""What a watched 3-D view costs, and what a viewer that joins late costs the others."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import httpx
import numpy as np

from motionlab.scene3d import protocol
from tests.bench.table import Row
from tests.scene3d.viewers import Viewer

_SECONDS = 10.0
_SHARE = 0.05
_SHOWN = 1_000_000
_MESSAGES_A_POSE = 9
_STALL = 0.1  # s
_ORIGIN = "lab://bench"


def scene() -> Iterator[Row]:
    """Measure a session at real time with and without a viewer, then a late join."""
    yield _cost()
    yield _late_join()


def _cost() -> Row:
    command = (sys.executable, "-m", "motionlab", "serve", "--port", "0")
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as server:
        try:
            assert server.stderr is not None
            found = re.search(r":(\d+)/", server.stderr.readline())
            assert found
            port = int(found[1])
            with httpx.Client(base_url=f"http://127.0.0.1:{port}", timeout=60) as client:
                session = client.post("/api/v1/sessions", json={}).json()["id"]
                client.post(f"/api/v1/sessions/{session}/play")
                client.get("/api/v1/scenarios/circle")
                time.sleep(8.0)  # until what a server loads after its start is there
                alone = _busy([server.pid])
                with Viewer(f"ws://127.0.0.1:{port}/scene/{session}/") as viewer:
                    _read_on(viewer.look())
                    time.sleep(6.0)  # until the trace is as long as it gets
                    watched = _busy([server.pid, *_children(server.pid)])
        finally:
            server.terminate()
    share = watched - alone
    return Row(
        f"3-D view watched, {protocol.RATE:g} Hz, both processes",
        f"< {_SHARE:.0%} of a core",
        f"{share:.1%}",
        f"{alone:.1%} unwatched",
        "",
        share < _SHARE,
    )


def _late_join() -> Row:
    """Send a million updates to one viewer, then let another join while the first reads on."""
    start = protocol.SceneDescription(
        _ORIGIN,
        (protocol.DrawnAxis(0.085, 7.2e-3, 0.0), protocol.DrawnAxis(0.145, 7.2e-3, 0.0)),
        {"A": "", "B": ""},
        [],
    )
    command = (sys.executable, "-m", "motionlab.scene3d")
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdin=pipe, stdout=pipe) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(start.encode())
        process.stdin.flush()
        url = f"ws://127.0.0.1:{json.loads(process.stdout.readline())['port']}"
        pose = np.zeros((1, protocol.width(2)), np.float32)
        with Viewer(url, _ORIGIN) as first:
            arrivals = _read_on(first.look())
            time.sleep(1.0)
            for shown in range(_SHOWN // _MESSAGES_A_POSE):
                pose[:] = 0.01 * np.sin(0.01 * shown + np.arange(pose.size))
                process.stdin.write(protocol.poses(pose))
            process.stdin.flush()
            quiet = _longest_gap(process, arrivals, pose, None)
            stalled = _longest_gap(process, arrivals, pose, url)
        process.stdin.close()
        process.wait()
    return Row(
        f"longest gap as another joins, {_SHOWN:.0e} updates on",
        f"< {_STALL * 1e3:g} ms",
        f"{stalled * 1e3:.0f} ms",
        f"{quiet * 1e3:.0f} ms with none joining",
        f"{stalled / quiet:.1f}",
        stalled < _STALL,
    )


def _longest_gap(
    process: subprocess.Popen[bytes],
    arrivals: list[float],
    pose: protocol.Values,
    joins: str | None,
) -> float:
    """Return the longest time between two windows of the first viewer, at the usual rate, s."""
    assert process.stdin is not None
    before = len(arrivals)
    other = None
    for tick in range(round(3.0 * protocol.RATE)):
        pose[:] = 0.01 * np.sin(0.1 * tick + np.arange(pose.size))
        process.stdin.write(protocol.poses(pose))
        process.stdin.flush()
        time.sleep(1.0 / protocol.RATE)
        if joins is not None and other is None and tick > protocol.RATE:
            other = Viewer(joins, _ORIGIN)
            _read_on(other.look())
    if other is not None:
        other.socket.close()
    return float(np.diff(arrivals[before:]).max())


def _read_on(viewer: Viewer) -> list[float]:
    """Read in a thread until the connection ends; return when each window came, growing."""
    arrivals: list[float] = []

    def read() -> None:
        for _ in viewer.socket:
            arrivals.append(time.perf_counter())

    threading.Thread(target=read, daemon=True).start()
    return arrivals


def _children(pid: int) -> list[int]:
    tasks = Path(f"/proc/{pid}/task")
    return [
        int(child) for task in tasks.iterdir() for child in (task / "children").read_text().split()
    ]


def _busy(pids: list[int]) -> float:
    """Return the share of a core that processes take over some seconds."""
    before = sum(map(_seconds, pids))
    time.sleep(_SECONDS)
    return (sum(map(_seconds, pids)) - before) / _SECONDS


def _seconds(pid: int) -> float:
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")
