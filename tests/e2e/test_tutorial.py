"""The steps of docs/tutorial.md, done as they are written, with the figures that it gives.

Its cursors and 3-D view are in test_scopes.py and test_scene.py; the identification, which takes
minutes, is a command that tests/project/test_documented_commands.py runs.
"""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import (
    LONG,
    asked_for,
    button,
    choose_scenario,
    metric,
    region,
    set_field,
    state,
    until,
    wait_for_clock,
)
from tests.e2e.test_trajectories import click, limits, points
from tests.e2e.test_tune import SLOW
from tests.paths import ROOT

TEXT = " ".join((ROOT / "docs" / "tutorial.md").read_text().split())
ON_THE_PATH = "and *A and B on this path* that the largest error on x is # um for A and # um for B"
MICRO = {"µm": 1.0, "mm": 1000.0}


def told(words: str) -> list[float]:
    """Return the numbers of the tutorial where it says these words, each # a number."""
    found = re.search(re.escape(words).replace(r"\#", r"(-?[\d.]*\d)"), TEXT)
    assert found is not None, words
    return [float(number) for number in found.groups()]


def shown(page: Page, name: str, column: int) -> float | None:
    """Return a metric of A or of B in um, or None while there is no exact one."""
    panel = region(page, "Metrics")
    text = panel.inner_text()
    row = panel.locator("tr", has_text=name).first
    if "exact" not in text or row.count() == 0:
        return None
    unit = row.locator("th").inner_text().removesuffix("?").split()[-1]
    number = metric(page, name, column)
    return float(number) * MICRO[unit] if re.fullmatch(r"[\d.]+", number) else None


def shows(page: Page, name: str, column: int, micrometres: float) -> None:
    """Wait until the Lab has the largest error that the text gives, of A or of B."""

    def does() -> bool:
        return shown(page, name, column) == near(micrometres)

    until(page, f"{name} {micrometres} um", does)


def near(number: float) -> object:
    # Processors round differently: K with the opposite sign makes 0.486 um of 0.471.
    return pytest.approx(number, rel=0.04)


def test_break_it_and_mend_it(page: Page) -> None:
    a, b = told("error on x is # um for A and # um for B. From a shell")
    shows(page, "max |ex|", 0, a)
    shows(page, "max |ex|", 1, b)
    button(page, "Play")
    state(page, "playing")
    wait_for_clock(page, 0.5)
    button(page, "Pause")
    page.get_by_role("radio", name="Staged").click()

    gain, *_ = told("k_p x from 200.3 to # N/mm")
    set_field(page, "B k_p x, N/mm", f"{gain:g}")
    shows(page, "max |ex|", 1, *told("falls to # um; A is unchanged"))
    shows(page, "max |ex|", 0, a)
    feedforward = page.get_by_role("checkbox", name="B feedforward", exact=True)
    feedforward.check()
    shows(page, "max |ex|", 1, *told("*feedforward* as well: # um"))
    feedforward.uncheck()
    gain, worst = told(
        "drag k_p x to # N/mm, and B chatters between its force limits with up to # um"
    )
    set_field(page, "B k_p x, N/mm", f"{gain:g}")
    shows(page, "max |ex|", 1, worst)
    region(page, "Changes").get_by_role("button", name="Discard").click()
    shows(page, "max |ex|", 1, b)

    law = page.get_by_role("combobox", name="B compensation law")
    law.select_option("K as published")
    # Chaotic: it is its order of magnitude that the text gives.
    assert "error on x grows to a millimetre or so" in TEXT
    until(page, "B far beyond A", lambda: (shown(page, "max |ex|", 1) or 0.0) > 300.0)
    law.select_option("K, sign reversed")
    shows(page, "max |ex|", 1, *told("the error is # um, less"))

    choose_scenario(page, "circle-matched")
    shows(page, "max |ex|", 1, *told("B's error is # um. Two remedies"))
    law.select_option("K, sign reversed")
    feedforward.check()
    page.get_by_role("checkbox", name="B DOB", exact=True).check()
    shows(page, "max |ex|", 1, *told("what the model lacks, # um"))


def test_draw_a_path_and_tune_for_it(page: Page) -> None:
    page.get_by_role("link", name="Trajectories").click()
    page.get_by_label("start from").select_option("nothing")
    expect(limits(page)).to_contain_text("Set 2 points or more", timeout=LONG)
    for x, y in ((0.041, 0.0), (0.0, 0.052), (-0.039, 0.001), (0.0, -0.05)):
        click(page, x, y)
    page.get_by_role("checkbox", name="closed").check()
    expect(points(page)).to_have_count(8)
    for i, value in enumerate(told("type #, #; #, #; #, # and #, # mm into *Points*")):
        points(page).nth(i).fill(f"{value:g}")
        points(page).nth(i).press("Enter")
    verdict = limits(page).get_by_role("status")
    expect(verdict).to_have_text("feasible", timeout=LONG)
    errors = region(page, "Errors of A and B")
    row = errors.locator("tbody tr").first

    def has(column: int, um: float) -> None:
        what = f"{um} um on the path"
        until(
            page,
            what,
            lambda: (
                "exact" in errors.inner_text()
                and float(row.locator("td").nth(column).inner_text()) == near(um)
            ),
        )

    for column, um in enumerate(told(ON_THE_PATH)):
        has(column, um)

    speed, acceleration = told("*max speed* # mm/s and *max accel.* # m/s^2. The proposal")
    set_field(page, "max speed, mm/s", f"{speed:g}")
    set_field(page, "max acceleration, m/s²", f"{acceleration:g}")
    cost = page.get_by_role("group", name="Cost of the retiming")
    button(page, "Apply")
    needed, there = told("where y needs # N of thrust and has # N")
    worst = limits(page).get_by_role("listitem").first
    expect(worst).to_contain_text(f"y needs too much thrust: {needed:g} N", timeout=LONG)
    expect(worst).to_contain_text(f"±{there:.1f} N")
    button(page, "Slow down until feasible")
    (factor,) = told("proposes to take # times as long")
    expect(cost).to_contain_text(f"Every move takes {factor:g}", timeout=LONG)
    expect(cost).to_contain_text("no longer than needed")
    button(page, "Apply")
    expect(verdict).to_have_text("feasible", timeout=LONG)
    acceleration, um = told(
        "set *max accel.* to # m/s^2 and *Apply* that too: B's error on x is # um"
    )
    set_field(page, "max acceleration, m/s²", f"{acceleration:g}")
    button(page, "Apply")
    has(1, um)
    errors.get_by_role("button", name="Stage in Lab").click()

    page.get_by_role("link", name="Tune", exact=True).click()
    set_field(page, "starts", f"{told('set *starts* to #')[0]:g}")
    asked_for(page, page.get_by_role("button", name="Search gains").click)
    found = region(page, "Candidates").locator("tbody tr")
    expect(found.filter(has_text="start")).to_have_count(2, timeout=SLOW)
    button(page, "Compare")
    compared = region(page, "Compare and stage")
    x, y = told("the largest error on x falls to # um, that on y to # um")
    for name, um in (("max |ex|", x), ("max |ey|", y)):
        cell = compared.locator("tr", has_text=name).locator("td").nth(1)
        expect(cell).not_to_be_empty(timeout=LONG)
        assert float(cell.inner_text()) == pytest.approx(um, rel=0.05), name
    compared.get_by_role("button", name="Stage in Lab").click()
    compared.get_by_role("link", name="Open the Lab").click()
    shows(page, "max |ex|", 1, x)
