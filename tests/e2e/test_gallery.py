"""The gallery of examples: a picture and a sentence each, found by typing."""

from __future__ import annotations

from playwright.sync_api import Page, expect

from motionlab.config.named_configs import names
from tests.e2e.actions import LONG, press, region, scenario_control, serious, session
from tests.e2e.conftest import Server


def test_an_example_is_chosen_by_its_picture(page: Page, server: Server) -> None:
    control = scenario_control(page)
    expect(control).to_have_text("The paper's circle, without and with friction compensation")
    control.click()
    gallery = page.get_by_role("dialog", name="Examples")
    cards = gallery.locator("[data-scenario]")
    expect(cards).to_have_count(len(names("scenarios")))
    for card in cards.all():  # reference, A and B
        expect(card.locator("polyline")).to_have_count(3)
    expect(gallery.locator("[aria-current=true]")).to_contain_text("The paper's circle")
    assert serious(page, "dialog") == []
    gallery.get_by_role("button", name="Pentagram of 57.06 mm").click()
    expect(gallery).to_be_hidden()
    expect(control).to_have_text("Table 1: pentagram of 57.06 mm")
    expect(region(page, "Trajectory")).to_contain_text("star", timeout=LONG)
    assert session(page, server)["scenario"]["name"] == "pentagram"


def test_an_example_is_found_by_keyboard(page: Page, server: Server) -> None:
    scenario_control(page).focus()
    press(page, "Enter")
    gallery = page.get_by_role("dialog", name="Examples")
    search = gallery.get_by_role("searchbox", name="Find an example")
    expect(search).to_be_focused()
    page.keyboard.type("0.5 µm")
    cards = gallery.locator("[data-scenario]")
    expect(cards).to_have_count(2)
    press(page, "ArrowDown")
    expect(cards.first).to_be_focused()
    press(page, "ArrowRight")
    expect(cards.nth(1)).to_be_focused()
    press(page, "Escape")
    expect(gallery).to_be_hidden()
    assert session(page, server)["scenario"]["name"] == "circle"
    press(page, "Enter")
    expect(search).to_have_value("")
    page.keyboard.type("nothing of the kind")
    expect(gallery).to_contain_text("No example has these words.")
    page.keyboard.press("Control+A")
    page.keyboard.type("rhombus")
    press(page, "Enter")
    expect(scenario_control(page)).to_contain_text("rhombus", timeout=LONG)
    assert session(page, server)["scenario"]["name"] == "rhombus"
