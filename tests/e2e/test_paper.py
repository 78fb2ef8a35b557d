"""What a person does on the Paper screen, in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import (
    API,
    LONG,
    button,
    region,
    scenario_control,
    serious,
    session,
    shipped_only,
    state,
    until,
)
from tests.e2e.conftest import EMPTY, Server


@pytest.fixture
def address() -> str:
    return "?screen=paper"


@pytest.fixture
def paper(page: Page) -> Page:
    """The Paper screen with its rows."""
    expect(row(page, "Turns of a phase N")).to_be_visible(timeout=LONG)
    return page


SLOW = 240_000  # ms; rows on a machine that does much else


def row(page: Page, name: str) -> Locator:
    return page.get_by_role("row", name=re.compile(re.escape(name))).first


JOBS: dict[tuple[str, ...], str] = {}
"""What was computed on the server of this file."""


def computed(page: Page, server: Server, *only: str) -> None:
    """Have some rows computed, and open the screen at the record of it."""
    address = f"{server.url}{API}"
    if only not in JOBS:
        JOBS[only] = page.request.post(f"{address}/reproduce", data={"only": only}).json()["id"]
    url = f"{address}/jobs/{JOBS[only]}"
    until(
        page, "all rows are computed", lambda: page.request.get(url).json()["state"] == "done", SLOW
    )
    page.goto(f"{server.url}{EMPTY}")
    page.evaluate(
        "job => localStorage.setItem('motionlab.job.reproduce', JSON.stringify(job))", JOBS[only]
    )
    page.goto(f"{server.url}/?screen=paper")
    page.get_by_text("connected", exact=True).wait_for()


@pytest.mark.usefixtures("unopened")
def test_it_opens_with_its_shipped_result_and_computes_nothing(page: Page, server: Server) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(f"{request.method} {request.url}"))
    shipped_only(page, "reproduce")
    page.goto(f"{server.url}/?screen=paper")
    expect(row(page, "Turns of a phase N")).to_contain_text("✓holds", timeout=LONG)
    expect(region(page, "Run")).to_contain_text(
        re.compile(r"Shipped with \d+\.\d+\.\d+.*, computed on \d+ \w+ \d{4}")
    )
    expect(page.get_by_role("button", name="Compute them again")).to_be_enabled()
    circle = region(page, "Circle, compensation from 90 s on")
    expect(circle.get_by_role("figure").first).to_be_visible()
    expect(row(page, "Deformation of the new x platform")).to_contain_text("not comparable")
    expect(region(page, "Row")).to_contain_text("known failure")  # the first that does not hold
    # A number that is none is shown as printed.
    expect(row(page, "suspended motors of")).to_contain_text("in the centimeter range")
    assert not [each for each in asked if "reproduce" in each and each.startswith("POST")]


def test_rows_fill_in_survive_a_reload_and_are_cancelled(paper: Page) -> None:
    paper.get_by_role("button", name=re.compile("^Compute them")).click()
    expect(paper.get_by_role("progressbar", name="Reproduction, share done")).to_be_visible()
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds", timeout=LONG)
    paper.reload()
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds", timeout=LONG)
    expect(paper.get_by_role("progressbar", name="Reproduction, share done")).to_be_visible()
    button(paper, "Cancel")
    expect(region(paper, "Run")).to_contain_text("Cancelled")
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds")
    expect(row(paper, "pentagram, y")).to_contain_text("not computed")
    expect(paper.get_by_role("button", name="Compute them")).to_be_enabled()


@pytest.mark.usefixtures("unopened")
def test_a_record_is_shown_at_once_with_its_failures_red(page: Page, server: Server) -> None:
    computed(page, server, "limits", "sizing")
    failed = row(page, "Largest velocity, one phase, y")
    expect(failed).to_contain_text("✗known failure", timeout=LONG)
    page.get_by_role("radio", name="Red").click()
    expect(row(page, "Turns of a phase N")).to_have_count(0)
    failed.get_by_role("button").click()
    expect(region(page, "Row")).to_contain_text("0.89 m/s needs 12.5 kg")
    expect(region(page, "Row")).to_contain_text("motionlab design --json")
    page.reload()
    expect(region(page, "Row")).to_contain_text("0.89 m/s needs 12.5 kg", timeout=LONG)
    expect(row(page, "Turns of a phase N")).to_have_count(0)
    page.get_by_role("radio", name="All").click()
    expect(row(page, "Turns of a phase N")).to_contain_text("145")


def test_what_others_have_computed_is_listed_and_shown_when_chosen(
    paper: Page, server: Server
) -> None:
    name = "Turns of a phase N"
    answer = paper.request.post(f"{server.url}{API}/reproduce", data={"only": ["sizing"]})
    url = f"{server.url}{API}/jobs/{answer.json()['id']}"
    until(
        paper,
        "all rows are computed",
        lambda: paper.request.get(url).json()["state"] == "done",
        SLOW,
    )
    other = "pentagram, y"
    paper.reload()
    # The newest of the server is shown, in place of the shipped one.
    expect(row(paper, name)).to_contain_text("✓holds", timeout=LONG)
    expect(row(paper, other)).to_contain_text("not computed")
    earlier = paper.get_by_role("combobox", name="Reproduction: earlier results")
    groups = earlier.locator("optgroup")
    expect(groups.first).to_have_attribute("label", "Started elsewhere")
    expect(groups.last).to_have_attribute("label", "Shipped")
    earlier.select_option("reproduce---")
    expect(row(paper, other)).not_to_contain_text("not computed")
    earlier.select_option(answer.json()["id"])
    expect(row(paper, other)).to_contain_text("not computed")
    paper.reload()
    expect(row(paper, name)).to_contain_text("✓holds", timeout=LONG)
    expect(row(paper, other)).to_contain_text("not computed")


@pytest.mark.usefixtures("unopened")
def test_rows_are_shown_by_kind(page: Page, server: Server) -> None:
    computed(page, server, "sizing")
    expect(row(page, "Mover height h")).to_contain_text(re.compile("✓holds +fit"), timeout=LONG)
    kinds = page.get_by_role("table", name="Rows by kind")
    expect(kinds.get_by_role("row", name=re.compile("^fit"))).to_contain_text("fit207")
    page.get_by_role("button", name="fit", exact=True).press("Enter")
    expect(row(page, "Turns of a phase N")).to_have_count(0)
    page.reload()
    expect(row(page, "Mover height h")).to_be_visible(timeout=LONG)
    expect(row(page, "Turns of a phase N")).to_have_count(0)
    page.get_by_role("button", name="all rows").click()
    expect(row(page, "Turns of a phase N")).to_contain_text(re.compile("✓holds +arithmetic"))


@pytest.mark.usefixtures("unopened")
def test_lax_rows_say_why(page: Page, server: Server) -> None:
    computed(page, server, "sizing")
    loading = row(page, "Electric loading A")
    expect(loading).to_contain_text("arithmetic, weak test", timeout=LONG)
    page.get_by_role("radio", name="Weak").click()
    expect(row(page, "Turns of a phase N")).to_have_count(0)
    loading.get_by_role("button").click()
    expect(region(page, "Row")).to_contain_text("nearly any model would hold this row")
    page.get_by_role("radio", name="All").click()


@pytest.mark.usefixtures("unopened")
def test_a_recipe_opens_in_the_lab(page: Page, server: Server) -> None:
    computed(page, server, "rhombus-x")
    expect(row(page, "Following error, rhombus, x")).to_contain_text("✓better", timeout=LONG)
    row(page, "Following error, rhombus, x").get_by_role("button").click()
    chosen = region(page, "Row")
    expect(chosen).to_contain_text("the motion profile of the edges is not printed")
    expect(chosen).to_contain_text("Plausible motors")
    expect(chosen.get_by_role("figure").first).to_be_visible()
    expect(chosen).to_contain_text("motionlab run rhombus --set plant=matched --json")
    button(page, "Open rhombus in the Lab")
    state(page, "paused")
    expect(scenario_control(page)).to_contain_text("rhombus")
    assert session(page, server)["scenario"]["plant"]["name"] == "matched"


def test_a_row_is_chosen_by_keyboard_and_its_command_copied(paper: Page) -> None:
    paper.context.grant_permissions(["clipboard-read", "clipboard-write"])
    row(paper, "Turns of a phase N").get_by_role("button").focus()
    paper.keyboard.press("Enter")
    expect(region(paper, "Row")).to_contain_text("a whole number")
    expect(paper).to_have_url(re.compile("row=turns"))
    paper.get_by_role("button", name="Copy: Command").click()
    paper.wait_for_function(  # which looks at every frame: it is said for two seconds
        "document.querySelector('[aria-label=\"Copy: Command\"]').innerText === '✓ copied'"
    )
    assert paper.evaluate("navigator.clipboard.readText()") == "motionlab design --json"


@pytest.mark.usefixtures("unopened")
def test_on_a_phone_nothing_sticks_out(page: Page, server: Server) -> None:
    computed(page, server, "limits", "sizing")
    page.set_viewport_size({"width": 390, "height": 844})
    failed = row(page, "Largest velocity, one phase, y")
    expect(failed).to_contain_text("known failure", timeout=LONG)
    root = "document.documentElement"
    page.wait_for_function(f"{root}.scrollWidth <= {root}.clientWidth")
    failed.click()
    expect(region(page, "Row")).to_be_in_viewport()


@pytest.mark.usefixtures("unopened")
def test_axe_finds_nothing_serious(page: Page, server: Server) -> None:
    computed(page, server, "limits", "performance", "friction")
    expect(region(page, "Identified friction").get_by_role("figure").first).to_be_visible(
        timeout=LONG
    )
    row(page, "Largest velocity, one phase, y").get_by_role("button").click()
    expect(region(page, "Row")).to_contain_text("0.89 m/s needs 12.5 kg")
    assert serious(page) == []
