"""Scopes: channels in layouts that links and the server keep, from the whole run to one tick."""

from __future__ import annotations

import base64
import re
from urllib.parse import parse_qs, urlencode, urlparse

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD
from tests.e2e.actions import LONG, button, choose_scenario, region, serious, state, wait_for_clock
from tests.e2e.conftest import Server

API = "/api/v1"


def headings(page: Page) -> list[str]:
    return region(page, "Scopes").locator("h3").all_inner_texts()


def menu_of(page: Page, title: str) -> Locator:
    page.get_by_role("button", name=f"{title}: channels, value axis, place").click()
    return page.locator(":popover-open")


def test_a_layout_is_built_and_opens_elsewhere(
    page: Page, browser: Browser, server: Server
) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("combobox", name="Layout of the scopes").select_option("Paper figure")
    assert headings(page) == ["Following error x", "Following error y"]
    button(page, "New scope")
    channels = page.get_by_label("Channels", exact=True)
    search = channels.get_by_role("combobox", name="Find a channel")
    search.fill("position x reference")
    search.press("Enter")
    search.fill("b.x.friction_estimate")
    search.press("Enter")
    search.press("Escape")
    expect(channels).to_be_hidden()
    menu = menu_of(page, "Position, friction estimate x")
    menu.get_by_role("button", name="Value axis of its own for B.x.friction_estimate").click()
    menu.get_by_role("button", name="Up").click()
    menu = menu_of(page, "Following error x")
    menu.get_by_role("button", name="Show A.x.following_error").click()
    menu.get_by_role("button", name="Forward").click()
    built = ["Following error x", "Position, friction estimate x", "Following error y"]
    assert headings(page) == built
    expect(page.get_by_role("button", name="A", exact=True).first).to_have_attribute(
        "aria-pressed", "false"
    )
    page.get_by_role("combobox", name="Layout of the scopes").select_option("Keep, open…")
    sheet = page.get_by_role("dialog", name="Layouts")
    sheet.get_by_role("textbox", name="Name of the layout").fill("mine")
    sheet.get_by_role("button", name="Keep the present scopes").click()
    expect(sheet).to_contain_text("3 scopes", timeout=LONG)
    kept = page.request.get(f"{server.url}{API}/layouts").json()
    [mine] = [layout for layout in kept if layout["name"] == "mine"]
    assert mine["scopes"][1] == "x.position_reference,B.x.friction_estimate~"
    link = page.url.replace(re.findall(r"session=[^&]+", page.url)[0], "")
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    try:
        fresh = context.new_page()
        fresh.goto(link)
        expect(region(fresh, "Metrics")).to_contain_text("exact", timeout=LONG)
        assert headings(fresh) == built
        # By its name, in a browser that has never seen it.
        fresh.get_by_role("combobox", name="Layout of the scopes").select_option("Errors")
        assert headings(fresh) != built
        choice = fresh.get_by_role("combobox", name="Layout of the scopes")
        choice.select_option("Keep, open…")
        fresh.get_by_role("button", name="Open mine").click()
        assert headings(fresh) == built
    finally:
        context.close()


@pytest.mark.usefixtures("fresh")
def test_a_scope_alone_asks_for_nothing_anew(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    page.keyboard.press("2")
    assert headings(page)[0] == "Following error y"
    page.wait_for_timeout(600)
    page.keyboard.press("1")
    page.wait_for_timeout(600)
    assert [url for url in asked if "whatif" in url] == []


def test_a_channel_is_dragged_onto_a_scope_and_hidden_by_its_legend(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.keyboard.press("/")
    page.get_by_role("combobox", name="Find a channel").fill("a.y.thrust")
    target = page.get_by_role("region", name="Phase currents B x, what-if")
    page.get_by_role("option", name=re.compile("A.y.thrust")).drag_to(
        target.locator("canvas"), target_position={"x": 120, "y": 20}
    )
    page.get_by_label("Channels", exact=True).get_by_role("button", name="Close").click()
    mixed = page.get_by_role("region", name=re.compile("^A, b,"))
    trace = mixed.get_by_role("button", name=re.compile("^thrust"))
    expect(trace).to_have_attribute("aria-pressed", "true")
    trace.click(modifiers=["Alt"])
    for other in "abc":
        shown = mixed.get_by_role("button", name=re.compile(rf"^{other} B x"))
        expect(shown).to_have_attribute("aria-pressed", "false")
    trace.click(modifiers=["Alt"])
    first = mixed.get_by_role("button", name=re.compile("^a B x"))
    expect(first).to_have_attribute("aria-pressed", "true")


def test_from_the_whole_run_to_one_tick_and_back(page: Page) -> None:
    choose_scenario(page, "fig5")
    expect(region(page, "Metrics")).to_contain_text("174 to 180 s", timeout=LONG)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    overview = page.get_by_role("slider", name="Overview: the part that is shown")
    expect(overview).to_have_attribute("aria-valuetext", "0 to 180 s")
    overview.press("Enter")  # the switch at 90 s
    expect(overview).to_have_attribute("aria-valuetext", "85.5 to 103.5 s", timeout=LONG)
    for _ in range(16):
        overview.press("ArrowUp")
    scopes = region(page, "Scopes")
    scopes.get_by_role("button", name="Table").click()
    table = region(page, "Scopes as numbers")
    # Four periods are left, each tick with the number that it has in the simulation.
    expect(table.locator("tbody tr").nth(3)).not_to_contain_text("–", timeout=LONG)  # noqa: RUF001
    times = [float(text) for text in table.locator("tbody th").all_inner_texts()[:-6]]
    assert np.diff(times) == pytest.approx([CONTROL_PERIOD] * (len(times) - 1))
    assert len(times) in {3, 4, 5}
    recording = run(prepare(load_scenario("fig5")))
    error = recording.variants["A"].channel("following_error", "x")
    ticks = np.rint(np.array(times) / CONTROL_PERIOD).astype(int)
    unit = {"nm": 1e-9, "µm": 1e-6}[table.locator("thead th").nth(1).locator(".unit").inner_text()]
    shown = [float(text) * unit for text in table_column(table, 1)[: len(times)]]
    assert shown == pytest.approx(error[ticks], abs=0.006 * float(np.abs(error[ticks]).max()))
    scopes.get_by_role("button", name="Table").click()
    overview.press("Home")
    expect(overview).to_have_attribute("aria-valuetext", "0 to 180 s", timeout=LONG)


def table_column(table: Locator, place: int) -> list[str]:
    cells = table.locator(f"tbody tr td:nth-child({place + 1})").all_inner_texts()
    return [cell.replace("−", "-") for cell in cells]  # noqa: RUF001


def test_measurements_are_those_of_the_samples(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("combobox", name="Layout of the scopes").select_option("Paper figure")
    page.keyboard.press("M")
    table = region(page, "Measurements as numbers")
    row = table.get_by_role("row", name="Following error x of A")
    expect(row).to_contain_text("15.2", timeout=LONG)
    prepared = prepare(load_scenario("circle"))
    start, stop = prepared.window
    error = run(prepared).variants["A"].channel("following_error", "x")[start:stop]
    heads = table.locator("thead th").all_inner_texts()
    cells = [text.replace("−", "-") for text in row.locator("td").all_inner_texts()]  # noqa: RUF001
    read = {head.strip(): cell for head, cell in zip(heads[1:], cells, strict=True)}
    for name, value in (
        ("least", error.min()),
        ("most", error.max()),
        ("p-p", np.ptp(error)),
        ("mean", error.mean()),
        ("RMS", np.sqrt(np.mean(error**2))),
        ("std", error.std()),
    ):
        assert float(read[name]) == pytest.approx(1e6 * value, rel=0.006, abs=0.006), name
    page.keyboard.press("V")
    page.keyboard.press("m")
    page.keyboard.press("m")
    expect(
        page.get_by_text(re.compile(r"Between the cursors: .* Δt 2.00 s, 1/Δt 0.500 Hz"))
    ).to_be_visible()


def test_a_math_channel_is_written_measured_and_kept(page: Page, server: Server) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("combobox", name="Layout of the scopes").select_option("Paper figure")
    button(page, "New scope")
    channels = page.get_by_label("Channels", exact=True)
    search = channels.get_by_role("combobox", name="Find a channel")
    search.fill("no such channel")
    assert serious(page, '[aria-label="Channels"]') == []
    search.clear()
    # The editor is loaded meanwhile.
    page.keyboard.type("=hypot(B.x.following_error, B.y.thrust)")
    form = page.get_by_role("form", name="Math channel")
    text = form.get_by_role("combobox", name="Expression")
    expect(text).to_have_value("hypot(B.x.following_error, B.y.thrust)")
    expect(form.get_by_role("status")).to_contain_text("not m and N", timeout=LONG)
    expect(form.locator("mark")).to_have_text("B.y.thrust")
    expect(form.get_by_role("button", name="Add to scope")).to_be_disabled()
    for _ in "thrust)":
        text.press("Backspace")
    text.press_sequentially("foll")
    text.press("ArrowDown")
    text.press("Enter")
    expect(text).to_have_value("hypot(B.x.following_error, B.y.following_error")
    text.press_sequentially(")")
    form.get_by_role("textbox", name="Name").fill("error")
    expect(form.get_by_role("status")).to_have_text("Unit: m", timeout=LONG)
    form.get_by_role("textbox", name="Name").press("Enter")
    assert serious(page, '[aria-label="Channels"]') == []
    page.keyboard.press("Escape")
    page.keyboard.press("m")
    page.keyboard.press("m")
    shown = read_at_the_second_cursor(page)
    prepared = prepare(load_scenario("circle"))
    start, stop = prepared.window
    tick = start + round(2 / 3 * (stop - start))
    recording = run(prepared).variants["B"]
    errors = [recording.channel("following_error", axis) for axis in "xy"]
    near = 1e6 * np.hypot(*errors)[tick - 2 : tick + 3]
    assert near.min() - 0.006 <= shown <= near.max() + 0.006
    # The address has both cursors a moment later.
    page.wait_for_url(re.compile("cursors%22%3A%5B[^%]+%2C"))
    page.reload()
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    shown = read_at_the_second_cursor(page)
    assert near.min() - 0.006 <= shown <= near.max() + 0.006
    it_is_computed_live_renamed_and_deleted(page, server)


def it_is_computed_live_renamed_and_deleted(page: Page, server: Server) -> None:
    page.keyboard.press("l")
    page.get_by_role("button", name="Step").click()
    live = page.get_by_role("region", name="error, live")
    expect(live.locator("button.trace .value")).to_contain_text("m", timeout=LONG)
    link = page.get_by_role("link", name="CSV ↓").get_attribute("href")
    head = page.request.get(f"{server.url}{link}").text().splitlines()[0]
    assert head.replace('"', "").endswith(",error [m]")
    assert "B.y.thrust [N]" in head
    # Renamed, then deleted, in the list of channels.
    page.keyboard.press("/")
    channels = page.get_by_label("Channels", exact=True)
    form = page.get_by_role("form", name="Math channel")
    channels.get_by_role("button", name="Edit error").click()
    form.get_by_role("textbox", name="Name").fill("distance")
    expect(form.get_by_role("status")).to_have_text("Unit: m", timeout=LONG)
    form.get_by_role("button", name="Change").click()
    assert headings(page) == ["distance", "Following error x", "Following error y"]
    channels.get_by_role("button", name="Delete distance").click()
    assert headings(page) == ["Following error x", "Following error y"]


def read_at_the_second_cursor(page: Page) -> float:
    scope = page.get_by_role("region", name="error, what-if")
    value = scope.locator("button.trace .value")
    expect(value).to_contain_text("µm", timeout=LONG)
    return float(value.inner_text().replace("µm", ""))


PIXELS = """canvases => canvases.map(canvas => {
  const { width, height } = canvas;
  const { data } = canvas.getContext('2d').getImageData(0, 0, width, height);
  let text = '';  // base 64: millions of numbers one by one take seconds
  for (let i = 0; i < data.length; i += 8192)
    text += String.fromCharCode(...data.subarray(i, i + 8192));
  return [height, width, btoa(text)];
})"""


def test_curves_drawn_as_they_come_are_those_drawn_at_once(page: Page, server: Server) -> None:
    session = parse_qs(urlparse(page.url).query)["session"][0]
    held = "A.x.following_error,B.x.following_error=-0.00004:0.00004;A.y.thrust,B.y.thrust=-40:40"
    query = urlencode({"session": session, "mode": "live", "scopes": held, "open": "0,1"})
    page.goto(f"{server.url}/?{query}")
    page.get_by_text("connected", exact=True).wait_for()
    page.keyboard.press(" ")
    wait_for_clock(page, 12)  # its window is 10 s: curves have moved out of it
    page.keyboard.press(" ")
    state(page, "paused")
    canvases = region(page, "Scopes").locator(".chart canvas")
    page.wait_for_timeout(500)
    moved = canvases.evaluate_all(PIXELS)
    for _ in range(2):
        page.keyboard.press("t")  # another theme, and back: all is drawn again
        page.wait_for_timeout(500)
    assert len(moved) == 2
    for (height, width, before), (*_, after) in zip(
        moved, canvases.evaluate_all(PIXELS), strict=True
    ):
        pixels = [np.frombuffer(base64.b64decode(text), np.uint8) for text in (before, after)]
        pictures = np.array(pixels, float).reshape(2, height, width, 4)
        assert np.ptp(pictures[1, :, :, 3]) > 200
        differ = np.abs(pictures[1] - pictures[0]).max(axis=-1) > 64
        assert differ.mean() < 0.002


def test_a_value_axis_is_zoomed_with_round_numbers_and_reset(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    scopes = region(page, "Scopes")
    auto = scopes.get_by_role("button", name="Auto")
    reset = scopes.get_by_role("button", name="Reset")
    expect(reset).to_be_disabled()
    canvas = page.get_by_role("region", name="Following error x, what-if").locator("canvas")
    box = canvas.bounding_box()
    assert box is not None
    # A click beside the axis, where the wheel zooms, sets nothing; the wheel holds the axis.
    page.mouse.click(box["x"] + 30, box["y"] + 10)
    expect(reset).to_be_disabled()
    page.mouse.wheel(0, 170)
    expect(auto).to_have_attribute("aria-pressed", "false")
    page.mouse.move(box["x"] + 30, box["y"] + 10)
    page.mouse.down()
    page.mouse.move(box["x"] + 30, box["y"] + 17)
    page.mouse.up()
    assert "=" in page.evaluate("new URL(location.href).searchParams.get('scopes')")
    reset.click()
    expect(auto).to_have_attribute("aria-pressed", "true")
    expect(reset).to_be_disabled()
    assert "=" not in (page.evaluate("new URL(location.href).searchParams.get('scopes')") or "")
    page.keyboard.down("Shift")
    page.mouse.click(box["x"] + 30, box["y"] + 10)
    page.keyboard.up("Shift")
    expect(reset).to_be_enabled()
