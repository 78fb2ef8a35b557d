"""Start of the server: process start to an answer, to a streamed sample, to the first A and B."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from ctypes.util import find_library

from playwright.sync_api import Browser, sync_playwright

from tests.bench.clients import Client, run
from tests.bench.serving import API, Serving
from tests.bench.table import Row
from tests.e2e.conftest import CHROMIUM, FLAGS, ROOT, VIEW

_REPETITIONS = 5
_HEALTH, _SAMPLE, _CURVES = 1.5, 3.0, 3.0  # s
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
    yield _first_curves(reference)


def _first_curves(reference: float) -> Row:
    """Start servers that have nothing compiled, with the Lab open on each until it draws A and B.

    Parameters
    ----------
    reference : float
        What bare imports take, s.
    """
    what = "  to the first A and B drawn, nothing compiled"
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        return Row(what, "", "not built", "make run builds it")
    if CHROMIUM is None or find_library("atomic") is None:
        return Row(what, "", "skipped", "no Chromium: make browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        median = statistics.median(_curves_drawn(browser) for _ in range(_REPETITIONS))
        browser.close()
    return Row(
        what,
        f"<= {_CURVES:g} s",
        f"{median:.2f} s",
        f"bare imports: {reference:.2f} s",
        f"{median / reference:.2f}",
        median <= _CURVES,
    )


def _curves_drawn(browser: Browser) -> float:
    """Return the time from the start of a server's process to the page's first preview, s."""
    with (
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as cache,
        tempfile.TemporaryDirectory(ignore_cleanup_errors=True) as data,
        Serving(NUMBA_CACHE_DIR=cache, MOTIONLAB_DATA=data) as server,
    ):
        context = browser.new_context(viewport=VIEW)
        opened = context.new_page()
        opened.goto(server.url)
        opened.wait_for_function(
            "() => document.querySelector('footer').innerText.includes('what-if')"
        )
        taken = time.perf_counter() - server.begun
        context.close()
    return taken


def _first_sample(server: Serving) -> None:
    """Create a session, watch it, play, and return when the first binary frame is here."""
    session = server.post("/sessions", scenario="circle")["id"]
    client = Client.connect(server.port, session)
    server.post(f"/sessions/{session}/play")
    while not client.received:
        run([client], 0.001)
    client.stream.close()
