"""The Runs screen: what another law would have done in a kept run."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import API, button, region, serious, set_field
from tests.e2e.conftest import Server
from tests.e2e.test_jobs import SLOW, item, tray
from tests.e2e.test_runs import keep, open_runs, open_screen


@pytest.fixture
def run(page: Page, server: Server, refusals: list[str]) -> Iterator[str]:
    """A kept run on a motor that its controllers believe in."""
    refusals.append("404")
    kept = keep(page, server, scenario="circle-matched", set={"trajectory.laps": 3})
    yield kept
    page.request.delete(f"{server.url}{API}/runs/{kept}")


def choose(section: Locator, law: str) -> None:
    section.get_by_role("button", name="With which law").press("ArrowDown")
    find = section.get_by_role("combobox", name="Find: With which law")
    find.fill(law)
    find.press("Enter")


@pytest.mark.usefixtures("unopened")
def test_another_law_is_predicted_for_a_run_and_found_again(
    page: Page, server: Server, run: str, refusals: list[str]
) -> None:
    refusals.append("422")
    open_runs(page, server, f"&run={run}")
    section = region(page, "Another law")
    section.get_by_role("button", name="Another law", exact=True).press("Space")
    choose(section, "lugre-reference")
    set_field(section, "End of the stretch, s", "2")
    button(section, "Predict")
    expect(section.get_by_role("alert")).to_contain_text("too short a part: 2 s. Allowed: ≥ 3 s")

    button(section, "Whole run")
    button(section, "Predict")
    table = section.get_by_role("table", name="Errors, recorded and predicted")
    expect(table).to_be_visible(timeout=SLOW)
    expect(section.get_by_role("alert")).to_have_count(0)
    recorded, predicted, band, ratio = (
        table.get_by_role("row", name="max |ex|").get_by_role("cell").all_inner_texts()
    )
    assert re.fullmatch(r"[\d.]+ to [\d.]+", band)
    assert float(predicted) < 0.2 * float(recorded)
    assert float(ratio) < 0.2
    page.mouse.move(0, 0)  # what scrolls below the pointer is read there
    for axis in "xy":
        plot = section.get_by_role("slider", name=f"Following error of {axis}")
        plot.press("Home")
        expect(plot).to_have_attribute("aria-valuetext", re.compile("A recorded .+ B predicted"))
    section.get_by_text("Fitted motor").click()
    expect(section.get_by_role("table", name="Motor of x")).to_contain_text("kg")
    assert serious(page, within="main") == []

    button(page, "Close the run")
    expect(section).to_have_count(0)
    open_screen(page, "Paper")
    tray(page)
    button(item(page, "The same minute").first, "Open")
    expect(page).to_have_url(re.compile(f"run={run}"))
    expect(table).to_be_in_viewport()
    expect(section.get_by_role("button", name="With which law")).to_have_text("lugre-reference")
