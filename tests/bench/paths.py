"""``python -m tests.bench.paths``: what a hand that drags a point waits for, in a real browser."""

from __future__ import annotations

import http.client
import json
import math
import statistics
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import urlopen

from playwright.sync_api import Page, sync_playwright

from tests.bench.machine import description
from tests.bench.table import Row, Table
from tests.e2e.conftest import CHROMIUM, FLAGS, Server

_POINTS = 200
_REPETITIONS = 60
_MOVES = 240
_FRAMES = 59  # 1/s
_JSON = {"Content-Type": "application/json"}
_LAWS = ("minimum_jerk", "trapezoid", "jerk_limited", "constant_speed")
# Corners at constant speed are infeasible wherever they are.
_CASES = [("polyline", law) for law in _LAWS[:-1]] + [("spline", law) for law in _LAWS]
_CURVE = 50  # ms
_JERK = 20.0  # m/s^3
_SHORT = 3.0  # s, the simulated time that the target for A and B is stated for


def main() -> int:
    """Measure and print; return 1 only if something could not be run."""
    print(description())
    table = Table()
    with tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder))
        try:
            table.add("server", lambda: _server(server))
            table.add("page", lambda: _page(server))
        finally:
            server.stop()
    return 0 if table.complete else 1


def dragging() -> Iterator[Row]:
    """Drag one of 200 points of a spline, in a browser."""
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        server = Server(Path(folder))
        try:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
            page = browser.new_page(viewport={"width": 1440, "height": 900})
            _open(page, server, _path("spline", law="minimum_jerk"))
            yield from _drag(page, "spline, minimum jerk")
            browser.close()
        finally:
            server.stop()


def _blossom(points: int) -> list[list[float]]:
    """Return points of a closed curve as large as a third of the stroke, m."""
    angles = [2 * math.pi * k / points for k in range(points)]
    return [[0.05 * math.cos(a) * (1 + 0.1 * math.cos(9 * a)), 0.09 * math.sin(a)] for a in angles]


def _path(geometry: str, **change: Any) -> dict[str, Any]:
    table = {"kind": "path", "points": _blossom(_POINTS), "closed": True, "geometry": geometry}
    return table | {"v_max": 0.08, "a_max": 0.8} | change


def _server(server: Server) -> Iterator[Row]:
    """Time checks of 200 points, one of which moves each time, as the client sees them."""
    with urlopen(f"{server.url}/api/v1/scenarios/circle") as answer:
        scenario = json.load(answer)
    connection = http.client.HTTPConnection("127.0.0.1", server.port)
    for geometry in ("polyline", "spline"):
        table = _path(geometry)
        taken = []
        for _ in range(_REPETITIONS):
            table["points"][5][0] += 1e-5
            body = json.dumps({"scenario": scenario, "trajectory": table, "points": 400}).encode()
            before = time.perf_counter()
            connection.request("POST", "/api/v1/trajectories/check", body, _JSON)
            connection.getresponse().read()
            taken.append((time.perf_counter() - before) * 1e3)
        typical, slow = statistics.median(taken), _p95(taken)
        yield Row(
            f"check of {_POINTS} points, {geometry}",
            "<= 8 ms",
            f"{typical:.1f} ms",
            f"p95 {slow:.1f} ms",
            met=typical <= 8,
        )


def _page(server: Server) -> Iterator[Row]:
    """Drag one of 200 points, then edit a path of 3 s and wait for A and B."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        for geometry, law in _CASES:
            numbers = {"j_max": _JERK} if law == "jerk_limited" else {}
            _open(page, server, _path(geometry, law=law, **numbers))
            yield from _drag(page, f"{geometry}, {law.replace('_', ' ')}")
        rhombus = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]]
        timed = {"v_max": None, "a_max": None, "lap_time": _SHORT}
        _open(page, server, _path("polyline", points=rhombus, **timed))
        yield _what_if(page)
        browser.close()


def _open(page: Page, server: Server, table: dict[str, Any]) -> None:
    page.goto(f"{server.url}/?screen=trajectories")
    page.evaluate("t => localStorage.setItem('motionlab.path', t)", json.dumps(table))
    page.goto(f"{server.url}/?screen=trajectories")
    page.get_by_role("status").get_by_text("feasible", exact=True).wait_for()
    page.wait_for_timeout(1500)


def _drag(page: Page, what: str) -> Iterator[Row]:
    """Count animation frames, and answers that the profiles show, while a point moves."""
    page.evaluate(_DRAG_START)
    frames, answers, drawn, seconds, waits = page.evaluate(_DRAG, _MOVES)
    yield Row(
        f"drag among {_POINTS}, {what}: frames",
        ">= 59 /s",
        f"{frames / seconds:.1f} /s",
        "display: 60 /s",
        met=frames / seconds >= _FRAMES,
    )
    yield Row(
        "  fresh checks drawn meanwhile",
        "60 /s",
        f"{drawn / seconds:.1f} /s",
        f"answered: {answers / seconds:.1f} /s",
        met=drawn / seconds >= _FRAMES,
    )
    typical, slow = statistics.median(waits), _p95(waits)
    yield Row(
        "  from the hand to its curve",
        "<= 50 ms",
        f"{typical:.0f} ms",
        f"p95 {slow:.0f} ms",
        met=typical <= _CURVE,
    )


def _what_if(page: Page) -> Row:
    taken = sorted(page.evaluate(_EDITS, 40))
    return Row(
        f"edited path of {_SHORT:g} s to A and B on screen",
        "p95 <= 100 ms",
        f"{_p95(taken):.0f} ms",
        f"median {statistics.median(taken):.0f} ms",
        met=_p95(taken) <= 100,
    )


def _p95(values: list[float]) -> float:
    return sorted(values)[math.ceil(0.95 * len(values)) - 1]


_DRAG_START = """() => {
  const plane = document.querySelector('[role=application]');
  const [x, y] = [plane.clientWidth, plane.clientHeight];
  const box = plane.getBoundingClientRect();
  window.send = (type, px, py) => plane.dispatchEvent(new PointerEvent(type, {
    bubbles: true, button: 0, pointerId: 1, pointerType: 'mouse',
    clientX: box.x + px, clientY: box.y + py }));
  plane.setPointerCapture = plane.releasePointerCapture = () => {};
  const scale = Math.min((x - 72) / 0.1785, (y - 26) / 0.3045);
  window.grip = [(x + 44) / 2 + 0.055 * scale, (y - 14) / 2];
}"""

_DRAG = """moves => new Promise(done => {
  // A check is drawn when the profiles are, for the first time since its answer was read.
  let [answers, drawn, waits] = [0, 0, 0];
  // When the point went where the answer that is shown next has it.
  let moved = 0;
  const taken = [];
  const fetched = window.fetch;
  window.fetch = async (...given) => {
    const at = moved;
    const response = await fetched(...given);
    if (String(given[0]).endsWith('/trajectories/check')) {
      const read = response.arrayBuffer.bind(response);
      response.arrayBuffer = async () => {
        const buffer = await read();
        answers += 1;
        waits = at;
        return buffer;
      };
    }
    return response;
  };
  const profiles = document.querySelector('[aria-label=Profiles] canvas');
  const { clearRect } = CanvasRenderingContext2D.prototype;
  CanvasRenderingContext2D.prototype.clearRect = function (...given) {
    if (this.canvas === profiles && waits) {
      drawn += 1;
      taken.push(performance.now() - waits);
      waits = 0;
    }
    return clearRect.apply(this, given);
  };
  send('pointerdown', ...grip);
  const begin = performance.now();
  let i = 0;
  const step = () => {
    i += 1;
    if (i <= moves) {
      moved = performance.now();
      // Further than the grid that points snap to: a point that stays where it is is not checked.
      send('pointermove', grip[0] - 4 * (i % 10), grip[1] + (i % 23));
    }
    // The answer to the last move is drawn after it.
    if (i < moves + 2) requestAnimationFrame(step);
    else {
      send('pointerup', ...grip);
      window.fetch = fetched;
      CanvasRenderingContext2D.prototype.clearRect = clearRect;
      done([i, answers, drawn, (performance.now() - begin) / 1e3, taken]);
    }
  };
  requestAnimationFrame(step);
})"""

_EDITS = """async count => {
  // Until the path has been checked there is no table; then there is the old one for a moment.
  const text = () =>
    document.querySelector('[aria-label="Errors of A and B"] tbody')?.innerText ?? null;
  const taken = [];
  for (let i = 0; i < count; i++) {
    const field = document.querySelector('[aria-label="point 1 x, mm"]');
    const before = text();
    field.value = String(30 + (i % 2 ? 0 : 4) + (i + 1) / 100);
    const begin = performance.now();
    field.dispatchEvent(new Event('change', { bubbles: true }));
    while ([null, before].includes(text())) {
      await new Promise(requestAnimationFrame);
      if (performance.now() - begin > 10_000) throw new Error(`edit ${i} without a result`);
    }
    taken.push(performance.now() - begin);
    await new Promise(go => setTimeout(go, 400));
  }
  return taken;
}"""

if __name__ == "__main__":
    sys.exit(main())
