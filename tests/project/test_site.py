"""The documentation as `make docs` has built it: whole, offline, small, true to the program."""

from __future__ import annotations

import io
import json
import re
import zipfile
from functools import cache
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import unquote, urlsplit

import pytest

from motionlab.analysis.metrics import CONTOUR_DEFINITIONS, DEFINITIONS
from motionlab.cli.main import _MODULES
from motionlab.telemetry.channels import CHANNELS
from tests.e2e.conftest import missing
from tests.paths import ROOT

SITE = ROOT / "build" / "help"
LARGEST = 1_400_000
"""Bytes, compressed: the wheel holds the site."""

LOADING = {"script": "src", "img": "src", "link": "href", "iframe": "src", "source": "srcset"}


class Elements(HTMLParser):
    """Ids of a page, what it loads and what it links to; text of scripts within it."""

    def __init__(self, page: Path) -> None:
        super().__init__()
        self.ids: set[str] = set()
        self.loads: list[str] = []
        self.links: list[str] = []
        self.inline: list[str] = []
        self._within = ""
        self.feed(page.read_text())

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        found = dict(attrs)
        self._within = tag
        self.ids.add(found.get("id") or "")
        if tag in LOADING and (address := found.get(LOADING[tag])):
            self.loads.append(address)
        if tag == "a" and (address := found.get("href")):
            self.links.append(address)
        self.inline += [name for name in found if name.startswith("on")]

    def handle_endtag(self, tag: str) -> None:
        self._within = ""

    def handle_data(self, data: str) -> None:
        if self._within == "script" and data.strip():
            self.inline.append(data)


@pytest.fixture(scope="module", autouse=True)
def built() -> None:
    if not (SITE / "index.html").is_file():
        missing("the documentation is not built: make docs")


@cache
def pages() -> dict[Path, Elements]:
    return {page: Elements(page) for page in SITE.rglob("*.html")}


def text(name: str) -> str:
    return (SITE / f"{name}.html").read_text()


def test_every_page_is_in_the_navigation() -> None:
    sources = {page.stem for page in (ROOT / "docs").glob("*.md")}
    navigation = text("index").partition('class="sidebar-tree"')[2].partition("</aside>")[0]
    linked = set(re.findall(r'href="([\w-]+)\.html"', navigation))
    assert sources - linked == {"index"}
    titles = re.findall(r"^\*\*(.+)\*\*$", (ROOT / "README.md").read_text(), re.MULTILINE)
    assert re.findall(r'class="caption-text">(.+?)<', navigation) == titles


def test_it_loads_nothing_from_elsewhere_and_no_script_is_within_a_page() -> None:
    for page, found in pages().items():
        assert found.inline == [], page.name
        for address in found.loads:
            if not address.startswith(("data:", "#")):
                assert (page.parent / urlsplit(address).path).resolve().is_file(), address
    for style in SITE.rglob("*.css"):
        assert re.findall(r"@import|url\((?!['\"]?data:|#)[^)]*\)", style.read_text()) == []


def test_links_and_their_anchors_lead_somewhere() -> None:
    for page, found in pages().items():
        for address in found.links:
            parts = urlsplit(address)
            if parts.scheme or parts.netloc:
                continue
            target = (page.parent / unquote(parts.path)).resolve() if parts.path else page
            assert target.is_file(), f"{page.name}: {address}"
            if parts.fragment and target in pages():
                assert unquote(parts.fragment) in pages()[target].ids, f"{page.name}: {address}"


def test_it_is_small_and_holds_no_sources() -> None:
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in SITE.rglob("*"):
            archive.write(file, file.relative_to(SITE))
    assert packed.tell() < LARGEST
    unused = {"_sources", "objects.inv", ".doctrees", ".buildinfo"}
    assert not unused & {path.name for path in SITE.rglob("*")}
    assert not {".png", ".woff2", ".map"} & {path.suffix for path in SITE.rglob("*")}


def test_the_reference_names_everything(document: dict[str, Any]) -> None:
    commands = text("commands")
    names = [name for each in _MODULES.values() for name in each] + ["tune", "montecarlo"]
    assert [name for name in names if f"usage: motionlab {name}" not in commands] == []
    channels = text("channels")
    assert [each.name for each in CHANNELS if f"B.x.{each.name}<" not in channels] == []
    metrics = text("metrics")
    assert [name for name in (*DEFINITIONS, *CONTOUR_DEFINITIONS) if name not in metrics] == []
    fields = text("fields")
    for name in ("plant.AXIS.friction.sigma_0", "variants.*.controller.AXIS.k_p", "seed"):
        assert f">{name}<" in fields, name
    operations = text("operations")
    for path, methods in document["paths"].items():
        for method in methods:
            assert f"<h3>{method.upper()} {path}<" in operations, f"{method} {path}"


def test_equations_are_rendered_without_a_script() -> None:
    physics = text("physics")
    assert physics.count("<math ") > 10
    assert "<mfrac>" in physics


def test_what_can_be_brought_in_is_found_by_its_usual_names() -> None:
    index = (SITE / "searchindex.js").read_text(encoding="utf-8")
    index = json.loads(index[index.index("{") : index.rindex("}") + 1])

    def pages_of(words: str) -> set[str]:
        """Return the pages that have all words, which are stems; `own` is none of the index."""
        sets = []
        for word in words.removeprefix("own ").split():
            places = [index[part].get(word, []) for part in ("terms", "titleterms")]
            flat = [each for one in places for each in (one if isinstance(one, list) else [one])]
            sets.append({index["docnames"][place] for place in flat})
        return set.intersection(*sets)

    for words, page in {
        "own law": "own-law",
        "plugin": "own-law",
        "ilc": "learning",
        "cog": "own-effect",  # the stem of cogging
        "friction model": "own-effect",
        "own studi": "extending",  # the stem of study
        "own view": "views",
    }.items():
        assert {page, "extending"} <= pages_of(words), words
