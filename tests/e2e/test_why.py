"""Why?: the causes of the peak that the headline names, and the change that mends it."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, choose_scenario, region


def test_the_causes_are_shown_and_the_change_is_staged(page: Page) -> None:
    headline = region(page, "Result").get_by_test_id("headline")

    def changed(before: str) -> str:
        """Wait until another result is exact; return its headline."""
        expect(headline).not_to_have_text(before, timeout=LONG)
        expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
        return headline.inner_text()

    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    first = headline.inner_text()
    choose_scenario(page, "circle-matched")
    peak = re.match(r"B ([\d.]+) µm", matched := changed(first))
    assert peak
    region(page, "Result").get_by_role("button", name="Why?").click()
    sheet = page.get_by_role("dialog", name="Why?")
    expect(sheet).to_contain_text(f"Why does B err by {peak[1]} µm on y", timeout=LONG)
    rows = sheet.locator("tbody tr")
    shares = [
        float(text.replace("\u2212", "-").removesuffix("%"))
        for text in page.locator("dialog[open] tbody tr td:last-child").all_inner_texts()
    ]
    assert shares == sorted(shares, reverse=True)
    expect(rows.first).to_contain_text("Stribeck effect")
    sheet.get_by_role("button", name="Stage this change").click()
    expect(sheet).to_be_hidden()
    expect(region(page, "Result")).to_contain_text("staged change", timeout=LONG)
    after = re.match(r"B ([\d.]+) µm", changed(matched))
    assert after
    assert float(after[1]) < float(peak[1])
