"""The Runs screen: two runs compared, one simulated again, a measurement imported."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlparse

import pyarrow as pa
import pytest
from playwright.sync_api import Locator, Page, Request, expect
from pyarrow import parquet

from motionlab.telemetry.recorder import parquet_writer
from tests.e2e.actions import (
    API,
    LONG,
    asked_for,
    button,
    region,
    serious,
    session,
    set_field,
    tab_to,
    type_number,
    until,
)
from tests.e2e.conftest import Server
from tests.e2e.test_runs import GAIN, keep, open_runs, row

ERROR = "B.x.following_error"


@pytest.fixture
def two(page: Page, server: Server, refusals: list[str]) -> Iterator[list[str]]:
    """Two kept simulations, which are gone afterwards, even while the page reads their curves."""
    refusals.append("404")
    kept = [
        keep(page, server, name="shipped"),
        keep(page, server, name="stiffer", set={GAIN: 312e3}),
    ]
    yield kept
    for run in kept:
        page.request.delete(f"{server.url}{API}/runs/{run}")


def verdict(page: Page, channel: str) -> Locator:
    name = page.get_by_role("rowheader", name=channel, exact=True)
    return region(page, "Compare").get_by_role("row").filter(has=name).locator("td").last


@pytest.mark.usefixtures("unopened")
def test_a_wider_tolerance_changes_the_verdict(
    page: Page, server: Server, two: list[str], refusals: list[str]
) -> None:
    refusals.append("422")
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    open_runs(page, server, f"&run={','.join(two)}")
    expect(region(page, "Run")).to_contain_text("2 runs selected")
    page.keyboard.press("c")
    panel = region(page, "Compare")
    headline = panel.get_by_role("status")
    told = r"Differs: ex of B by \S+ [nµ]m at \S+ s, \d of 8 channels beyond tolerance"
    expect(headline).to_contain_text(re.compile(told))
    expect(region(page, "Plane of both runs")).to_contain_text("errors \u00d7")
    expect(panel).to_contain_text("Set differently in 2: B kp x 200.3 → 312 N/mm")
    expect(verdict(page, ERROR)).to_contain_text("out of tolerance")
    expect(region(page, f"Curves of {ERROR}")).to_be_visible()

    tab_to(page, f"Absolute tolerance of {ERROR}, µm")
    type_number(page, "2")
    expect(verdict(page, ERROR)).to_contain_text("within")
    button(page, "Copy as CLI")
    command = page.evaluate("navigator.clipboard.readText()")
    assert command == (f"motionlab compare {two[0]} {two[1]} --tolerance {ERROR}=0.000002,0,0.001")
    page.reload()  # the address says all of it
    expect(verdict(page, ERROR)).to_contain_text("within")
    tolerance = page.get_by_role("radiogroup", name="Tolerance", exact=True)
    tolerance.get_by_text("own", exact=True).click()
    set_field(page, "Relative tolerance, %", "1e9")
    expect(headline).to_contain_text("Agrees within")
    added = page.get_by_role("combobox", name="Compare the channels too")
    added.fill("B.x.thrust")
    added.press("Enter")
    expect(verdict(page, "B.x.thrust")).to_contain_text("within")
    expect(headline).to_contain_text("on 9 of 9")
    panel.get_by_role("button", name=re.compile(r"^within \d+")).click()
    expect(panel.get_by_role("row").filter(has_text="out of tolerance")).to_have_count(0)

    def part(asked: Request) -> bool:
        return asked.url.endswith("/compare/window") and '"from"' in (asked.post_data or "")

    with page.expect_request(part) as asked:
        page.get_by_role("grid").focus()
        page.keyboard.press("+")
    assert json.loads(asked.value.post_data or "")["from"] > 0
    page.keyboard.press("s")
    expect(panel.locator("dd").first).to_contain_text("stiffer")
    (run,) = parse_qs(urlparse(page.url).query)["run"]
    assert run.split(",") == two[::-1]
    with page.expect_download() as caught:
        panel.get_by_role("button", name="CSV ↓").click()
    assert caught.value.path().read_text().count("\n") == 10
    assert serious(page, within="main") == []


@pytest.mark.usefixtures("unopened")
def test_a_run_that_is_recorded_is_not_compared(
    page: Page, server: Server, two: list[str], refusals: list[str]
) -> None:
    refusals.append("409")
    open_runs(page, server)
    panel = region(page, "Compare")
    name = page.evaluate("new URL(location.href).searchParams.get('session')")
    page.request.post(f"{server.url}{API}/sessions/{name}/play", data={})
    until(page, "the session is recorded", lambda: bool(session(page, server)["run"]))
    recorded = session(page, server)["run"]
    open_runs(page, server, f"&run={two[0]},{recorded}&compare=%7B%7D")
    expect(panel.get_by_role("alert")).to_contain_text("record")
    expect(panel.get_by_role("table")).to_have_count(0)


@pytest.mark.usefixtures("unopened")
def test_a_comparison_ends_before_a_stop(page: Page, server: Server, two: list[str]) -> None:
    begun = page.request.post(f"{server.url}{API}/sessions", data={})
    path = server.url + begun.headers["location"]
    page.request.post(f"{path}/step", data={"ticks": 2000})
    run = page.request.get(path).json()["run"]
    page.request.post(f"{path}/play", data={})
    page.request.post(f"{path}/stop")
    until(page, "it stands", lambda: page.request.get(path).json()["state"] == "stopped")
    page.request.delete(path)
    at = f"{server.url}{API}/runs/{run}"
    until(page, "it is a run", lambda: page.request.get(at).json()["state"] == "complete")
    open_runs(page, server, f"&run={two[0]},{run}&compare=%7B%7D")
    headline = region(page, "Compare").get_by_role("status")
    expect(headline).to_contain_text("beyond tolerance")
    button(page, "Only up to STOP")
    expect(headline).to_contain_text("Identical on 8 of 8.")
    page.get_by_role("radiogroup", name="Tolerance", exact=True).get_by_text("exact").click()
    expect(headline).to_contain_text("Identical on 108 of 108.")
    page.request.delete(at)


@pytest.mark.usefixtures("unopened")
def test_a_run_is_simulated_again_and_a_baseline_kept(
    page: Page, server: Server, two: list[str]
) -> None:
    open_runs(page, server, f"&run={two[0]}")
    detail = region(page, "Run")
    expect(detail.get_by_role("heading", name="shipped")).to_be_visible()
    expect(row(page, "shipped")).to_be_visible()
    page.keyboard.press("b")
    expect(row(page, "shipped").get_by_text("baseline", exact=True)).to_be_visible()
    expect(row(page, "stiffer")).to_contain_text("\N{MINUS SIGN}33.0")
    expect(row(page, "stiffer")).to_contain_text("200.3 → 312 N/mm")
    button(page, "Simulate again and check")
    expect(detail.get_by_role("status")).to_contain_text("bit-identical 108 channels, 21,000 ticks")

    row(page, "stiffer").click()
    expect(detail.get_by_role("heading", name="stiffer")).to_be_visible()
    first = {"tick": 700, "time": 0.35, "channel": "A.x.thrust", "unit": "N"}
    values = {"recorded": 2.0, "simulated": 2.5, "difference": 0.5}
    answer = {"identical": False, "channels": 108, "ticks": 21000, "missing": 0, "samples": 3}
    answer |= {"errors": []}
    more = {"differing": ["A.x.thrust"], "reasons": ["other processor: kept with a, is b"]}
    page.route(
        "**/replay",
        lambda route: route.fulfill(
            body=json.dumps(answer | more | {"first": first | values}),
            content_type="application/json",
        ),
    )
    button(page, "Simulate again and check")
    status = detail.get_by_role("status")
    expect(status).to_contain_text("First at tick 700, 0.35 s: A.x.thrust was 2 N, is 2.5 N")
    expect(status).to_contain_text("3 samples differ, in 1 of 108 channels.")
    expect(status).to_contain_text("other processor: kept with a, is b")

    page.keyboard.press("c")  # with the baseline, which is 1
    expect(region(page, "Compare").locator("dd").first).to_contain_text("shipped")
    button(page, "No baseline")
    expect(row(page, "stiffer")).to_contain_text("1.72")


def moved(server: Server, run: str) -> None:
    """Alter one sample of the record of a run, as another model would many."""
    (path,) = server.data.rglob(f"{run}.parquet")
    table = parquet.read_table(path)
    index = table.schema.get_field_index(ERROR)
    values = table[ERROR].to_numpy().copy()
    values[-1] = 1e-3
    table = table.set_column(index, table.schema.field(ERROR), pa.array(values))
    with parquet_writer(path, table.schema) as writer:
        writer.write_table(table, row_group_size=700)


@pytest.mark.usefixtures("unopened")
def test_runs_are_simulated_again_and_those_that_moved_are_listed(
    page: Page, server: Server, tmp_path: Path, two: list[str], refusals: list[str]
) -> None:
    refusals.append("404")
    content = Path(german(tmp_path / "rig.csv")).read_bytes()
    headers = {"content-type": "application/octet-stream"}
    address = f"{server.url}{API}/runs/import?name=rig"
    answer = page.request.post(address, data=content, headers=headers)
    rig = answer.headers["location"].rpartition("/")[2]
    for run in (*two, rig):
        page.request.patch(f"{server.url}{API}/runs/{run}", data={"tags": ["again"]})
    rows = open_runs(page, server, "&q=tag:again kind:simulation")
    expect(row(page, "shipped")).to_be_visible()
    page.keyboard.press("w")
    panel = region(page, "What changed?")
    asked_for(page, panel.get_by_role("button", name="Simulate 2 runs again").click)
    status = panel.get_by_role("status")
    expect(status).to_contain_text("None has moved: 2 runs are the same", timeout=LONG)
    expect(status).to_contain_text("runs of tag:again kind:simulation")
    expect(panel.get_by_role("table")).to_have_count(0)

    moved(server, two[1])
    page.get_by_role("textbox", name="Search").fill("tag:again")
    expect(row(page, "rig")).to_be_visible()
    expect(panel).to_contain_text("with other settings than the form shows: search")
    asked_for(page, panel.get_by_role("button", name="Simulate 3 runs again").click)
    headline = "Of 3 runs 1 has moved, 1 identical. 1 run cannot be simulated again."
    expect(status).to_contain_text(headline, timeout=LONG)
    table = panel.get_by_role("table", name="Runs that have moved")
    expect(table.locator("tbody tr")).to_have_count(1)
    largest = re.compile("B x \N{MINUS SIGN}99\\d µm *1000 µm → \\S+ µm")
    expect(table.get_by_role("row", name="stiffer")).to_contain_text(largest)
    expect(table).to_contain_text("at 10.50 s")
    refused = panel.get_by_role("table", name="Runs that were not simulated again")
    expect(refused.get_by_role("row", name="rig")).to_contain_text("has no scenario")
    assert serious(page, within="main") == []
    table.get_by_role("link", name="stiffer").press("Enter")
    expect(region(page, "Run").get_by_role("heading", name="stiffer")).to_be_visible()
    expect(panel).to_be_visible()

    page.keyboard.press("w")
    expect(panel).to_have_count(0)
    rows.focus()
    page.get_by_role("textbox", name="Search").fill("")
    page.get_by_role("button", name="What changed?").click()
    expect(panel.get_by_role("button", name=re.compile("^Simulate all"))).to_be_enabled()
    button(panel, "Show them")  # the search of the last result
    expect(page.get_by_role("textbox", name="Search")).to_have_value("tag:again")
    page.request.delete(f"{server.url}{API}/runs/{rig}")


@pytest.mark.usefixtures("unopened")
def test_a_check_of_runs_is_cancelled_and_opened_from_elsewhere(page: Page, server: Server) -> None:
    long = keep(page, server, name="long", set={"trajectory.laps": 80})
    page.request.patch(f"{server.url}{API}/runs/{long}", data={"tags": ["long"]})
    page.goto(f"{server.url}/?screen=lab")
    page.get_by_text("connected", exact=True).wait_for()
    job = page.request.post(f"{server.url}{API}/runs/replay", data={"q": "tag:long"}).json()["id"]
    page.get_by_role("button", name=re.compile("^Jobs:")).click()
    jobs = page.get_by_role("dialog", name="Jobs")
    button(jobs.get_by_role("listitem", name="Check of runs").first, "Open")
    panel = region(page, "What changed?")
    expect(page.get_by_role("textbox", name="Search")).to_have_value("tag:long")
    button(panel, "Cancel")
    expect(panel).to_contain_text("Cancelled after")
    page.request.delete(f"{server.url}{API}/jobs/{job}")
    page.request.delete(f"{server.url}{API}/runs/{long}")


def german(path: Path, *, broken: bool = False) -> str:
    """Write a measurement as a German system does: decimal commas, a gap, an unknown name."""
    rows = ["Zeit [s];Sollposition X [µm];Istposition X;Drift"]
    for i in range(400):
        if not 100 <= i < 150:
            reference = 1500 * math.sin(0.03 * i)
            fields = (i / 1000, reference, reference - 2, 3 + i / 100)
            rows.append(";".join(f"{field:.3f}" for field in fields).replace(".", ","))
    if broken:
        rows[7] = rows[7].replace(";", ";zero", 1)
    path.write_bytes("\n".join(rows).encode("cp1252"))
    return str(path)


@pytest.mark.usefixtures("unopened")
def test_a_measurement_is_compared_with_a_variant(
    page: Page, server: Server, tmp_path: Path, two: list[str]
) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    content = Path(german(tmp_path / "rig.csv")).read_bytes()
    headers = {"content-type": "application/octet-stream"}
    address = f"{server.url}{API}/runs/import?name=rig"
    answer = page.request.post(address, data=content, headers=headers)
    rig = answer.headers["location"].rpartition("/")[2]
    open_runs(page, server, f"&run={two[0]},{rig}&compare=%7B%7D")
    panel = region(page, "Compare")
    letter = panel.get_by_label("Variant M is compared with")
    expect(panel.get_by_role("group", name="Variants compared")).to_contain_text("No variant is in")
    name = "*.position_measured"
    panel.get_by_label("Compare the channels too").fill(name)
    page.keyboard.press("Enter")
    panel.get_by_role("button", name="x.position_reference ✕").click()
    expect(verdict(page, "M.x.position_measured")).to_contain_text("missing")
    letter.select_option("B")
    expect(panel.get_by_role("rowheader", name="M.x.position_measured")).to_have_count(0)
    expect(verdict(page, "B.x.position_measured")).to_contain_text("out of tolerance")
    set_field(page, "Compared to, s", "0.05")
    expect(panel.get_by_role("button", name=re.compile(r"^all 4"))).to_be_visible()
    button(page, "Copy as CLI")
    command = page.evaluate("navigator.clipboard.readText()")
    wanted = f"motionlab compare {two[0]} {rig} --to=0.05 --only '{name}' --variant M=B"
    assert command == wanted
    page.reload()  # the address says all of it
    expect(letter).to_have_value("B")
    expect(panel.get_by_label("Compared to, s")).to_have_value("0.05")
    assert serious(page, within="main") == []
    page.request.delete(f"{server.url}{API}/runs/{rig}")


def logged(path: Path, header: str, period: float, late: float, factor: float = 1.0) -> str:
    """Write a motion that does not repeat as one of two loggers has it, by a clock of its own."""
    rows = [header]
    for k in range(400):
        t = k * 0.001 + late
        rows.append(f"{k * period:.6f},{factor * math.sin(40 * t**2 + 3 * t):.6f}")
    path.write_text("\n".join(rows))
    return str(path)


@pytest.mark.usefixtures("unopened")
def test_the_time_of_a_second_file_is_named(
    page: Page, server: Server, tmp_path: Path, refusals: list[str]
) -> None:
    refusals.append("422")
    expect(open_runs(page, server)).to_be_visible()
    page.keyboard.press("i")
    sheet = page.get_by_role("dialog", name="Import a measurement")
    first = logged(tmp_path / "drive.csv", "t [s],Torque", 0.001, 0.0)
    sheet.get_by_label("File of a measurement", exact=True).set_input_files(first)
    expect(sheet.get_by_label("Channel of Torque")).to_be_visible()
    second = logged(tmp_path / "cell.csv", "Channel name,Force", 1.0, 0.004, -2.0)
    sheet.get_by_label("Second file of a measurement").set_input_files(second)
    time = sheet.get_by_role("combobox", name="its time", exact=True)
    expect(time).to_have_value("")
    expect(time.get_by_role("option").first).to_have_text("none found")
    alert = sheet.get_by_role("alert")
    expect(alert).to_contain_text("The second file has no column of time")

    time.select_option("Channel name")
    sheet.get_by_label("Unit of its time").select_option("ms")
    sheet.get_by_label("align", exact=True).fill("Torque=-Force")
    sheet.get_by_label("align", exact=True).press("Enter")
    findings = sheet.get_by_role("list", name="Findings")
    expect(findings).to_contain_text(re.compile("second file: 400 rows, offset 0.00(4|3999)"))
    expect(alert).to_have_count(0)
    # its other columns are mapped with those of the first
    sheet.get_by_label("Unit of Force").select_option("kN")
    expect(sheet.get_by_role("row", name="Force")).to_contain_text("corrected")
    assert serious(page, within="dialog") == []
    button(sheet, "Import")
    expect(region(page, "Run").get_by_role("heading", name="drive.csv")).to_be_visible()
    name = page.evaluate("new URL(location.href).searchParams.get('run')")
    kept = page.request.get(f"{server.url}{API}/runs/{name}").json()["result"]["import"]
    units = {column["name"]: column["unit"] for column in kept["columns"]}
    assert units == {"": "s", "Torque": "", "M.x.thrust": "kN"}
    page.request.delete(f"{server.url}{API}/runs/{name}")

    # without the second file nothing is left of what was said of it
    page.keyboard.press("i")
    sheet.get_by_label("File of a measurement", exact=True).set_input_files(first)
    sheet.get_by_label("Second file of a measurement").set_input_files(second)
    time.select_option("Channel name")
    button(sheet, "No second file")
    expect(sheet.get_by_role("button", name="Import", exact=True)).to_be_enabled()
    expect(alert).to_have_count(0)


@pytest.mark.usefixtures("unopened")
def test_a_german_csv_is_corrected_and_imported(
    page: Page, server: Server, tmp_path: Path, refusals: list[str]
) -> None:
    refusals += ["422", "503"]
    expect(open_runs(page, server)).to_be_visible()
    page.keyboard.press("i")
    sheet = page.get_by_role("dialog", name="Import a measurement")
    chooser = sheet.get_by_label("File of a measurement", exact=True)
    chooser.set_input_files(german(tmp_path / "bad.csv", broken=True))
    expect(sheet.get_by_role("alert")).to_contain_text(
        "Line 8, column 'Sollposition X [µm]': is no"
    )
    expect(sheet.get_by_role("button", name="Import", exact=True)).to_have_count(0)

    chooser.set_input_files(german(tmp_path / "rig.csv"))
    expect(sheet.get_by_label("Channel of Istposition X")).to_have_value("M.x.position_measured")
    expect(sheet).to_contain_text("csv, semicolon, decimal comma")
    expect(sheet).to_contain_text("line 102: 50 samples are missing, 0.099 to 0.15 s")
    sheet.get_by_label("Channel of Drift").select_option("M.x.thrust")
    sheet.get_by_label("Unit of Drift").select_option("mN")
    expect(sheet.get_by_role("row", name="Drift")).to_contain_text("corrected")
    assert serious(page, within="dialog") == []
    sheet.get_by_role("textbox", name="name", exact=True).fill("rig 7")
    sheet.get_by_role("button", name="Import", exact=True).click()

    detail = region(page, "Run")
    expect(detail.get_by_role("heading", name="rig 7")).to_be_visible()
    expect(detail).to_contain_text("Partial: 0.05 s are missing in the file")
    expect(row(page, "rig 7").get_by_text("partial", exact=True)).to_be_visible()
    expect(region(page, "Metrics of the run")).to_contain_text("2.00")
    name = page.evaluate("new URL(location.href).searchParams.get('run')")
    columns = page.request.get(f"{server.url}{API}/runs/{name}").json()["result"]["import"][
        "columns"
    ]
    (drift,) = (column for column in columns if column["column"] == "Drift")
    assert (drift["channel"], drift["unit"]) == ("M.x.thrust", "mN")

    gone = {"type": "urn:motionlab:problem:unavailable", "title": "Unavailable", "status": 503}
    gone |= {"errors": []}
    body = json.dumps(gone | {"detail": "the index cannot be reached"})
    page.route(re.compile(r"/api/v1/runs\?"), lambda route: route.fulfill(status=503, body=body))
    runs = region(page, "Runs")
    expect(runs.get_by_role("alert")).to_contain_text("The runs cannot be read: the index cannot")
    expect(row(page, "rig 7")).to_be_visible()
    page.unroute_all()
    expect(runs.get_by_role("alert")).to_have_count(0)
    page.request.delete(f"{server.url}{API}/runs/{name}")
