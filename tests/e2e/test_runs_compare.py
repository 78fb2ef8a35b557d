"""The Runs screen: two runs compared, one simulated again, a measurement imported."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator
from pathlib import Path
from urllib.parse import parse_qs, urlparse

import pytest
from playwright.sync_api import Locator, Page, Request, expect

from tests.e2e.actions import (
    API,
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
