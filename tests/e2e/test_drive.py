"""The circle on a virtual drive from the Lab: A, then B; without control one is refused."""

from __future__ import annotations

import re
import time
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from playwright.sync_api import Browser, Page, expect

from motionlab.drive.virtual.process import VirtualDrive
from tests.drive.link.rig import SLOW
from tests.e2e.actions import API, LONG, button, region, serious, until
from tests.e2e.conftest import PATIENCE, ROOT, START, Server

pytestmark = pytest.mark.realtime

SHORT = {
    "trajectory.radius": 0.002,
    "trajectory.frequency": 2.0,
    "trajectory.laps": 1,
    "trajectory.lead_in": 0.25,
}
RUN = "Run A, then B on the drive"


@pytest.fixture(scope="module")
def virtual() -> Iterator[VirtualDrive]:
    with VirtualDrive(priority=70, slow=SLOW) as drive:
        yield drive


@pytest.fixture(scope="module")
def server(virtual: VirtualDrive, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server that is linked to a virtual drive."""
    folder = tmp_path_factory.mktemp("data")
    text = (ROOT / "configs" / "drives" / "virtual.toml").read_text()
    file = folder / "drive.toml"
    file.write_text(text.replace("port = 34980", f"port = {virtual.port}\nslow = {SLOW}"))
    server = Server(folder, "--drive", str(file))
    yield server
    server.stop()


@pytest.fixture(autouse=True)
def _ready(server: Server) -> None:
    """Begin with drives that are ready, whatever became of them in the test before."""
    bring_up(f"{server.url}{API}/drive")


def bring_up(calls: str) -> None:
    """Wait until the drives are operational: the loop may have to be compiled."""
    end = time.monotonic() + 2 * START  # on a machine that has other work, compiling takes minutes
    while not is_up(status := httpx.get(calls, timeout=START).json()):
        assert time.monotonic() < end, status
        if status["problem"] or status["fault"]:
            lease = httpx.post(f"{calls}/lease", json={"holder": "test"}).json().get("lease", "")
            httpx.post(f"{calls}/reset", headers={"Lease": lease})
            httpx.delete(f"{calls}/lease", headers={"Lease": lease})
        time.sleep(1.0)


def is_up(status: dict[str, Any]) -> bool:
    return status["state"] == "ready" and status["loop"]["phase_locked"]


def drive(page: Page, server: Server) -> dict[str, Any]:
    return page.request.get(f"{server.url}{API}/drive").json()


def reaches(page: Page, server: Server, state: str) -> None:
    """Wait for a state of the drives."""
    until(page, f"the drives are {state}", lambda: drive(page, server)["state"] == state)


def open_short_circle(page: Page, server: Server, laps: int = 1) -> None:
    """Open the Lab on a circle that drives have done with soon, and choose the drive."""
    body = {"scenario": "circle", "set": SHORT | {"trajectory.laps": laps}}
    made = page.request.post(f"{server.url}{API}/sessions", data=body).json()
    page.goto(f"{server.url}?session={made['id']}")
    page.get_by_text("connected", exact=True).wait_for()
    machine = region(page, "Scenario").get_by_role("radiogroup", name="Runs on")
    machine.get_by_role("radio", name="Drive").click()


def arm(page: Page, server: Server) -> None:
    """Arm the drives on the Drive screen, and go back to the Lab."""
    page.get_by_role("navigation").get_by_role("link", name="Drive").click()
    begin = page.get_by_role("button", name="Arm…")
    expect(begin).to_be_enabled()
    begin.click()
    question = page.get_by_role("alertdialog")
    question.get_by_role("checkbox").check()
    question.get_by_role("button", name="Arm", exact=True).click()
    reaches(page, server, "holding")
    page.get_by_role("navigation").get_by_role("link", name="Lab").click()


def run_with_a_reload(page: Page, server: Server) -> None:
    """Run A, load the page anew meanwhile, and run B, which is left."""
    scenario = region(page, "Scenario")
    page.get_by_role("button", name=RUN).click()
    expect(page.get_by_role("button", name="A moves")).to_be_visible()
    reaches(page, server, "moving")
    page.reload()
    rest = page.get_by_role("button", name="Run B on the drive")
    expect(rest).to_be_enabled()
    expect(scenario).to_contain_text("A is done, B left.")
    rest.click()
    expect(page.get_by_role("button", name="B moves")).to_be_visible()


def kept(page: Page, server: Server) -> list[dict[str, Any]]:
    """Return the runs of drives."""
    return page.request.get(f"{server.url}{API}/runs?q=kind:drive").json()["runs"]


def test_a_then_b_and_a_stop_by_somebody_else(
    page: Page, server: Server, browser: Browser, refusals: list[str]
) -> None:
    refusals.append("409")
    open_short_circle(page, server)
    scenario = region(page, "Scenario")
    expect(page.get_by_role("button", name=RUN)).to_be_disabled()
    expect(scenario).to_contain_text("Take control of the drives first.")
    expect(scenario).to_contain_text("A and B run one after the other")
    scenario.get_by_role("link", name="Drive screen").click()
    page.get_by_role("button", name="Take control").click()
    arm(page, server)

    run_with_a_reload(page, server)
    overlaid = region(page, "Overlaid runs")
    expect(overlaid).to_contain_text("circle A on Virtual drive")
    expect(page.get_by_role("button", name=RUN)).to_be_enabled()
    metrics = region(page, "Metrics")
    expect(metrics).to_contain_text("Not measured on drives")
    first = metrics.get_by_role("table").first.get_by_role("row").filter(has_text="max |e")
    a, b = (float(cell) for cell in first.first.get_by_role("cell").all_inner_texts()[:2])
    assert 0.0 < b < a < 100.0  # um

    until(
        page,
        "both runs are complete",
        lambda: "recording" not in {run["state"] for run in kept(page, server)},
    )
    runs = kept(page, server)
    names = {"circle A on Virtual drive", "circle B on Virtual drive"}
    assert {run["name"].partition(",")[0] for run in runs} == names
    assert {run["state"] for run in runs} == {"complete"}

    other = browser.new_context(viewport={"width": 1440, "height": 900})
    try:
        second = other.new_page()
        second.set_default_timeout(PATIENCE)
        open_short_circle(second, server, laps=30)
        theirs = region(second, "Scenario")
        expect(second.get_by_role("button", name=RUN)).to_be_disabled()
        expect(theirs).to_contain_text("controls the drives.")
        body = {"scenario": "circle", "variant": "A"}
        refused = second.request.post(
            f"{server.url}{API}/drive/motions", data=body, headers={"Lease": "none"}
        )
        assert refused.status == 409
        page.get_by_role("button", name=RUN).click()
        reaches(page, server, "moving")
        second.get_by_role("button", name="STOP", exact=True).click()
        reaches(page, server, "ready")
    finally:
        other.close()
    expect(page.get_by_role("button", name=RUN)).to_be_disabled()
    expect(scenario).to_contain_text("Arm the drives first.")
    page.get_by_role("navigation").get_by_role("link", name="Runs").click()
    for name in names:
        expect(page.get_by_text(name).first).to_be_visible()


def test_a_run_on_drives_against_its_simulation(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("409")  # a heartbeat on its way while control is given up
    body = {"scenario": "circle", "set": SHORT | {"trajectory.laps": 2}, "variant": "B"}
    calls = f"{server.url}{API}/drive"
    page.goto(f"{server.url}?screen=drive")
    control = region(page, "Control")
    control.get_by_label("Take it as").fill("Mara")
    button(page, "Take control")
    expect(control).to_contain_text("as Mara")
    arm(page, server)
    lease = page.evaluate("sessionStorage.getItem('motionlab.lease')")
    earlier = {run["id"] for run in kept(page, server)}
    begun = page.request.post(f"{calls}/motions", data=body, headers={"Lease": lease})
    assert begun.status == 201, begun.text()
    until(
        page,
        "the run is complete",
        lambda: any(
            run["state"] == "complete" and run["id"] not in earlier for run in kept(page, server)
        ),
    )
    page.get_by_role("navigation").get_by_role("link", name="Drive").click()
    judged = region(page, "Simulation against drive")
    simulations = f"{server.url}{API}/runs?q=kind:simulation"
    before = page.request.get(simulations).json()["total"]
    judged.get_by_role("button", name="Simulate and compare").click()
    verdict = judged.get_by_role("status")
    expect(verdict).to_have_text(
        re.compile(r"(Agrees|Differs).* 8( channels beyond tolerance)?\.$")
    )
    for axis in "xy":
        error = judged.get_by_role("img", name=f"B.{axis}.following_error of both runs")
        expect(error).to_be_visible()
    expect(judged.get_by_role("table")).to_be_hidden()
    judged.get_by_text("Channels that matter").click()
    expect(judged.get_by_role("table").get_by_role("row")).to_have_count(1 + 8)
    judged.get_by_role("button", name="B.x.current_a").click()
    expect(judged.get_by_role("img", name="B.x.current_a of both runs")).to_be_visible()
    assert page.request.get(simulations).json()["total"] == before + 1

    # Another browser has the same verdict without another simulation.
    sentence = verdict.inner_text()
    page.reload()
    expect(verdict).to_have_text(sentence)
    assert page.request.get(simulations).json()["total"] == before + 1
    judged.get_by_role("link", name="Open in Compare").click()
    compare = region(page, "Compare")
    expect(compare.get_by_role("status")).to_have_text(sentence)
    expect(compare).to_contain_text("simulated")
    expect(compare.get_by_label("Compared from, s")).to_have_value("0.75")
    page.get_by_role("navigation").get_by_role("link", name="Drive").click()
    button(page, "Disarm")
    button(page, "Give up")


SHAKEN = {
    "kind": "multisine",
    "axis": "x",
    "velocity": 0.0288,
    "acceleration": 0.1,
    "low": 2.0,
    "slides": 9,
}
"""Nine slides of two seconds; five of them are to be without a late cycle."""


def shake(page: Page, server: Server, lease: str, changes: dict[str, Any]) -> str:
    """Move the drives under a multisine; return the run."""
    earlier = {run["id"] for run in kept(page, server)}
    body = {"scenario": "circle", "set": {"trajectory": SHAKEN} | changes, "variant": "A"}
    begun = page.request.post(
        f"{server.url}{API}/drive/motions", data=body, headers={"Lease": lease}
    )
    assert begun.status == 201, begun.text()

    def complete() -> list[str]:
        runs = kept(page, server)
        return [
            run["id"] for run in runs if run["state"] == "complete" and run["id"] not in earlier
        ]

    until(page, "the run is complete", lambda: bool(complete()), most=240_000)
    return complete()[0]


def choose_newest(page: Page, of: str) -> None:
    """Choose the newest run of drives."""
    region(page, "Shape on a measurement").get_by_role("button", name=of).click()
    page.get_by_role("combobox", name=f"Find: {of}").fill("kind:drive")
    page.get_by_role("option", name=re.compile("Virtual drive")).first.click()


def test_a_loop_is_shaped_on_drives_and_checked_by_a_second_run(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("409")  # a heartbeat on its way while control is given up
    page.goto(f"{server.url}?screen=drive")
    button(page, "Take control")
    arm(page, server)
    lease = page.evaluate("sessionStorage.getItem('motionlab.lease')")
    first = shake(page, server, lease, {})

    page.goto(f"{server.url}/?screen=tune")
    page.get_by_role("combobox", name="gains of").select_option("A")
    choose_newest(page, "Measured on")
    shape = region(page, "Shape on a measurement")
    button(shape, "Shape")
    expect(shape).to_contain_text("Not checked yet", timeout=LONG)
    expect(shape.get_by_role("row", name="GM up")).to_contain_text(" to ")
    report = page.request.get(f"{server.url}{API}/jobs?kind=shape").json()[0]
    job = page.request.get(f"{server.url}{API}/jobs/{report['id']}").json()
    changes = job["result"]["changes"]
    assert changes
    assert job["result"]["response"]["run"] == first

    shake(page, server, lease, changes)
    choose_newest(page, "Checked by")
    button(shape, "Shape")
    expect(shape).to_contain_text("a second measurement keeps the margins", timeout=LONG)
    assert serious(page) == []
