"""A phone and narrow places: nothing is cut, STOP is in reach, captures are told apart."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.actions import API, LONG, button, on_a_phone, region
from tests.e2e.conftest import Server

ACROSS = """document.documentElement.scrollWidth <= innerWidth && innerWidth === 390
  && [...document.querySelectorAll(".panel")].every(
    (e) => e.getBoundingClientRect().right <= 390
  )"""
END = "scrollTo(0, document.documentElement.scrollHeight)"
WHOLE = "(all) => all.every((e) => e.scrollWidth <= e.clientWidth)"
UNCUT = """(all) => all.every((e) => {
  const text = document.createRange();
  text.selectNodeContents(e);
  return text.getBoundingClientRect().width <= e.getBoundingClientRect().width + 0.05;
})"""
"""An ellipsis may be for less than a pixel."""
CHANGES = {"variants.B.controller.y.k_d": 2042.0, "variants.B.controller.feedforward": True}
REVERSALS = (10500, 13500, 16500)
"""Ticks at which x of the circle reverses."""


@pytest.fixture
def phone(browser: Browser, server: Server) -> Iterator[Page]:
    page = on_a_phone(browser, server)
    yield page
    for run in page.request.get(f"{server.url}{API}/runs").json()["runs"]:
        page.request.delete(f"{server.url}{API}/runs/{run['id']}")
    page.context.close()


def keep_runs(page: Page, server: Server) -> None:
    """Keep a run named circle, then captures of reversals."""
    circle = {"scenario": "circle", "keep": True}
    assert page.request.post(f"{server.url}{API}/simulate", data=circle).ok
    for tick in REVERSALS:
        stretch = {"from_tick": tick - 100, "to_tick": tick + 300, "trigger_tick": tick}
        capture = {"scenario": "circle", "set": CHANGES, **stretch}
        assert page.request.post(f"{server.url}{API}/whatif/captures", data=capture).ok


def test_the_share_and_the_change_of_why_are_whole(phone: Page) -> None:
    expect(region(phone, "Metrics")).to_contain_text("exact", timeout=LONG)
    region(phone, "Result").get_by_role("button", name="Why?").tap()
    sheet = phone.get_by_role("dialog", name="Why?")
    stage = sheet.get_by_role("button", name="Stage this change")
    expect(stage).to_be_visible(timeout=LONG)
    assert sheet.evaluate("(e) => e.scrollWidth <= e.clientWidth")
    assert stage.evaluate("(e) => e.scrollWidth <= e.clientWidth")
    for share in sheet.locator("tbody td:last-child").all():
        expect(share).to_be_in_viewport(ratio=1)
    unit = sheet.locator("thead th").nth(1).inner_text()
    expect(sheet.locator(".mend")).to_contain_text(f" {unit} over the window")


def test_stop_is_in_reach_at_the_end_of_every_screen_of_a_phone(
    phone: Page, server: Server
) -> None:
    keep_runs(phone, server)
    stop = phone.get_by_role("button", name="STOP")
    screens = phone.get_by_role("combobox", name="Screen")
    for title in screens.locator("option").all_inner_texts():
        screens.select_option(title)
        phone.evaluate(END)
        expect(stop, title).to_be_in_viewport(ratio=1)
        assert phone.evaluate(ACROSS), title
    screens.select_option("Runs")
    phone.get_by_role("row", name="as shipped").tap()
    run = region(phone, "Run")
    expect(run.get_by_role("heading", name="circle")).to_be_in_viewport(ratio=1)
    expect(run.get_by_role("button", name="Table")).to_be_visible(timeout=LONG)
    expect(run.get_by_role("heading", name="circle")).to_be_in_viewport(ratio=1)
    assert phone.evaluate(ACROSS)
    phone.evaluate(END)
    expect(stop).to_be_in_viewport(ratio=1)
    run.get_by_role("button", name="Close the run").tap()
    expect(region(phone, "Runs").first.get_by_role("combobox", name="Order")).to_be_in_viewport()


def test_trigger_on_a_phone_is_scrolled_to_and_nothing_lies_over_the_status_bar(
    phone: Page,
) -> None:
    scopes = region(phone, "Scopes")
    scopes.get_by_role("button", name="Measure").tap()
    table = region(phone, "Measurements as numbers")
    expect(table).to_be_visible(timeout=LONG)
    table.evaluate("(e) => scrollBy(0, e.getBoundingClientRect().top - innerHeight + 40)")
    over = "document.elementFromPoint(60, innerHeight - 14).closest('footer') !== null"
    assert phone.evaluate(over)
    scopes.get_by_role("button", name="Trigger").tap()
    expect(region(phone, "Trigger").get_by_role("button", name="Find")).to_be_in_viewport(
        ratio=1, timeout=LONG
    )


def test_the_list_of_a_phone_has_whole_heads_and_no_hints_for_keys(phone: Page) -> None:
    phone.get_by_role("combobox", name="Screen").select_option("Runs")
    heads = phone.get_by_role("columnheader").locator(".number")
    expect(heads).to_have_text(["max ex µm", "max ey µm"], use_inner_text=True, timeout=LONG)
    assert heads.evaluate_all(WHOLE)
    box = phone.locator(".heads")
    assert box.evaluate("(e) => e.scrollHeight <= e.clientHeight + 1")
    expect(phone.get_by_text("move, Space selects")).to_be_hidden()


def test_captures_are_told_apart_in_lists(page: Page, server: Server) -> None:
    keep_runs(page, server)
    page.get_by_role("link", name="Runs", exact=True).click()
    row = page.get_by_role("row", name="capture at 5.25 s, circle")
    expect(row).to_contain_text("glitch x")
    expect(row).not_to_contain_text("–")  # noqa: RUF001
    page.get_by_role("link", name="Lab", exact=True).click()
    page.set_viewport_size({"width": 1440, "height": 420})
    page.keyboard.press("o")
    sheet = page.get_by_role("dialog", name="Overlay runs")
    rows = sheet.get_by_role("listitem")
    expect(rows).to_have_count(4)
    assert max(box["height"] for row in rows.all() if (box := row.bounding_box())) < 48
    sheet.get_by_role("textbox", name="Search runs").fill("circle")
    expect(rows.first.locator("b")).to_have_text("circle")
    expect(rows).to_have_count(4)
    sheet.evaluate("(e) => e.scrollTo(0, e.scrollHeight)")
    expect(sheet.get_by_role("textbox", name="Search runs")).to_be_in_viewport(ratio=1)
    expect(sheet.get_by_role("button", name="Close")).to_be_in_viewport(ratio=1)


def test_texts_of_the_scopes_are_whole(page: Page) -> None:
    page.set_viewport_size({"width": 1440, "height": 900})
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    button(page, "Measure")
    table = region(page, "Measurements as numbers")
    expect(table).to_contain_text("overshoot", timeout=LONG)
    assert table.evaluate("(e) => e.scrollWidth <= e.clientWidth")
    legend = page.get_by_role("toolbar", name="Traces of Following error x")
    expect(legend).to_contain_text("axis ±5 µm")
    chart = region(page, "Scopes").locator(".chart").first
    chart.click(position={"x": 300, "y": 60})
    expect(legend).to_contain_text("Δ")
    assert legend.evaluate("(e) => e.scrollWidth <= e.clientWidth")
    assert legend.locator(".value, .axis, .change").evaluate_all(WHOLE)
    names = page.locator(".strip .trace:not(.off) .name")
    assert names.evaluate_all(UNCUT)
    assert table.evaluate("(e) => e.scrollWidth <= e.clientWidth")
