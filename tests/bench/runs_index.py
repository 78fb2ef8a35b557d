"""The index with 100,000 runs: pages, filters and sorts, on SQLite and PostgreSQL.

Cold: another connection has just changed a run, so that nothing found before is kept. Warm: the
same search once more. Both read a database whose pages are in memory.
"""

from __future__ import annotations

import os
import random
import secrets
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from motionlab.library.index import Index
from motionlab.library.run import Difference, Page, RunDetail
from motionlab.library.search import HEADLINE, parse
from tests.bench.table import Row
from tests.library.databases import DATABASES, NAMED, database
from tests.library.sample_runs import sample

_RUNS = 100_000
_BATCH = 2000
_TARGET = 0.05  # s
_REPETITIONS = 5
_CHANGED = "r-" + 12 * "a"
_DAY = 86_400.0
_BEGAN = 1_790_000_000.0
_SCENARIOS = ("circle", "rhombus", "staircase", "sine", "scan")
_WORDS = ("stiffer", "softer", "rig", "bearing", "cold", "warm", "notch", "load", "night", "new")
_NAMES = (
    "",
    "tag:often",
    "tag:seldom",
    "tag:often tag:half",
    "tag:left tag:right",  # half of the runs each, none has both
    "tag:never",
    "scenario:circle",
    "kind:live state:complete",
    "state:partial",
    "is:pinned",
    "is:deleted",
    "stiffer",
    "bearing night",
    "k_p",
    "no",
    "zebra",
    "xq",
    "B.x.max<3um",
    "B.x.max<0.01um",
    "B.x.max<3um B.y.max<3um A.x.max>2um",
    "B.x.max<1um tag:half circle",
    "after:2027-01-01",
    "before:2026-10-01 rig",
)
_SORTS = ("-created", "name", "-duration", "-size", "B.x.max", "-A.y.rms")


def runs_index() -> Iterator[Row]:
    """Fill an index, ask for every filter in every order, first and third page."""
    for kind in DATABASES:
        if kind == "postgresql" and not os.environ.get(NAMED):
            yield Row("index on PostgreSQL", "", "skipped", f"{NAMED} names none")
            continue
        with tempfile.TemporaryDirectory() as folder, database(kind, Path(folder)) as url:
            index, beside = Index(url), Index(url)
            _fill(index)
            index.put(sample(id=_CHANGED))
            yield from _asked(index, beside, kind)
            index.close()
            beside.close()


def _asked(index: Index, beside: Index, kind: str) -> Iterator[Row]:
    taken: dict[str, dict[tuple[str, str, str], float]] = {"cold": {}, "warm": {}}
    for text in _NAMES:
        for sort in _SORTS:
            for page, cold, warm in _pages(index, beside, text, sort):
                taken["cold"][text, sort, page] = cold
                taken["warm"][text, sort, page] = warm
    for state, times in taken.items():
        slowest = max(times, key=lambda each: times[each])
        p50, p95 = np.percentile(list(times.values()), (50.0, 95.0))
        yield Row(
            f"{kind}, {_RUNS:,} runs: any page, {len(times)} ways, {state}",
            f"p95 <= {_TARGET * 1e3:g} ms",
            f"p95 {p95 * 1e3:.0f} ms",
            f"p50 {p50 * 1e3:.0f} ms",
            f"{p95 / p50:.1f}",
            bool(p95 <= _TARGET),
        )
        what = " ".join(each for each in slowest if each)
        yield Row(f"  slowest: {what}", "", f"{times[slowest] * 1e3:.0f} ms")
        if os.environ.get("MOTIONLAB_BENCH_ALL"):
            for each in sorted(times, key=lambda each: -times[each])[:40]:
                yield Row("    " + " | ".join(each), "", f"{times[each] * 1e3:.0f} ms")
    before = time.perf_counter()
    index.totals()
    yield Row(f"  {kind}: counts by tag and scenario", "", f"{time.perf_counter() - before:.3f} s")


def _pages(index: Index, beside: Index, text: str, sort: str) -> Iterator[tuple[str, float, float]]:
    """Yield how long the first and the third page take, s, cold and warm, medians of some times."""
    cursor: str | None = None
    for page in ("first", "", "third"):
        found, cold, warm = _timed(index, beside, text, sort, cursor)
        if page:
            yield page, cold, warm
        if (cursor := found.cursor) is None:
            return


def _timed(
    index: Index, beside: Index, text: str, sort: str, cursor: str | None
) -> tuple[Page, float, float]:
    taken: list[float] = []
    found = index.page(parse(text), sort=sort, limit=100, cursor=cursor)
    for _ in range(_REPETITIONS):
        beside.change(_CHANGED, {"note": secrets.token_hex(4)})
        for _ in ("cold", "warm"):
            before = time.perf_counter()
            found = index.page(parse(text), sort=sort, limit=100, cursor=cursor)
            taken.append(time.perf_counter() - before)
    return found, float(np.median(taken[::2])), float(np.median(taken[1::2]))


def _fill(index: Index) -> None:
    chance = random.Random(2019)
    for start in range(0, _RUNS, _BATCH):
        index.put(*(_run(chance, start + i) for i in range(_BATCH)))


def _run(chance: random.Random, i: int) -> RunDetail:
    tags = ["left" if i % 2 else "right"]
    tags += ["half"] if chance.random() < 0.5 else []
    tags += ["often"] if chance.random() < 0.05 else []
    tags += ["seldom"] if chance.random() < 0.0005 else []
    words = " ".join(chance.sample(_WORDS, 3))
    gain = Difference(path="variants.B.controller.x.k_p", shipped=3e5, value=chance.random() * 4e5)
    # Runs of one day are alike, as they are in a laboratory.
    error = 3e-6 * np.exp(0.7 * np.sin(i / 700.0)) * chance.lognormvariate(0.0, 0.5)
    changed: dict[str, Any] = {
        "name": f"{words} {i}",
        "kind": "live" if chance.random() < 0.6 else "simulation",
        "state": "partial" if chance.random() < 0.005 else "complete",
        "scenario": chance.choice(_SCENARIOS),
        "note": "a night at the zebra crossing" if chance.random() < 0.0002 else "",
        "tags": tags,
        "pinned": chance.random() < 0.003,
        "created": _BEGAN + i * 300.0 + chance.random() * _DAY,
        "deleted": _BEGAN if chance.random() < 0.001 else None,
        "duration": round(chance.uniform(1.0, 240.0), 3),
        "size": chance.randrange(10**7),
        "differences": [gain],
        "metrics": {
            f"{variant}.{axis}.{metric}": error * chance.uniform(0.5, 2.0)
            for variant in "AB"
            for axis in "xy"
            for metric in HEADLINE.values()
        },
        "thumbnail": {name: [500] * 120 for name in ("reference", "A", "B")},
    }
    return sample(**changed)
