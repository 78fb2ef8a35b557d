"""Paths from files of other programs, and as such files, through the page."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import FilePayload, Locator, Page, expect

from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import validate_trajectory
from motionlab.trajectories.drawn_motion import curve_of
from tests.e2e.actions import API, LONG, region, set_field
from tests.e2e.conftest import Server
from tests.e2e.test_trajectories import RHOMBUS, pixels, press_until_disabled, shows

SQUARE = """G21 G90
G0 X-10 Y-15
G1 X10 F1200
G3 X15 Y-10 I0 J5
G1 Y10
G3 X10 Y15 R5
G1 X-10
G3 X-15 Y10 I0 J-5
G1 Y-10
G3 X-10 Y-15 I5 J0
"""
"""30 mm wide, corners rounded by 5 mm."""

LENGTH = 4 * 0.02 + 2 * math.pi * 0.005
SVG = '<svg xmlns="http://www.w3.org/2000/svg" width="40mm" height="40mm" viewBox="0 0 40 40">'
SVG += '<path transform="translate(10 20)" d="M 0 0 C 0 -8 16 -8 20 0 l 5 5"/></svg>'


@pytest.fixture
def address() -> str:
    return "?screen=trajectories"


@pytest.fixture
def paths(page: Page) -> Page:
    """The screen of paths."""
    expect(region(page, "Limits")).to_contain_text("feasible", timeout=LONG)
    set_field(page, "dwell, s", "0.1")  # what was changed is kept, and can be read
    return page


def sheet(page: Page) -> Locator:
    return page.get_by_role("dialog", name="Import a path")


def fact(page: Page, name: str) -> Locator:
    term = sheet(page).locator("dt", has_text=re.compile(f"^{name}$"))
    return term.locator("xpath=following-sibling::dd[1]")


def take(page: Page) -> None:
    sheet(page).get_by_role("button", name="Take", exact=True).click()
    expect(sheet(page)).to_be_hidden()


def table(page: Page) -> dict[str, Any]:
    """Return the path as the page keeps it."""
    return page.evaluate("JSON.parse(localStorage.getItem('motionlab.path'))")


def shape(tables: dict[str, Any]) -> tuple[float, np.ndarray]:
    """Return the length of a path, m, and where it runs."""
    path = validate_trajectory(tables)
    assert isinstance(path, DrawnPath)
    curve = curve_of(path)
    return curve.length, curve.path(np.linspace(0.0, curve.length * (1 - 1e-12), 801))[0]


def choose(page: Page, name: str, content: str) -> None:
    file = FilePayload(name=name, mimeType="text/plain", buffer=content.encode())
    page.get_by_label("File of a path").set_input_files([file])


def bring(page: Page, kind: str, *, name: str = "", content: str) -> None:
    """Drag a file over the page, or drop it, or paste a text."""
    page.evaluate(
        """([kind, name, content]) => {
          const data = new DataTransfer();
          if (name) data.items.add(new File([content], name));
          else data.setData('text/plain', content);
          const paste = kind === 'paste';
          const given = paste ? { clipboardData: data } : { dataTransfer: data };
          const Made = paste ? ClipboardEvent : DragEvent;
          const event = new Made(kind, { bubbles: true, cancelable: true, ...given });
          document.body.dispatchEvent(event);
        }""",
        [kind, name, content],
    )


def test_a_chosen_csv_is_shown_placed_and_taken_and_undone(paths: Page) -> None:
    before = table(paths)
    paths.get_by_role("button", name="Import…").click()
    choose(paths, "My Zigzag.csv", "time,x,y\n0,0,0\n1,20,0\n2,20,40\n")
    expect(fact(paths, "path")).to_have_text("3 points, 1 corner", timeout=LONG)
    expect(fact(paths, "timing")).to_contain_text("2.00 s a lap")
    expect(fact(paths, "extent")).to_have_text("20.0 by 40.0 mm")
    expect(sheet(paths).get_by_label("Notes")).to_contain_text("time column")
    expect(sheet(paths).get_by_role("combobox").first).to_contain_text("as found: CSV")
    sheet(paths).get_by_role("radio", name="Fitted").click()
    # 95 % of the stroke of the session's motor, 170 x 290 mm: y is what binds.
    expect(fact(paths, "extent")).to_have_text(re.compile("^138 by 27[56] mm$"), timeout=LONG)
    sheet(paths).get_by_role("radio", name="As is").click()
    expect(fact(paths, "extent")).to_have_text("20.0 by 40.0 mm", timeout=LONG)
    assert table(paths) == before
    take(paths)
    assert table(paths)["points"] == [[0.0, 0.0], [0.02, 0.0], [0.02, 0.04]]
    expect(paths.get_by_role("textbox", name="Name of the path")).to_have_value("my-zigzag")
    paths.keyboard.press("Control+z")
    expect(region(paths, "Path")).to_contain_text("4 points")
    assert table(paths) == before


def test_samples_keep_their_times_and_run_as_they_are(paths: Page, refusals: list[str]) -> None:
    refusals.append("422")
    rows = [
        (k / 100, 10 * math.sin(k / 100 * math.pi / 2) ** 4, 2 * (k / 200) ** 4) for k in range(201)
    ]
    text = "time,x,y\n" + "".join(f"{t:.2f},{x:.6f},{y:.6f}\n" for t, x, y in rows)
    bring(paths, "drop", name="planned.csv", content=text)
    expect(fact(paths, "timing")).to_contain_text("a lap", timeout=LONG)
    samples = sheet(paths).get_by_role("radio", name="Samples")
    samples.click()
    expect(fact(paths, "read")).to_have_text("201 samples over 2 s, with their times", timeout=LONG)
    expect(fact(paths, "timing")).to_have_text("of the file, from rest")
    expect(fact(paths, "extent")).to_have_text("10.0 by 2.00 mm")
    expect(sheet(paths).get_by_role("textbox", name="tolerance, µm")).to_be_hidden()
    picture = sheet(paths).get_by_role("img", name="The path that was read, on the stroke")
    expect(picture).to_be_visible()
    # Times have to rise, and there have to be some.
    box = sheet(paths).get_by_role("textbox", name="File or text")
    box.fill(text.replace("0.05,", "0.03,", 1))
    problem = sheet(paths).get_by_role("alert")
    expect(problem).to_contain_text("Line 7", timeout=LONG)
    expect(sheet(paths).get_by_role("button", name="Take", exact=True)).to_be_disabled()
    box.fill("".join(f"{x:.6f},{y:.6f}\n" for _, x, y in rows))
    samples.click()
    expect(problem).to_contain_text("has no column of time", timeout=LONG)
    box.fill(text)
    samples.click()
    expect(problem).to_be_hidden(timeout=LONG)
    take(paths)
    kept = table(paths)
    assert (kept["kind"], len(kept["time"])) == ("samples", 201)
    assert [kept["time"][-1], kept["x"][100], kept["y"][200]] == pytest.approx([2.0, 0.01, 0.002])
    expect(region(paths, "Limits")).to_contain_text("feasible", timeout=LONG)
    paths.keyboard.press("Control+z")
    expect(region(paths, "Path")).to_contain_text("4 points")


def test_a_dropped_svg_has_a_target_while_it_is_dragged(paths: Page) -> None:
    bring(paths, "dragover", name="bow.svg", content=SVG)
    target = paths.get_by_text("Drop it to import a path")
    expect(target).to_be_visible()
    bring(paths, "drop", name="bow.svg", content=SVG)
    expect(target).to_be_hidden()
    expect(fact(paths, "extent")).to_have_text("25.0 by 11.0 mm", timeout=LONG)
    take(paths)
    length, places = shape(table(paths))
    t = np.linspace(0.0, 1.0, 4001)
    bezier = np.c_[48 * t**2 * (1 - t) + 20 * t**3, 24 * t * (1 - t)]
    expected = 1e-3 * np.hypot(*np.diff(bezier, axis=0).T).sum() + 1e-3 * math.hypot(5, 5)
    assert length == pytest.approx(expected, abs=1e-5)
    assert np.ptp(places[:, 1]) == pytest.approx(0.011, abs=1e-5)


def test_words_that_are_pasted_are_written_in_strokes(paths: Page) -> None:
    bring(paths, "paste", content="Lab")
    expect(fact(paths, "read")).to_contain_text("3 characters", timeout=LONG)
    expect(fact(paths, "extent")).to_have_text("22.9 by 10.1 mm")
    set_field(paths, "height of capitals, mm", "20")
    # The bowls of round letters reach a little below the line.
    expect(fact(paths, "extent")).to_have_text("45.8 by 20.2 mm", timeout=LONG)
    take(paths)
    assert shape(table(paths))[1][:, 1].max() == pytest.approx(0.02, abs=2e-5)


def test_another_file_keeps_neither_kind_nor_name_of_the_one_before(
    paths: Page, server: Server
) -> None:
    saved = region(paths, "Saved paths")
    name = saved.get_by_role("textbox", name="Name of the path")
    bring(paths, "drop", name="bow.svg", content=SVG)
    kind = sheet(paths).get_by_role("combobox").first
    expect(kind).to_contain_text("as found: SVG", timeout=LONG)
    # Another text in the place of the file's is read as what it is.
    text = sheet(paths).get_by_role("textbox", name="File or text")
    text.fill("G21 G90 G1 X10 Y0 F600\nG1 X10 Y10\nG1 X0 Y10\n")
    expect(kind).to_contain_text("as found: G-code", timeout=LONG)
    expect(sheet(paths)).not_to_contain_text("bow.svg")
    bring(paths, "drop", name="bow.svg", content=SVG)
    expect(kind).to_contain_text("as found: SVG", timeout=LONG)
    take(paths)
    expect(name).to_have_value("bow")
    saved.get_by_role("button", name="Save").click()
    expect(paths.get_by_text("Saved as bow.")).to_be_visible(timeout=LONG)
    paths.get_by_role("button", name="Import…").click()
    choose(paths, "part.nc", "G21 G90 G1 X10 Y0 F600\nG1 X10 Y10\nG1 X0 Y10\n")
    expect(kind).to_contain_text("as found: G-code", timeout=LONG)
    take(paths)
    expect(name).to_have_value("part")
    # The name of another path is not taken unasked.
    name.fill("bow")
    saved.get_by_role("button", name="Save").click()
    expect(saved.get_by_role("alert")).to_contain_text("Another path is saved as bow", timeout=LONG)
    kept = paths.request.get(f"{server.url}{API}/trajectories/bow").json()["trajectory"]
    assert kept != table(paths)
    saved.get_by_role("button", name="Overwrite").click()
    expect(saved.get_by_role("alert")).to_be_hidden(timeout=LONG)
    saved.get_by_role("button", name="Delete the path bow").click()


def test_a_malformed_file_is_refused_with_its_line(paths: Page, refusals: list[str]) -> None:
    refusals.append("422")
    before = table(paths)
    bring(paths, "paste", content=SQUARE)
    expect(fact(paths, "timing")).to_have_text("feed 20.0 mm/s", timeout=LONG)
    box = sheet(paths).get_by_label("File or text")
    box.fill(SQUARE.replace("G3 X10 Y15 R5", "G3 X10 Y15 Q5"))
    problem = sheet(paths).get_by_role("alert")
    expect(problem).to_contain_text("Line 6", timeout=LONG)
    expect(problem).to_contain_text("G3 X10 Y15 Q5")
    expect(sheet(paths).get_by_role("button", name="Take")).to_be_disabled()
    # What was typed, what was read before it, and the path are all still there.
    expect(box).to_have_value(re.compile("Y15 Q5"))
    expect(fact(paths, "timing")).to_have_text("feed 20.0 mm/s")
    choose(paths, "empty.csv", "")
    expect(problem).to_have_text("The file is empty.")
    paths.keyboard.press("Escape")
    expect(sheet(paths)).to_be_hidden()
    assert table(paths) == before


@pytest.mark.parametrize(
    ("kind", "ending", "within"),
    [("CSV, points", "csv", 1e-5), ("SVG", "svg", 7e-6), ("G-code", "ngc", 7e-6)],
)
def test_an_exported_file_is_the_same_path_again(
    paths: Page, kind: str, ending: str, within: float
) -> None:
    bring(paths, "paste", content=SQUARE)
    expect(fact(paths, "path")).to_contain_text("corner", timeout=LONG)
    take(paths)
    paths.get_by_role("textbox", name="Name of the path").fill("square")
    before, places = shape(table(paths))
    assert before == pytest.approx(LENGTH, abs=2e-6)
    paths.get_by_role("button", name="Export").click()
    with paths.expect_download() as told:
        paths.get_by_role("menuitem", name=kind).click()
    assert told.value.suggested_filename == f"square.{ending}"
    written = Path(told.value.path()).read_text()
    paths.get_by_role("button", name="Import…").click()
    choose(paths, f"square.{ending}", written)
    expect(fact(paths, "path")).to_contain_text("corner", timeout=LONG)
    take(paths)
    after, others = shape(table(paths))
    assert after == pytest.approx(before, rel=1e-3)
    nearest = np.hypot(*(places[:, None] - others[None]).transpose(2, 0, 1)).min(axis=1)
    spacing = 0.5 * before / 800
    assert nearest.max() <= math.hypot(within, spacing) + within


def test_every_tick_is_exported(paths: Page) -> None:
    paths.get_by_role("textbox", name="Name of the path").fill("")
    paths.get_by_role("button", name="Export").click()
    with paths.expect_download() as told:
        paths.get_by_role("menuitem", name="CSV, every tick").click()
    assert told.value.suggested_filename == "path.csv"
    rows = Path(told.value.path()).read_text().splitlines()
    assert rows[0] == "t [s],x [mm],y [mm]"
    assert float(rows[2].split(",")[0]) == pytest.approx(0.0005)


def test_a_square_with_arcs_from_g_code_runs_under_a_and_b(paths: Page, server: Server) -> None:
    bring(paths, "paste", content=SQUARE)
    expect(fact(paths, "path")).to_contain_text("corner", timeout=LONG)
    take(paths)
    expect(region(paths, "Limits").get_by_role("status")).to_have_text("feasible", timeout=LONG)
    results = region(paths, "Errors of A and B")
    results.get_by_role("button", name="Send to motor").click()
    expect(region(paths, "Trajectory")).to_contain_text("drawn path", timeout=LONG)
    name = paths.evaluate("new URL(location.href).searchParams.get('session')")
    api = f"{server.url}{API}/sessions/{name}"
    assert paths.request.post(f"{api}/step", data={"ticks": 4000}).ok
    variants = paths.request.get(f"{api}/metrics").json()["variants"]
    for variant in ("A", "B"):
        for axis in ("x", "y"):
            error = variants[variant]["axes"][axis]["max_abs_following_error"]
            assert 1e-9 < error < 1e-3, (variant, axis, error)


def at(page: Page, x: float, y: float) -> None:
    page.mouse.move(*pixels(page, x, y))


def test_a_path_is_drawn_by_hand(paths: Page) -> None:
    before = table(paths)
    paths.get_by_role("radio", name="Draw", exact=True).click()
    at(paths, 0.04, 0.0)
    paths.mouse.down()
    for k in range(1, 61):
        angle = 2 * math.pi * k / 60
        at(paths, 0.04 * math.cos(angle), 0.04 * math.sin(angle))
    paths.mouse.up()
    found = table(paths)
    assert found["closed"]
    assert 8 <= len(found["points"]) <= 60
    assert shape(found)[0] == pytest.approx(2 * math.pi * 0.04, rel=0.02)
    paths.keyboard.press("Control+z")
    assert table(paths) == before


def test_several_points_are_selected_and_changed_together(paths: Page) -> None:
    paths.get_by_role("application").focus()
    at(paths, -0.04, 0.01)
    paths.keyboard.down("Shift")
    paths.mouse.down()
    at(paths, 0.04, -0.01)
    paths.mouse.up()
    strip = paths.get_by_role("toolbar", name="Selected points")
    expect(strip).to_contain_text("2 points")
    paths.mouse.click(*pixels(paths, 0.0, 0.03))
    paths.keyboard.up("Shift")
    expect(strip).to_contain_text("3 points")
    set_field(paths, "width, mm", "100")
    assert table(paths)["points"] == [[0.05, 0.0], [0.0, 0.03], [-0.05, 0.0], [0.0, -0.03]]
    paths.get_by_role("application").focus()
    paths.keyboard.press("Control+a")
    expect(strip).to_contain_text("4 points")
    paths.keyboard.press("ArrowRight")
    strip.get_by_role("button", name="Rotate").click()
    assert table(paths)["points"] == [[0.001, 0.05], [-0.029, 0.0], [0.001, -0.05], [0.031, 0.0]]
    strip.get_by_role("button", name="Mirror x").click()
    strip.get_by_label("Align").select_option("bottom")
    assert [y for _, y in table(paths)["points"]] == [-0.05] * 4
    press_until_disabled(paths, "Control+z", "Undo")
    shows(paths, RHOMBUS)
    paths.get_by_role("application").focus()
    paths.keyboard.press("Control+a")
    paths.keyboard.press("[")
    paths.keyboard.press("Delete")
    assert table(paths)["points"] == [[0.0, -0.03]]
