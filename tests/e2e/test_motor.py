"""What a person does on the Motor screen, in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import LONG, button, region, serious


@pytest.fixture
def address() -> str:
    return "?screen=motor"


@pytest.fixture
def motor(page: Page) -> Page:
    """The Motor screen at its first tab."""
    expect(result(page, "mover width")).to_contain_text("39.6 mm", timeout=LONG)
    return page


def result(page: Page, name: str) -> Locator:
    return region(page, "Results").get_by_role("row", name=name)


def field(page: Page, label: str) -> Locator:
    return page.get_by_role("textbox", name=label, exact=True)


def tab(page: Page, name: str) -> None:
    page.get_by_role("radio", name=name, exact=True).click()


def test_results_follow_the_numbers_while_they_are_typed(motor: Page) -> None:
    field(motor, "teeth per limb").fill("4")
    expect(result(motor, "mover width")).to_contain_text("54 mm")
    motor.reload()
    expect(result(motor, "mover width")).to_contain_text("54 mm", timeout=LONG)
    button(motor, "Reset 1")
    expect(result(motor, "mover width")).to_contain_text("39.6 mm")
    field(motor, "thrust, N").press("ArrowUp")
    expect(field(motor, "thrust, N")).to_have_value("32.32")


def test_printed_stands_beside_corrected(motor: Page) -> None:
    row = region(motor, "Readings").get_by_role("row", name=re.compile(r"^\(3\) mover width"))
    expect(row).to_contain_text("18")
    expect(row).to_contain_text("≠")
    expect(row).to_contain_text("39.6")


def test_dimensions_that_were_found_are_rated(motor: Page) -> None:
    field(motor, "thrust, N").fill("50")
    expect(result(motor, "stack length")).to_contain_text("66.09 mm")
    button(motor, "Rate them →")
    expect(result(motor, "thrust capacity")).to_contain_text("50 N")
    expect(field(motor, "stack length, mm")).to_have_value("66.0934")
    motor.reload()
    expect(result(motor, "thrust capacity")).to_contain_text("50 N", timeout=LONG)


def test_bad_geometry_is_named_at_its_field(motor: Page, refusals: list[str]) -> None:
    refusals.append("422")
    tooth = field(motor, "tooth, mm")
    tooth.fill("8")
    problem = region(motor, "Numbers").get_by_role("alert")
    expect(problem).to_contain_text("leaves no slot beside a tooth p = 0.008 m")
    expect(tooth).to_have_attribute("aria-invalid", "true")
    motor.get_by_role("button", name="tooth: back to the preset").click()
    gap = field(motor, "air gap, mm")
    gap.fill("0")
    expect(problem).to_have_text("Is out of range: 0 mm. Allowed: 0.001 to 10 mm.")
    gap.fill("0.3")
    expect(problem).to_have_count(0)


def test_the_previous_design_says_what_is_not_known_of_it(motor: Page) -> None:
    tab(motor, "previous")
    expect(field(motor, "pole pitch, mm")).to_have_value("9")
    tab(motor, "Dimensions → limits")
    button(motor, "Take those of the paper's example")
    expect(result(motor, "acceleration")).to_contain_text("7.305 m/s²")


def test_the_preview_follows_the_geometry(motor: Page, refusals: list[str]) -> None:
    refusals.append("422")
    tab(motor, "Force maps")
    tab(motor, "preview")
    peaks = region(motor, "Peaks")
    ours = peaks.get_by_role("row", name="this preview")
    expect(ours).to_contain_text(re.compile(r"4[3-7]\.\d"), timeout=LONG)
    measured = peaks.get_by_role("row", name="paper, measured")
    expect(measured).to_contain_text(re.compile(r"38\.4 .*not comparable.*427 .*not comparable"))
    expect(peaks).to_contain_text("A preview is not held against the paper.")
    field(motor, "air gap, mm").fill("0.5")
    expect(peaks).to_contain_text("The paper prints no peaks for this geometry.", timeout=LONG)
    expect(ours).to_contain_text(re.compile(r"[23]\d\.\d"))
    field(motor, "tooth, mm").fill("7.2")
    expect(region(motor, "Geometry").get_by_role("alert")).to_contain_text("eeth overlap")
    expect(motor.get_by_role("button", name="Compute")).to_be_disabled()


def test_a_preview_that_was_refused_is_asked_for_again(motor: Page, refusals: list[str]) -> None:
    refusals.append("429")
    tab(motor, "Force maps")
    tab(motor, "preview")
    motor.route("**/maps/preview*", lambda route: route.fulfill(status=429, json={"title": "Busy"}))
    motor.reload()
    again = region(motor, "Force map").get_by_role("button", name="Try again")
    expect(again).to_be_visible()
    motor.unroute("**/maps/preview*")
    again.click()
    peaks = region(motor, "Peaks")
    expect(peaks.get_by_role("row", name="this preview")).to_be_visible(timeout=LONG)


def test_the_map_of_a_known_geometry_is_shown_and_not_computed(motor: Page) -> None:
    tab(motor, "Force maps")
    shown = region(motor, "Force map")
    expect(shown).to_contain_text("new-design: finite elements", timeout=LONG)
    gap = field(motor, "air gap, mm")
    gap.fill("0.31")
    expect(shown).to_contain_text("Preview", timeout=LONG)
    gap.fill("0.3")
    expect(shown).to_contain_text("new-design: finite elements", timeout=LONG)
    button(motor, "Compute")
    expect(motor).to_have_url(re.compile("map=new-design"))
    expect(region(motor, "Stored maps")).not_to_contain_text("f00b9ee959812f3c")


def test_a_map_is_computed_kept_opened_and_deleted(motor: Page) -> None:
    tab(motor, "Force maps")
    tab(motor, "preview")
    field(motor, "air gap, mm").fill("0.4")
    button(motor, "Compute")
    stored = region(motor, "Stored maps").get_by_role("article").filter(has_text="g 400 µm")
    expect(stored).to_have_count(1, timeout=LONG)
    # The address names it: a reload, or another who is sent it, sees the same map.
    expect(motor).to_have_url(re.compile(r"map=[0-9a-f]{16}"))
    motor.reload()
    row = region(motor, "Peaks").get_by_role("row", name=re.compile("this preview"))
    expect(row).to_be_visible(timeout=LONG)
    expect(field(motor, "air gap, mm")).to_have_value("0.4")
    stored.get_by_role("button", name=re.compile("Delete")).click()
    expect(stored).to_have_count(0)


def test_a_map_that_runs_is_found_after_a_reload_and_cancelled(motor: Page) -> None:
    tab(motor, "Force maps")
    field(motor, "stack length, mm").fill("43")
    button(motor, "Compute")
    progress = motor.get_by_role("progressbar", name="Force map, share done")
    expect(progress).to_be_visible(timeout=LONG)
    motor.reload()
    expect(progress).to_be_visible(timeout=LONG)
    button(motor, "Cancel")
    expect(region(motor, "Geometry")).to_contain_text("Cancelled after", timeout=LONG)


def test_the_field_is_drawn_where_one_looks(motor: Page) -> None:
    tab(motor, "Force maps")
    tab(motor, "Surface")
    surface = motor.get_by_role("slider", name=re.compile("^Thrust: thrust over"))
    surface.focus()
    motor.keyboard.press("ArrowUp")
    motor.keyboard.press("Enter")
    section = region(motor, "Force map")
    expect(section).to_contain_text("flux linkage", timeout=LONG)
    expect(field(motor, "current, A")).to_have_value("5")
    button(motor, "Table of Flux density")
    expect(motor.get_by_role("region", name="Flux density as numbers")).to_contain_text("|B|")


def test_a_stored_map_goes_into_the_what_if(motor: Page) -> None:
    tab(motor, "Force maps")
    motor.get_by_role("button", name=re.compile("^Open new-design")).click()
    use = motor.get_by_role("group", name="Stage in the Lab")
    use.get_by_role("button", name="plant").click()
    expect(use.get_by_role("button", name="plant ✓")).to_be_disabled()
    use.page.get_by_role("link", name="Lab").last.click()
    changes = region(motor, "Changes")
    expect(changes).to_contain_text("plant x force map")
    expect(changes).to_contain_text("new-design")


def compared(page: Page, name: str) -> Locator:
    return region(page, "Laws compared").get_by_role("row", name=name)


def test_currents_and_loss_change_with_the_law(motor: Page, refusals: list[str]) -> None:
    refusals.append("422")
    tab(motor, "Force sharing")
    least = motor.get_by_role("figure", name="least norm", exact=True)
    expect(least).to_be_visible(timeout=LONG)
    motor.get_by_role("checkbox", name="cubic").check()
    expect(motor.get_by_role("figure", name="cubic", exact=True)).to_be_visible(timeout=LONG)
    expect(compared(motor, "copper loss, rel.").get_by_role("cell")).to_have_count(4)
    button(motor, "Table of cubic")
    currents = motor.get_by_role("region", name="cubic as numbers")
    expect(currents.get_by_role("cell").first).to_be_visible()
    before = currents.inner_text()
    field(motor, "force, N").fill("10")
    expect(compared(motor, "mean force")).to_contain_text("10", timeout=LONG)
    expect(currents).not_to_have_text(before, use_inner_text=True)
    field(motor, "current limit, A").fill("11")
    expect(region(motor, "Command and laws").get_by_role("alert")).to_contain_text("≤ 10 A")


def test_the_previous_design_stands_beside_the_new_one(motor: Page) -> None:
    tab(motor, "Force sharing")
    button(motor, "New against previous design")
    tab(motor, "Analytic fit")
    expect(region(motor, "Command and laws")).to_contain_text(
        re.compile(r"Fit to previous-design: \d\.\d\d N rms off"), timeout=LONG
    )
    expect(compared(motor, "ripple p-p").get_by_role("cell")).to_have_count(5)
    motor.reload()
    figure = motor.get_by_role("figure", name="force per ampere, previous-design")
    expect(figure).to_be_visible(timeout=LONG)


def test_axe_finds_nothing_serious(motor: Page) -> None:
    first_answers = {
        "Sizing": result(motor, "mover width"),
        "Force maps": region(motor, "Peaks").get_by_role("row").nth(1),
        "Force sharing": motor.get_by_role("figure", name="least norm", exact=True),
    }
    for name, answer in first_answers.items():
        tab(motor, name)
        expect(answer).to_be_visible(timeout=LONG)
        assert serious(motor) == [], name
