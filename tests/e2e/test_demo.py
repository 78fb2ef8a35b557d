"""The lab as a static folder: opened from a path of a file server, with no lab behind it."""

from __future__ import annotations

import functools
import gzip
import http.server
import json
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, expect

from motionlab.analysis.views.ballbar import ballbar
from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.loop.document import loop_document
from motionlab.simulation.prepare import prepare
from motionlab.simulation.recorded import of_scenario
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.studies.why.study import WhyStudy
from tests.e2e.actions import (
    ANSWERS,
    DRAFT,
    LONG,
    MAX,
    RMS,
    choose_scenario,
    controller,
    lab_views,
    region,
    set_field,
)
from tests.e2e.conftest import VIEW, missing
from tests.e2e.test_trajectories import drag
from tests.paths import ROOT

COUNT = 50e-9
"""One count of the encoder, m."""
FIRST_LOAD = 500_000
"""Bytes, compressed: all that a first A and B takes."""


class Files(http.server.SimpleHTTPRequestHandler):
    """The handler of `python -m http.server`, without its log."""

    def log_message(self, format: str, *args: Any) -> None:
        """Write nothing."""


class Host:
    """A static host on a port of its own."""

    def __init__(self, folder: Path, files: type[Files] = Files) -> None:
        handler = functools.partial(files, directory=str(folder))
        self._server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler)
        self.url = f"http://127.0.0.1:{self._server.server_port}"
        self._thread = threading.Thread(target=self._server.serve_forever)
        self._thread.start()

    def stop(self) -> None:
        self._server.shutdown()
        self._thread.join()
        self._server.server_close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a host; the demo lies two levels below it."""
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        missing("the page is not built: frontend/npm run build")
    folder = tmp_path_factory.mktemp("host")
    command = [sys.executable, "-m", "motionlab", "demo", str(folder / "people" / "lab")]
    subprocess.run(command, check=True)
    return folder


@pytest.fixture
def host(folder: Path) -> Iterator[Host]:
    host = Host(folder)
    yield host
    host.stop()


@pytest.fixture
def demo(browser: Browser) -> Iterator[Page]:
    """An empty page; an error on its console fails the test."""
    page = browser.new_context(viewport=VIEW).new_page()
    complaints: list[str] = []
    page.on("console", lambda each: complaints.append(each.text) if each.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.add_init_script(ANSWERS)
    yield page
    page.context.close()
    assert complaints == []


def opened(page: Page, host: Host, address: str = "") -> None:
    page.goto(f"{host.url}/people/lab/{address}")
    computed(page)


def computed(page: Page) -> None:
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)


def previewed(page: Page, variant: str) -> dict[str, Any]:
    return page.evaluate(f"window.answers['{variant}']")["windows"][0]["axes"]


def metrics_of(scenario: str, changes: dict[str, Any], variant: str) -> dict[str, Any]:
    tables = load_scenario(scenario).model_dump(mode="json")
    prepared = prepare(validate(apply_changes(tables, changes)))
    return document(prepared, run(prepared))["variants"][variant]["axes"]


def agree(axes: dict[str, Any], scenario: str, changes: dict[str, Any], variant: str) -> None:
    """Check the metrics of the page against those of the compiled kernel here."""
    for axis, metrics in metrics_of(scenario, changes, variant).items():
        for name in (MAX, RMS, "max_abs_position_error"):
            assert abs(axes[axis][name] - metrics[name]) <= COUNT, (axis, name)


def test_margins_are_the_servers(demo: Page, host: Host) -> None:
    opened(demo, host)
    set_field(demo, "B k_p x, N/mm", "300")
    computed(demo)
    loops = loop_document(load_scenario("circle", {"variants.B.controller.x.k_p": 3e5}))
    for variant, axis in (("B", "x"), ("A", "y")):
        if variant == "A":
            controller(demo, "A")
        worst = loops.variants[variant].axes[axis].worst
        assert worst.Ms is not None
        line = demo.get_by_role("group", name=f"{variant} {axis} margins")
        expect(line).to_contain_text(f"{worst.Ms.value:.2f}")


def test_a_gain_is_dragged_and_the_metrics_are_the_servers(
    demo: Page, host: Host, folder: Path
) -> None:
    urls: list[str] = []

    demo.on("request", lambda request: urls.append(request.url))
    demo.goto(f"{host.url}/people/lab/")
    demo.wait_for_function("() => window.answers.A && window.answers.B", timeout=LONG)
    loaded = urls.copy()
    computed(demo)
    files = {url.removeprefix(host.url).lstrip("/").partition("?")[0] for url in loaded}
    paths = [folder / (f"{name}index.html" if name.endswith("/") else name) for name in files]
    assert 0 < sum(len(gzip.compress(path.read_bytes())) for path in paths) < FIRST_LOAD
    agree(previewed(demo, "B"), "circle", {}, "B")

    gain = demo.get_by_role("slider", name="B k_p x", exact=True)
    gain.focus()
    for _ in range(5):
        gain.press("ArrowRight")
    expect(demo.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    shown = demo.get_by_role("textbox", name="B k_p x, N/mm").input_value()
    value = demo.evaluate(DRAFT)
    assert float(f"{1e-3 * value['variants.B.controller.x.k_p']:.4g}") == float(shown) != 200.3
    demo.wait_for_timeout(500)
    computed(demo)
    agree(previewed(demo, "B"), "circle", value, "B")


def test_plant_law_and_scenario_change_without_a_server(demo: Page, host: Host) -> None:
    opened(demo, host)
    set_field(demo, "stiction F_s x, N", "5")
    controller(demo, "A")
    demo.get_by_role("combobox", name="A compensation law").select_option("residual-k")
    demo.wait_for_timeout(500)
    computed(demo)
    changes = {"plant.x.friction.F_s": 5.0, "variants.A.controller.compensation.law": "residual-k"}
    agree(previewed(demo, "A"), "circle", changes, "A")
    choose_scenario(demo, "rhombus")
    demo.wait_for_timeout(500)
    computed(demo)
    agree(previewed(demo, "B"), "rhombus", {}, "B")


def test_another_circle_is_sampled_in_the_page(demo: Page, host: Host) -> None:
    opened(demo, host)
    set_field(demo, "frequency, Hz", "0.7")
    set_field(demo, "radius, mm", "12")
    demo.wait_for_timeout(500)
    computed(demo)
    changes = {"trajectory.frequency": 0.7, "trajectory.radius": 0.012}
    agree(previewed(demo, "B"), "circle", changes, "B")
    set_field(demo, "radius, mm", "200")
    problem = demo.get_by_text("position of x exceeds the motor's", exact=False)
    expect(problem.first).to_be_visible()
    agree(previewed(demo, "B"), "circle", changes, "B")


def test_other_motions_are_sampled_in_the_page(demo: Page, host: Host) -> None:
    opened(demo, host)
    for scenario, label, shown, path, value in (
        ("rhombus", "frequency, Hz", "0.5", "frequency", 0.5),
        ("stair-y-50mm", "max speed, mm/s", "120", "v_max", 0.12),
    ):
        choose_scenario(demo, scenario)
        demo.wait_for_timeout(500)
        computed(demo)
        before = demo.evaluate("window.answers.B.windows[0]")
        set_field(demo, label, shown)
        demo.wait_for_function("(old) => window.answers.B.windows[0] !== old", arg=before)
        demo.wait_for_timeout(500)
        computed(demo)
        agree(previewed(demo, "B"), scenario, {f"trajectory.{path}": value}, "B")


def test_ballbar_and_spectrum_are_of_what_is_shown(demo: Page, host: Host) -> None:
    opened(demo, host)
    lab_views(demo)
    set_field(demo, "stiction F_s x, N", "5")
    region(demo, "Views").get_by_role("button", name="Figures", exact=True).click()
    row = demo.get_by_role("table", name="Each direction").get_by_role("row", name="F max")
    changes = {"plant.x.friction.F_s": 5.0}
    prepared = prepare(load_scenario("circle", changes))
    variants = ballbar(of_scenario(prepared, None, None, window=False)).variants
    exact = [variants[variant].directions[way].F_max for variant in "AB" for way in ("ccw", "cw")]
    expect(row.get_by_role("cell").first).to_have_text(f"{1e6 * exact[0]:.1f}", timeout=LONG)
    shown = [float(text) for text in row.get_by_role("cell").all_inner_texts()[:4]]
    assert shown == pytest.approx([1e6 * each for each in exact], rel=0.005)

    kinds = region(demo, "Views").get_by_role("combobox", name="Kind of view")
    kinds.select_option("Spectrum")
    rms = previewed(demo, "A")["x"][RMS]
    expect(demo.get_by_text(re.compile(r"^A: RMS"))).to_contain_text(
        f"4.500 to 10.50 s, resolution {1 / 1.296:.3g} Hz"
    )
    text = demo.get_by_text(re.compile(r"^A: RMS")).inner_text()
    assert float(text.split()[2]) == pytest.approx(1e6 * rms, rel=0.005)  # its mean is 0
    kinds.select_option("Cost")
    expect(demo.get_by_role("alert")).to_contain_text("motionlab serve")


def test_a_path_is_drawn_checked_and_run_by_a_and_b(demo: Page, host: Host) -> None:
    demo.goto(f"{host.url}/people/lab/?screen=trajectories")
    limits = region(demo, "Limits")
    results = region(demo, "Errors of A and B")
    expect(results).to_contain_text("exact", timeout=LONG)
    expect(limits).to_contain_text("motionlab serve")
    strips = region(demo, "Profiles").locator("canvas")
    before = strips.evaluate("canvas => canvas.toDataURL()")
    drag(demo, (0.03, 0.0), (0.095, 0.01))
    expect(limits.get_by_role("listitem").first).to_contain_text("x leaves the stroke")
    demo.wait_for_function(
        "([canvas, before]) => canvas.toDataURL() !== before",
        arg=[strips.element_handle(), before],
    )
    demo.get_by_role("button", name="Undo").click()
    demo.get_by_role("radio", name="Smooth", exact=True).click()
    drag(demo, (0.03, 0.0), (0.04, 0.01))
    expect(limits.get_by_role("status")).to_have_text("feasible")
    expect(results).to_contain_text("exact", timeout=LONG)
    region(demo, "Saved paths").get_by_role("textbox", name="Name of the path").fill("bow")
    demo.get_by_role("button", name="Save", exact=True).click()
    demo.wait_for_function("localStorage['motionlab.demo-paths']")
    expect(region(demo, "Saved paths")).to_contain_text("bow")
    table = json.loads(demo.evaluate("localStorage['motionlab.demo-paths']"))["bow"]
    assert table["points"][0] == [0.04, 0.01]
    results.get_by_role("button", name="Stage in Lab").click()
    demo.wait_for_timeout(500)
    computed(demo)
    agree(previewed(demo, "A"), "circle", {"trajectory": table}, "A")
    agree(previewed(demo, "B"), "circle", {"trajectory": table}, "B")


def test_what_a_path_needs_a_server_for_says_so(demo: Page, host: Host) -> None:
    demo.goto(f"{host.url}/people/lab/?screen=trajectories")
    cost = demo.get_by_role("group", name="Cost of the retiming")
    expect(region(demo, "Errors of A and B")).to_contain_text("exact", timeout=LONG)
    demo.evaluate("navigator.serviceWorker.ready.then((worker) => worker.active.state)")
    demo.get_by_role("combobox", name="Motion profile").select_option("time_optimal")
    expect(cost.get_by_role("alert")).to_contain_text("motionlab serve")
    expect(demo.get_by_role("button", name="Send to motor")).to_be_disabled()


def test_a_range_is_that_of_the_kind_of_motion(demo: Page, host: Host) -> None:
    demo.goto(f"{host.url}/people/lab/?screen=trajectories")
    expect(region(demo, "Errors of A and B")).to_contain_text("exact", timeout=LONG)
    set_field(demo, "laps", "1000000")
    expect(region(demo, "Limits")).to_contain_text("1 to 1000")


def test_a_link_to_a_scenario_that_it_has_not_says_so(browser: Browser, host: Host) -> None:
    page = browser.new_context(viewport=VIEW).new_page()
    page.goto(f"{host.url}/people/lab/?scenario=zzz")
    expect(page.locator("body")).to_contain_text("This demo has no scenario zzz", timeout=LONG)
    page.context.close()


@pytest.mark.parametrize("name", ["answers.bin", "circle.bin", "lanes-*.js"])
def test_a_file_that_is_not_there_is_named(browser: Browser, host: Host, name: str) -> None:
    page = browser.new_context(viewport=VIEW, service_workers="block").new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.route(f"**/{name}", lambda route: route.fulfill(status=404))
    page.goto(f"{host.url}/people/lab/")
    named = name.replace("-*", "")
    expect(page.locator("body")).to_contain_text(f"{named} cannot be read", timeout=LONG)
    assert complaints == []
    page.context.close()


def test_it_opens_again_without_a_network(demo: Page, host: Host) -> None:
    opened(demo, host)
    demo.evaluate("navigator.serviceWorker.ready.then((worker) => worker.active.state)")
    host.stop()
    demo.reload()
    computed(demo)
    choose_scenario(demo, "stair-x-500nm")
    demo.wait_for_timeout(500)
    computed(demo)


@pytest.mark.parametrize(
    ("scenario", "label", "shown", "changes"),
    [
        ("circle", "stiction F_s x, N", "5", {"plant.x.friction.F_s": 5.0}),
        ("fig5", None, None, {}),
    ],
)
def test_why_names_the_causes_that_the_server_finds(
    demo: Page, host: Host, scenario: str, label: str | None, shown: str, changes: dict[str, Any]
) -> None:
    opened(demo, host)
    choose_scenario(demo, scenario)
    if label:
        set_field(demo, label, shown)
    demo.wait_for_timeout(500)
    computed(demo)
    study = WhyStudy()
    exact = study.run(
        study.plan({"scenario": scenario, "set": changes, "variant": "B"}), lambda *_: None
    )
    region(demo, "Result").get_by_role("button", name="Why?").click()
    sheet = demo.get_by_role("dialog", name="Why?")
    question = f"Why does B err by {1e6 * exact.peak:.3g}"
    expect(sheet.get_by_role("status")).to_contain_text(question, timeout=LONG)
    rows = sheet.get_by_role("row").filter(has=demo.get_by_role("rowheader")).all()
    causes = {row.get_by_role("rowheader").inner_text(): row for row in rows}
    # By error, the smallest first; of causes within a count of one another either comes first.
    assert set(causes) == {each.label for each in exact.causes}
    errors = {
        name: float(row.get_by_role("cell").nth(0).inner_text()) for name, row in causes.items()
    }
    assert list(errors.values()) == sorted(errors.values())
    for each in exact.causes:
        assert each.error is not None
        assert abs(1e-6 * errors[each.label] - each.error) <= max(COUNT, 0.005 * each.error)
    absent = ", ".join(each.label for each in exact.absent)
    expect(sheet).to_contain_text(f"Not there: {absent}.")
    expect(sheet).to_contain_text("motionlab serve")


def test_the_machine_and_the_tour_go_as_far_as_a_demo_goes(demo: Page, host: Host) -> None:
    opened(demo, host)
    expect(region(demo, "Second view").locator("p")).to_contain_text("pull", timeout=LONG)
    demo.get_by_role("button", name="Take the tour, five steps").click()
    tour = demo.get_by_role("complementary", name="Tour")
    show = tour.get_by_role("button", name="Show me")
    for _ in range(3):
        expect(show).to_be_enabled()
        tour.get_by_role("button", name="Next").click()
    show.click()
    expect(region(demo, "Path")).to_contain_text("5 points", timeout=LONG)
    tour.get_by_role("button", name="Next").click()
    expect(tour).to_contain_text("This needs a server")
    expect(show).to_be_disabled()
