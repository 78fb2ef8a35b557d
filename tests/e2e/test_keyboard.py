"""Everything once more, by keyboard alone."""

from __future__ import annotations

import re
from pathlib import Path
from urllib.parse import parse_qs, urlparse

import numpy as np
import pytest
from playwright.sync_api import FileChooser, FilePayload, Page, expect

from motionlab.timing import CONTROL_PERIOD
from tests.e2e.actions import (
    API,
    LONG,
    command,
    lab_views,
    press,
    region,
    serious,
    simulated,
    state,
    tab_to,
    type_number,
    until,
    wait_for_clock,
)
from tests.e2e.conftest import Server
from tests.e2e.test_scene import BLIND


def test_a_session_from_play_to_reload_by_keyboard_alone(page: Page, tmp_path: Path) -> None:
    keyboard = page.keyboard
    changes = region(page, "Changes")

    keyboard.press("Space")
    state(page, "playing")
    tab_to(page, "B k_p x")
    keyboard.press("Shift+ArrowRight")
    expect(changes).to_contain_text("220.3", timeout=LONG)
    tab_to(page, "B k_p x, N/mm")
    type_number(page, "312")
    expect(changes).to_contain_text("312", timeout=LONG)

    tab_to(page, "Force on x, N")
    type_number(page, "8")
    tab_to(page, "Push x")
    wait_for_clock(page, 1.0)
    keyboard.press("Enter")
    metrics = region(page, "Metrics")
    page.wait_for_function(  # B's error is 2.6 um without a push
        "() => { const cells = document.querySelectorAll('[aria-label=Metrics] tbody td');"
        " return parseFloat(cells[1]?.innerText) > 5 }",
        timeout=LONG,
    )
    tab_to(page, "Definitions")
    keyboard.press("Enter")
    expect(metrics.get_by_text("largest following error").first).to_be_visible()

    keyboard.press("Escape")
    state(page, "stopped")
    tab_to(page, "CSV ↓")
    with page.expect_download() as csv:
        keyboard.press("Enter")
    csv.value.save_as(tmp_path / "run.csv")
    assert len((tmp_path / "run.csv").read_text().splitlines()) > 1000

    page.reload()
    state(page, "stopped")
    expect(changes).to_contain_text("312", timeout=LONG)
    keyboard.press("r")
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)


def test_what_if_undo_and_apply_by_keyboard_alone(page: Page, server: Server) -> None:
    keyboard = page.keyboard
    changes, metrics = region(page, "Changes"), region(page, "Metrics")
    _, before = simulated(page, server)
    _, after = simulated(page, server, k_p=400e3)
    expect(metrics).to_contain_text(before, timeout=LONG)
    tab_to(page, "B k_p x, N/mm")
    type_number(page, "400")
    expect(metrics).to_contain_text(after, timeout=LONG)
    expect(metrics).to_contain_text("exact", timeout=LONG)
    tab_to(page, "B k_d x")
    keyboard.press("u")
    expect(metrics).to_contain_text(before, timeout=LONG)
    keyboard.press("ArrowRight")
    expect(changes).to_contain_text("1.545", timeout=LONG)
    keyboard.press("a")
    expect(changes.get_by_role("button", name="Send to motor")).to_be_disabled(timeout=LONG)
    keyboard.press("l")
    expect(changes).to_contain_text("1.545")


def test_views_and_help_by_keyboard_alone(page: Page) -> None:
    keyboard = page.keyboard
    scopes = region(page, "Scopes")
    keyboard.press("2")
    expect(scopes.locator(".chart canvas")).to_have_count(1)
    expect(page.get_by_role("region", name="Following error y, what-if")).to_be_visible()
    keyboard.press("1")
    expect(page.get_by_role("region", name="Following error x, what-if")).to_be_visible()
    keyboard.press("n")
    keyboard.type("velocity reference x")
    keyboard.press("Enter")
    expect(scopes.get_by_role("heading", name="Velocity x")).to_be_visible()
    keyboard.press("Escape")
    expect(scopes.locator(".chart canvas")).to_have_count(1)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    keyboard.press("m")
    keyboard.press("m")
    expect(scopes).to_contain_text("Δt 2.00 s", timeout=LONG)  # A third of the 6 s shown.
    keyboard.press("<")
    expect(scopes).to_contain_text("Δt 1.97 s", timeout=LONG)
    keyboard.press("v")
    expect(scopes.get_by_role("heading", name="Velocity x, mean")).to_be_visible()
    keyboard.press("0")
    expect(scopes).not_to_contain_text("Δt")
    press(page, "Shift+F6", "Shift+F6")
    tab_to(page, "Table")
    keyboard.press("Enter")
    numbers = region(page, "Plane as numbers")
    expect(numbers.get_by_role("row", name="most")).to_contain_text("15.0", timeout=LONG)
    keyboard.press("S")
    expect(page.locator(".clock")).to_contain_text("0:00.100")
    keyboard.press("?")
    sheet = page.get_by_role("dialog", name="Keys and help")
    expect(sheet).to_be_visible()
    keyboard.press("Escape")
    expect(sheet).to_be_hidden()
    state(page, "paused")


def open_menu(page: Page, words: str) -> None:
    command(page, words)
    expect(
        page.locator(":popover-open").get_by_role("button", name="Remove", exact=True)
    ).to_be_visible()


def test_scopes_are_built_by_keyboard_alone(page: Page) -> None:
    scopes = region(page, "Scopes")

    def built() -> list[str]:
        return scopes.locator("h3").all_inner_texts()

    def layout() -> list[str]:
        return parse_qs(urlparse(page.url).query)["scopes"][0].split(";")

    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    press(page, "F6", "Shift+F6")
    expect(region(page, "Changes")).to_be_focused()
    press(page, "/")
    page.keyboard.type("b.y.thrust")
    press(page, "Enter")
    expect(scopes.locator("h3").first).to_have_text("Following error, thrust")
    press(page, "Escape")
    expect(region(page, "Changes")).to_be_focused()
    open_menu(page, "following error, thrust place")
    press(page, "Tab", "End", "ArrowLeft", "Enter")
    until(page, "it is the second", lambda: "thrust" in layout()[1])
    open_menu(page, "following error, thrust place")
    tab_to(page, "Lock")
    press(page, "Enter")
    until(page, "the axis is locked", lambda: "=" in layout()[1])
    low, high = map(float, layout()[1].split("=")[1].split(":"))
    press(page, "ArrowRight", "Enter")
    nearer = [0.9 * low + 0.1 * high, 0.1 * low + 0.9 * high]
    assert list(map(float, layout()[1].split("=")[1].split(":"))) == pytest.approx(nearer, rel=1e-3)
    press(page, "Escape", "Shift+Tab", "ArrowRight", "Alt+Enter")
    shown = scopes.get_by_role("toolbar", name="Traces of Following error, thrust")
    pressed = shown.locator("button[aria-pressed]")
    expect(pressed.nth(1)).to_be_focused()
    for place, alone in enumerate(["false", "true", "false", "false"]):
        expect(pressed.nth(place)).to_have_attribute("aria-pressed", alone)
    press(page, "Alt+Enter", "Enter")
    expect(pressed.nth(1)).to_have_attribute("aria-pressed", "false")
    expect(pressed.nth(0)).to_have_attribute("aria-pressed", "true")
    open_menu(page, "following error y place")
    tab_to(page, "Open too")
    press(page, "Enter")
    tab_to(page, "Height of Following error y")
    press(page, "ArrowDown")
    assert re.search(r"@1\.\d", layout()[0])


def test_a_layout_is_kept_and_opened_by_keyboard_alone(page: Page) -> None:
    scopes = region(page, "Scopes")

    def built() -> list[str]:
        return scopes.locator("h3").all_inner_texts()

    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    command(page, "layout keep, open")
    sheet = page.get_by_role("dialog", name="Layouts")
    expect(sheet.get_by_role("textbox")).to_be_focused()
    page.keyboard.type("by keys")
    press(page, "Enter")
    expect(sheet).to_contain_text("4 scopes", timeout=LONG)
    kept = built()
    press(page, "Escape")
    command(page, "layout paper figure")
    assert built() == ["Following error x", "Following error y"]
    open_menu(page, "following error y place")
    press(page, "Tab", "End", "Enter")  # Remove
    assert built() == ["Following error x"]
    expect(scopes.locator(":focus")).to_have_count(1)
    command(page, "layout keep, open")
    tab_to(page, "Open by keys")
    press(page, "Enter")
    assert built() == kept


def test_a_signal_is_looked_at_and_its_glitch_kept_by_keyboard_alone(page: Page) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    scopes, notices = region(page, "Scopes"), page.locator(".message")
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    command(page, "layout paper figure")
    press(page, *"+" * 12)
    command(page, "table scopes")
    cells = region(page, "Scopes as numbers").locator("tbody tr")
    until(page, "a few ticks are left", lambda: 8 < cells.count() < 12)
    times = [float(text) for text in cells.locator("th").all_inner_texts()[:-6]]
    assert np.diff(times) == pytest.approx([CONTROL_PERIOD] * (len(times) - 1))
    press(page, "Enter", "0", "m", "m", ">")
    expect(scopes).to_contain_text("\u0394t 2.03 s", timeout=LONG)
    press(page, "M")
    expect(region(page, "Measurements as numbers")).to_contain_text("error x of A", timeout=LONG)
    command(page, "copy measurements")
    row = re.compile("^Following error x of A\t\u00b5m\t", re.MULTILINE)
    clipboard = "navigator.clipboard.readText()"
    until(page, "the table is copied", lambda: bool(row.search(page.evaluate(clipboard))))

    press(page, "0", "k")
    expect(notices).to_contain_text("Peak of Following error x of A", timeout=LONG)
    command(page, "why notice")
    why = page.get_by_role("dialog", name="Why?")
    expect(why).to_contain_text(re.compile("Why does A err by .* on x at 5.3"), timeout=LONG)
    assert serious(page, '[aria-label="Why?"], dialog[open]') == []
    press(page, "Escape", "h")
    trigger = region(page, "Trigger")
    expect(trigger.get_by_role("status")).to_have_text("4 of 4 hits", timeout=LONG)
    shown = trigger.locator("[aria-current=true]")
    command(page, "show it; arrow keys")
    press(page, "Home", "ArrowDown", "End")
    expect(
        trigger.get_by_role("table").get_by_role("row").last.get_by_role("button")
    ).to_be_focused()
    expect(shown).to_be_focused()
    assert serious(page, "main") == []

    press(page, "l")
    command(page, "play")
    press(page, "h")
    expect(trigger.get_by_role("status")).to_have_text("Done: 10 captured", timeout=LONG)
    opened = trigger.get_by_role("button", name="Open", exact=True)
    expect(opened).to_be_enabled(timeout=LONG)
    command(page, "open trigger")
    run = region(page, "Run")
    expect(run.get_by_role("region", name="Following error x")).to_be_visible(timeout=LONG)


def test_every_view_and_the_spectrum_by_keyboard_alone(page: Page, server: Server) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    lab_views(page)
    expect(page.get_by_role("link", name="Open as a page")).to_be_visible(timeout=LONG)
    command(page, "open as a page")
    views = region(page, "View")
    expect(page).to_have_url(re.compile(r"pane=ballbar\+staged"))
    tab_to(page, "Ballbar")
    for name, shows in {
        "Contouring": "Errors",
        "Friction": "Friction figures",
        "Positioning": "Positioning figures",
        "Cost": "Cost of x",
        "Spectrum": None,
        "XY": None,
        "Ballbar": "Each direction",
    }.items():
        press(page, "ArrowRight")
        expect(views.get_by_role("radio", name=name, exact=True)).to_be_focused()
        if shows:
            expect(views.get_by_role("table", name=shows, exact=True)).to_be_visible(timeout=LONG)
        elif name == "Spectrum":
            expect(views).to_contain_text("noise bandwidth", timeout=LONG)
        else:
            drawn = views.get_by_role("slider", name=re.compile("^Friction x over velocity x"))
            expect(drawn).to_be_visible(timeout=LONG)
        assert serious(page, '[aria-label="View"]') == [], name

    command(page, "table of ballbar")
    table = region(page, "Ballbar as numbers")
    body = {"scenario": "circle"}
    answer = page.request.post(f"{server.url}{API}/views/ballbar", data=body).json()
    first = answer["variants"]["A"]["directions"]["ccw"]["deviation"][0]
    shown = table.locator("tbody td").first.inner_text().replace("\N{MINUS SIGN}", "-")
    assert float(shown) == pytest.approx(1e6 * first, abs=6e-3)
    tab_to(page, "CSV")
    with page.expect_download() as csv:
        press(page, "Enter")
    assert csv.value.suggested_filename == "Ballbar.csv"

    command(page, "spectrum kind of view")
    command(page, "window function: flat top")
    settled = re.compile('"averages":1,.*"window":"flat-top"|"window":"flat-top".*"averages":1,')
    with page.expect_request(lambda request: bool(settled.search(request.post_data or ""))):
        command(page, "averages: no average")
    command(page, "spectrum of following error x frequency")
    press(page, "Home", "ArrowRight")
    expect(views.get_by_role("slider")).to_have_attribute(
        "aria-valuetext", re.compile(r"frequency [\d.]+ Hz, A ")
    )


def test_the_3d_view_by_keyboard_alone(page: Page, refusals: list[str]) -> None:
    refusals += BLIND
    page.get_by_role("radio", name="3-D view").focus()
    press(page, "Enter", "F")
    fills = page.get_by_role("button", name="Fill page")
    expect(fills).to_have_attribute("aria-pressed", "true")
    cameras = page.get_by_role("radiogroup", name="Camera")
    for words, chosen in {
        "section camera": "Section",
        "follow b camera": "Follow B",
        "top camera": "Top",
    }.items():
        command(page, words)
        expect(cameras.get_by_role("radio", name=chosen)).to_be_checked()
    press(page, "ArrowRight")
    expect(cameras.get_by_role("radio", name="Side")).to_be_checked()
    assert serious(page, ".centre .bar") == []
    press(page, "F")
    expect(fills).to_have_attribute("aria-pressed", "false")


def import_a_box(page: Page) -> None:
    """Open the screen of paths and import a box of 20 by 10 mm from a file."""
    choosers: list[FileChooser] = []

    def chosen(chooser: FileChooser) -> None:
        choosers.append(chooser)

    page.on("filechooser", chosen)  # from here on, or the first would be missed
    command(page, "trajectories screen")
    expect(region(page, "Limits")).to_contain_text("feasible", timeout=LONG)
    command(page, "import saved paths")
    sheet = page.get_by_role("dialog", name="Import a path")
    expect(sheet.get_by_role("button", name="Choose a file…")).to_be_focused()
    press(page, "Enter")
    until(page, "files can be chosen", lambda: len(choosers) > 0)
    content = b"x,y\n0,0\n20,0\n20,10\n0,10\n"
    choosers[0].set_files(FilePayload(name="box.csv", mimeType="text/csv", buffer=content))
    page.remove_listener("filechooser", chosen)
    expect(sheet).to_contain_text("feasible", timeout=LONG)
    assert serious(page, "dialog[open]") == []
    tab_to(page, "Take")
    press(page, "Enter")
    expect(sheet).to_be_hidden()


def test_a_path_is_imported_shaped_and_exported_by_keyboard_alone(page: Page) -> None:
    def path() -> dict:
        return page.evaluate("JSON.parse(localStorage.getItem('motionlab.path'))")

    import_a_box(page)
    command(page, "path of 4 points")
    press(page, "Control+a", "Shift+ArrowRight", "Tab")
    tools = page.get_by_role("toolbar", name="Selected points")
    expect(tools.locator(":focus")).to_have_count(1)
    assert serious(page, "main") == []
    tab_to(page, "scale by")
    type_number(page, "0.5")
    command(page, "angle")
    type_number(page, "30")
    command(page, "rotate")
    press(page, "Tab", "Enter")  # Mirror x
    turn = np.deg2rad(30)
    about = np.array([[-5.0, -2.5], [5.0, -2.5], [5.0, 2.5], [-5.0, 2.5]]) * 1e-3
    turned = about @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    shaped = turned * [-1, 1] + np.array([10.1, 5.0]) * 1e-3
    assert np.array(path()["points"]) == pytest.approx(shaped, abs=1e-8)
    command(page, "align: left")
    assert len({point[0] for point in path()["points"]}) == 1
    press(page, "Control+z")
    assert np.array(path()["points"]) == pytest.approx(shaped, abs=1e-8)

    command(page, "closed path")
    press(page, "Space")
    command(page, "n times")
    command(page, "laps")
    type_number(page, "4")
    assert path()["laps"] == 4
    command(page, "export saved paths")
    expect(page.get_by_role("menuitem").first).to_be_focused()
    press(page, "ArrowDown")
    with page.expect_download() as file:
        press(page, "Enter")
    assert file.value.suggested_filename == "box.csv"


def test_a_path_is_pasted_by_keyboard_alone(page: Page) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    command(page, "trajectories screen")
    expect(region(page, "Limits")).to_contain_text("feasible", timeout=LONG)
    page.evaluate("text => navigator.clipboard.writeText(text)", "G21 G90\nG1 X10 F1200\nY10\n")
    press(page, "Control+v")
    sheet = page.get_by_role("dialog", name="Import a path")
    expect(sheet).to_contain_text("feasible", timeout=LONG)
    tab_to(page, "Take")
    press(page, "Enter")
    expect(sheet).to_be_hidden()
    path = page.evaluate("JSON.parse(localStorage.getItem('motionlab.path'))")
    assert np.array(path["points"]) == pytest.approx(np.array([[0, 0], [10, 0], [10, 10]]) * 1e-3)


def test_a_switch_on_the_schedule_is_jumped_to_by_keyboard_alone(
    page: Page, server: Server
) -> None:
    page.goto(f"{server.url}/?scenario=fig5")
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    press(page, *"+" * 12, *"," * 12)
    command(page, "table scopes")
    times = region(page, "Scopes as numbers").locator("tbody th")
    until(page, "a short stretch", lambda: 5 < times.count() < 120)
    first = float(times.first.inner_text())
    assert first < 90 - CONTROL_PERIOD
    press(page, "Enter", "j")
    command(page, "table scopes")
    until(page, "the switch is in view", lambda: float(times.first.inner_text()) > first)
    shown = [float(text) for text in times.all_inner_texts()[:-6]]
    assert min(shown) < 90 < max(shown)


def test_runs_are_compared_opened_and_exported_by_keyboard_alone(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("404")
    short = {"trajectory.laps": 1, "window": {"start": 0.5, "end": 2.5}}
    kept = [
        page.request.post(
            f"{server.url}{API}/simulate",
            data={"scenario": "circle", "keep": True, "name": name, "set": short},
            timeout=LONG,
        ).json()["run"]
        for name in ("keyed first", "keyed second")
    ]
    command(page, "runs screen")
    grid = page.get_by_role("grid", name="List of runs")
    expect(grid).to_contain_text("keyed second", timeout=LONG)
    press(page, "/")
    page.keyboard.type("keyed")  # runs of sessions that end meanwhile would come between
    expect(grid.get_by_role("row").filter(has_text="keyed")).to_have_count(2, timeout=LONG)
    expect(grid).to_have_attribute("aria-rowcount", "3", timeout=LONG)  # and the heads
    command(page, "list of runs")
    press(page, "ArrowDown", "Shift+ArrowDown", "c")
    panel = region(page, "Compare")
    expect(panel.get_by_role("status")).to_contain_text("Identical on 8 of 8", timeout=LONG)
    press(page, "c")
    expect(panel).to_be_hidden()
    press(page, "ArrowDown", "Enter")
    expect(page.get_by_role("slider", name=re.compile("^Overview"))).to_be_visible(timeout=LONG)
    press(page, "k")
    expect(page.locator(".message")).to_contain_text("Peak of", timeout=LONG)
    assert serious(page, "main") == []
    press(page, "Enter")
    expect(grid).to_be_visible()
    expect(page.get_by_role("link", name="CSV \u2193")).to_be_visible(timeout=LONG)
    with page.expect_download() as file:
        command(page, "csv run")
    assert file.value.suggested_filename.endswith(".csv")
    for run in kept:
        page.request.delete(f"{server.url}{API}/runs/{run}")
