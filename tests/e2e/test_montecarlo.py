"""The Monte Carlo study of the Lab screen, in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import API, LONG, button, command, region, serious, set_field, until
from tests.e2e.conftest import Server

PATIENT = 120_000  # ms; the first study of a new model compiles its kernel


def _decides_and_opens(page: Page, server: Server, panel: Locator) -> None:
    """What decides is told as the server computed it; the worst motor shows its row in the Lab."""
    jobs = page.request.get(f"{server.url}{API}/jobs").json()
    job = next(each["id"] for each in jobs if each["kind"] == "monte-carlo")
    study = page.request.get(f"{server.url}{API}/jobs/{job}").json()["result"]
    names = [(each["path"], each["of"]) for each in study["parameters"]["x"]]
    rho = study["variants"]["A"]["axes"]["x"]["correlations"]["max_abs_following_error"]
    decides = panel.get_by_role("table", name="Rank correlations").locator("tbody tr")
    stiction = decides.filter(has_text="stiction Fs").filter(has_not_text="deviation")
    told = stiction.locator("td").first.inner_text().replace("\u2212", "-")
    assert float(told) == pytest.approx(rho[names.index(("friction.F_s", "value"))], abs=6e-3)
    worst = panel.get_by_role("table", name="Worst plants").locator("tr", has_text="B x")
    largest = worst.locator("td").first.inner_text()
    row = next(one for one in study["worst"] if (one["variant"], one["axis"]) == ("B", "x"))
    assert float(largest) == pytest.approx(1e6 * row["value"], rel=6e-3)
    command(page, f"plant {row['case']}, worst of b")
    expect(panel).to_contain_text(f"plant {row['case']} of this study, staged")
    shown = region(page, "Metrics").locator("tr", has_text="max |ex|").locator("td").nth(1)
    expect(shown).to_have_text(largest, timeout=LONG)
    command(page, "back to its own motor")
    expect(panel).not_to_contain_text("of this study, staged")


def test_bands_spec_and_stale_draft_survive_a_reload(page: Page, server: Server) -> None:
    page.keyboard.press("w")
    panel = region(page, "Monte Carlo")
    panel.locator("summary").first.click()
    expect(panel.get_by_role("combobox", name="Number of plants")).to_be_visible()
    command(page, "number of plants: 100")
    command(page, "run on monte carlo")
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

    _decides_and_opens(page, server, panel)
    expect(scope).to_contain_text("of 100 plants")

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
    expect(scope).not_to_contain_text("of 100 plants")
    assert serious(page, within='[aria-label="Monte Carlo"]') == []

    page.reload()
    expect(panel).to_contain_text("B meets it on 100 %", timeout=LONG)
    expect(panel).to_contain_text("Of another scenario or draft", timeout=LONG)
    button(page, "Discard")
    expect(panel).not_to_contain_text("Of another scenario or draft", timeout=LONG)
    expect(scope).to_contain_text("of 100 plants")

    # A setting that the result was not asked for with is named, and can be had back.
    plants = panel.get_by_role("combobox", name="Number of plants")
    plants.select_option("1000")
    expect(panel).to_contain_text("other settings than the form shows: number of plants")
    button(page, "Show them")
    expect(plants).to_have_value("100")


def test_a_fresh_browser_takes_up_no_study_of_others(page: Page, server: Server) -> None:
    session = page.evaluate("new URL(location.href).searchParams.get('session')")
    scenario = page.request.get(f"{server.url}{API}/sessions/{session}").json()["scenario"]
    asked = {"scenario": scenario, "set": {}, "cases": 20}
    job = page.request.post(f"{server.url}{API}/montecarlo", data=asked).json()["id"]
    url = f"{server.url}{API}/jobs/{job}"
    until(
        page, "the study is done", lambda: page.request.get(url).json()["state"] == "done", PATIENT
    )
    page.reload()
    page.get_by_text("connected", exact=True).wait_for()
    page.keyboard.press("w")
    panel = region(page, "Monte Carlo")
    panel.locator("summary").first.click()
    earlier = panel.get_by_role("combobox", name="Monte Carlo: earlier results")
    expect(earlier).to_be_visible(timeout=LONG)
    expect(panel).to_contain_text("How sure are these numbers?")
    scope = page.get_by_role("region", name=re.compile("^Following error x"))
    expect(scope).not_to_contain_text("of 20 plants")

    # Chosen by the user it is shown, with what it was asked for, and found again.
    earlier.select_option(job)
    expect(scope).to_contain_text("of 20 plants", timeout=LONG)
    expect(panel.get_by_role("combobox", name="Number of plants")).to_have_value("20")
    page.reload()
    expect(scope).to_contain_text("of 20 plants", timeout=LONG)


def test_a_study_is_cancelled(page: Page) -> None:
    page.keyboard.press("w")
    panel = region(page, "Monte Carlo")
    panel.locator("summary").first.click()
    panel.get_by_role("combobox", name="Number of plants").select_option("1000")
    button(page, "Run on")
    panel.get_by_role("button", name="Cancel").click()
    expect(panel).to_contain_text("Cancelled", timeout=LONG)
