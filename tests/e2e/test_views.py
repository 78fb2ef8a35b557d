"""Views: what the page shows of a recording equals what its downloaded samples give."""

from __future__ import annotations

import io
import json
import re
import urllib.parse

import numpy as np
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import API, LONG, lab_views, region, serious
from tests.e2e.conftest import Server

Array = NDArray[np.float64]

R = 0.015  # m, of the circle
LAP = 6000  # ticks
WINDOW = 6000  # ticks, of the metrics
PERIOD = 0.5e-3  # s
SHORT = {"trajectory.laps": 2, "trajectory.lead_in": 0.5}


def keep(page: Page, server: Server) -> str:
    body = {"scenario": "circle", "set": SHORT, "keep": True}
    return page.request.post(f"{server.url}{API}/simulate", data=body, timeout=LONG).json()["run"]


def samples(page: Page, server: Server, run: str) -> dict[str, Array]:
    """Download a run and return its columns."""
    path = f"{server.url}{API}/runs/{run}/telemetry?format=parquet"
    table = pq.read_table(io.BytesIO(page.request.get(path).body()))
    return {name: table[name].to_numpy().astype(float) for name in table.column_names}


def cells(table: Locator, row: str) -> list[str]:
    found = table.get_by_role("row").filter(
        has=table.page.get_by_role("rowheader", name=row, exact=True)
    )
    return [
        text.replace("\N{MINUS SIGN}", "-") for text in found.get_by_role("cell").all_inner_texts()
    ]


def lap(of: dict[str, Array], variant: str) -> tuple[Array, Array]:
    """Return angle and radial deviation of the last lap."""
    x, y = (
        of[f"{axis}.position_reference"][-LAP:] - of[f"{variant}.{axis}.following_error"][-LAP:]
        for axis in "xy"
    )
    return np.arctan2(y, x), np.hypot(x, y) - R


def kind(views: Locator, name: str) -> None:
    """Choose a kind of view: side by side where there is room, else from a list."""
    side = views.get_by_role("radiogroup", name="Kind of view")
    narrow = views.get_by_role("combobox", name="Kind of view")
    side.or_(narrow).wait_for()
    if narrow.count() > 0:
        narrow.select_option(name)
    else:
        side.get_by_role("radio", name=name, exact=True).click()


def contour_and_cost(views: Locator, of: dict[str, Array]) -> None:
    """Compare errors off a circle, and what its x cost, with the samples."""
    kind(views, "Contouring")
    errors = views.get_by_role("table", name="Errors", exact=True)
    errors.wait_for()
    for place, variant in enumerate("AB"):
        part = slice(-WINDOW, None)
        length = np.hypot(*(of[f"{variant}.{axis}.following_error"][part] for axis in "xy"))
        F = radial(of, variant, WINDOW)
        for name, value in {
            "contour max": np.abs(F).max(),
            "contour RMS": np.sqrt(np.mean(F**2)),
            "tracking max": length.max(),
            "tracking RMS": np.sqrt(np.mean(length**2)),
        }.items():
            shown = float(cells(errors, name)[place])
            assert shown == pytest.approx(1e6 * value, rel=6e-3, abs=6e-3), name
    top = cells(views.get_by_role("table", name="Contour peaks"), "A 1")
    assert abs(float(top[0])) == pytest.approx(float(cells(errors, "contour max")[0]), rel=6e-3)
    views.get_by_role("radio", name="Off the path").click()
    expect(views.get_by_text(re.compile(r"contour error \W [\d,]+$"))).to_be_visible()
    kind(views, "Cost")
    cost = views.get_by_role("table", name="Cost of x")
    cost.wait_for()
    peaks = []
    for place, variant in enumerate("AB"):
        currents = [of[f"{variant}.x.current_{phase}"][-WINDOW:] for phase in "abc"]
        thrust = of[f"{variant}.x.thrust"][-WINDOW:]
        copper = sum(float(np.sum(i * i)) for i in currents) * PERIOD
        peaks.append(max(np.abs(i).max() for i in currents))
        assert float(cells(cost, "copper loss")[place]) == pytest.approx(copper, rel=1e-2)
        assert float(cells(cost, "peak current")[place]) == pytest.approx(peaks[-1], rel=6e-3)
        rms = np.sqrt(np.mean(thrust**2))
        assert float(cells(cost, "RMS thrust")[place]) == pytest.approx(rms, rel=6e-3)
    change = float(cells(cost, "peak current")[2].removesuffix(" %"))
    assert change == pytest.approx(100 * (peaks[1] / peaks[0] - 1), abs=0.06)
    balance = views.get_by_role("table", name="Energy of x")
    expect(balance.get_by_role("rowheader", name="= residual")).to_be_visible()


def radial(of: dict[str, Array], variant: str, count: int) -> Array:
    """Return the radial deviation of the last samples."""
    x, y = (
        of[f"{axis}.position_reference"][-count:] - of[f"{variant}.{axis}.following_error"][-count:]
        for axis in "xy"
    )
    return np.hypot(x, y) - R


def friction_of(views: Locator, recorded: dict[str, Array]) -> None:
    """Compare the friction anatomy with the samples, and move its point by keys and pointer."""
    kind(views, "Friction")
    figures = views.get_by_role("table", name="Friction figures")
    figures.wait_for()
    for place, variant in enumerate("AB"):
        true, estimate = (
            recorded[f"{variant}.x.{name}"][-LAP:] for name in ("friction", "friction_estimate")
        )
        left = {"A": true, "B": true - estimate}[variant]
        offline = {
            "mismatch RMS": 1e3 * np.sqrt(np.mean((estimate - true) ** 2)),
            "mismatch max": 1e3 * np.abs(estimate - true).max(),
            "compensated": 100 * (1 - np.sqrt(np.mean(left**2) / np.mean(true**2))),
        }
        for name, value in offline.items():
            shown = cells(figures, name)
            assert shown[-1] == ("%" if name == "compensated" else "mN")
            assert float(shown[place]) == pytest.approx(value, rel=6e-3, abs=1e-9), name
    # One point on all plots: at the time shown, its values are those of the samples.
    views.get_by_role("slider", name="Moment").press("End")
    views.get_by_role("slider", name="Over velocity").press("ArrowLeft")
    at_moment(views, recorded)
    views.get_by_label("Plot", exact=True).select_option("Bristle over time")
    views.get_by_role("slider", name="Bristle over time").hover()
    at_moment(views, recorded)


def at_moment(views: Locator, recorded: dict[str, Array]) -> None:
    moment = views.get_by_role("slider", name="Moment").get_attribute("aria-valuetext")
    assert moment is not None
    time = float(moment.removesuffix(" s"))  # to a millisecond: two samples
    tick = round(time / 0.5e-3)
    near = slice(tick - 2, tick + 3)
    legend = views.get_by_role("list", name="Friction at the moment")
    shown = legend.get_by_role("listitem").filter(has_text="true").inner_text()
    value = float(shown.split()[-2].replace("\N{MINUS SIGN}", "-"))
    assert np.abs(recorded["B.x.friction"][near] - value).min() < 6e-3
    bristle = cells(views.get_by_role("table", name="At the moment"), "bristle z")
    assert bristle[-1] == "µm"
    assert np.abs(1e6 * recorded["B.x.bristle"][near] - float(bristle[0])).min() < 0.06


@pytest.mark.usefixtures("unopened")
def test_the_figures_of_a_ballbar_are_those_of_the_downloaded_recording(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("404")
    run = keep(page, server)
    page.goto(f"{server.url}/?screen=runs&run={run}")
    views = region(page, "Views")
    views.get_by_role("button", name="Views").click()
    kind(views, "Ballbar")
    each = views.get_by_role("table", name="Each direction")
    each.wait_for()
    recorded = samples(page, server, run)
    heads = each.get_by_role("columnheader").all_inner_texts()
    assert heads[1:] == ["A ccw", "A cw*", "B ccw", "B cw*"]
    for place, variant in ((0, "A"), (2, "B")):
        theta, F = lap(recorded, variant)
        matrix = np.stack([np.ones(LAP), np.cos(theta), np.sin(theta)], axis=1)
        left = F - matrix @ np.linalg.lstsq(matrix, F, rcond=None)[0]
        offline = {"F max": F.max(), "F min": F.min(), "G": np.ptp(left)}
        for name, value in offline.items():
            shown = cells(each, name)
            assert shown[-1] == "µm"
            # The downloaded reference is rounded by a nanometre, and figures to three digits.
            assert float(shown[place]) == pytest.approx(1e6 * value, rel=6e-3, abs=4e-3), name
    both = views.get_by_role("table", name="Both directions")
    assert float(cells(both, "G(b)")[1]) < 0.1 * float(cells(both, "G(b)")[0])
    contour_and_cost(views, recorded)
    friction_of(views, recorded)
    assert serious(page, within='[aria-label="Views"]') == []
    page.request.delete(f"{server.url}{API}/runs/{run}")


@pytest.mark.usefixtures("unopened")
def test_the_lab_has_the_ballbar_and_the_spectrum_of_what_it_shows(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("422")  # a sine is no circle
    frequency = 40.0
    sine = {"kind": "sine", "amplitude": {"x": 1e-5}, "frequency": frequency, "cycles": 80}
    settings = urllib.parse.quote(
        json.dumps({"trajectory": sine, "window": {"start": 0.4, "end": 1.9}})
    )
    page.goto(f"{server.url}/?scenario=circle&set={settings}")
    page.get_by_text("connected", exact=True).wait_for()
    page.keyboard.press("w")
    views = lab_views(page)
    kind(views, "Ballbar")
    expect(views.get_by_role("alert")).to_contain_text("s no circle")
    kind(views, "Positioning")
    for shown in ("Options", "Figures"):  # beside the plane there is room for the picture alone
        views.get_by_role("button", name=shown, exact=True).click()
    figures = views.get_by_role("table", name="Positioning figures")
    figures.wait_for()
    body = {"scenario": "circle", "axis": "x", "targets": 3, "runs": 2}
    answer = page.request.post(f"{server.url}{API}/views/positioning", data=body).json()
    for name, value in (("Targets", "3"), ("Runs", "2")):
        field = views.get_by_role("textbox", name=name, exact=True)
        field.fill(value)
        field.press("Enter")
    under = views.get_by_role("table", name="Targets under B")
    expect(under.get_by_title("2 up, 2 down")).to_have_count(3)
    for place, variant in enumerate("AB"):
        offline = answer["variants"][variant]["figures"]
        reversal = cells(figures, "B")
        scale = {"µm": 1e6, "nm": 1e9}[reversal[-1]]
        assert float(reversal[place]) == pytest.approx(scale * offline["B"], rel=6e-3)
    kind(views, "Spectrum")
    peaks = views.get_by_role("region", name="Peaks")
    line = peaks.get_by_role("row").filter(has_text="line").first
    line.wait_for()
    shown = float(line.get_by_role("rowheader").inner_text())
    assert shown == pytest.approx(frequency, abs=3.0)  # a bin of 8 averages over 1.5 s


@pytest.mark.usefixtures("unopened")
def test_a_run_and_the_what_if_side_by_side_by_a_link(page: Page, server: Server) -> None:
    run = keep(page, server)
    page.goto(
        f"{server.url}/?screen=views&pane=xy+{run}+B.x.position+B.y.position&pane2=cost+staged"
    )
    left, right = region(page, "View 1"), region(page, "View 2")
    expect(right.get_by_role("table", name="Cost of x")).to_be_visible(timeout=LONG)
    left.get_by_role("button", name="Table of Position y over position x").click()
    shown = left.get_by_role("region", name="as numbers").locator("tbody tr").first
    recorded = samples(page, server, run)
    x, y = (recorded[f"B.{axis}.position"][-WINDOW] for axis in "xy")  # where the window begins
    texts = [
        text.replace("\N{MINUS SIGN}", "-") for text in shown.locator("th, td").all_inner_texts()
    ]
    assert [float(text) for text in texts] == pytest.approx([1e3 * x, 1e3 * y], abs=6e-2)
    # Another channel by keys alone; the address has it, and back undoes it.
    before = page.url
    left.get_by_role("button", name="Y: Position y of B").press("Enter")
    page.keyboard.type("velocity y of b")
    page.keyboard.press("Enter")
    expect(page).to_have_url(re.compile(r"B\.x\.position\+B\.y\.velocity"))
    expect(
        left.get_by_role("slider", name=re.compile("^Velocity y over position x"))
    ).to_be_visible()
    page.go_back()
    expect(page).to_have_url(before)
    expect(
        left.get_by_role("slider", name=re.compile("^Position y over position x"))
    ).to_be_visible()
    assert serious(page, "main") == []
    right.get_by_role("button", name="Close view 2").click()
    expect(page).to_have_url(re.compile("pane=xy"))
    expect(page).not_to_have_url(re.compile("pane2"))
    page.request.delete(f"{server.url}{API}/runs/{run}")
