"""The page's plot core beside uPlot: script a frame at 6 x 20,000 points, size as sent."""

from __future__ import annotations

import json
import statistics
import subprocess
import tempfile
from collections.abc import Iterator
from ctypes.util import find_library
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from tests.bench.table import Row
from tests.e2e.conftest import CHROMIUM, FLAGS, ROOT

_HERE = Path(__file__).parent
_PLOTS = 6
_TURNS, _FRAMES = 3, 240  # the best turn of each counts: the machine is shared
_COMPRESSED = (
    "const z = require('node:zlib'), b = require('node:fs').readFileSync(process.argv[1]);"
    "const sizes = [z.gzipSync(b, {level: 9}), z.brotliCompressSync(b)].map(({length}) => length);"
    "console.log(JSON.stringify(sizes))"
)


def plots() -> Iterator[Row]:
    """Compare frame time and size."""
    with tempfile.TemporaryDirectory() as folder:
        yield from _sizes(Path(folder))
        script = _bundled("plots.js", Path(folder))
        if CHROMIUM is None or find_library("atomic") is None:
            yield Row("six plots of 20,000 points", "", "skipped", "no Chromium: make browser")
            return
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
            page = browser.new_page(viewport={"width": 1100, "height": 760})
            page.set_content("<!doctype html><body></body>")
            page.add_script_tag(path=script)
            yield _frames(page)
            browser.close()


def _frames(page: Page) -> Row:
    taken: dict[str, list[float]] = {"ours": [], "uPlot": []}
    for _ in range(_TURNS):
        for who, turns in taken.items():
            found = page.evaluate("given => measure(...given)", [who, _FRAMES])
            assert found["plots"] == _PLOTS, found["plots"]
            turns.append(statistics.median(found["taken"]))
    ours, theirs = (min(turns) for turns in taken.values())
    return Row(
        f"{_PLOTS} plots of 20,000 points: script a frame",
        "",
        f"{ours:.2f} ms",
        f"uPlot {theirs:.2f} ms",
        f"{ours / theirs:.2f}",
    )


def _sizes(folder: Path) -> Iterator[Row]:
    sizes = {
        name: _size(_bundled(f"plots-{name}.js", folder)) for name in ("ours", "core", "uplot")
    }
    reference = sizes["uplot"]
    for name, what in (("ours", "scopes alone"), ("core", "whole plot core")):
        gzip, brotli = sizes[name]
        yield Row(
            f"{what}, minified: gzip, brotli",
            "",
            f"{gzip / 1e3:.1f}, {brotli / 1e3:.1f} kB",
            f"uPlot {reference[0] / 1e3:.1f}, {reference[1] / 1e3:.1f}",
            f"{brotli / reference[1]:.2f}",
        )


def _bundled(name: str, folder: Path) -> Path:
    target = folder / name
    _node(f"rolldown {_HERE / name} --file {target} --format esm --minify --log-level silent")
    return target


def _size(script: Path) -> tuple[int, int]:
    gzip, brotli = json.loads(_node(f'node -e "{_COMPRESSED}" {script}'))
    return gzip, brotli


def _node(command: str) -> str:
    return subprocess.run(
        [str(ROOT / "frontend" / "npm"), "exec", "--call", command],
        check=True,
        capture_output=True,
        text=True,
    ).stdout
