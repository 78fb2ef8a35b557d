"""What a person does on the screen of paths, in a real browser."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.e2e.actions import API, LONG, region, serious, session, set_field
from tests.e2e.conftest import Server

STROKE = (0.085, 0.145)


@pytest.fixture
def address() -> str:
    return "?screen=trajectories"


@pytest.fixture
def paths(page: Page) -> Page:
    """The screen of paths."""
    expect(limits(page)).to_contain_text("feasible", timeout=LONG)
    return page


def limits(page: Page) -> Locator:
    return region(page, "Limits")


def pixels(page: Page, x: float, y: float) -> tuple[float, float]:
    """Return where a place, m, is on the page while the whole stroke is shown."""
    box = page.get_by_role("application").bounding_box()
    assert box is not None
    width, height = box["width"], box["height"]
    scale = min((width - 72) / (2.1 * STROKE[0]), (height - 26) / (2.1 * STROKE[1]))
    return (
        box["x"] + (width + 44) / 2 + x * scale,
        box["y"] + (height - 14) / 2 - y * scale,
    )


def click(page: Page, x: float, y: float) -> None:
    page.mouse.click(*pixels(page, x, y))


def drag(page: Page, start: tuple[float, float], end: tuple[float, float]) -> None:
    page.mouse.move(*pixels(page, *start))
    page.mouse.down()
    page.mouse.move(*pixels(page, *end), steps=8)
    page.mouse.up()


def points(page: Page) -> Locator:
    """Return the fields of the points, x and y in turns."""
    return region(page, "Points").get_by_role("textbox")


def shows(page: Page, expected: list[tuple[str, str]]) -> None:
    """Wait until the table, which follows a hand ten times a second, has these points."""
    expect(points(page)).to_have_count(2 * len(expected))
    for i, value in enumerate(value for point in expected for value in point):
        expect(points(page).nth(i)).to_have_value(value)


def press_until_disabled(page: Page, key: str, name: str) -> None:
    for _ in range(30):
        if page.get_by_role("button", name=name).is_disabled():
            return
        page.keyboard.press(key)
    raise AssertionError(f"{name} never ends")


RHOMBUS = [("30", "0"), ("0", "30"), ("-30", "0"), ("0", "-30")]


def test_a_rhombus_is_drawn_by_hand_and_run(paths: Page) -> None:
    paths.get_by_label("start from").select_option("nothing")
    expect(limits(paths)).to_contain_text("Set 2 points or more", timeout=LONG)
    for x, y in ((0.04, 0.0), (0.0, 0.05), (-0.04, 0.0), (0.0, -0.05)):
        click(paths, x, y)
    paths.get_by_role("checkbox", name="closed").check()
    shows(paths, [("40", "0"), ("0", "50"), ("-40", "0"), ("0", "-50")])
    expect(limits(paths).get_by_role("status")).to_have_text("feasible", timeout=LONG)
    results = region(paths, "Errors of A and B")
    expect(results).to_contain_text("exact", timeout=LONG)
    expect(results.locator("thead")).to_contain_text("µm")
    results.get_by_role("button", name="Send to motor").click()
    expect(region(paths, "Trajectory")).to_contain_text("path", timeout=LONG)
    paths.get_by_role("button", name="Play", exact=True).click()
    expect(paths.locator(".bar").get_by_role("status")).to_have_text("playing", timeout=LONG)


def test_a_point_out_of_the_stroke_is_refused_with_place_and_reason(paths: Page) -> None:
    drag(paths, (0.03, 0.0), (0.095, 0.01))
    expect(limits(paths).get_by_role("status")).to_have_text(re.compile("infeasible"), timeout=LONG)
    shows(paths, [("95", "10"), *RHOMBUS[1:]])
    worst = limits(paths).get_by_role("listitem").first
    expect(worst).to_contain_text("x leaves the stroke")
    expect(worst).to_contain_text("x 95.00, y 10.00 mm")
    expect(worst).to_contain_text("95.0 mm, allowed ±85.0 mm")
    expect(limits(paths)).to_contain_text("no slower motion profile helps")
    for name in ("Slow down until feasible", "Stage in Lab", "Send to motor"):
        expect(paths.get_by_role("button", name=name)).to_be_disabled()
    paths.get_by_role("button", name="Last feasible").click()
    expect(limits(paths).get_by_role("status")).to_have_text("feasible", timeout=LONG)
    expect(paths.get_by_role("button", name="Send to motor")).to_be_enabled()


def test_too_fast_a_path_is_slowed_down_until_feasible(paths: Page) -> None:
    set_field(paths, "max speed, mm/s", "600")
    set_field(paths, "max acceleration, m/s²", "6")
    cost = paths.get_by_role("group", name="Cost of the retiming")
    expect(cost.get_by_role("status")).to_have_text(re.compile("infeasible"), timeout=LONG)
    expect(cost.locator("tr", has_text="speed")).to_contain_text("393")
    expect(cost.locator("tr", has_text="lap time")).to_contain_text("3.98")
    expect(limits(paths).get_by_role("status")).to_have_text("feasible")
    cost.get_by_role("button", name="Apply").click()
    expect(cost).to_be_hidden()
    expect(limits(paths)).to_contain_text("y needs too much thrust", timeout=LONG)
    slow = paths.get_by_role("button", name="Slow down until feasible")
    slow.press("Enter")
    expect(cost).to_contain_text(re.compile(r"Every move takes 1\.\d+ times as long"), timeout=LONG)
    expect(cost.get_by_role("status")).to_have_text("feasible", timeout=LONG)
    expect(limits(paths)).to_contain_text("y needs too much thrust")  # until it is taken
    expect(cost.get_by_role("button", name="Apply")).to_be_focused()
    cost.get_by_role("button", name="Discard").press("Enter")
    expect(cost).to_be_hidden()
    slow.press("Enter")
    expect(cost.get_by_role("button", name="Apply")).to_be_focused(timeout=LONG)
    paths.keyboard.press("Enter")
    expect(limits(paths).get_by_role("status")).to_have_text("feasible", timeout=LONG)
    slower = paths.get_by_role("textbox", name="max acceleration, m/s²")
    expect(slower).to_have_value(re.compile(r"^[1-5]\.\d+$"))


def test_a_path_runs_once_finishes_and_plays_again(paths: Page) -> None:
    profile = region(paths, "Motion profile")
    repeat = profile.get_by_role("radiogroup", name="Repeat")
    expect(repeat.get_by_role("radio", name="For ever")).to_be_checked()
    expect(profile).to_contain_text("A session repeats it for ever")
    repeat.get_by_role("radio", name="For ever").press("ArrowLeft")
    expect(repeat.get_by_role("radio", name="n times")).to_be_checked()
    expect(paths.get_by_role("textbox", name="laps", exact=True)).to_have_value("2")
    repeat.get_by_role("radio", name="Once").click()
    expect(profile).to_contain_text("A session ends after one lap")
    set_field(paths, "max speed, mm/s", "200")
    paths.get_by_role("button", name="Apply").click()
    expect(limits(paths).get_by_role("status")).to_have_text("feasible", timeout=LONG)
    send = region(paths, "Errors of A and B").get_by_role("button", name="Send to motor")
    expect(send).to_be_enabled(timeout=LONG)
    send.click()
    lab = region(paths, "Trajectory")
    choice = lab.get_by_role("radiogroup", name="Repeat")
    expect(choice.get_by_role("radio", name="Once")).to_be_checked(timeout=LONG)
    state = paths.locator(".bar").get_by_role("status")
    play = paths.get_by_role("button", name="Play", exact=True)
    play.click()
    expect(state).to_have_text("finished", timeout=LONG)
    play.click()  # from 0 s again
    expect(state).to_have_text("playing", timeout=LONG)
    expect(state).to_have_text("finished", timeout=LONG)
    choice.get_by_role("radio", name="n times").click()
    expect(lab.get_by_role("textbox", name=re.compile("laps"))).to_have_value("2")


def test_everything_is_undone_and_done_again(paths: Page) -> None:
    drag(paths, (0.03, 0.0), (0.05, 0.02))
    click(paths, -0.015, -0.015)
    paths.keyboard.press("ArrowLeft")
    paths.keyboard.press("Shift+ArrowDown")
    paths.keyboard.press("Delete")
    paths.get_by_role("radio", name="Smooth").click()
    set_field(paths, "laps", "3")
    changed = [("50", "20"), *RHOMBUS[1:]]
    shows(paths, changed)
    press_until_disabled(paths, "Control+z", "Undo")
    shows(paths, RHOMBUS)
    expect(paths.get_by_role("radio", name="Straight")).to_be_checked()
    press_until_disabled(paths, "Control+Shift+Z", "Redo")
    shows(paths, changed)
    expect(paths.get_by_role("textbox", name="laps", exact=True)).to_have_value("3")


def test_a_click_on_the_smooth_curve_adds_a_point_there(paths: Page) -> None:
    expect(limits(paths)).to_contain_text("170 mm in", timeout=LONG)
    paths.get_by_role("radio", name="Smooth").click()
    # The curve comes with the answer that has its length.
    expect(limits(paths)).not_to_contain_text("170 mm in", timeout=LONG)
    # By symmetry the curve crosses the diagonal at the radius of the spline, 8 mm off the chord.
    click(paths, 0.021, 0.021)
    shows(paths, [RHOMBUS[0], ("21", "21"), *RHOMBUS[1:]])


def test_points_are_reached_and_moved_by_keys(paths: Page) -> None:
    plane = paths.get_by_role("application")
    plane.focus()
    paths.keyboard.press("Tab")
    paths.keyboard.press("Tab")
    paths.keyboard.press("ArrowUp")
    paths.keyboard.press("Shift+ArrowRight")
    shows(paths, [RHOMBUS[0], ("0.1", "31"), *RHOMBUS[2:]])
    paths.keyboard.press("Insert")
    expect(points(paths)).to_have_count(10)
    paths.keyboard.press("Delete")
    expect(points(paths)).to_have_count(8)
    for _ in range(5):
        paths.keyboard.press("Tab")
    expect(plane).not_to_be_focused()


def test_a_path_is_saved_and_loaded_in_a_fresh_browser(
    paths: Page, browser: Browser, server: Server
) -> None:
    set_field(paths, "point 1 x, mm", "42.5")
    saved = region(paths, "Saved paths")
    saved.get_by_role("textbox", name="Name of the path").fill("my-rhombus")
    saved.get_by_role("button", name="Save").click()
    expect(paths.get_by_text("Saved as my-rhombus.")).to_be_visible(timeout=LONG)
    fresh = browser.new_page(viewport={"width": 1280, "height": 720})
    fresh.goto(f"{server.url}/?screen=trajectories")
    expect(limits(fresh)).to_contain_text("feasible", timeout=LONG)
    shows(fresh, RHOMBUS)
    mine = region(fresh, "Saved paths").get_by_role("article", name="path my-rhombus")
    mine.get_by_role("button", name="Open my-rhombus").click()
    expect(fresh.get_by_role("textbox", name="point 1 x, mm")).to_have_value("42.5", timeout=LONG)
    mine.get_by_role("button", name="Rename my-rhombus").click()
    mine.get_by_role("textbox", name="New name of my-rhombus").fill("my-other")
    mine.get_by_role("button", name="Rename", exact=True).click()
    other = region(fresh, "Saved paths").get_by_role("article", name="path my-other")
    delete = other.get_by_role("button", name="Delete the path my-other")
    delete.click()
    expect(other).to_have_count(0, timeout=LONG)
    expect(mine).to_have_count(0)
    fresh.locator(".message").get_by_role("button", name="Undo").click()
    delete.click(timeout=LONG)
    expect(other).to_have_count(0, timeout=LONG)
    name = session(fresh, server)["id"]
    fresh.close()
    paths.request.delete(f"{server.url}{API}/sessions/{name}")


def test_a_shipped_figure_is_made_editable(paths: Page) -> None:
    paths.get_by_label("Open a path").select_option("pentagram")
    expect(region(paths, "Path")).to_contain_text("star", timeout=LONG)
    paths.get_by_role("button", name="Make its points editable").click()
    expect(points(paths)).to_have_count(10)
    expect(limits(paths).get_by_role("status")).to_have_text("feasible", timeout=LONG)
    saved = region(paths, "Saved paths")
    expect(saved).to_contain_text("save under another name")
    expect(saved.get_by_role("button", name="Save")).to_be_disabled()


def test_the_path_goes_to_the_lab_as_a_what_if(paths: Page) -> None:
    paths.get_by_role("button", name="Stage in Lab").click()
    expect(region(paths, "Changes")).to_contain_text("drawn path", timeout=LONG)
    expect(region(paths, "Trajectory")).to_contain_text("path")
    paths.go_back()
    expect(region(paths, "Path on the plane")).to_be_visible(timeout=LONG)


def test_axe_finds_nothing_serious(paths: Page) -> None:
    set_field(paths, "point 1 x, mm", "93")
    expect(limits(paths)).to_contain_text("leaves the stroke", timeout=LONG)
    assert serious(paths) == []
