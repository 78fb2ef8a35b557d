"""What a person does on the Paper screen, in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import API, LONG, button, region, serious, session, state, until
from tests.e2e.conftest import Server


@pytest.fixture
def paper(page: Page) -> Page:
    """The Paper screen with its rows."""
    page.get_by_role("link", name="Paper").click()
    expect(row(page, "Turns of a phase N")).to_be_visible(timeout=LONG)
    return page


SLOW = 240_000  # ms; rows on a machine that does much else


def row(page: Page, name: str) -> Locator:
    return page.get_by_role("row", name=re.compile(re.escape(name))).first


def computed(page: Page, server: Server, *only: str) -> None:
    """Have some rows computed, and look at the record of it."""
    job = page.request.post(f"{server.url}{API}/reproduce", data={"only": list(only)}).json()["id"]
    url = f"{server.url}{API}/jobs/{job}"
    until(
        page, "all rows are computed", lambda: page.request.get(url).json()["state"] == "done", SLOW
    )
    # As the next page opens: this one may still be reading an older record, and would keep it.
    page.add_init_script(f"localStorage.setItem('motionlab.job.reproduce', '\"{job}\"')")
    page.reload()


def test_rows_are_there_before_anything_is_computed(paper: Page) -> None:
    expect(row(paper, "Turns of a phase N")).to_contain_text("not computed")
    expect(row(paper, "Deformation of the new x platform")).to_contain_text("not comparable")
    expect(region(paper, "Row")).to_contain_text("Choose a row")
    expect(region(paper, "Errata")).to_have_count(0)


def test_rows_fill_in_survive_a_reload_and_are_cancelled(paper: Page) -> None:
    button(paper, "Compute them")
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds", timeout=LONG)
    paper.reload()
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds", timeout=LONG)
    expect(paper.get_by_role("progressbar", name="Reproduction, share done")).to_be_visible()
    button(paper, "Cancel")
    expect(region(paper, "Run")).to_contain_text("Cancelled")
    expect(row(paper, "Turns of a phase N")).to_contain_text("✓holds")
    expect(row(paper, "pentagram, y")).to_contain_text("not computed")
    expect(paper.get_by_role("button", name="Compute them")).to_be_enabled()


def test_a_record_is_shown_at_once_with_its_failures_red(paper: Page, server: Server) -> None:
    computed(paper, server, "limits", "sizing")
    failed = row(paper, "Largest velocity, one phase, y")
    expect(failed).to_contain_text("✗known failure", timeout=LONG)
    paper.get_by_role("radio", name="Red").click()
    expect(row(paper, "Turns of a phase N")).to_have_count(0)
    failed.get_by_role("button").click()
    expect(region(paper, "Row")).to_contain_text("0.89 m/s needs 12.5 kg")
    expect(region(paper, "Row")).to_contain_text("motionlab design --json")
    paper.reload()
    expect(region(paper, "Row")).to_contain_text("0.89 m/s needs 12.5 kg", timeout=LONG)
    expect(row(paper, "Turns of a phase N")).to_have_count(0)
    paper.get_by_role("radio", name="All").click()
    expect(row(paper, "Turns of a phase N")).to_contain_text("145")


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
    paper.reload()
    earlier = paper.get_by_role("combobox", name="Reproduction: earlier results")
    expect(earlier).to_be_visible(timeout=LONG)
    expect(earlier.locator("optgroup")).to_have_attribute("label", "Started elsewhere")
    expect(row(paper, name)).to_contain_text("not computed")
    earlier.select_option(answer.json()["id"])
    expect(row(paper, name)).not_to_contain_text("not computed")
    paper.reload()
    expect(row(paper, name)).not_to_contain_text("not computed", timeout=LONG)


def test_rows_are_shown_by_kind(paper: Page, server: Server) -> None:
    computed(paper, server, "sizing")
    expect(row(paper, "Mover height h")).to_contain_text(re.compile("✓holds +fit"), timeout=LONG)
    kinds = paper.get_by_role("table", name="Rows by kind")
    expect(kinds.get_by_role("row", name=re.compile("^fit"))).to_contain_text("fit206")
    paper.get_by_role("button", name="fit", exact=True).press("Enter")
    expect(row(paper, "Turns of a phase N")).to_have_count(0)
    paper.reload()
    expect(row(paper, "Mover height h")).to_be_visible(timeout=LONG)
    expect(row(paper, "Turns of a phase N")).to_have_count(0)
    paper.get_by_role("button", name="all rows").click()
    expect(row(paper, "Turns of a phase N")).to_contain_text(re.compile("✓holds +arithmetic"))


def test_lax_rows_say_why(paper: Page, server: Server) -> None:
    computed(paper, server, "sizing")
    loading = row(paper, "Electric loading A")
    expect(loading).to_contain_text("arithmetic, weak test", timeout=LONG)
    paper.get_by_role("radio", name="Weak").click()
    expect(row(paper, "Turns of a phase N")).to_have_count(0)
    loading.get_by_role("button").click()
    expect(region(paper, "Row")).to_contain_text("nearly any model would hold this row")
    paper.get_by_role("radio", name="All").click()


def test_a_number_that_is_no_number_is_shown_as_printed(paper: Page) -> None:
    expect(row(paper, "suspended motors of")).to_contain_text("in the centimeter range")


def test_a_recipe_opens_in_the_lab(paper: Page, server: Server) -> None:
    computed(paper, server, "rhombus-x")
    expect(row(paper, "Following error, rhombus, x")).to_contain_text("✓better", timeout=LONG)
    row(paper, "Following error, rhombus, x").get_by_role("button").click()
    chosen = region(paper, "Row")
    expect(chosen).to_contain_text("the motion profile of the edges is not printed")
    expect(chosen).to_contain_text("Plausible motors")
    expect(chosen.get_by_role("figure").first).to_be_visible()
    expect(chosen).to_contain_text("motionlab run rhombus --set plant=matched --json")
    button(paper, "Open rhombus in the Lab")
    state(paper, "paused")
    scenario = region(paper, "Scenario").get_by_role("combobox").first
    expect(scenario).to_have_value("rhombus")
    assert session(paper, server)["scenario"]["plant"]["name"] == "matched"


def test_a_command_is_copied(paper: Page) -> None:
    paper.context.grant_permissions(["clipboard-read", "clipboard-write"])
    row(paper, "Turns of a phase N").get_by_role("button").click()
    paper.get_by_role("button", name="Copy: Command").click()
    paper.wait_for_function(  # which looks at every frame: it is said for two seconds
        "document.querySelector('[aria-label=\"Copy: Command\"]').innerText === '✓ copied'"
    )
    assert paper.evaluate("navigator.clipboard.readText()") == "motionlab design --json"


def test_a_row_is_chosen_by_keyboard(paper: Page) -> None:
    row(paper, "Turns of a phase N").get_by_role("button").focus()
    paper.keyboard.press("Enter")
    expect(region(paper, "Row")).to_contain_text("a whole number")
    expect(paper).to_have_url(re.compile("row=turns"))


def test_on_a_phone_nothing_sticks_out(paper: Page, server: Server) -> None:
    computed(paper, server, "limits")
    paper.set_viewport_size({"width": 390, "height": 844})
    failed = row(paper, "Largest velocity, one phase, y")
    expect(failed).to_contain_text("known failure", timeout=LONG)
    page = "document.documentElement"
    paper.wait_for_function(f"{page}.scrollWidth <= {page}.clientWidth")
    failed.click()
    expect(region(paper, "Row")).to_be_in_viewport()


def test_axe_finds_nothing_serious(paper: Page, server: Server) -> None:
    computed(paper, server, "limits", "performance", "friction")
    expect(region(paper, "Identified friction").get_by_role("figure").first).to_be_visible(
        timeout=LONG
    )
    row(paper, "Largest velocity, one phase, y").get_by_role("button").click()
    expect(region(paper, "Row")).to_contain_text("0.89 m/s needs 12.5 kg")
    assert serious(paper) == []
