"""The Sweep screen: a search, its front, a case opened in the Lab, and every number."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, asked_for, region, serious
from tests.e2e.conftest import Server

pytestmark = pytest.mark.browser

PATIENT = 120_000  # ms; the first study of a new model compiles its kernel


@pytest.fixture
def screen(page: Page, server: Server) -> Page:
    """The Sweep screen with both gains of B on x."""
    page.goto(f"{server.url}/?screen=sweep")
    form = region(page, "Swept fields")
    form.get_by_role("button", name="Add a field").click(timeout=LONG)
    return page


def _run(page: Page, name: str = "Run") -> None:
    form = region(page, "Swept fields")
    asked_for(page, form.get_by_role("button", name=name, exact=True).click)
    expect(region(page, "Result")).to_have_attribute("aria-busy", "false", timeout=PATIENT)
    expect(form.get_by_text("took").first).to_be_visible(timeout=PATIENT)


def test_a_case_of_a_search_opens_in_the_lab(screen: Page) -> None:
    page, form = screen, region(screen, "Swept fields")
    form.get_by_label("values", exact=True).select_option(label="searched")
    form.get_by_label("samples").fill("64")
    form.get_by_label("samples").press("Enter")
    for _ in range(2):
        form.get_by_role("button", name="Add an objective").click()
    form.get_by_role("button", name="Add a limit").click()
    _run(page)

    plot = region(page, "Result").get_by_role("slider")
    plot.focus()
    page.keyboard.press("ArrowUp")  # the least value of the first field
    page.keyboard.press("Enter")
    first = page.get_by_role("region", name="Case")
    expect(first).to_be_visible()
    least = first.get_by_role("row").first.inner_text()
    page.keyboard.press("End")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Enter")
    expect(first.get_by_role("row").first).not_to_have_text(least)
    assert serious(page) == []

    page.get_by_role("radio", name="two metrics").click()
    expect(region(page, "Result").get_by_text("front")).to_be_visible()
    first.get_by_role("button", name="Open in the Lab").click()
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    staged = page.evaluate("new URL(location.href).searchParams.get('set') ?? ''")
    assert "variants.B.controller.x.k_p" in staged or page.get_by_text("staged").count() > 0


def test_what_is_kept_of_an_axis_filters_the_cases(screen: Page) -> None:
    page, form = screen, region(screen, "Swept fields")
    form.get_by_label("values", exact=True).select_option(label="drawn: Sobol")
    form.get_by_label("samples").fill("64")
    form.get_by_label("samples").press("Enter")
    _run(page)
    result = region(page, "Result")
    expect(result.get_by_text("64 cases")).to_be_visible()
    box = result.get_by_role("slider").bounding_box()
    assert box is not None
    left = box["x"] + 46  # the first axis
    page.mouse.move(left, box["y"] + 0.3 * box["height"])
    page.mouse.down()
    page.mouse.move(left, box["y"] + 0.6 * box["height"], steps=4)
    page.mouse.up()
    page.mouse.move(left, box["y"] + 4)
    expect(result.get_by_text("of 64 cases")).to_be_visible()
    page.mouse.click(left, box["y"] + 0.8 * box["height"])
    expect(result.get_by_text("64 cases", exact=True)).to_be_visible()

    page.mouse.move(left, box["y"] + 0.3 * box["height"])
    page.mouse.down()
    page.mouse.move(left, box["y"] + 0.5 * box["height"], steps=4)
    expect(result.get_by_text("of 64 cases")).to_be_visible()
    result.get_by_role("slider").dispatch_event("pointercancel")  # as where a touch scrolls
    expect(result.get_by_text("64 cases", exact=True)).to_be_visible()
    page.mouse.move(left, box["y"] + 0.6 * box["height"], steps=4)
    expect(result.get_by_text("64 cases", exact=True)).to_be_visible()
    page.mouse.up()


def test_every_number_names_what_matters(screen: Page) -> None:
    page = screen
    _run(page, "Every number")
    result = region(page, "Result")
    rows = result.get_by_role("row")
    expect(rows.nth(1)).to_contain_text("tau", timeout=LONG)
    assert serious(page) == []
    rows.nth(3).get_by_role("button").click()
    expect(region(page, "Swept fields").get_by_role("group", name="Field 3")).to_be_visible()
