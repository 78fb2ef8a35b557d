"""Start of the server: process start to the first answer, and to the first streamed sample."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time
from collections.abc import Iterator

from tests.bench.clients import Client, run
from tests.bench.serving import API, Serving
from tests.bench.table import Row

_REPETITIONS = 5
_HEALTH, _SAMPLE = 1.5, 3.0  # s
_IMPORTS = (sys.executable, "-c", "import fastapi, numba, uvicorn")


def start() -> Iterator[Row]:
    """Start the server again and again; the first start, which may compile, is not counted."""
    imports, health, sample = [], [], []
    for _ in range(_REPETITIONS + 1):
        before = time.perf_counter()
        subprocess.run(_IMPORTS, check=True)
        imports.append(time.perf_counter() - before)
        with Serving() as server:
            server.client.get(f"{API}/health").raise_for_status()
            health.append(time.perf_counter() - server.begun)
        with Serving() as server:
            _first_sample(server)
            sample.append(time.perf_counter() - server.begun)
    reference = statistics.median(imports[1:])
    for what, times, target in (
        ("motionlab serve: process start to /health", health, _HEALTH),
        ("  to the first streamed sample", sample, _SAMPLE),
    ):
        median = statistics.median(times[1:])
        yield Row(
            what,
            f"<= {target:g} s",
            f"{median:.2f} s",
            f"bare imports: {reference:.2f} s",
            f"{median / reference:.2f}",
            median <= target,
        )


def _first_sample(server: Serving) -> None:
    """Create a session, watch it, play, and return when the first binary frame is here."""
    session = server.post("/sessions", scenario="circle")["id"]
    client = Client.connect(server.port, session)
    server.post(f"/sessions/{session}/play")
    while not client.received:
        run([client], 0.001)
    client.stream.close()
