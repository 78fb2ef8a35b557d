"""The command palette: screens, controls and channels are found by typing."""

from __future__ import annotations

import re

from playwright.sync_api import Page, Route, expect

from tests.e2e.actions import LONG, region, serious, until


def find(page: Page, words: str) -> None:
    page.keyboard.press("Control+k")
    search = page.get_by_role("combobox", name="Find a screen, control or channel")
    expect(search).to_be_focused()
    search.fill(words)


def test_screens_fields_buttons_keys_and_channels_by_typing(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.keyboard.press("Control+k")
    page.keyboard.type("b.y.thrust")  # while it is being loaded
    search = page.get_by_role("combobox", name="Find a screen, control or channel")
    expect(search).to_have_value("b.y.thrust")
    page.keyboard.press("Enter")
    expect(page.get_by_role("region", name="Thrust y, what-if")).to_be_visible()
    find(page, "radius")
    page.keyboard.press("Enter")
    expect(page.get_by_role("textbox", name=re.compile("radius", re.IGNORECASE))).to_be_focused()
    # From a field, too; what is typed there stays.
    find(page, "all readings as a table")
    page.keyboard.press("Enter")
    expect(region(page, "Measurements as numbers")).to_be_visible()
    find(page, "tune screen")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile("screen=tune"))
    find(page, "no such thing")
    expect(page.get_by_role("listbox", name="Commands found")).to_contain_text("Nothing")
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog", name="Commands")).to_be_hidden()
    expect(page.get_by_text("STOPPED")).to_have_count(0)
    for words in ("", "no such thing"):
        find(page, words)
        assert serious(page, within=".palette") == []


def test_what_is_typed_while_it_loads_are_words(page: Page) -> None:
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route)

    page.route("**/Palette-*.js", hold)
    with page.expect_request("**/Palette-*.js"):
        page.keyboard.press("Control+k")
    page.keyboard.type("tune")
    expect(page.get_by_role("dialog", name="Commands")).to_be_hidden()
    until(page, "it is being loaded", lambda: bool(held))
    held[0].continue_()
    expect(page.get_by_role("combobox", name="Find a screen")).to_have_value("tune")
    expect(page.get_by_role("button", name="Dark theme")).to_be_visible()


def first_found(page: Page, words: str) -> None:
    find(page, words)
    page.keyboard.press("Enter")


def test_views_and_what_screens_have_by_their_own_words(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("button", name="Find", exact=True).click()
    page.get_by_role("combobox", name="Find a screen, control or channel").fill("fft")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(r"screen=views.*pane=spectrum\+staged"))
    view = region(page, "View")
    expect(view.get_by_role("slider", name=re.compile("^Spectrum of following"))).to_be_visible()
    first_found(page, "lissajous")
    expect(page).to_have_url(re.compile(r"pane=xy\+staged"))
    expect(view.get_by_role("slider", name=re.compile("^Friction x over velocity"))).to_be_visible()
    page.go_back()
    expect(page).to_have_url(re.compile(r"pane=spectrum\+staged"))
    expect(view.get_by_role("radio", name="Spectrum", exact=True)).to_be_checked()
    first_found(page, "phase margin")
    expect(region(page, "Loop figures")).to_be_focused()
    first_found(page, "bode")
    expect(region(page, "Loop over frequency")).to_be_focused()
