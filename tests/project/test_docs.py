"""The documents point at what exists, and their pictures can be drawn again."""

import re
import subprocess
import sys
from typing import get_args

import pytest

from motionlab.server.job_reports import Kind
from tests.e2e.pictures import PICTURES
from tests.paths import ROOT

PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.md"))]
CALL = re.compile(r"`([A-Z]+) (/[^`? ]*)")
LINK = re.compile(r"""(?:\]\(|src(?:set)?=")([^)"#:]+)(?:#[^)"]*)?[)"]""")
SECTION = re.compile(r"\]\(([\w./-]*\.md)?#([^)]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
IDIOMS = re.compile(
    r"edges? of stability|r[au]ns? away|laws? of sharing|time laws?\b|turned away|\bof late\b"
    r"|\b(?:is|are|was) told\b|\bnobody\b|\blets? go of\b",
    re.IGNORECASE,
)
NAMED = re.compile(r"\bdocs/[a-z-]+\.md\b")


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_links_lead_somewhere(page):
    for target in LINK.findall(page.read_text()):
        assert (page.parent / target).exists(), target


def test_sections_that_links_name_exist():
    for page in PAGES:
        for file, section in SECTION.findall(page.read_text()):
            text = (page.parent / (file or page.name)).read_text()
            titles = [re.sub(r"[^\w -]", "", title).lower() for title in HEADING.findall(text)]
            assert section in [title.replace(" ", "-") for title in titles], (
                f"{page.name}: {section}"
            )


def test_every_page_can_be_reached_from_the_readme():
    seen, waiting = set(), [ROOT / "README.md"]
    while waiting:
        page = waiting.pop()
        seen.add(page)
        links = [(page.parent / target).resolve() for target in LINK.findall(page.read_text())]
        waiting += [link for link in links if link.suffix == ".md" and link not in seen]
    assert set(PAGES) <= seen


def test_text_uses_the_terms_of_the_field():
    """Stability boundary, diverged, force-sharing function, motion profile; plain sentences."""
    sources = {"backend/motionlab": "py", "frontend/src": "svelte", "configs": "toml", "docs": "md"}
    files = [
        file for folder, kind in sources.items() for file in (ROOT / folder).rglob(f"*.{kind}")
    ]
    found = {file.name: IDIOMS.findall(file.read_text()) for file in [*files, ROOT / "README.md"]}
    assert {name: words for name, words in found.items() if words} == {}


def test_lines_of_the_pages_fit_a_screen():
    tested = ("|", "    ", "$$", "Readings of", "  `motionlab")  # tables, commands, equations
    for page in PAGES[2:]:
        lines = [line for line in page.read_text().splitlines() if not line.startswith(tested)]
        assert [line for line in lines if len(line) > 160 and "](" not in line] == [], page.name


def test_pages_that_the_program_names_are_there():
    sources = [*(ROOT / "backend").rglob("*.py"), *(ROOT / "frontend" / "src").rglob("*.svelte")]
    named = {page for path in sources for page in NAMED.findall(path.read_text())}
    assert "docs/known-failures.md" in named
    assert sorted(page for page in named if not (ROOT / page).is_file()) == []


def test_every_call_is_on_the_page_of_rest(document):
    page = (ROOT / "docs" / "rest.md").read_text()
    told = {(method, path) for method, path in CALL.findall(page)}
    calls = {
        (method.upper(), path.removeprefix("/api/v1"))
        for path, methods in document["paths"].items()
        for method in methods
    }
    assert sorted(calls - told) == []


def test_every_picture_is_shown():
    shown = {
        (page.parent / target).resolve()
        for page in PAGES
        for target in LINK.findall(page.read_text())
    }
    assert {*(ROOT / "docs").glob("*.png")} <= shown


def test_every_picture_can_be_taken_or_drawn_again():
    drawn = {file.name for file in (ROOT / "docs").glob("physics-*.png")}  # by docs/plots.py, below
    assert {file.name for file in (ROOT / "docs").glob("*.png")} - drawn == PICTURES


def test_the_plots_are_drawn_and_print_what_the_pages_quote(tmp_path):
    command = [sys.executable, ROOT / "docs" / "plots.py", tmp_path]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert {file.name for file in tmp_path.iterdir()} == {
        file.name for file in (ROOT / "docs").glob("physics-*.png")
    }
    crossings = re.search(r"(\S+) changes of sign a second", printed)
    assert crossings is not None
    assert f"{crossings[1]} times a second" in (ROOT / "docs" / "compensation.md").read_text()
    reached = re.search(r"40 N commanded: (\S+) to (\S+) N", printed)
    assert reached is not None
    assert [f"{float(force):.1f}" for force in reached.groups()] == ["28.1", "34.1"]


def test_every_kind_of_job_is_documented():
    page = (ROOT / "docs" / "rest.md").read_text()
    assert [kind for kind in get_args(Kind) if f"`{kind}`" not in page] == []
