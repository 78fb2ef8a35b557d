"""The Lab says its result in one line; margins beside gains; what Play runs; what terms mean."""

from __future__ import annotations

import math
import re

import httpx
from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, controller, region, set_field
from tests.e2e.conftest import Server


def _settled(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)


def test_the_headline_is_the_metric_that_it_names(page: Page) -> None:
    _settled(page)
    result = region(page, "Result")
    text = result.get_by_test_id("headline").inner_text()
    found = re.fullmatch(r"B ([\d.]+) µm on ([xy]), (\d+) % less than A", text)
    assert found, text
    axis = re.search(r"max \|e(.)\|", result.inner_text().replace("\n", ""))
    assert axis
    assert axis[1] == found[2]
    row = region(page, "Metrics").locator("tr", has_text=f"max |e{axis[1]}|")
    cells = row.locator("td").all_inner_texts()
    assert cells[1] == found[1]
    assert round(100 * (1 - float(cells[1]) / float(cells[0]))) == int(found[3])
    expect(result).to_contain_text(
        "A without friction compensation, B with friction compensation (LuGre observer, K = 0)"
    )


def test_margins_beside_gains_are_those_of_the_loop(page: Page, server: Server) -> None:
    _settled(page)
    set_field(page, "B k_p x, N/mm", "300")
    asked = {"scenario": "circle", "set": {"variants.B.controller.x.k_p": 3e5}}
    loops = httpx.post(f"{server.url}/api/v1/loop", json=asked, timeout=60.0).json()["variants"]
    folded = page.get_by_role("button", name="Controller A")
    expect(folded).to_contain_text("21.2°", timeout=LONG)
    controller(page, "A")
    for variant, axis in (("A", "y"), ("B", "x")):
        worst = loops[variant]["axes"][axis]["worst"]
        if variant == "B":
            controller(page, "B")
        line = page.get_by_role("group", name=f"{variant} {axis} margins")
        expect(line).to_contain_text(f"{worst['Ms']['value']:.2f}", timeout=LONG)
        expect(line).to_contain_text(f"{math.degrees(worst['phase_margin']['value']):.1f}°")
    # 21.2 degrees, where Tune wants 30.
    controller(page, "A")
    below = page.get_by_role("group", name="A y margins")
    expect(below).to_contain_text("beyond its limit, at least 30.0°")
    expect(page.get_by_role("group", name="A x margins")).not_to_contain_text("beyond")


def test_play_says_what_it_runs_and_the_headline_what_it_shows(page: Page) -> None:
    _settled(page)
    expect(region(page, "Result")).not_to_contain_text("preview")
    set_field(page, "B k_p x, N/mm", "619.5")
    set_field(page, "B k_p y, N/mm", "1500")
    expect(region(page, "Result")).to_contain_text("with 2 staged changes")
    changes = region(page, "Changes")
    expect(changes.locator(".chip.staged")).to_have_count(2)
    expect(changes.get_by_role("button", name="Play as it was")).to_be_visible()
    changes.get_by_role("button", name="Play with 2 changes").click()
    expect(changes.locator(".chip:not(.staged)")).to_have_count(2, timeout=LONG)
    expect(region(page, "Result")).to_contain_text("in the motor")


def test_a_term_explains_itself_on_focus_and_on_hover(page: Page) -> None:
    _settled(page)
    line = page.get_by_role("group", name="B x margins")
    term = line.get_by_text("PM", exact=True)
    tip = page.get_by_role("tooltip").filter(has_text="Phase margin")
    page.keyboard.press("Tab")  # the focus is one of the keyboard
    term.focus()
    expect(tip).to_be_visible()
    expect(tip).to_contain_text("lag")
    assert term.get_attribute("aria-describedby") == tip.get_attribute("id")
    region(page, "Changes").get_by_role("button", name="Undo").focus()
    expect(tip).to_have_count(0)
    page.get_by_role("group", name="B y margins").get_by_text("GM", exact=True).hover()
    other = page.get_by_role("tooltip").filter(has_text="Gain margin")
    expect(other).to_be_visible()
    # A control explains itself too; Escape closes it, and at the edge it stays in the window.
    page.get_by_role("checkbox", name="B DOB").focus()
    observer = page.get_by_role("tooltip").filter(has_text="Disturbance observer")
    expect(observer).to_be_visible()
    box, size = observer.bounding_box(), page.viewport_size
    assert box is not None and size is not None
    assert box["x"] >= 0 and box["x"] + box["width"] <= size["width"]
    assert box["y"] >= 0 and box["y"] + box["height"] <= size["height"]
    page.keyboard.press("Escape")
    expect(page.get_by_role("tooltip")).to_have_count(0)
    # Each term is reached by Tab once, and a sentence sets its symbols as the gains do.
    assert page.locator(".term[data-term=k_p][tabindex='0']").count() == 1
    expect(region(page, "Result")).not_to_contain_text("_")
