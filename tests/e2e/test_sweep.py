"""The Sweep screen: fields and their values, a job, curves and maps of what it finds."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import LONG, asked_for, button, region, serious, set_field

PATIENT = 120_000  # ms; the first batch of a new model compiles its kernel


@pytest.fixture
def address() -> str:
    return "?screen=sweep"


@pytest.fixture
def form(page: Page) -> Iterator[Locator]:
    yield region(page, "Swept fields")


def run(page: Page) -> None:
    asked_for(page, page.get_by_role("button", name="Run", exact=True).click)
    took = region(page, "Swept fields").get_by_text(re.compile("took"))
    expect(took).to_be_visible(timeout=PATIENT)


def test_a_gain_gives_curves_a_table_and_a_file_that_a_reload_keeps(
    page: Page, form: Locator
) -> None:
    set_field(page, "Number of values of field 1", "4")
    expect(form).to_contain_text("4 cases")
    run(page)
    plot = page.get_by_role("figure", name=re.compile(r"^max \|e_x\|"))
    slider = plot.get_by_role("slider")
    slider.focus()
    page.keyboard.press("Home")
    expect(slider).to_have_attribute("aria-valuetext", re.compile(r"k_p x 100 N/mm.*B 4\.\d+ µm"))
    plot.get_by_role("button", name="Table").click()
    table = plot.get_by_role("region", name=re.compile("as numbers"))
    expect(table.locator("tbody tr")).to_have_count(4)

    best = region(page, "Least values")
    expect(best.get_by_role("row", name=re.compile("^B x"))).to_contain_text("400 N/mm")
    with page.expect_download() as caught:
        best.get_by_role("button", name="CSV").click()
    rows = list(csv.DictReader(io.StringIO(caught.value.path().read_text())))
    assert [float(row["variants.B.controller.x.k_p"]) for row in rows][::3] == [1e5, 4e5]
    peaks = [float(row["B.x.max_abs_following_error"]) for row in rows]
    assert peaks == sorted(peaks, reverse=True)
    assert serious(page, within="main") == []

    page.reload()
    expect(best).to_contain_text("400 N/mm", timeout=LONG)
    expect(form).to_contain_text("4 cases")
    set_field(page, "Number of values of field 1", "5")
    expect(form).to_contain_text("other settings than the form shows: swept fields")
    button(page, "Show them")
    expect(form).to_contain_text("4 cases")


def test_two_fields_give_a_map(page: Page, form: Locator) -> None:
    button(page, "Add a field")
    form.get_by_role("button", name=re.compile("^Field 2: ")).click()
    form.get_by_role("combobox", name="Find: Field 2").fill("plant.x.mass")
    form.get_by_role("combobox", name="Find: Field 2").press("Enter")
    for number in (1, 2):
        set_field(page, f"Number of values of field {number}", "3")
    expect(form).to_contain_text("9 cases")
    run(page)
    plot = page.get_by_role("figure", name=re.compile(r"^B, max \|e_x\|"))
    slider = plot.get_by_role("slider")
    slider.focus()
    page.keyboard.press("ArrowRight")
    said = re.compile(r"k_p x 200 N/mm, plant x mass [\d.]+ kg, max \|e_x\| \d")
    expect(slider).to_have_attribute("aria-valuetext", said)
    page.get_by_role("radio", name="A", exact=True).click()
    expect(page.get_by_role("figure", name=re.compile(r"^A, max \|e_x\|"))).to_be_visible()


def test_what_is_refused_stands_at_its_field(
    page: Page, form: Locator, refusals: list[str]
) -> None:
    refusals += ["422"]
    button(page, "Add a field")
    second = form.get_by_role("group", name="Field 2", exact=True)
    set_field(page, "First value of field 2, N s/mm", "no")
    button(page, "Run")
    expect(second.get_by_role("alert")).to_have_text("“no” is not a number.")
    set_field(page, "First value of field 2, N s/mm", "-1")
    button(page, "Run")
    expect(second.get_by_role("alert")).to_contain_text("above 0", timeout=LONG)
    expect(
        form.get_by_role("group", name="Field 1", exact=True).get_by_role("alert")
    ).to_have_count(0)


def test_a_sweep_is_cancelled(page: Page, form: Locator) -> None:
    set_field(page, "Number of values of field 1", "3000")
    button(page, "Run")
    form.get_by_role("button", name="Cancel").click()
    expect(form).to_contain_text("Cancelled", timeout=LONG)
