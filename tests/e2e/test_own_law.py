"""A law of one's own: chosen, read, saved anew while the lab shows it, and refused."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from motionlab.own_laws.template import template
from tests.e2e.actions import (
    API,
    LONG,
    asked_for,
    metric,
    region,
    serious,
    set_field,
    until,
)
from tests.e2e.conftest import Server, missing
from tests.paths import ROOT

TEXT = template("mine")
TOKEN = "a-token-of-some-length"
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
    expect(events).to_contain_text("law mine, version 2")
    page.keyboard.press("Escape")

    saved(file, FORCE)
    expect(page.locator(".messages")).not_to_contain_text("not taken", timeout=LONG)
    expect(region(page, "Metrics").locator("tr", has_text="RMS ey")).to_contain_text(
        f"{whole:.2f}", timeout=LONG
    )


@pytest.mark.usefixtures("fresh")
def test_back_by_a_key_and_old_against_new_in_one_click(page: Page, file: Path) -> None:
    saved(file, FORCE)
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    page.get_by_role("button", name="Source of the law of B").click()
    sheet = page.get_by_role("dialog", name="mine, mine.py")
    expect(sheet).to_contain_text(re.compile(r"costs .* in a tick|too little"), timeout=LONG)
    saved(file, f"0.3 * {FORCE}")
    expect(sheet).to_contain_text(f"0.3 * {FORCE}", timeout=LONG)
    number = re.search(r"Version (\d+) of \1 runs\.", sheet.inner_text())
    assert number is not None
    last = int(number[1])

    sheet.get_by_role("button", name="Old against new").click()
    sheet.get_by_role("button", name="Close").click()
    folded = page.get_by_role("button", name=re.compile("^Controller A: mine, before"))
    expect(folded).to_be_visible()
    until(page, "the old one better", lambda: rms(page) > float(metric(page, "RMS ey", 0)))
    old = metric(page, "RMS ey", 0)

    page.keyboard.press("b")  # B runs what A ran
    until(page, "the old one", lambda: rms(page) == float(old))
    page.get_by_role("button", name="Source of the law of B").click()
    expect(sheet).to_contain_text(f"Version {last - 1} of {last} runs; the file is newer.")
    expect(sheet.get_by_role("region")).not_to_contain_text(f"0.3 * {FORCE}")
    assert serious(page, "dialog[open]") == []
    sheet.get_by_role("button", name="Forward").click()
    expect(sheet).to_contain_text(f"Version {last} of {last} runs.", timeout=LONG)
    assert f"0.3 * {FORCE}" in file.read_text()


@pytest.mark.usefixtures("fresh")
def test_margins_of_the_version_before_are_marked_until_the_new_ones_come(
    page: Page, file: Path
) -> None:
    saved(file, FORCE)
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    controllers = region(page, "Controllers")
    waiting = controllers.get_by_text("margins: computing…")
    margins = controllers.get_by_test_id("margins").first
    expect(margins).to_contain_text("GM", timeout=LONG)
    expect(margins).to_have_attribute("aria-busy", "false", timeout=LONG)
    held: list[Route] = []
    page.route("**/api/v1/loop", lambda route: held.append(route))  # noqa: PLW0108
    saved(file, f"0.5 * {FORCE}")
    expect(waiting).to_be_visible(timeout=LONG)
    expect(margins).to_have_class(re.compile(r"\blate\b"))
    expect(margins).to_contain_text("GM")
    assert serious(page, "main") == []
    for each in held:
        each.continue_()
    page.unroute("**/api/v1/loop")
    expect(waiting).to_have_count(0, timeout=LONG)
    expect(margins).not_to_have_class(re.compile(r"\blate\b"))


@pytest.mark.usefixtures("fresh")
def test_its_parameter_is_searched_with_the_gains(
    page: Page, server: Server, file: Path, refusals: list[str]
) -> None:
    saved(file, FORCE)
    refusals.append("422")
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    page.get_by_role("link", name="Tune", exact=True).click()
    set_field(page, "starts", "1")
    set_field(page, "evaluations", "20")
    limits = region(page, "Limits")
    limits.get_by_role("checkbox", name="mine share").check()
    set_field(limits, "largest mine share", "5")
    page.get_by_role("button", name="Search gains").click()
    expect(region(page, "Search")).to_contain_text("mine share: Is out of range", timeout=LONG)
    set_field(limits, "largest mine share", "1.5")
    assert serious(page, "main") == []
    job = asked_for(page, page.get_by_role("button", name="Search gains").click)
    request = page.request.get(f"{server.url}{API}/jobs/{job}").json()["request"]
    assert request["also"] == {"compensation.mine_share": [0.002, 1.5]}
    expect(region(page, "Candidates").locator("tbody tr")).to_have_count(3, timeout=3 * LONG)


@pytest.fixture(scope="module")
def editable(file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(
        tmp_path_factory.mktemp("data"),
        "--laws",
        str(file.parent),
        "--edit-laws",
        MOTIONLAB_TOKEN=TOKEN,
    )
    yield server
    server.stop()


def test_a_law_is_changed_in_the_page_and_what_is_not_saved_stays(
    browser: Browser, editable: Server, file: Path
) -> None:
    saved(file, FORCE)
    page = browser.new_page(viewport={"width": 1440, "height": 900})
    page.goto(editable.url)
    page.get_by_label("Token", exact=True).fill(TOKEN)
    page.keyboard.press("Enter")
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    source = page.get_by_role("button", name="Source of the law of B")
    source.click()
    sheet = page.get_by_role("dialog", name="mine, mine.py")
    sheet.get_by_role("button", name="Edit").click()
    text = sheet.get_by_role("textbox", name="Text of mine.py")
    expect(text).to_be_focused()
    expect(sheet.get_by_role("button", name="Save")).to_be_disabled()
    changed = TEXT.replace(FORCE, f"0.25 * {FORCE}")
    text.fill(changed)
    assert serious(page, "dialog[open]") == []

    page.keyboard.press("Escape")  # closes the sheet
    expect(sheet).to_be_hidden()
    source.click()
    expect(text).to_have_value(changed)
    assert file.read_text() == TEXT
    text.focus()
    page.keyboard.press("Control+s")
    expect(sheet.get_by_role("region", name="Text of mine.py")).to_contain_text(f"0.25 * {FORCE}")
    assert file.read_text() == changed
    page.close()


@pytest.mark.usefixtures("fresh")
def test_a_new_parameter_has_its_control_and_a_new_file_is_a_law_without_a_reload(
    page: Page, file: Path
) -> None:
    saved(file, FORCE)
    page.evaluate("window.kept = true")
    page.get_by_role("combobox", name="B compensation law").select_option("mine")
    page.get_by_text("Parameters of the law", exact=True).last.click()
    expect(page.get_by_role("textbox", name="B mine share")).to_be_visible()
    parameter = 'MORE = Parameter("mine_more", "Force", unit="N", default=0, ge=0, le=9)\nclass'
    more = TEXT.replace("class", parameter, 1).replace("(SHARE,)", "(SHARE, MORE)")
    more = more.replace("_share: Lanes  # 1", "_share: Lanes  # 1\n    mine_more: Lanes  # N")
    file.write_text(more.replace(FORCE, f"{FORCE} + par.mine_more"), encoding="utf-8")
    control = page.get_by_role("textbox", name="B mine more, N")
    expect(control).to_be_visible(timeout=LONG)
    before = rms(page)
    control.fill("4")
    control.press("Enter")
    until(page, "the parameter acting", lambda: rms(page) != before)
    law = page.get_by_role("combobox", name="B compensation law")
    file.with_name("fresh.py").write_text(template("fresh"), encoding="utf-8")
    expect(law.locator("option[value=fresh]")).to_have_count(1, timeout=LONG)
    law.select_option("fresh")
    expect(page.get_by_role("textbox", name="B fresh share")).to_be_visible()
    assert page.evaluate("window.kept") is True

    law.select_option("mine")
    saved(file, FORCE)
    expect(control).to_have_count(0, timeout=LONG)
    assert serious(page, "main") == []
