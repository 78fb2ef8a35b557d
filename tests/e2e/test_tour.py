"""The tour: five steps that play on the page, are left at any time and leave nothing staged."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import LONG, button, command, press, region, serious
from tests.e2e.conftest import Server

LAW = "B compensation law"


@pytest.fixture
def card(page: Page) -> Locator:
    """The first step."""
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    command(page, "tour")
    card = page.get_by_role("complementary", name="Tour")
    expect(card).to_contain_text("1 of 5")
    return card


def step(card: Locator, title: str) -> None:
    expect(card.get_by_role("heading")).to_have_text(title)


def test_the_tour_plays_and_takes_back_what_it_staged(
    page: Page, card: Locator, server: Server
) -> None:
    headline = region(page, "Result").get_by_test_id("headline")
    before, outlined = headline.inner_text(), page.locator("[data-toured]")
    expect(outlined).to_have_count(3)
    assert serious(page, ".tour") == []
    button(card, "Show me")
    expect(page.locator(".message")).to_contain_text("Peak of", timeout=LONG)
    button(card, "Next")
    step(card, "Why?")
    button(card, "Show me")
    why = page.get_by_role("dialog", name="Why?")
    expect(why).to_be_visible(timeout=LONG)
    button(card, "Next")
    step(card, "Break it")
    expect(why).to_be_hidden()
    button(card, "Show me")
    expect(page.get_by_role("combobox", name=LAW)).to_have_value("published-k")
    expect(headline).not_to_have_text(before, timeout=LONG)
    button(card, "Next")
    step(card, "Draw a path")
    expect(outlined).to_have_text("Trajectories")
    button(card, "Show me")
    expect(region(page, "Path")).to_contain_text("5 points", timeout=LONG)
    expect(outlined).to_have_count(2)
    button(card, "Next")
    button(card, "Show me")
    expect(region(page, "State")).to_contain_text("No drive configured")
    button(card, "Done")
    expect(card).to_be_hidden()
    expect(outlined).to_have_count(0)
    page.get_by_role("link", name="Lab", exact=True).click()
    expect(headline).to_have_text(before, timeout=LONG)
    expect(page.get_by_role("combobox", name=LAW)).to_have_value("lugre-observer")


def test_the_tour_by_keyboard_and_stop_stays_stop(
    page: Page, card: Locator, server: Server
) -> None:
    expect(card).to_be_focused()
    press(page, "ArrowRight", "ArrowRight")
    step(card, "Break it")
    press(page, "ArrowLeft")
    step(card, "Why?")
    press(page, "ArrowRight")
    button(card, "Show me")
    expect(page.get_by_role("combobox", name=LAW)).to_have_value("published-k")
    stop = page.get_by_role("button", name="STOP")
    box, over = stop.bounding_box(), card.bounding_box()
    assert box and over and over["y"] > box["y"] + box["height"]
    button(card, "Leave")
    expect(card).to_be_hidden()
    expect(page.get_by_role("combobox", name=LAW)).to_have_value("lugre-observer")
    # Esc is not taken: it stops what plays.
    command(page, "tour")
    page.get_by_role("button", name="Play", exact=True).click()
    expect(page.locator(".bar").get_by_role("status")).to_have_text("playing", timeout=LONG)
    card.focus()
    press(page, "Escape")
    expect(page.locator(".bar").get_by_role("status")).to_have_text(
        re.compile("stopping|stopped"), timeout=LONG
    )
    expect(card).to_be_visible()


def test_the_tour_is_offered_once(page: Page) -> None:
    offer = page.get_by_role("button", name="Take the tour, five steps")
    expect(offer).to_be_visible()
    button(page, "No tour")
    expect(offer).to_be_hidden()
    page.reload()
    page.get_by_text("connected", exact=True).wait_for()
    expect(offer).to_be_hidden()
    press(page, "?")
    page.get_by_role("dialog").get_by_role("button", name="Take the tour").click()
    expect(page.get_by_role("complementary", name="Tour")).to_contain_text("1 of 5")
