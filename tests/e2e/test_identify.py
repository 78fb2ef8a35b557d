"""What a person does on the screen that identifies friction, in a real browser."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from motionlab.config.load import load_scenario
from motionlab.drive.motion import on_drives
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run as simulation
from tests.e2e.actions import (
    API,
    LONG,
    asked_for,
    region,
    serious,
    session,
    set_field,
    shipped_only,
    tab_to,
    until,
)
from tests.e2e.conftest import Server
from tests.studies.identify.measured_runs import FRICTION, SLOW_AND_FAST, channels, kept_of_drives

DONE = 180_000  # ms; a run on a machine that does much else
MINUS = "\N{MINUS SIGN}"


@pytest.fixture
def address() -> str:
    return "?screen=identify"


@pytest.fixture
def screen(page: Page) -> Page:
    """The screen that identifies, on its defaults."""
    expect(region(page, "Experiment")).to_contain_text("29 min of the motor", timeout=LONG)
    return page


def points(page: Page) -> int:
    text = region(page, "Measured").get_by_text(re.compile(r"^\d+ points$")).inner_text()
    return int(text.split()[0])


def wait_for_points(page: Page, count: int) -> None:
    page.wait_for_function(
        "least => parseInt([...document.querySelectorAll('[aria-label=Measured] .note')]"
        ".map(e => e.innerText).find(t => /points$/.test(t))) >= least",
        arg=count,
        timeout=LONG,
    )


def identify(page: Page) -> Locator:
    return page.get_by_role("button", name="Identify", exact=True)


def set_short(page: Page, motor: str = "matched") -> None:
    """Choose an experiment that is over within a second or two."""
    page.get_by_label("motor", exact=True).select_option(motor)
    for label, value in {
        "slowest, mm/s": "2",
        "speeds": "9",
        "time of each, s": "1",
        "rates, N/s": "50",
    }.items():
        set_field(page, label, value)
    page.get_by_label("positions").select_option("4")
    expect(region(page, "Experiment")).to_contain_text("18 motions there and back", timeout=LONG)


def set_long(page: Page) -> None:
    """Choose an experiment that goes on until it is cancelled."""
    for label, value in {
        "slowest, mm/s": "1",
        "fastest, mm/s": "30",
        "speeds": "60",
        "time of each, s": "28",
    }.items():
        set_field(page, label, value)
    page.get_by_role("radio", name="linear").click()
    expect(region(page, "Experiment")).to_contain_text("120 motions there and back", timeout=LONG)


def run(page: Page, press: Callable[[], object] | None = None) -> None:
    """Start a run and wait for its end, not for that of an earlier one."""
    asked_for(page, press or identify(page).click)
    expect(region(page, "Experiment")).to_contain_text("took", timeout=DONE)


def cell(page: Page, name: str, column: int) -> str:
    row = ("F_c", "F_s", "v_s", "sigma_2", "f_0", "sigma_0", "sigma_1", "M").index(name)
    line = region(page, "Found").locator("tbody tr").nth(row)
    return line.locator("td").nth(column).inner_text().replace(MINUS, "-")


def percent(page: Page, name: str, column: int) -> float:
    return float(cell(page, name, column).removesuffix(" %"))


@pytest.mark.usefixtures("unopened")
def test_it_opens_with_its_shipped_result(page: Page, server: Server) -> None:
    shipped_only(page, "identify")
    page.goto(f"{server.url}/?screen=identify")
    experiment = region(page, "Experiment")
    expect(experiment).to_contain_text("Shipped with", timeout=LONG)
    expect(experiment).to_contain_text("64 motions there and back", timeout=LONG)
    expect(experiment).to_contain_text("29 min")
    expect(experiment).not_to_contain_text("other settings than the form shows")
    expect(region(page, "Measured")).to_contain_text("64 points")
    assert percent(page, "F_s", 4) < 1.0
    for name in ("Compare", "Stage"):
        expect(region(page, name).get_by_role("button").first).to_be_enabled()
    page.set_viewport_size({"width": 390, "height": 844})
    expect(region(page, "Experiment")).to_be_in_viewport()


def test_points_arrive_and_the_run_is_cancelled(screen: Page) -> None:
    set_long(screen)
    identify(screen).click()
    experiment = region(screen, "Experiment")
    expect(experiment.get_by_role("progressbar")).to_be_visible(timeout=LONG)
    expect(identify(screen)).to_be_disabled()
    wait_for_points(screen, 2)
    first = points(screen)
    expect(experiment.get_by_role("status")).to_contain_text("x: uniform motion")
    wait_for_points(screen, first + 4)
    expect(experiment).to_contain_text("left")
    experiment.get_by_role("button", name="Cancel").click()
    expect(experiment).to_contain_text("Cancelled after", timeout=LONG)
    assert points(screen) >= first + 4
    expect(identify(screen)).to_be_enabled()


def test_a_reload_finds_the_run_going_on(screen: Page) -> None:
    set_long(screen)
    identify(screen).click()
    expect(region(screen, "Experiment").get_by_role("progressbar")).to_be_visible(timeout=LONG)
    wait_for_points(screen, 4)
    before = points(screen)
    screen.reload()
    expect(region(screen, "Experiment").get_by_role("progressbar")).to_be_visible(timeout=LONG)
    wait_for_points(screen, before + 2)
    # what was typed is still there
    expect(screen.get_by_role("textbox", name="speeds", exact=True)).to_have_value("60")
    region(screen, "Experiment").get_by_role("button", name="Cancel").click()
    expect(region(screen, "Experiment")).to_contain_text("Cancelled after", timeout=LONG)


def test_from_a_run_to_the_model_of_the_lab(screen: Page, server: Server) -> None:
    model = session(screen, server)["scenario"]["variants"]["B"]["controller"]["model"]
    believed = {axis: f"{1e3 * model[axis]['friction']['F_c']:.4g}" for axis in "xy"}  # mN
    set_short(screen)
    run(screen)
    found = region(screen, "Found")
    expect(found.locator("tbody tr")).to_have_count(8)
    assert cell(screen, "F_c", 0) == believed["x"]
    # the matched motor is stronger than its map: forces come out low, velocities do not
    assert -20.0 < percent(screen, "F_s", 4) < -10.0
    assert abs(percent(screen, "v_s", 4)) < 1.0
    screen.get_by_role("radio", name="y", exact=True).last.click()
    expect(found).to_contain_text("Found on y")
    assert cell(screen, "F_c", 0) == believed["y"]

    compare = region(screen, "Compare")
    compare.get_by_role("button", name="Compare old with new").click()
    row = compare.locator("tr", has_text="max |e").first
    smaller = re.compile(rf"^{MINUS}[1-9]\d\.\d %$")
    expect(row.locator("td").nth(2)).to_have_text(smaller, timeout=LONG)

    apply = region(screen, "Stage")
    apply.get_by_role("button", name="Stage in Lab").click()
    expect(apply.get_by_role("status")).to_contain_text("model of B is the identified one")
    apply.get_by_role("link", name="Open the Lab").click()
    changes = region(screen, "Changes")
    expect(changes).to_contain_text("B Coulomb F_c".replace("_", ""), timeout=LONG)
    screen.go_back()
    region(screen, "Stage").get_by_role("button", name="Undo").click()
    expect(region(screen, "Stage").get_by_role("status")).to_contain_text("stay as they are")
    screen.go_forward()
    expect(changes).not_to_contain_text("Coulomb", timeout=LONG)


def test_what_is_found_goes_to_a_running_session_and_back(screen: Page, server: Server) -> None:
    def believed() -> list[float]:
        variants: dict[str, Any] = session(screen, server)["scenario"]["variants"]
        return [v["controller"]["model"]["x"]["friction"]["F_s"] for v in variants.values()]

    before = believed()
    set_short(screen)
    run(screen)
    apply = region(screen, "Stage")
    apply.get_by_role("checkbox", name="A").check()
    apply.get_by_role("button", name="Send to motor").click()
    expect(apply.get_by_role("status")).to_contain_text("model of A and B", timeout=LONG)
    expect(apply.get_by_role("status")).to_contain_text("in the motor")

    def smaller() -> bool:
        return all(new < old for new, old in zip(believed(), before, strict=True))

    until(screen, "the fit replaces F_s", smaller)
    apply.get_by_role("button", name="Undo").click()
    until(screen, "undo restores F_s", lambda: believed() == before)


def test_an_earlier_record_is_opened_and_laid_beside(screen: Page) -> None:
    for motor in ("nominal", "as-measured"):
        set_short(screen, motor)
        run(screen)
    found = region(screen, "Found")
    beside = found.get_by_role("combobox", name="Earlier result beside it")
    nominal = beside.locator("option", has_text="nominal").first.get_attribute("value")
    assert nominal is not None
    beside.select_option(nominal)
    expect(found.get_by_role("columnheader", name="earlier")).to_be_visible()
    assert -20.0 < percent(screen, "F_s", 6) < -10.0
    expect(found).to_contain_text(re.compile(r"less by \d+ %: the force map in control is off"))
    expect(region(screen, "Measured")).to_contain_text("earlier fit")
    screen.get_by_role("combobox", name="Identification: earlier results").select_option(nominal)
    expect(screen.get_by_label("motor", exact=True)).to_have_value("nominal")
    expect(found.locator("tbody tr").first.locator("td").nth(4)).to_have_text(
        re.compile(rf"^{MINUS}?0(\.\d)? %$")
    )


def test_what_is_wrong_is_told_before_anything_moves(screen: Page, refusals: list[str]) -> None:
    refusals += ["422"]
    experiment = region(screen, "Experiment")
    set_field(screen, "speeds", "3")
    expect(experiment.get_by_role("alert")).to_have_text(
        "Has too few items: 3 items. Allowed: 5 or more items.", timeout=LONG
    )
    expect(identify(screen)).to_be_disabled()
    set_field(screen, "speeds", "12")
    expect(experiment.get_by_role("alert")).to_have_count(0, timeout=LONG)
    set_field(screen, "fastest, mm/s", "900")
    expect(experiment.get_by_role("alert").last).to_contain_text(
        re.compile(r"900 mm/s needs .* the stroke of x is 170 mm"), timeout=LONG
    )
    set_field(screen, "fastest, mm/s", "150")
    set_field(screen, "slowest, mm/s", "0.1")
    set_field(screen, "time of each, s", "3600")
    too_long = experiment.get_by_role("alert").filter(has_text="too long for one experiment")
    expect(too_long).to_be_visible()
    screen.get_by_role("button", name=re.compile("^Reset")).click()
    expect(experiment.get_by_role("alert")).to_have_count(0, timeout=LONG)
    expect(identify(screen)).to_be_enabled()


def test_from_an_imported_measurement_to_the_model(
    screen: Page, server: Server, refusals: list[str]
) -> None:
    refusals += ["422"]
    columns = {name: values[::2] for name, values in channels().items() if "i_" not in name}
    text = "\n".join(
        [
            ",".join(columns),
            *(",".join(f"{v:.9g}" for v in row) for row in zip(*columns.values(), strict=True)),
        ]
    )
    answer = screen.request.post(
        f"{server.url}{API}/runs/import?name=rig%207",
        data=text.encode(),
        headers={"Content-Type": "application/octet-stream"},
    )
    run_id = answer.json()["run"]
    screen.get_by_role("radio", name="measured run").click()
    expect(identify(screen)).to_be_disabled()
    experiment = region(screen, "Experiment")
    chosen = screen.get_by_role("combobox", name="run", exact=True)
    expect(chosen.locator("option").nth(1)).to_contain_text("rig 7, measured", timeout=LONG)
    chosen.select_option(run_id)
    expect(experiment).to_contain_text("x: M.x.position_measured and M.x.force_command")
    run(screen)
    expect(region(screen, "Found")).to_contain_text(re.compile(r"\d+ reversals.*Condition number"))
    lines = region(screen, "Found").locator("tbody tr")
    found = lines.filter(has_text="N/mm").locator("td").nth(1).inner_text()
    assert abs(float(found) / 1e-3 / FRICTION["sigma_0"] - 1.0) < 0.02
    expect(region(screen, "Residuals")).to_contain_text("95 % band")
    apply = region(screen, "Stage")
    apply.get_by_role("button", name="Stage in Lab").click()
    expect(apply.get_by_role("status")).to_contain_text("model of B is the identified one")
    assert serious(screen) == []
    # another column, of another unit's name: refused before anything is read
    screen.get_by_role("radio", name="y", exact=True).first.click()
    expect(experiment.get_by_role("alert")).to_contain_text("none of M.y.position_measured")


@pytest.mark.realtime
def test_the_simulated_motor_fitted_to_a_run_of_drives(
    screen: Page, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the run to its simulation, to what is identified, to the motor, to the simulation."""
    monkeypatch.setenv("MOTIONLAB_DATA", str(server.data))
    machine = {"plant.x.friction.F_c": 0.9, "plant.x.friction.v_s": 0.02}
    scenario = on_drives(load_scenario("circle", {"trajectory": SLOW_AND_FAST}), "A")
    drives = prepare(
        on_drives(load_scenario("circle", {"trajectory": SLOW_AND_FAST} | machine), "A")
    )
    run = kept_of_drives(simulation(drives), scenario, "sines A on Rig")

    screen.goto(f"{server.url}/?screen=runs&run={run}")
    screen.get_by_role("button", name="Compare with its simulation").click()
    before = left_over(screen, server, run)
    screen.goto(f"{server.url}/?screen=runs&run={run}")
    screen.get_by_role("button", name="Identify from it").click()
    region(screen, "Experiment").get_by_role("radio", name="x", exact=True).click()
    asked_for(screen, identify(screen).click)
    motor = region(screen, "Fit the simulated motor")
    motor.get_by_role("textbox", name="Name of the motor").fill("Rig 7")
    motor.get_by_role("button", name="Save as motor").click()
    expect(motor.get_by_role("status")).to_contain_text("Motor rig-7 has 7 fitted values")
    assert serious(screen) == []
    origin = screen.request.get(f"{server.url}{API}/motors/rig-7").json()["origin"]
    assert origin["run"] == run
    assert origin["residual"]["x"]["before"] == pytest.approx(before, rel=1e-3)
    motor.get_by_role("button", name="Simulate the run with rig-7").click()
    after = left_over(screen, server, run)
    assert after == pytest.approx(origin["residual"]["x"]["after"], rel=1e-3)
    assert after < before / 20.0


def left_over(page: Page, server: Server, run: str) -> float:
    """Return what the comparison that is opened says of x's following error, rms, m."""
    page.wait_for_url(re.compile(rf"run=r-\w+(,|%2C){run}"))
    expect(page.get_by_role("button", name="A.x.following_error")).to_be_visible()
    found = re.search(r"run=(r-\w+)", page.url)
    assert found is not None
    body = {"a": found[1], "b": run, "only": ["A.x.following_error"]}
    answer = page.request.post(f"{server.url}{API}/runs/compare", data=body).json()
    return answer["channels"][0]["rms"]


def test_everything_by_keyboard_alone(screen: Page) -> None:
    set_short(screen)
    keyboard = screen.keyboard
    tab_to(screen, "Identify")
    tab_to(screen, "slowest, mm/s")
    tab_to(screen, "Identify")
    run(screen, lambda: keyboard.press("Enter"))
    tab_to(screen, "Stribeck curve, friction force over velocity")
    plot = screen.get_by_role("slider", name="Stribeck curve, friction force over velocity")
    keyboard.press("End")
    expect(plot).to_have_attribute("aria-valuetext", re.compile(r"velocity .*measured .*N"))
    tab_to(screen, "Table of Residuals")
    keyboard.press("Enter")
    expect(region(screen, "Residuals").get_by_role("table")).to_be_visible()
    tab_to(screen, "Compare old with new")
    keyboard.press("Enter")
    expect(region(screen, "Compare")).to_contain_text("max |e", timeout=LONG)
    tab_to(screen, "Stage in Lab")
    keyboard.press("Enter")
    expect(region(screen, "Stage").get_by_role("status")).to_contain_text("model of B")
    tab_to(screen, "Undo")
    keyboard.press("Enter")
    expect(region(screen, "Stage").get_by_role("status")).to_contain_text("stay as they are")


def test_axe_finds_nothing_serious(screen: Page) -> None:
    set_short(screen)
    run(screen)
    region(screen, "Compare").get_by_role("button").click()
    expect(region(screen, "Compare")).to_contain_text("max |e", timeout=LONG)
    assert serious(screen) == []
