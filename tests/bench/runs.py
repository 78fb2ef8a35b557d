"""Runs of 240 s: recording, files, curves, comparison, the screen, and servers that are killed."""

from __future__ import annotations

import os
import random
import statistics
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from playwright.sync_api import sync_playwright
from pyarrow import parquet

from motionlab.analysis.comparison_options import Comparing, Tolerance
from motionlab.analysis.run_comparison import compare
from motionlab.config.load import load_scenario
from motionlab.library.columns import of_file_or_run
from motionlab.library.library import Library
from motionlab.library.new_run import live_run
from motionlab.library.run import RunDetail, new_id
from motionlab.library.spool import Spool
from motionlab.library.window import PYRAMIDS, grid, window
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document, metadata
from motionlab.simulation.run import run
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.recording import Recording
from tests.bench.serving import API, Serving
from tests.bench.stream import watch
from tests.bench.table import Row
from tests.e2e.conftest import CHROMIUM, FLAGS
from tests.library.served import Served

_LAPS = 80  # of 3 s
_SECONDS = 240.0
_REPETITIONS = 5
_ROUNDS, _WINDOWS = 3, 3  # of recorded and unrecorded in turns; of 4 s each
_MORE = 0.01  # of a core
_FASTER = 50.0  # than real time
_SIZE = 15.0  # MB
_CURVE, _COMPARE, _OPEN, _LOOK = 0.02, 1.0, 0.3, 0.05  # s
_KEYS = ("+" * 7 + ",,..--+,,,+..-" + "-" * 6) * 4
"""From 240 s to 2 s and back, with moves on the way."""
_KILLS, _LOST = 50, 1.0  # s
_CHANNELS = 24
_HOWS: dict[str, Comparing] = {
    "by time": Comparing(exact=True),
    "by time, 5 ms of tolerance": Comparing(
        exact=True, tolerance=Tolerance(absolute=1e-6, time=0.005)
    ),
    "by reference": Comparing(exact=True, align="reference"),
}
_WATCH = Path(__file__).with_name("watch.js")


def runs() -> Iterator[Row]:
    """Measure what is done with a run of 240 s, then what recording costs and a kill loses."""
    with tempfile.TemporaryDirectory() as folder:
        library = Library(Path(folder) / "data")
        simulated = [_simulated({}), _simulated({"variants.B.controller.x.k_p": 210_000.0})]
        try:
            yield from _written(library, *simulated[0])
            kept = [
                library.keep(*each, document(*each), name=f"run {i}")
                for i, each in enumerate(simulated)
            ]
            yield from _read(library, kept[0])
            yield from _compared([library.files.path(each.id) for each in kept])
        finally:
            library.close()
        yield from _opened(Path(folder) / "data")
    yield from _recorded()
    with tempfile.TemporaryDirectory() as folder:
        yield from _killed(Path(folder))


def _simulated(changes: dict[str, Any]) -> tuple[Prepared, Recording]:
    prepared = prepare(load_scenario("circle", {"trajectory.laps": _LAPS} | changes))
    return prepared, run(prepared)


# -- files ----------------------------------------------------------------------------------------


def _written(library: Library, prepared: Prepared, recording: Recording) -> Iterator[Row]:
    """Keep a simulation; make a run of what a session has recorded."""
    result = document(prepared, recording)

    def simulation() -> RunDetail:
        return library.keep(prepared, recording, result)

    about = live_run(prepared.scenario, new_id(), time.time())
    channels = stream_columns(list(prepared.scenario.variants))
    samples = np.stack([values for _, _, values in recorder.columns(recording)])

    def live() -> RunDetail | None:
        begun = about.model_copy(update={"id": new_id()})
        spool = Spool(library.spools, begun, channels, metadata(prepared.scenario))
        for first in range(0, samples.shape[1], 800):  # a batch each 0.4 s
            spool.append(first, samples[:, first : first + 800])
        spool.end(complete=True)
        return library.finish(begun.id)

    size = 0
    ways: dict[str, Callable[[], RunDetail | None]] = {
        "kept": simulation,
        "recorded, made a run": live,
    }
    for what, keep in ways.items():
        times = []
        for _ in range(_REPETITIONS):
            before = time.perf_counter()
            found = keep()
            times.append(time.perf_counter() - before)
            assert found is not None and found.ticks == recording.ticks
            size = found.size
            library.delete(found.id)
        taken = statistics.median(times)
        with _synced(library.spools.parent, size) as plain:
            yield Row(
                f"240 s, {len(samples)} channels, {what}",
                f">= {_FASTER:g} x real",
                f"{_SECONDS / taken:.0f} x",
                f"as many bytes: {plain:.2f} s",
                f"{taken / plain:.1f}",
                _SECONDS / taken >= _FASTER,
            )


@contextmanager
def _synced(folder: Path, size: int) -> Iterator[float]:
    """Give how long the disk takes for as many random bytes, s."""
    path = folder / "plain"
    content = random.Random(1).randbytes(size)
    before = time.perf_counter()
    with path.open("wb") as file:
        file.write(content)
        os.fsync(file.fileno())
    yield time.perf_counter() - before
    path.unlink()


def _read(library: Library, kept: RunDetail) -> Iterator[Row]:
    """Decimate one channel; the file's pages are dropped from memory each time."""
    path = library.files.path(kept.id)
    sizes, plain_size = _sizes(path), _CHANNELS * 4 * kept.ticks / 1e6
    first, most = sum(sizes[:_CHANNELS]), sum(sorted(sizes)[-_CHANNELS:])
    yield Row(
        f"  its size, the first {_CHANNELS} channels",
        f"<= {_SIZE:g} MB",
        f"{first:.1f} MB",
        f"plain: {plain_size:.0f} MB",
        f"{first / plain_size:.2f}",
        first <= _SIZE,
    )
    yield Row(
        f"  the {_CHANNELS} that shrink least", "", f"{most:.1f} MB", f"all: {sum(sizes):.1f} MB"
    )

    def cold() -> None:
        with Path(path).open("rb") as file:
            os.fsync(file.fileno())
            os.posix_fadvise(file.fileno(), 0, 0, os.POSIX_FADV_DONTNEED)

    times, plain = [], []
    for _ in range(4 * _REPETITIONS):
        cold()
        PYRAMIDS.clear()
        before = time.perf_counter()
        window(
            library.files, kept.id, ["B.x.following_error"], grid(0, kept.ticks, 2000, kept.ticks)
        )
        times.append(time.perf_counter() - before)
        cold()
        before = time.perf_counter()
        Path(path).read_bytes()
        plain.append(time.perf_counter() - before)
    taken, whole = statistics.median(times), statistics.median(plain)
    yield Row(
        "  a channel in 2000 points, file not in memory",
        f"< {_CURVE * 1e3:g} ms",
        f"{taken * 1e3:.1f} ms",
        f"bytes of the file: {whole * 1e3:.1f} ms",
        f"{taken / whole:.2f}",
        taken < _CURVE,
    )


def _sizes(path: str) -> list[float]:
    """Return what each channel takes of a file, MB."""
    about = parquet.read_metadata(path)
    groups = [about.row_group(group) for group in range(about.num_row_groups)]
    names = [name for name in about.schema.names if name not in {"tick", "time"}]
    first = about.num_columns - len(names)
    return [
        sum(group.column(first + i).total_compressed_size for group in groups) / 1e6
        for i in range(len(names))
    ]


def _compared(files: list[str]) -> Iterator[Row]:
    """Compare files with one gain changed; columns are read each time."""
    for what, how in _HOWS.items():
        times, spent, count = [], [], 0
        for _ in range(_REPETITIONS + 1):
            wall, processor = time.perf_counter(), time.process_time()
            baseline, candidate = map(of_file_or_run, files)
            count = len(compare(baseline, candidate, how).channels)
            times.append(time.perf_counter() - wall)
            spent.append(time.process_time() - processor)
        taken = statistics.median(times[1:])
        yield Row(
            f"  compare with another, {count} channels, {what}",
            f"< {_COMPARE:g} s",
            f"{taken:.2f} s",
            f"{statistics.median(spent[1:]):.2f} s of processor",
            "",
            taken < _COMPARE if what == "by time" else None,
        )


# -- the screen -----------------------------------------------------------------------------------


def _opened(data: Path) -> Iterator[Row]:
    """Click on one run and on the other, until all its plots are drawn."""
    if CHROMIUM is None:
        yield Row("  open a run in a browser", "", "skipped", "no Chromium: make browser")
        return
    with Serving(MOTIONLAB_DATA=str(data)) as server, sync_playwright() as playwright:
        server.warm()
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.add_init_script(path=_WATCH)
        page.goto(f"{server.url}/?screen=runs")
        page.get_by_role("row", name="run 0").wait_for()
        taken = []
        for i in range(2 * _REPETITIONS + 2):
            taken.append(page.evaluate("name => bench.open(name)", f"run {i % 2}") / 1e3)
        page.wait_for_timeout(500)
        looks = {
            what: [page.evaluate("key => bench.press(key)", key) for key in _KEYS]
            for what in ("first", "seen")
        }
        browser.close()
        listed = server.client.get(f"{API}/runs").json()["runs"]
        answers = []
        for each in listed[:2] * _REPETITIONS:
            query = {"columns": "A.x.following_error,B.x.following_error", "points": 2000}
            before = time.perf_counter()
            server.client.get(f"{API}/runs/{each['id']}/window", params=query).raise_for_status()
            answers.append(time.perf_counter() - before)
    median, answer = statistics.median(taken[2:]), statistics.median(answers)
    yield Row(
        "  open: click to all plots drawn",
        f"< {_OPEN * 1e3:g} ms",
        f"{median * 1e3:.0f} ms",
        f"one answer: {answer * 1e3:.0f} ms",
        f"{median / answer:.1f}",
        median < _OPEN,
    )
    for what, presses in looks.items():
        drawn = [each for each in presses if each["frames"] > 0]
        p50, p95 = np.percentile([each["taken"] for each in drawn], (50.0, 95.0)) / 1e3
        frames = float(np.percentile([each["frames"] for each in drawn], 95.0))
        seen = what == "seen"
        yield Row(
            f"  {len(drawn)} zooms and moves{', once seen' if seen else ''}: all redrawn",
            "p95: next frame" if seen else f"p95 < {_LOOK * 1e3:g} ms",
            f"p95 {p95 * 1e3:.0f} ms, {frames:g}",
            f"p50 {p50 * 1e3:.0f}, one answer: {answer * 1e3:.0f} ms",
            f"{p95 / answer:.1f}",
            frames <= 1.0 if seen else p95 < _LOOK,
        )


# -- recording ------------------------------------------------------------------------------------


def _recorded() -> Iterator[Row]:
    """Watch a session of two variants on a server that records and one that does not, in turns."""
    load: dict[bool, list[float]] = {True: [], False: []}
    late: dict[bool, list[float]] = {True: [], False: []}
    with Serving() as recording, Serving(program="tests.bench.unrecorded") as plain:
        servers = {True: recording, False: plain}
        sessions = {
            each: server.post("/sessions", scenario="circle")["id"]
            for each, server in servers.items()
        }
        for each, server in servers.items():
            server.post(f"/sessions/{sessions[each]}/step", ticks=20_000)
        for _ in range(_ROUNDS):
            for each, server in servers.items():
                options = ("--clients", "1", "--windows", str(_WINDOWS))
                figures, cpu, _ = watch(server, sessions[each], *options)
                load[each].append(cpu)
                late[each] += [found["p99"] for found in figures["windows"]]
                server.post(f"/sessions/{sessions[each]}/pause")
    more = min(load[True]) - min(load[False])
    yield Row(
        "recording a session of two variants at 1x",
        f"<= {_MORE:.0%} of a core more",
        f"{more:+.1%}",
        f"unrecorded: {min(load[False]):.1%}",
        f"{min(load[True]) / min(load[False]):.2f}",
        more <= _MORE,
    )
    p99 = {each: statistics.median(values) for each, values in late.items()}
    yield Row(
        "  the stream's p99 meanwhile",
        "unchanged",
        f"{p99[True] * 1e3:.1f} ms",
        f"unrecorded: {p99[False] * 1e3:.1f} ms",
        f"{p99[True] / p99[False]:.2f}",
    )


def _killed(data: Path) -> Iterator[Row]:
    """Kill the server at random moments of a session; the next one keeps what was written."""
    chance = random.Random(2019)
    lost: list[float] = []
    known: dict[str, Any] = {}
    server = Served(data)
    for _ in range(_KILLS):
        path = server.play(speed=1.0)
        end = time.monotonic() + chance.random() * 2.5
        ran, seen = 0.0, time.monotonic()
        while time.monotonic() < end or server.session(path)["run"] is None:
            ran, seen = server.session(path)["time"], time.monotonic()
            time.sleep(0.005)
        run_id = server.session(path)["run"]
        ran += time.monotonic() - seen
        server.kill()
        server = Served(data)
        server.settled()
        known |= _recovered(server, run_id)
        lost.append(ran - known[run_id]["duration"] if run_id in known else ran)
        for each, before in known.items():
            assert server.client.get(f"{API}/runs/{each}").json() == before, each
    server.end()
    yield Row(
        f"kill -9 while recording, {_KILLS} times: lost at most",
        f"<= {_LOST:g} s",
        f"{max(lost):.2f} s",
        f"median {statistics.median(lost):.2f} s",
        "",
        max(lost) <= _LOST,
    )
    yield Row(
        "  runs that open, others untouched", "", f"{len(known)}", "rest: nothing written yet"
    )


def _recovered(server: Served, run_id: str) -> dict[str, Any]:
    """Return the run that was made of what was written, by identifier; empty if nothing was."""
    answer = server.client.get(f"{API}/runs/{run_id}")
    if answer.status_code == 404:
        return {}
    found = answer.raise_for_status().json()
    assert found["state"] == "partial"
    query = {"columns": "A.x.following_error", "from": found["ticks"] - 1}  # the last sample
    server.client.get(f"{API}/runs/{run_id}/window", params=query).raise_for_status()
    return {run_id: found}
