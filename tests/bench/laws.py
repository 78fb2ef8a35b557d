"""Laws of one's own: from a saved file to a live session, and what their calls cost in a tick."""

from __future__ import annotations

import dataclasses
import json
import os
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.laws import lugre_observer
from motionlab.own_laws.template import template
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.bench.serving import API, Serving
from tests.bench.table import Row

_SAVES, _LIVE = 20, 1.0  # versions; s
_DEARER = 1.08  # times a tick of the law that ships
_ROUNDS = 15


def laws() -> Iterator[Row]:
    """Measure all."""
    yield _saved("file saved", lambda k: ("F_c  # N", f"F_c * {1 + k / 100}"))
    yield _saved("another declaration saved", lambda k: ("le=2)", f"le={3 + k})"))
    with tempfile.TemporaryDirectory() as folder:
        source = Path(lugre_observer.__file__).read_text(encoding="utf-8")
        own = source.replace('name="lugre-observer"', 'name="own"')
        (Path(folder) / "own.py").write_text(own, encoding="utf-8")
        words = (sys.executable, "-m", "tests.bench.laws")
        done = subprocess.run(
            words, env=os.environ | {"MOTIONLAB_LAWS": folder}, capture_output=True, check=True
        )
    own_time, shipped = json.loads(done.stdout)
    ratio = own_time / shipped
    yield Row(
        "a run with a law of one's own, of the same text",
        f"<= {_DEARER:.2f}",
        f"{1e3 * own_time:.1f} ms",
        f"shipped: {1e3 * shipped:.1f} ms",
        f"{ratio:.2f}",
        ratio <= _DEARER,
    )


def _saved(what: str, change: Callable[[int], tuple[str, str]]) -> Row:
    """Save versions of a law that a session plays with, and wait for each."""
    text = template("mine")
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mine.py"
        file.write_text(text, encoding="utf-8")
        with Serving(MOTIONLAB_LAWS=folder) as server:
            session = server.client.post(f"{API}/sessions", json={"scenario": "circle"})
            place = session.raise_for_status().headers["location"]
            law = {"variants.B.controller.compensation.law": "mine"}
            server.client.patch(f"{place}/parameters", json={"set": law}).raise_for_status()
            server.client.post(f"{place}/play", json={}).raise_for_status()
            times = []
            for k in range(_SAVES + 1):
                time.sleep(0.3)
                file.write_text(text.replace(*change(k)), encoding="utf-8")
                begun = time.perf_counter()
                while not _taken(server, place, k + 1):
                    time.sleep(0.005)
                times.append(time.perf_counter() - begun)
    p95 = float(np.quantile(times[1:], 0.95))  # the first waits for the process that stands by
    return Row(
        f"own law: {what} to live session running it",
        f"p95 < {_LIVE:g} s",
        f"p95 {p95:.2f} s",
        f"median {statistics.median(times[1:]):.2f} s",
        met=p95 < _LIVE,
    )


def _taken(server: Serving, place: str, count: int) -> bool:
    events = server.client.get(place).raise_for_status().json()["events"]
    return sum(event["kind"] == "law" for event in events) == count


def _runs() -> tuple[float, float]:
    """Return the least times of a circle with the own law and with the one that ships, s."""
    prepared = {}
    for law in ("own", "lugre-observer"):
        changes = {f"variants.{name}.controller.compensation.law": law for name in "AB"}
        prepared[law] = prepare(load_scenario("circle", changes))
        run(prepared[law])
    best = dict.fromkeys(prepared, float("inf"))
    for _ in range(_ROUNDS):
        for law, each in prepared.items():
            begun = time.perf_counter()
            run(dataclasses.replace(each))
            best[law] = min(best[law], time.perf_counter() - begun)
    return best["own"], best["lugre-observer"]


if __name__ == "__main__":
    print(json.dumps(_runs()))
