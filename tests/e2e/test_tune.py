"""Tuning as a person does it: search, map, reload, cancel, compare, apply, read off."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import (
    API,
    LONG,
    asked_for,
    button,
    command,
    press,
    region,
    serious,
    set_field,
    shipped_only,
    state,
)
from tests.e2e.conftest import Server

SLOW = 240_000  # ms; a search or a map on a machine that does much else


@pytest.fixture
def address() -> str:
    return "?screen=tune"


@pytest.fixture
def tune(page: Page, server: Server) -> Iterator[Page]:
    """The Tune screen, with searches that are soon over."""
    state(page, "paused")
    set_field(page, "starts", "2")
    set_field(page, "evaluations", "40")
    page.get_by_role("checkbox", name="window", exact=True).check()
    yield page
    for job in page.request.get(f"{server.url}{API}/jobs").json():
        page.request.delete(f"{server.url}{API}/jobs/{job['id']}")


def searched(page: Page) -> Locator:
    """Search, wait for the end, and return the lines of the candidates."""
    asked_for(page, page.get_by_role("button", name="Search gains").click)
    rows = region(page, "Candidates").locator("tbody tr")
    expect(rows).to_have_count(4, timeout=SLOW)
    return rows


def line(page: Page, name: str) -> Locator:
    return region(page, "Candidates").locator("tbody tr", has_text=name)


@pytest.mark.usefixtures("unopened")
def test_it_opens_with_shipped_results_and_the_present_gains(page: Page, server: Server) -> None:
    shipped_only(page, "tune")
    shipped_only(page, "landscape")
    page.goto(f"{server.url}/?screen=tune")
    search = region(page, "Search")
    expect(search.get_by_text("Shipped with")).to_have_count(2, timeout=LONG)
    expect(search).not_to_contain_text("other settings than the form shows")
    expect(region(page, "Landscape")).to_contain_text("stability boundary")
    expect(region(page, "Landscape")).to_contain_text("worst of nominal, matched")
    candidates = region(page, "Candidates")
    expect(candidates.locator("tbody tr")).to_have_count(6)
    # What comes with the program chooses nothing.
    expect(candidates.locator("tr.chosen")).to_contain_text("present")
    page.set_viewport_size({"width": 390, "height": 844})
    expect(search).to_be_in_viewport()


def test_search_reload_compare_apply_and_undo(tune: Page) -> None:
    page = tune
    candidates = region(page, "Candidates")
    rows = searched(page)
    expect(rows.first).to_contain_text("present")
    expect(candidates.locator("tr.chosen")).to_contain_text("start")
    search = region(page, "Search")
    set_field(page, "starts", "3")
    expect(search).to_contain_text("other settings than the form shows: starts")
    search.get_by_role("button", name="Show them").first.click()
    expect(page.get_by_role("textbox", name="starts", exact=True)).to_have_value("2")
    expect(search).not_to_contain_text("other settings than the form shows: starts")
    chosen = candidates.locator("tr.chosen").inner_text()

    page.reload()
    expect(region(page, "Candidates").locator("tr.chosen")).to_have_text(
        re.compile(re.escape(chosen.split("\t", maxsplit=1)[0].strip())), timeout=LONG
    )

    apply = region(page, "Compare and stage")
    button(page, "Compare")
    row = apply.locator("tbody tr", has_text="RMS").first
    expect(row.locator("td").last).to_contain_text("\u2212", timeout=LONG)
    apply.get_by_role("button", name="Stage in Lab").click()
    expect(apply).to_contain_text("has these gains, staged")
    apply.get_by_role("link", name="Open the Lab").click()
    changes = region(page, "Changes")
    expect(changes).to_contain_text(re.compile("B.*x"), timeout=LONG)
    page.get_by_role("link", name="Tune", exact=True).click()
    button(page, "Undo")
    expect(apply).not_to_contain_text("has these gains")


def test_progress_is_shown_and_a_search_is_cancelled(tune: Page) -> None:
    page = tune
    set_field(page, "evaluations", "2000")
    set_field(page, "starts", "8")
    set_field(page, "end of the window, s", "9")
    button(page, "Search gains")
    panel = region(page, "Search")
    expect(panel.get_by_role("progressbar")).to_be_visible()
    expect(page.get_by_role("button", name="Search gains")).to_be_disabled()
    # what goes on is drawn, and found again after a reload
    page.get_by_role("radio", name="search", exact=True).click()
    legend = region(page, "Landscape")
    expect(legend).to_contain_text("start 3", timeout=SLOW)
    page.reload()
    expect(region(page, "Search").get_by_role("progressbar")).to_be_visible(timeout=LONG)
    expect(region(page, "Landscape")).to_contain_text("start 3", timeout=LONG)
    button(page, "Cancel")
    expect(region(page, "Search")).to_contain_text("Cancelled")
    expect(page.get_by_role("button", name="Search gains")).to_be_enabled()


def test_gains_are_picked_off_the_map_and_refused_where_unstable(
    tune: Page, server: Server
) -> None:
    page = tune
    page.get_by_role("radio", name="x", exact=True).first.click()
    asked_for(page, page.get_by_role("button", name="Map the cost").click)
    expect(region(page, "Search").get_by_role("progressbar")).to_be_visible()
    landscape = region(page, "Landscape")
    expect(landscape).to_contain_text("stability boundary", timeout=SLOW)
    expect(region(page, "Search").get_by_role("progressbar")).to_have_count(0, timeout=SLOW)
    # both motors count, and the map's margins are those of the server
    expect(landscape).to_contain_text("worst of nominal, matched")
    jobs = page.request.get(f"{server.url}{API}/jobs").json()
    job = next(each["id"] for each in jobs if each["kind"] == "landscape")
    grid = page.request.get(f"{server.url}{API}/jobs/{job}").json()["result"]["axes"]["x"]
    landscape.get_by_role("button", name="Table of Axis x").click()
    row = landscape.locator("tbody tr", has_text="PM").nth(20)
    assert grid["limits"]["phase_margin"][20][0] is None  # unstable at rest on matched
    phase = grid["limits"]["phase_margin"][20][20]
    assert phase is not None
    shown = float(row.locator("td").nth(11).inner_text())  # every other column
    assert shown == pytest.approx(math.degrees(phase), rel=6e-3)
    landscape.get_by_role("button", name="Table of Axis x").click()
    margin = landscape.get_by_role("button", name="PM", exact=True)
    expect(margin).to_have_attribute("aria-pressed", "true")
    margin.click()
    expect(margin).to_have_attribute("aria-pressed", "false")
    picture = landscape.get_by_role("slider")
    box = picture.bounding_box()
    assert box is not None
    # the middle of the map is stable, its lower right corner far beyond the edge
    page.mouse.click(box["x"] + 0.45 * box["width"], box["y"] + 0.5 * box["height"])
    expect(line(page, "picked")).to_have_class(re.compile("chosen"))
    warnings = region(page, "Compare and stage").get_by_role("alert")
    expect(region(page, "Loop figures")).to_contain_text("yes", timeout=LONG)
    expect(warnings).to_have_count(0)
    page.mouse.click(box["x"] + 0.8 * box["width"], box["y"] + 0.8 * box["height"])
    expect(warnings.first).to_contain_text("The chosen gains of x are unstable", timeout=LONG)
    expect(warnings.first).to_contain_text("stability boundary")
    # by keyboard alone: the cell in the middle, its gains staged
    command(page, "axis x: cost over k_p")
    press(page, "Escape", "ArrowRight", "Enter")
    expect(warnings).to_have_count(0, timeout=LONG)
    expect(line(page, "picked")).to_have_class(re.compile("chosen"))
    command(page, "stage in lab")
    expect(region(page, "Compare and stage")).to_contain_text("has these gains, staged")
    assert serious(page) == []


def test_a_range_that_is_the_wrong_way_round_is_told_by_name(
    tune: Page, refusals: list[str]
) -> None:
    refusals.append("422")
    page = tune
    set_field(page, "least k_p, N/mm", "50000")
    button(page, "Search gains")
    alert = region(page, "Search").get_by_role("alert")
    expect(alert).to_contain_text("range of k_p")
    expect(alert).to_contain_text("must lie below")


def test_the_loop_is_drawn_as_it_is_measured_and_in_figures(tune: Page, server: Server) -> None:
    page = tune
    figures = region(page, "Loop figures")
    expect(figures).to_contain_text("crossover (39)", timeout=LONG)
    present = figures.get_by_role("radio", name="present", exact=True)
    if present.count() > 0:  # beside those of a search before
        present.click()
    sine = figures.locator("tr", has_text="error of the sine (41)")
    answer = page.request.post(
        f"{server.url}{API}/loop/accuracy", data={"scenario": "circle", "axis": "x"}
    )
    predicted = 1e6 * answer.json()["sine"]["predicted"]
    expect(sine).to_contain_text(f"{predicted:.3g}", timeout=LONG)
    loop = region(page, "Loop over frequency")
    button(page, "Measure")
    measured = re.compile("measured( of (present|chosen))?, 40.8 mm/s")
    expect(loop).to_contain_text(measured, timeout=SLOW)
    margins = re.compile(
        r"Measured in [\d.]+ s of sliding.* phase margin [\d.]+ \([\d.]+ to [\d.]+\) °"
    )
    expect(loop).to_contain_text(margins, timeout=SLOW)
    expect(loop).to_contain_text(re.compile(r"Fitted: mass [\d.]+ ± [\d.]+ kg, delay"))
    page.get_by_role("radio", name="S", exact=True).click()
    expect(loop).not_to_contain_text("Phase")
    # the numbers are there as a table too
    loop.get_by_role("button", name="Table").first.click()
    expect(loop.get_by_role("table").first).to_be_visible()
    # a measurement is not drawn beside a loop that it is not of
    page.get_by_label("gains of", exact=True).select_option("A")
    expect(loop).to_contain_text("The last measurement was of axis x of controller B", timeout=LONG)
    expect(loop).not_to_contain_text(measured)


def test_a_loop_is_measured_by_another_signal_and_force(tune: Page, refusals: list[str]) -> None:
    refusals.append("422")
    page = tune
    loop = region(page, "Loop over frequency")
    signal = loop.get_by_label("signal", exact=True)
    time = loop.get_by_label("time, s", exact=True)
    expect(signal).to_have_value("multisine")
    expect(time).to_have_value("60")
    # the slides of y are as long as slides can be
    region(page, "Landscape").get_by_role("radio", name="y", exact=True).click()
    signal.select_option("stepped-sine")
    expect(time).to_have_value("600")
    asked_for(page, loop.get_by_role("button", name="Measure", exact=True).click)
    expect(loop).to_contain_text("Measured by stepped sines in 5", timeout=SLOW)
    expect(loop).to_contain_text("In brackets 95 % intervals", timeout=SLOW)

    set_field(loop, "time, s", "60")
    button(loop, "Measure")
    expect(loop.get_by_role("alert")).to_contain_text("Is too short: 96 slides of 5.7 s")
    button(loop, "time: back to the preset")
    signal.select_option("chirp")
    set_field(loop, "force, N", "1.5")
    expect(loop).to_contain_text("with other settings than the form shows: time, signal, force")
    with page.expect_request("**/api/v1/response") as asked:
        button(loop, "Measure")
    body = asked.value.post_data_json
    assert body is not None
    assert (body["signal"], body["force"], body["axis"]) == ("chirp", 1.5, "y")
    assert "seconds" not in body
    expect(loop).to_contain_text("Measured by a chirp in", timeout=SLOW)
    button(loop, "force: back to the preset")
    expect(loop.get_by_label("force, N", exact=True)).to_have_value("")
    assert serious(page) == []


def test_a_loop_is_shaped_on_what_is_measured_and_staged(tune: Page, server: Server) -> None:
    shape = region(tune, "Shape on a measurement")
    asked_for(tune, shape.get_by_role("button", name="Shape", exact=True).click)
    expect(shape).to_contain_text("a second measurement keeps the margins", timeout=SLOW)
    expect(shape.get_by_role("row", name="PM")).to_contain_text(" to ")
    assert serious(tune) == []
    line(tune, "shaped").get_by_role("radio").check()
    loop = region(tune, "Loop over frequency")
    expect(loop.get_by_text("chosen").first).to_be_visible()
    compare = region(tune, "Compare and stage")
    expect(compare).to_contain_text("shaped")
    button(compare, "Stage in Lab")
    expect(compare).to_contain_text("has these gains", timeout=LONG)


def test_motions_on_a_machine_are_rehearsed_proposed_and_simulated(tune: Page) -> None:
    panel = region(tune, "Tune on the machine")
    set_field(panel, "motions", "2")
    panel.get_by_role("checkbox", name="measure", exact=True).uncheck()
    asked_for(tune, panel.get_by_role("button", name="Rehearse", exact=True).click)
    expect(panel).to_contain_text("2 motions are made, as many as were requested", timeout=SLOW)
    expect(panel.locator("tbody tr")).to_have_count(2)
    expect(panel.locator("tr", has_text="best")).to_have_count(1)
    expect(line(tune, "best rehearsed")).to_have_count(1)

    # the first motion is the present gains: no candidate
    propose = panel.get_by_role("button", name="Next motion", exact=True)
    asked_for(tune, propose.click)
    expect(panel).to_contain_text("It moves only if you start it", timeout=SLOW)
    expect(panel).to_contain_text("The present gains")
    expect(line(tune, "next")).to_have_count(0)
    button(panel, "Run it simulated")
    expect(panel.get_by_role("link", name="motion 1 of tuning")).to_be_visible(timeout=LONG)
    expect(panel).to_contain_text("of other runs than those that are listed")

    # from its run the next one, which is a candidate and goes to the Lab
    asked_for(tune, propose.click)
    expect(panel).to_contain_text("beyond every motion made", ignore_case=True, timeout=SLOW)
    expect(panel.locator("tr", has_text="motion 1 of tuning")).to_contain_text("best")
    assert serious(tune) == []
    line(tune, "next").get_by_role("radio").check()
    compare = region(tune, "Compare and stage")
    button(compare, "Stage in Lab")
    expect(compare).to_contain_text("has these gains", timeout=LONG)
    button(panel, "Remove motion 1")
    expect(panel).to_contain_text("None yet")


def test_nothing_serious_for_who_cannot_see_it_well(tune: Page) -> None:
    searched(tune)
    assert serious(tune) == []
