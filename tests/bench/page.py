"""The Lab page in a headless Chromium: what-if at a slider, live scopes; the page's weight."""

from __future__ import annotations

import json
import re
import statistics
import time
from collections.abc import Iterator
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from tests.bench.serving import API, Serving
from tests.bench.table import Row
from tests.e2e.conftest import CHROMIUM, FLAGS, ROOT

_WATCH = Path(__file__).with_name("watch.js")
_SLIDER = "B k_p x"
_WARM, _EVENTS = 20, 100
_TRIES = 3  # the best counts: the machine is shared
_WHAT_IF = 0.1  # s
_SCOPES, _SPAN = "ex,ey,v,a,i,f", 10  # s
_LIVE = 4.0  # s
_FRAMES, _SCRIPT = 59.0, 8e-3  # 1/s, s
_WEIGHT = 80  # kB
_CPU = 0.05  # of a core


def page() -> Iterator[Row]:
    """Measure the page's weight, and where there is a Chromium what it does."""
    index = ROOT / "frontend" / "dist" / "index.html"
    if not index.is_file():
        yield Row("the Lab page", "", "not built", "make run builds it")
        return
    with Serving() as server:
        yield _weight(server)
        yield from _in_a_browser(server)


def _weight(server: Serving) -> Row:
    """Load what the Lab needs as a browser does; other screens are fetched when they are opened."""
    names = re.findall(r'/assets/[\w.-]+\.js(?=")', server.client.get("/").text)
    answers = [server.client.get(name, headers={"Accept-Encoding": "gzip"}) for name in names]
    weight = sum(answer.num_bytes_downloaded for answer in answers) / 1e3
    whole = sum(len(answer.content) for answer in answers) / 1e3
    return Row(
        "JavaScript of the page, as sent",
        f"< {_WEIGHT} kB",
        f"{weight:.1f} kB",
        f"plain: {whole:.0f} kB",
        f"{weight / whole:.2f}",
        weight < _WEIGHT,
    )


def _in_a_browser(server: Serving) -> Iterator[Row]:
    if CHROMIUM is None or find_library("atomic") is None:
        yield Row("the Lab page in a browser", "", "skipped", "no Chromium: make browser")
        return
    with sync_playwright() as playwright:
        server.warm()
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield _what_if(browser, server, "what-if of 3 s", {"trajectory.laps": 1})
        yield _what_if(browser, server, "what-if of 6 s", {})
        yield from _live(browser, server)
        browser.close()


def _what_if(browser: Browser, server: Serving, what: str, changes: dict[str, Any]) -> Row:
    """Move a slider again and again, each time once all plots show the move before."""
    session = server.post("/sessions", scenario="circle", set=changes)
    opened = _open(browser, server, session["id"], "whatif", "ex,ey,i,f")
    opened.evaluate("times => bench.slide(times[0], times[1])", [_SLIDER, _WARM])
    tries = []
    for _ in range(_TRIES):
        got = opened.evaluate("times => bench.slide(times[0], times[1])", [_SLIDER, _EVENTS])
        p95, p50 = np.percentile(got["taken"], (95.0, 50.0)) / 1e3
        tries.append((p95, p50, got["plots"]))
    opened.context.close()
    p95, p50, plots = min(tries)
    # What the server takes for one, asked for as the page asks.
    body = {"scenario": "circle", "set": changes, "columns": ["B.x.following_error"]}
    server_times = [_timed(server, body) for _ in range(20)]
    reference = statistics.median(server_times)
    return Row(
        f"{what}: event to {plots} plots drawn",
        f"p95 <= {_WHAT_IF * 1e3:g} ms",
        f"p95 {p95 * 1e3:.0f} ms",
        f"p50 {p50 * 1e3:.0f}, server {reference * 1e3:.0f}",
        f"{p95 / reference:.2f}",
        p95 <= _WHAT_IF,
    )


def _timed(server: Serving, body: dict[str, Any]) -> float:
    before = time.perf_counter()
    server.client.post(f"{API}/whatif", json=body).raise_for_status()
    return time.perf_counter() - before


def _live(browser: Browser, server: Serving) -> Iterator[Row]:
    """Play with six full scopes and read the page's counters and the browser's."""
    session = server.post("/sessions", scenario="circle")["id"]
    server.post(f"/sessions/{session}/step", ticks=20_000)
    opened = _open(browser, server, session, "live", _SCOPES)
    server.post(f"/sessions/{session}/play", speed=1.0)
    opened.wait_for_timeout(2000)
    protocol = opened.context.new_cdp_session(opened)
    protocol.send("Performance.enable")

    def counters() -> tuple[float, float, float, float]:
        metrics = {
            m["name"]: m["value"] for m in protocol.send("Performance.getMetrics")["metrics"]
        }
        frames = opened.evaluate("bench.frames")
        return (
            time.perf_counter(),
            frames,
            metrics["ScriptDuration"],
            server.cpu(),
        )

    tries = []
    for _ in range(_TRIES):
        before = counters()
        opened.wait_for_timeout(1e3 * _LIVE)
        spent = [b - a for a, b in zip(before, counters(), strict=True)]
        tries.append([each / spent[0] for each in spent[1:]])
    frames, script, cpu = max(tries)
    shown = opened.locator("footer").inner_text().replace("\xa0", " ")
    own = shown[: shown.index("ms script")].split()[-1]
    opened.context.close()
    yield Row(
        f"Lab, 6 scopes of {_SPAN} s at 1x: frames",
        f">= {_FRAMES:g} /s",
        f"{frames:.1f} /s",
        "display: 60 /s",
        "",
        frames >= _FRAMES,
    )
    yield Row(
        "  script a frame, by the DevTools",
        f"< {_SCRIPT * 1e3:g} ms",
        f"{script / frames * 1e3:.1f} ms",
        f"page counts {own} ms",
        "",
        script / frames < _SCRIPT,
    )
    yield Row(
        "  server's processor meanwhile",
        f"<= {_CPU:.0%} of a core",
        f"{cpu:.1%}",
        "",
        "",
        cpu <= _CPU,
    )


def _open(browser: Browser, server: Serving, session: str, mode: str, scopes: str) -> Page:
    """Open the Lab on a session, connected and with its plots drawn."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    opened = context.new_page()
    opened.add_init_script(path=_WATCH)
    opened.add_init_script(f"localStorage.setItem('motionlab.span', {json.dumps(str(_SPAN))})")
    opened.goto(f"{server.url}/?session={session}&mode={mode}&scopes={scopes}")
    opened.get_by_text("connected", exact=True).wait_for()
    opened.wait_for_function("count => bench.drawn.size >= count", arg=scopes.count(",") + 2)
    opened.wait_for_timeout(500)
    return opened
