"""A law of one's own: chosen, read, saved anew while the lab shows it, and refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from motionlab.own_laws.template import template
from tests.e2e.actions import LONG, metric, region, serious, until
from tests.e2e.conftest import Server, missing
from tests.paths import ROOT

TEXT = template("mine")
FORCE = "par.mine_share * seen.friction.F_c"


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("laws") / "mine.py"
    path.write_text(TEXT, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def server(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        missing("the page is not built: make frontend/dist/index.html")
    server = Server(tmp_path_factory.mktemp("data"), "--laws", str(file.parent))
    yield server
    server.stop()


def saved(file: Path, force: str) -> None:
    file.write_text(TEXT.replace(FORCE, force), encoding="utf-8")


def rms(page: Page) -> float:
    """Return the RMS error of B on y once it is exact, um."""
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    return float(metric(page, "RMS ey", 1))


@pytest.mark.usefixtures("fresh")
def test_a_saved_law_runs_at_once_and_one_that_cannot_is_refused(page: Page, file: Path) -> None:
    saved(file, FORCE)  # as it was, for a second try
    source = page.get_by_role("button", name="Source of the law of B")
    sheet = page.get_by_role("dialog", name="mine, mine.py")
    text = sheet.get_by_role("region", name="Text of mine.py")

    shipped = rms(page)
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    expect(region(page, "Metrics").locator("tr", has_text="RMS ey")).not_to_contain_text(
        f"{shipped:.2f}", timeout=LONG
    )
    whole = rms(page)

    source.click()
    expect(text).to_contain_text(FORCE)
    expect(sheet).to_contain_text("Saving this file takes effect at once")
    saved(file, f"0.5 * {FORCE}")
    expect(text).to_contain_text(f"0.5 * {FORCE}", timeout=LONG)
    expect(region(page, "Metrics").locator("tr", has_text="RMS ey")).not_to_contain_text(
        f"{whole:.2f}", timeout=LONG
    )
    until(page, "half the force", lambda: rms(page) > whole > shipped)
    half = rms(page)

    saved(file, f"({FORCE}")
    reason = "mine.py:11: mine: SyntaxError: '(' was never closed"
    expect(sheet.get_by_role("alert")).to_contain_text(reason, timeout=LONG)
    expect(text.locator("[aria-current]")).to_contain_text(f"({FORCE}")
    expect(page.locator(".messages")).to_contain_text(f"Law mine not taken: {reason}")
    until(page, "the version before", lambda: rms(page) == half)
    assert serious(page, "dialog[open]") == []
    page.keyboard.press("Escape")
    expect(sheet).to_be_hidden()
    expect(source).to_be_focused()

    page.get_by_role("button", name=re.compile("^People")).click()
    events = page.get_by_role("list", name="Events", exact=True)
    expect(events).to_contain_text(f"law mine not taken: {reason}")
    expect(events).to_contain_text("law mine: a new version")
    page.keyboard.press("Escape")

    saved(file, FORCE)
    expect(page.locator(".messages")).not_to_contain_text("not taken", timeout=LONG)
    expect(region(page, "Metrics").locator("tr", has_text="RMS ey")).to_contain_text(
        f"{whole:.2f}", timeout=LONG
    )
