"""The Runs screen: what was played or kept is found, named, deleted, linked and opened again."""

from __future__ import annotations

import cmath
import json
import math
import os
import random
import re
import shutil
import struct
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.e2e.actions import (
    API,
    LONG,
    button,
    region,
    serious,
    session,
    set_field,
    simulated,
    state,
    wait_for_clock,
)
from tests.e2e.conftest import Server

GAIN = "variants.B.controller.x.k_p"


def keep(page: Page, server: Server, **body: object) -> str:
    """Keep a simulation; return its identifier."""
    asked = {"scenario": "circle", "keep": True} | body
    answer = page.request.post(f"{server.url}{API}/simulate", data=asked, timeout=LONG)
    return answer.json()["run"]


def open_runs(page: Page, server: Server, rest: str = "") -> Locator:
    page.goto(f"{server.url}/?screen=runs{rest}")
    page.get_by_text("connected", exact=True).wait_for()
    return page.get_by_role("grid", name="List of runs")


def open_screen(page: Page, name: str) -> None:
    screens = page.get_by_role("navigation", name="Screens")
    screens.get_by_role("link", name=name, exact=True).click()


def row(page: Page, name: str) -> Locator:
    return page.get_by_role("row", name=re.compile(rf"Select {name}"))


@pytest.fixture
def two(page: Page, server: Server, refusals: list[str]) -> Iterator[list[str]]:
    """Two kept simulations, which are gone afterwards, even while the page reads their curves."""
    refusals.append("404")
    kept = [
        keep(page, server, name="stiffer", set={GAIN: 312e3}),
        keep(page, server, name="shipped"),
    ]
    yield kept
    for run in kept:
        page.request.delete(f"{server.url}{API}/runs/{run}")


def test_a_session_is_found_tagged_pinned_deleted_and_linked(
    page: Page, server: Server, browser: Browser, refusals: list[str]
) -> None:
    refusals.append("404")  # asked for before the index has it
    page.keyboard.press("Space")
    wait_for_clock(page, 2.0)
    recording = page.get_by_role("contentinfo").get_by_role("link", name=re.compile("^r-"))
    expect(recording).to_be_visible()
    run = recording.inner_text()
    assert session(page, server)["run"] == run
    recording.click()
    detail = region(page, "Run")
    expect(detail).to_contain_text("recording")
    page.keyboard.press("Escape")
    state(page, "stopped")
    open_screen(page, "Lab")
    page.keyboard.press("r")
    state(page, "paused")
    open_screen(page, "Runs")
    expect(detail).to_contain_text("STOP", timeout=LONG)
    expect(detail.get_by_role("region", name="Following error x")).to_be_visible()

    page.keyboard.press("t")
    page.keyboard.type("rig")
    page.keyboard.press("Enter")
    expect(row(page, "circle").get_by_text("rig", exact=True)).to_be_visible()
    page.keyboard.press("/")
    page.keyboard.type("tag:rig")
    runs = region(page, "Runs")
    expect(runs.get_by_role("heading")).to_contain_text("Runs 1")
    page.get_by_role("grid").focus()
    page.keyboard.press("p")
    expect(row(page, "circle").get_by_role("button", name="Unpin circle")).to_be_visible()
    page.keyboard.press("Delete")
    expect(runs).to_contain_text("No run meets all of tag:rig.")
    button(page, "Undo")
    expect(row(page, "circle")).to_be_visible()

    with browser.new_context() as context:
        other = context.new_page()
        other.goto(f"{server.url}/?screen=runs&run={run}")
        expect(region(other, "Run")).to_contain_text(run, timeout=LONG)
        expect(region(other, "Metrics of the run")).to_contain_text("max |e")
        other.close()


@pytest.mark.usefixtures("unopened")
def test_a_run_is_named_by_what_differs_until_a_person_names_it(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("404")
    values = {"x": 4e5, "y": 5e5}
    gains = {f"variants.{v}.controller.{a}.k_p": values[a] for v in "AB" for a in values}
    kept = [
        keep(page, server, set=gains | {"seed": 7}),
        keep(page, server, set={"trajectory": "rhombus", "seed": 7}),
    ]
    open_runs(page, server, "&q=circle%20after:today")
    name = "circle, k_p x 400 N/mm, k_p y 500 N/mm and 1 more"
    checkbox = page.get_by_role("checkbox", name=f"Select {name}", exact=True)
    first = page.get_by_role("row").filter(has=checkbox)
    expect(first.locator("b")).to_have_text(name.replace("_", ""))  # the p is a subscript
    expect(row(page, "rhombus, seed 7").get_by_text("trajectory circle → rhombus")).to_be_visible()
    first.click()
    button(page, "Rename…")
    page.keyboard.press("Control+a")
    page.keyboard.type("my k_p")
    page.keyboard.press("Enter")
    expect(row(page, "my k_p").locator("b")).to_have_text("my k_p")
    for run in kept:
        page.request.delete(f"{server.url}{API}/runs/{run}")


@pytest.mark.usefixtures("unopened")
def test_the_search_is_refused_in_place_and_filters_write_into_it(
    page: Page, server: Server, two: list[str], refusals: list[str]
) -> None:
    refusals.append("422")
    open_runs(page, server)
    search = page.get_by_role("textbox", name="Search")
    search.fill("kind:car")
    find = region(page, "Find runs")
    expect(find.get_by_role("alert")).to_contain_text("“kind:car” unknown. Allowed: one of")
    search.fill("stiffer")
    expect(region(page, "Runs").get_by_role("heading")).to_contain_text("Runs 1 of")
    expect(find.get_by_role("alert")).to_have_count(0)
    expect(row(page, "stiffer")).to_contain_text("k_p x".replace("_p", "p"))
    expect(row(page, "stiffer")).to_contain_text("200.3 → 312 N/mm")
    page.get_by_role("checkbox", name=re.compile("^simulated")).check()
    expect(search).to_have_value("stiffer kind:simulation")
    find.get_by_role("button", name=re.compile("^Pinned")).click()
    expect(search).to_have_value("is:pinned stiffer kind:simulation")
    button(page, "Clear the search")
    expect(search).to_have_value("")


@pytest.mark.usefixtures("unopened")
def test_several_are_changed_at_once_and_come_back(
    page: Page, server: Server, two: list[str]
) -> None:
    open_runs(page, server)
    row(page, "shipped").click()
    page.keyboard.press("Shift+ArrowDown")
    bar = region(page, "Runs").locator("footer")
    expect(bar).to_contain_text("2 selected")
    bar.get_by_role("button", name="Tag…").click()
    page.keyboard.type("No Tag")
    page.keyboard.press("Enter")
    expect(bar.get_by_role("alert")).to_contain_text("lower-case")
    page.get_by_role("textbox", name="Tag", exact=True).fill("pair")
    page.keyboard.press("Enter")
    for name in ("shipped", "stiffer"):
        expect(row(page, name).get_by_text("pair", exact=True)).to_be_visible()
    with page.expect_download() as caught:
        region(page, "Run").get_by_role("button", name="Report").click()
    assert "Differences between their scenarios" in caught.value.path().read_text()
    bar.get_by_role("button", name="Delete").click()
    expect(row(page, "shipped")).to_have_count(0)
    region(page, "Find runs").get_by_role("button", name=re.compile("^Deleted")).click()
    page.locator(f"#row-{two[1]}").click()
    page.locator(f"#row-{two[0]}").click(modifiers=["Control"])
    bar.get_by_role("button", name="Restore").click()
    expect(page.locator(f"#row-{two[0]}")).to_have_count(0)
    region(page, "Find runs").get_by_role("button", name=re.compile("^All")).click()
    expect(row(page, "stiffer")).to_be_visible()
    assert serious(page, within="main") == []


@pytest.mark.usefixtures("unopened")
def test_a_run_opens_in_the_lab_and_its_copies_give_the_same_numbers(
    page: Page, server: Server, two: list[str], tmp_path: Path
) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    open_runs(page, server, f"&run={two[0]}")
    detail = region(page, "Run")
    expect(detail.get_by_role("heading", name="stiffer")).to_be_visible()
    kept = page.request.get(f"{server.url}{API}/runs/{two[0]}").json()

    def copied(form: str) -> str:
        button(page, f"Copy as {form}")
        return page.evaluate("navigator.clipboard.readText()")

    def printed(*command: str) -> Any:
        path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
        made = subprocess.run(
            command, capture_output=True, check=True, text=True, env=os.environ | {"PATH": path}
        )
        return json.loads(made.stdout)

    expected = kept["result"]["variants"]
    assert printed(sys.executable, "-c", copied("Python")) == expected
    assert printed("sh", "-c", copied("CLI") + " --json")["variants"] == expected
    (tmp_path / "copy.toml").write_text(copied("TOML"))
    from_file = printed("motionlab", "run", str(tmp_path / "copy.toml"), "--json")
    assert from_file["variants"] == expected
    request = copied("curl")
    if shutil.which("curl"):
        assert printed("sh", "-c", request)["variants"] == expected

    button(page, "Open in Lab")
    expect(region(page, "Scenario")).to_be_visible()
    assert session(page, server)["scenario"] == kept["scenario_document"]
    button(page, "Back to Runs")
    expect(detail.get_by_role("heading", name="stiffer")).to_be_visible()


@pytest.mark.usefixtures("unopened")
def test_a_zoom_asks_for_finer_curves(page: Page, server: Server, two: list[str]) -> None:
    open_runs(page, server, f"&run={two[0]}")
    detail = region(page, "Run")
    expect(detail.get_by_role("region", name="Following error y")).to_be_visible()
    detail.get_by_role("button", name="Table").click()
    with page.expect_request(
        re.compile(r"/window\?from=\d+&to=\d+&columns=[^&]*A\.x\.following[^&]*&points=3000")
    ) as asked:
        page.get_by_role("grid").focus()
        for _ in range(4):
            page.keyboard.press("+")
    # With a margin on both sides, so that a drag finds curves there.
    first, last = (int(found) for found in re.findall(r"(?:from|to)=(\d+)", asked.value.url))
    assert 0 < first < 9843
    assert 11158 < last < 21000
    with page.expect_download() as caught:
        detail.get_by_role("link", name="CSV").click()
    with caught.value.path().open() as file:
        assert sum(1 for line in file if line[:1].isdigit()) == 11158 - 9843
    with page.expect_download() as caught:
        detail.get_by_role("link", name="Report").click()
    assert caught.value.suggested_filename == f"{two[0]}.html"
    assert "How to simulate it again" in caught.value.path().read_text()
    table = detail.get_by_role("region", name="Scopes of the run as numbers")
    expect(table.locator("tbody th").first).to_have_text("5")
    page.keyboard.press("0")
    expect(table.locator("tbody th").first).to_have_text("0")

    detail.get_by_role("button", name="Table").click()
    reversals = detail.get_by_role("region", name="Reversals")
    reversals.get_by_role("button", name="Reversals").click()
    found = page.request.get(f"{server.url}{API}/runs/{two[0]}/glitches").json()["axes"]["y"]
    reversals.get_by_role("radio", name="y", exact=True).click()
    height = 1e6 * found["variants"]["A"]["mean"]["height"]
    expect(reversals.get_by_role("heading").first).to_contain_text(f"{height:.1f} µm under A")
    assert serious(page, within='[aria-label="Reversals"]') == []
    first = found["variants"]["A"]["rows"][0]["time"]
    reversals.get_by_role("button", name=f"{first:.4f}").click()
    expect(detail.get_by_role("heading", name=f"{first - 0.05:.2f}")).to_be_visible()


def measured_lines(seconds: int = 20) -> bytes:
    """Return a following error of a rig as CSV: noise, a sine at 47.3 Hz, a resonance at 180 Hz."""
    chance = random.Random(4)
    pole = cmath.exp(complex(-0.02, 1.0) * 2 * math.pi * 180 / 2000)
    lines, before, last = ["time [s],B.x.following_error [m]"], 0.0, 0.0
    for k in range(2000 * seconds):
        ring = chance.gauss(0, 1) + 2 * pole.real * last - abs(pole) ** 2 * before
        before, last = last, ring
        sine = math.sin(2 * math.pi * 47.3 * k / 2000)
        value = 5e-8 * sine + 2e-8 * ring + 1e-7 * chance.gauss(0, 1)
        lines.append(f"{k / 2000:.4f},{value:.9e}")
    return "\n".join(lines).encode()


@pytest.mark.usefixtures("unopened")
def test_a_line_and_a_resonance_of_a_measurement_are_read_off(page: Page, server: Server) -> None:
    headers = {"content-type": "application/octet-stream"}
    address = f"{server.url}{API}/runs/import?name=rig"
    answer = page.request.post(address, data=measured_lines(), headers=headers)
    rig = answer.headers["location"].rpartition("/")[2]
    open_runs(page, server, f"&run={rig}")
    panel = region(page, "Run").get_by_role("region", name="Views", exact=True)
    panel.get_by_role("button", name="Views", exact=True).click()
    peaks = panel.get_by_role("region", name="Peaks")
    expect(peaks).to_contain_text("line")
    found = [text.split("\t")[0] for text in peaks.locator("tbody tr").all_inner_texts()]
    line, broad = (float(text) for text in found)
    assert abs(line - 47.3) < 0.25  # resolution of eight averages of 20 s
    assert abs(broad - 180.0) < 5.0
    expect(panel).to_contain_text("resolution 0.229 Hz, noise bandwidth 0.343 Hz")
    expect(panel).to_contain_text("no scenario")
    panel.get_by_label("Averages").select_option("no average")
    expect(panel).to_contain_text("resolution 0.0500 Hz")
    panel.get_by_role("radio", name="Amplitude").click()
    peaks.get_by_role("button").first.click()
    expect(panel.get_by_label("Least frequency")).to_have_value("37.84")
    panel.get_by_role("button", name="Table").click()
    table = panel.get_by_role("region", name="as numbers")
    expect(table.locator("tbody th").first).to_contain_text("37.9")
    panel.get_by_role("button", name="Table").click()
    assert serious(page, within='[aria-label="Views"]') == []
    page.request.delete(f"{server.url}{API}/runs/{rig}")


def test_a_what_if_is_kept(page: Page, server: Server) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    button(page, "Keep")
    page.get_by_role("button", name="Show it").click()
    detail = region(page, "Run")
    expect(detail).to_contain_text("simulated", timeout=LONG)
    name = page.evaluate("new URL(location.href).searchParams.get('run')")
    assert page.request.get(f"{server.url}{API}/runs/{name}").json()["scenario"] == "circle"


def test_a_recorded_session_is_overlaid_on_a_what_if_with_another_gain(
    page: Page, server: Server
) -> None:
    page.keyboard.press("Space")
    wait_for_clock(page, 1.6)
    run = session(page, server)["run"]
    page.keyboard.press("Escape")
    state(page, "stopped")
    page.keyboard.press("r")
    state(page, "paused")
    page.keyboard.press("w")
    set_field(page, "B k_p x, N/mm", "312")
    open_screen(page, "Runs")
    expect(row(page, "circle").first).not_to_contain_text("recording", timeout=LONG)
    page.locator(f"#row-{run}").click()
    page.keyboard.press("o")

    overlaid = region(page, "Overlaid runs")
    expect(overlaid).to_contain_text("200.3 N/mm, now 312")
    expect(overlaid).to_contain_text("ended at")
    offset = page.get_by_role("textbox", name=re.compile("^Offset of circle.*, s$"))
    offset.fill("5")
    offset.press("Enter")
    expect(overlaid).not_to_contain_text("ended at")
    region(page, "Scopes").get_by_role("button", name="Table").click()
    table = region(page, "Scopes as numbers")
    expect(table.locator("thead")).to_contain_text(re.compile(r"Following error x B circle"))
    heads = table.locator("thead th").all_inner_texts()
    column = next(
        i for i, text in enumerate(heads) if "Following error x B circle" in " ".join(text.split())
    )
    at_six = table.locator("tbody tr", has=page.get_by_role("rowheader", name="6", exact=True))
    answer = page.request.get(
        f"{server.url}{API}/runs/{run}/window?columns=B.x.following_error&from=2000&to=2001"
    )
    value = 1e6 * struct.unpack("<f", answer.body()[-4:])[0]
    cell = at_six.locator("th, td").nth(column)
    expect(cell).to_have_text(re.compile(r"\d"))
    assert abs(float(re.sub(r"^\W", "-", cell.inner_text()))) == pytest.approx(abs(value), abs=0.1)

    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    metrics = region(page, "Metrics of the overlaid runs")
    expect(metrics).to_contain_text("is over another window")
    cells = metrics.locator("tr", has_text="max |ex|").locator("td")
    now = simulated(page, server, k_p=312e3)[1]
    expect(cells.nth(0)).to_have_text(now)
    kept = page.request.get(f"{server.url}{API}/runs/{run}").json()["result"]["variants"]
    then = 1e6 * kept["B"]["axes"]["x"]["max_abs_following_error"]
    expect(cells.nth(1)).to_contain_text(f"{then:.3g}")
    expect(cells.nth(1)).to_contain_text(f"{100 * (float(now) / then - 1):.0f}".lstrip("-"))
    assert serious(page, within='[aria-label="Overlaid runs"]') == []


def test_overlaid_runs_stay_over_a_reload_and_are_chosen_in_a_sheet(
    page: Page, server: Server, two: list[str]
) -> None:
    page.goto(f"{page.url}&overlay={two[0]}:2")
    field = page.get_by_role("textbox", name="Offset of stiffer, s")
    expect(field).to_have_value("2", timeout=LONG)
    set_field(page, "Offset of stiffer, s", "-1.5")
    page.reload()
    expect(field).to_have_value("-1.5", timeout=LONG)
    page.keyboard.press("o")
    page.keyboard.type("no such run")
    sheet = page.get_by_role("dialog", name="Overlay runs")
    expect(sheet).to_contain_text("No run meets all of it.")
    page.get_by_role("textbox", name="Search runs").fill("scenario:circle shipped")
    sheet.get_by_role("button", name="shipped").first.click()
    metrics = region(page, "Metrics of the overlaid runs")
    expect(metrics.locator("thead th")).to_have_text(["B now", "stiffer", "shipped"])
    page.get_by_role("textbox", name="Search runs").fill("stiffer")
    listed = sheet.get_by_role("button", name="stiffer")
    expect(listed).to_have_attribute("aria-pressed", "true")
    listed.click()
    expect(field).to_have_count(0)
    page.keyboard.press("Escape")
    button(page, "Remove shipped")
    expect(region(page, "Overlaid runs")).to_have_count(0)
    assert "overlay" not in page.url


@pytest.mark.usefixtures("unopened")
def test_a_run_is_played_over_the_whole_width_with_another_behind_it(
    page: Page, server: Server, two: list[str]
) -> None:
    open_runs(page, server)
    row(page, "shipped").first.click()
    page.locator(f"#row-{two[0]}").click(modifiers=["Control"])
    page.keyboard.press("Enter")
    moment = page.get_by_role("slider", name="Moment, s")
    expect(moment).to_have_value("0", timeout=LONG)
    scopes = region(page, "Scopes of the run")
    expect(scopes).to_contain_text("stiffer")
    ex = region(page, "Following error x")
    page.keyboard.press("End")
    expect(moment).to_have_value("10.4995")
    page.keyboard.press("<")
    expect(moment).to_have_value("10.499")
    # Each press is a hundredth of 10.5 s.
    page.keyboard.press("Home")
    for _ in range(20):
        page.keyboard.press("ArrowRight")
    expect(moment).to_have_value("2.1")
    answer = page.request.get(
        f"{server.url}{API}/runs/{two[1]}/window?columns=A.x.following_error&from=4200&to=4201"
    )
    value = 1e6 * struct.unpack("<f", answer.body()[-4:])[0]
    expect(ex.locator(".value").first).to_have_text(re.compile(r"^\W?\d"))
    shown = ex.locator(".value").first.inner_text()
    assert abs(float(re.findall(r"[\d.]+", shown)[0])) == pytest.approx(abs(value), rel=0.02)
    forward = scopes.locator(".scopes section")
    page.keyboard.press("2")
    expect(forward).to_have_attribute("aria-label", "Following error y")
    page.keyboard.press("1")
    expect(forward).to_have_attribute("aria-label", "Following error x")
    for _ in range(3):
        page.keyboard.press("]")
    page.keyboard.press("Space")
    expect(moment).to_have_value("10.4995")
    expect(region(page, "Playback").get_by_role("button", name="Play", exact=True)).to_be_visible()
    assert serious(page, within="main") == []
    page.reload()
    expect(scopes).to_contain_text("stiffer", timeout=LONG)
    page.keyboard.press("Enter")
    expect(page.get_by_role("grid", name="List of runs")).to_be_visible()


def test_without_runs_the_screen_says_how_to_begin(
    browser: Browser, tmp_path_factory: pytest.TempPathFactory
) -> None:
    server = Server(tmp_path_factory.mktemp("data"))
    try:
        with browser.new_context() as context:
            page = context.new_page()
            open_runs(page, server)
            runs = region(page, "Runs")
            expect(runs).to_contain_text("No runs yet. Press Play in the Lab", timeout=LONG)
            page.close()
    finally:
        server.stop()


@pytest.mark.usefixtures("unopened")
def test_columns_are_chosen_sorted_and_bounded_by_their_histograms(
    page: Page, server: Server, two: list[str]
) -> None:
    assert len(two) == 2
    grid = open_runs(page, server)
    page.get_by_role("button", name=re.compile("^Add a column")).click()
    page.keyboard.type("k_p x")
    page.keyboard.press("Enter")
    expect(grid).to_contain_text("200.3")
    grid.get_by_role("button", name=re.compile("^max ex$")).click()
    expect(page.get_by_role("combobox", name="Order")).to_have_value("B.x.max")
    grid.get_by_role("button", name="Remove the column k_p x").press("Enter")

    page.get_by_role("slider", name="Least max e_x of B").focus()
    for _ in range(3):
        page.keyboard.press("Shift+ArrowRight")
    search = page.get_by_role("textbox", name="Search")
    expect(search).to_have_value(re.compile(r"^B\.x\.max>\d\S*um$"))


def test_margins_are_columns_and_filters(page: Page, server: Server, two: list[str]) -> None:
    grid = open_runs(page, server)
    page.get_by_role("button", name=re.compile("^Add a column")).click()
    page.keyboard.type("gain margin")
    page.keyboard.press("Enter")
    margins = {}
    for run in two:
        kept = page.request.get(f"{server.url}{API}/runs/{run}").json()
        margins[kept["name"]] = 20 * math.log10(kept["metrics"]["B.x.gain_margin"])
    for name, margin in margins.items():
        expect(row(page, name)).to_contain_text(f"{margin:.1f}")
    grid.get_by_role("button", name=re.compile("^GMx$")).click()
    expect(page.get_by_role("combobox", name="Order")).to_have_value("B.x.gain_margin")
    assert margins["stiffer"] < margins["shipped"]

    search = page.get_by_role("textbox", name="Search")
    names = "name:stiffer name:shipped"
    search.fill(names)
    expect(grid.get_by_role("row")).to_have_count(3)  # with the heads
    page.get_by_role("slider", name="Least GM_x of B").press("Shift+ArrowRight")
    expect(search).to_have_value(re.compile(rf"^{names} B\.x\.gain_margin>\d\S*dB$"))
    search.fill(f"{names} B.x.gain_margin>{sum(margins.values()) / 2:.3f}dB")
    expect(grid.get_by_role("row")).to_have_count(2)
    expect(row(page, "shipped")).to_be_visible()
    # Of a single run there is nothing to divide: its value stands in place of bars.
    search.fill("name:stiffer")
    spread = page.get_by_role("group", name="GM_x of B")
    expect(spread).to_contain_text(f"{margins['stiffer']:.1f} dB one run")
    expect(spread.get_by_role("slider")).to_have_count(0)


def test_columns_of_overlaid_runs_have_their_colour(
    page: Page, server: Server, two: list[str]
) -> None:
    three = [*two, keep(page, server, name="heavier", set={"plant.x.mass": 7.0})]
    page.goto(f"{page.url}&overlay={','.join(three)}")
    metrics = region(page, "Metrics of the overlaid runs")
    inks = [
        metrics.locator("th", has_text=name).locator("path").get_attribute("stroke", timeout=LONG)
        for name in ("stiffer", "shipped", "heavier")
    ]
    assert len(set(inks)) == 3
    region(page, "Scopes").get_by_role("button", name="Table", exact=True).click()
    for name, ink in zip(("stiffer", "shipped", "heavier"), inks, strict=True):
        head = region(page, "Scopes").locator("th", has_text=name).first
        expect(head.locator("path")).to_have_attribute("stroke", ink or "")
    page.request.delete(f"{server.url}{API}/runs/{three[2]}")
