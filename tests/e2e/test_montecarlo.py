"""The Monte Carlo study of the Lab screen, in a real browser."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, button, region, serious, set_field

PATIENT = 120_000  # ms; the first study of a new model compiles its kernel


def test_bands_spec_and_stale_draft_survive_a_reload(page: Page) -> None:
    page.keyboard.press("w")
    panel = region(page, "Monte Carlo")
    panel.locator("summary").first.click()
    panel.get_by_role("combobox", name="Number of plants").select_option("100")
    button(page, "Run on")
    expect(panel).to_contain_text("max |ex|", timeout=PATIENT)
    expect(panel.get_by_role("columnheader", name="95 %", exact=True)).to_be_in_viewport()
    scope = page.get_by_role("region", name=re.compile("^Following error x"))
    expect(scope).to_contain_text("min–max of 100 plants")  # noqa: RUF001
    medians = [
        float(
            panel.locator("tr", has_text=f"{name} max |ex|").first.locator("td").nth(1).inner_text()
        )
        for name in "AB"
    ]
    assert medians[0] > 1.5 * medians[1]

    field = "Largest following error allowed on x, µm"
    set_field(page, field, "12")
    expect(panel).to_contain_text(re.compile(r"B meets it on \d+\.\d %.*95 % interval"))
    set_field(page, field, "1000")
    expect(panel).to_contain_text("B meets it on 100 %")

    panel.locator("summary", has_text="Bands as numbers").click()
    expect(panel.get_by_role("region", name="Bands as numbers").locator("tbody tr")).to_have_count(
        12
    )

    set_field(page, "B k_p x, N/mm", "312")
    expect(panel).to_contain_text("Of another scenario or draft", timeout=LONG)
    expect(scope).to_contain_text("stale")
    assert serious(page, within='[aria-label="Monte Carlo"]') == []

    page.reload()
    expect(panel).to_contain_text("B meets it on 100 %", timeout=LONG)
    expect(panel).to_contain_text("Of another scenario or draft", timeout=LONG)
    button(page, "Discard")
    expect(panel).not_to_contain_text("Of another scenario or draft", timeout=LONG)


def test_a_study_is_cancelled(page: Page) -> None:
    page.keyboard.press("w")
    panel = region(page, "Monte Carlo")
    panel.locator("summary").first.click()
    panel.get_by_role("combobox", name="Number of plants").select_option("1000")
    button(page, "Run on")
    panel.get_by_role("button", name="Cancel").click()
    expect(panel).to_contain_text("Cancelled", timeout=LONG)
