"""Two people on one session: who is there, who did what, and whose STOP it was."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.e2e.actions import LONG, button, region, set_field, state
from tests.e2e.conftest import VIEW, Server


def people(page: Page) -> Locator:
    """Open the list of people."""
    page.get_by_role("button", name=re.compile("^People")).click()
    return page.get_by_role("dialog", name="People on this session")


@pytest.mark.usefixtures("fresh")
def test_two_people_see_each_other(page: Page, browser: Browser, server: Server) -> None:
    alone = page.get_by_role("button", name="People: only you on this session")
    expect(alone).to_be_visible()
    context = browser.new_context(viewport=VIEW, reduced_motion="reduce")
    other = context.new_page()
    other.goto(page.url)
    other.get_by_text("connected", exact=True).wait_for()
    expect(page.get_by_role("button", name="People: 2 on this session")).to_have_text("2")
    listed = people(page)
    expect(listed.get_by_role("list", name="People").locator("li")).to_have_text(
        [re.compile(r"^Guest 1\s+you$"), "Guest 2"]
    )

    others = people(other)
    name = others.get_by_role("textbox", name="Your name")
    expect(name).to_have_attribute("placeholder", "Guest 2")
    name.fill("Anna <b>")
    name.press("Enter")
    expect(listed).to_contain_text("Anna <b>")
    others.get_by_role("button", name="Close").click()

    other.keyboard.press("l")
    set_field(other, "B k_p x, N/mm", "619")
    events = listed.get_by_role("list", name="Events").locator("li")
    expect(events).to_have_count(1, timeout=LONG)
    expect(events.first).to_contain_text("→ 619 N/mm, by Anna <b>")

    button(page, "Play")
    state(other, "playing")
    other.get_by_role("button", name="STOP").click()
    message = page.locator(".message")
    expect(message).to_contain_text(
        re.compile(r"The session was stopped by Anna <b> at \d+(\.\d+)? m?s\."), timeout=LONG
    )
    expect(events.first).to_contain_text("stopped by Anna <b>")
    # Who did it themselves is not told.
    assert other.locator(".message", has_text="stopped by").count() == 0
    expect(people(other).get_by_role("list", name="Events")).to_contain_text("stopped by you")

    # Who moved the clock, and what was before the reset.
    button(region(other, "Changes"), "Reset")
    expect(message.filter(has_text="The session was reset by Anna <b>.")).to_be_visible()
    expect(events).to_have_text([re.compile("reset by Anna <b>")])
    listed.get_by_text("Before the reset", exact=False).click()
    earlier = listed.get_by_role("list", name="Events before the reset").locator("li")
    expect(earlier.first).to_have_text(re.compile(r"\d\d:\d\d:\d\d\s.* s\s.*stopped by Anna <b>"))
    expect(earlier.last).to_contain_text("→ 619 N/mm, by Anna <b>")
    button(region(other, "Changes"), "Play")
    button(region(other, "Changes"), "Pause")
    expect(events.first).to_contain_text("paused by Anna <b>")

    # A reload keeps the name; who leaves is no longer there.
    other.reload()
    expect(listed).to_contain_text("Anna <b>", timeout=LONG)
    context.close()
    expect(alone).to_be_visible(timeout=LONG)
