"""The Drive screen before a virtual drive: control, arming, faults, STOP from anywhere."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, FilePayload, Locator, Page, expect

from motionlab.drive.virtual.process import VirtualDrive
from tests.e2e.actions import API, button, link_file, region, serious, tab_to
from tests.e2e.conftest import Server

pytestmark = pytest.mark.realtime

SLOW = 10
STOP = re.compile("^STOP")  # STOPPING and STOPPED too, not a panel's own Stop
"""A stall of a busy machine, which puts the exchange out of phase, counts less."""
BRING_UP = 180_000  # ms; the loop may have to be compiled
OVERCURRENT = 0x2310


@pytest.fixture(scope="module")
def drive() -> Iterator[VirtualDrive]:
    with VirtualDrive(priority=70, slow=SLOW, start=(0.0123, -0.0041)) as running:
        yield running


@pytest.fixture(scope="module")
def linked(drive: VirtualDrive, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    """A server with a link to the virtual drive."""
    data = tmp_path_factory.mktemp("data")
    server = Server(data, "--drive", str(link_file(drive, data, slow=SLOW)))
    yield server
    server.stop()


@pytest.fixture
def shown(browser: Browser, linked: Server, drive: VirtualDrive) -> Iterator[Page]:
    """The Drive screen of drives that are ready to arm, and that no one controls."""
    drive.switch(clear=True)
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page = context.new_page()
    complaints: list[str] = []
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.goto(f"{linked.url}/?screen=drive")
    made_ready(page)
    yield page
    page.request.post(f"{linked.url}/api/v1/drive/stop")
    context.close()
    assert complaints == []


def headline(page: Page) -> Locator:
    return region(page, "State").get_by_role("status")


def made_ready(page: Page) -> None:
    """Wait until drives and control are free, and reset what an earlier test has left."""
    torque, control = region(page, "Torque"), region(page, "Control")
    expect(torque).to_be_visible()
    expect(control.get_by_role("button", name="Take control")).to_be_enabled(timeout=BRING_UP)
    expect(headline(page)).not_to_have_text("Bringing the drives up", timeout=BRING_UP)
    if region(page, "State").get_by_role("alert").count():
        button(page, "Take control")
        was_reset(page)
        button(page, "Give up")
        expect(control).to_contain_text("No one has control")
    expect(headline(page)).to_have_text("Ready to arm", timeout=BRING_UP)


def was_reset(page: Page) -> None:
    """Reset, and once more where drives that were brought up again say what they had."""
    again = region(page, "State").get_by_role("alert").get_by_role("button")
    for _ in range(3):
        again.click()
        expect(headline(page)).not_to_have_text("Bringing the drives up", timeout=BRING_UP)
        page.wait_for_timeout(1000)
        if not again.count():
            break
    expect(headline(page)).to_have_text("Ready to arm", timeout=BRING_UP)


def taken(page: Page) -> None:
    button(page, "Take control")
    expect(region(page, "Control")).to_contain_text("This browser")


def armed(page: Page) -> None:
    expect(page.get_by_role("button", name="Arm…")).to_be_enabled()
    button(page, "Arm…")
    question = page.get_by_role("alertdialog")
    question.get_by_role("checkbox").check()
    question.get_by_role("button", name="Arm").click()
    expect(headline(page)).to_have_text("Armed, at rest")


def status(page: Page, server: Server) -> dict[str, Any]:
    return page.request.get(f"{server.url}{API}/drive").json()


def test_arming_is_a_question_that_enter_does_not_answer(shown: Page, linked: Server) -> None:
    page = shown
    torque = region(page, "Torque")
    expect(torque.get_by_role("button", name="Arm…")).to_be_disabled()
    expect(torque).to_contain_text("Take control first")
    taken(page)
    button(page, "Arm…")
    question = page.get_by_role("alertdialog", name="Arm six drives?")
    expect(question).to_contain_text("x 12.30, y \u22124.10 mm")
    expect(question).to_contain_text("allows torque, 6 of 6")
    expect(question.get_by_role("button", name="Cancel")).to_be_focused()
    sure, arm = question.get_by_role("checkbox"), question.get_by_role("button", name="Arm")
    expect(sure).not_to_be_checked()
    expect(arm).to_be_disabled()
    sure.check()
    arm.focus()
    page.keyboard.press("Enter")
    page.wait_for_timeout(1000)
    expect(question).to_be_visible()
    assert status(page, linked)["state"] == "ready"
    arm.press("Space")
    expect(question).to_be_hidden()
    expect(headline(page)).to_have_text("Armed, at rest")
    expect(region(page, "State").get_by_role("cell", name="torque on")).to_have_count(6)
    x, y = (axis["position"] for axis in status(page, linked)["axes"])
    assert (x, y) == pytest.approx((0.0123, -0.0041), abs=20e-6)
    button(page, "Disarm")
    expect(headline(page)).to_have_text("Ready to arm")
    button(page, "Give up")
    expect(region(page, "Control")).to_contain_text("No one has control")


def test_stop_of_another_browser_that_holds_nothing(
    shown: Page, linked: Server, browser: Browser
) -> None:
    taken(shown)
    armed(shown)
    with browser.new_context() as context:
        other = context.new_page()
        other.goto(f"{linked.url}/?screen=drive")
        expect(region(other, "Control")).to_contain_text("Held by browser")
        for name in ("Disarm", "Arm…", "Take control"):
            expect(other.get_by_role("button", name=name)).to_be_disabled()
        button(other, "Ask for control")
        expect(other.get_by_role("button", name="Asked")).to_be_disabled()
        expect(region(shown, "Control")).to_contain_text("asks for control")
        other.goto(f"{linked.url}/?screen=runs")
        expect(other.locator(".bar").get_by_text("armed", exact=True)).to_be_visible()
        other.get_by_role("button", name=STOP).click()
        expect(other.locator(".bar").get_by_text("no torque", exact=True)).to_be_visible()
    expect(headline(shown)).to_have_text("Ready to arm")
    expect(region(shown, "Control")).to_contain_text("This browser")
    expect(region(shown, "Torque")).to_contain_text("Last stop: STOP (browser ")


def test_escape_is_stop_over_the_question_too(shown: Page, linked: Server) -> None:
    taken(shown)
    button(shown, "Arm…")
    question = shown.get_by_role("alertdialog")
    expect(question).to_be_visible()
    with shown.expect_request("**/api/v1/drive/stop*"):
        shown.keyboard.press("Escape")
    expect(question).to_be_hidden()
    button(shown, "Arm…")
    with shown.expect_request("**/api/v1/drive/stop*"):
        shown.get_by_role("button", name=STOP).click()  # the veil does not cover it
    button(shown, "Cancel")
    assert status(shown, linked)["state"] == "ready"
    armed(shown)
    shown.keyboard.press("Escape")
    expect(headline(shown)).to_have_text("Ready to arm")


def test_the_question_ends_when_a_check_turns(shown: Page, drive: VirtualDrive) -> None:
    taken(shown)
    button(shown, "Arm…")
    question = shown.get_by_role("alertdialog")
    expect(question).to_be_visible()
    drive.switch(sto=True)
    expect(question).to_be_hidden()
    expect(shown.get_by_text("Nothing was armed. STO is active.")).to_be_visible()
    expect(headline(shown)).to_have_text("STO is active, no torque")
    expect(region(shown, "Two ways to stop")).to_contain_text("active 6/6")
    drive.switch(sto=False)
    expect(headline(shown)).to_have_text("Ready to arm")


def test_a_fault_has_its_remedy_and_reset_does_not_arm(
    shown: Page, linked: Server, drive: VirtualDrive
) -> None:
    taken(shown)
    armed(shown)
    drive.switch(fault={"node": 5, "code": OVERCURRENT})
    expect(headline(shown)).to_have_text("Fault of drive 5, no torque")
    told = region(shown, "State").get_by_role("alert")
    expect(told).to_contain_text("drive 5, y b: continuous overcurrent (0x2310)")
    expect(told).to_contain_text("Check the coil of this phase")
    expect(shown.get_by_role("button", name="Arm…")).to_be_disabled()
    expect(region(shown, "Torque")).to_contain_text("Reset it first")
    was_reset(shown)
    assert not any(one["state"] == "operation enabled" for one in status(shown, linked)["drives"])
    shown.get_by_text("since the start").click()
    expect(shown.get_by_role("list", name="Earlier faults")).to_contain_text(
        "continuous overcurrent"
    )


def test_a_cable_that_is_out_is_a_fault_until_it_is_reset(shown: Page, drive: VirtualDrive) -> None:
    taken(shown)
    armed(shown)
    drive.switch(black_hole=True)
    expect(headline(shown)).to_have_text("Fault of the link, state not known")
    panel = region(shown, "State")
    expect(panel).to_contain_text(re.compile(r"Last known, \d+ s ago"))
    expect(panel.get_by_role("row", name="not known")).to_have_count(6)
    expect(panel.get_by_text("torque on")).to_have_count(0)
    expect(panel.get_by_text("no torque")).to_have_count(0)
    expect(region(shown, "Torque")).to_contain_text("not known")
    expect(region(shown, "Link")).to_contain_text("not known")
    drive.switch(black_hole=False)
    shown.wait_for_timeout(1500)
    expect(headline(shown)).to_have_text("Fault of the link, no torque")
    was_reset(shown)


def test_nothing_moves_until_armed(shown: Page, linked: Server) -> None:
    taken(shown)
    lease = shown.evaluate("sessionStorage.getItem('motionlab.lease')")
    asked = shown.request.post(
        f"{linked.url}{API}/drive/motions",
        data={"scenario": "circle", "variant": "A"},
        headers={"Lease": lease},
    )
    assert asked.status == 409
    before = [axis["position"] for axis in status(shown, linked)["axes"]]
    shown.wait_for_timeout(1000)
    after = [axis["position"] for axis in status(shown, linked)["axes"]]
    assert after == pytest.approx(before, abs=1e-6)
    assert status(shown, linked)["state"] == "ready"


def test_control_outlives_a_reload_and_is_lost_with_its_tab(
    shown: Page, linked: Server, browser: Browser
) -> None:
    taken(shown)
    shown.reload()
    expect(region(shown, "Control")).to_contain_text("This browser")
    with browser.new_context() as context:
        other = context.new_page()
        other.goto(f"{linked.url}/?screen=drive")
        free = other.get_by_role("button", name="Take control")
        expect(free).to_be_disabled()
        armed(shown)
        shown.goto("about:blank")
        expect(free).to_be_enabled()  # after 2 s without a heartbeat
        expect(headline(other)).to_have_text("Ready to arm")
    shown.goto(f"{linked.url}/?screen=drive")


def test_by_keyboard_alone(shown: Page) -> None:
    keyboard = shown.keyboard
    tab_to(shown, "Take control")
    keyboard.press("Enter")
    expect(region(shown, "Control")).to_contain_text("This browser")
    tab_to(shown, "Arm…")
    keyboard.press("Enter")
    question = shown.get_by_role("alertdialog")
    expect(question.get_by_role("button", name="Cancel")).to_be_focused()
    keyboard.press("Shift+Tab")
    keyboard.press("Space")
    expect(question.get_by_role("checkbox")).to_be_checked()
    tab_to(shown, "Arm")
    keyboard.press("Space")
    expect(headline(shown)).to_have_text("Armed, at rest")
    tab_to(shown, "Disarm")
    keyboard.press("Enter")
    expect(headline(shown)).to_have_text("Ready to arm")


def test_it_can_be_read_by_everyone(shown: Page) -> None:
    taken(shown)
    assert serious(shown) == []
    button(shown, "Arm…")
    expect(shown.get_by_role("alertdialog")).to_be_visible()
    assert serious(shown) == []


def test_a_phone_watches_and_stops(shown: Page) -> None:
    shown.set_viewport_size({"width": 390, "height": 844})
    expect(headline(shown)).to_be_visible()
    for name in ("Torque", "Control", "Timing", "Link"):
        expect(region(shown, name)).to_be_hidden()
    assert shown.evaluate("document.documentElement.scrollWidth <= innerWidth")
    expect(shown.get_by_role("button", name=STOP)).to_be_in_viewport(ratio=1)


def test_a_server_without_drives_says_how_to_try_them(page: Page) -> None:
    page.get_by_role("link", name="Drive", exact=True).click()
    said = region(page, "State")
    expect(said).to_contain_text("No drive configured")
    expect(said).to_contain_text("motionlab serve --drive virtual")


def a_step_is_stopped(page: Page, panel: Locator) -> None:
    """Begin the step with torque that is due, and stop it."""
    button(page, "Begin…")
    question = page.get_by_role("alertdialog", name="Begin phase currents, one by one?")
    expect(question).to_contain_text("1.00 A a phase")
    expect(question.get_by_role("button", name="Cancel")).to_be_focused()
    begin = question.get_by_role("button", name="Begin")
    expect(begin).to_be_disabled()
    question.get_by_role("checkbox").check()
    begin.press("Space")
    expect(panel.get_by_role("progressbar")).to_be_visible()
    page.get_by_role("button", name=STOP).click()
    expect(panel).to_contain_text("ended before its end")
    expect(panel.get_by_role("progressbar")).to_have_count(0)
    expect(headline(page)).to_have_text("Ready to arm")


def test_commissioning_goes_step_by_step(shown: Page, drive: VirtualDrive) -> None:
    panel = region(shown, "Commissioning")
    steps = panel.get_by_role("listitem")
    expect(steps.filter(has_text="Find drives").get_by_role("button")).to_be_disabled()
    taken(shown)
    expect(steps.filter(has_text="Identity").get_by_role("button")).to_have_count(0)
    button(shown, "Check")
    expect(panel).to_contain_text("6 of 6 found, in OP")
    button(shown, "Check")
    expect(panel).to_contain_text("6 of 6 match; 10 A rated")
    button(shown, "Begin")
    expect(panel.get_by_role("status")).to_contain_text("x 0 mm, y 0 mm")
    for axis, force in (("x", -12.0), ("y", 12.0)):
        drive.switch(push={"axis": axis, "force": force, "time": 0.1})
    expect(panel).to_contain_text("x counts the wrong way")
    button(shown, "Take these changes")
    expect(headline(shown)).not_to_have_text("Ready to arm")
    kept = panel.get_by_role("list", name="Changes in effect")
    expect(kept).to_contain_text("x.direction 1 \u2192 \u22121")
    expect(headline(shown)).to_have_text("Ready to arm", timeout=BRING_UP)
    button(shown, "Begin")
    for axis, force in (("x", -12.0), ("y", 12.0)):
        drive.switch(push={"axis": axis, "force": force, "time": 0.1})
    expect(panel).to_contain_text("both signs right")
    expect(panel).to_contain_text("3 of 9 done")
    a_step_is_stopped(shown, panel)
    shown.reload()
    expect(panel).to_contain_text("3 of 9 done")  # the server keeps it
    shown.emulate_media(media="print")
    on_paper = shown.locator("article")
    expect(on_paper).to_contain_text("Commissioning of Virtual drive")
    expect(on_paper.get_by_role("row", name="x.direction", include_hidden=True)).to_be_visible()
    expect(panel).to_be_hidden()
    shown.emulate_media(media="screen")
    shown.get_by_role("button", name="Again: Identity and limits").click()
    expect(panel).to_contain_text("2 of 9 done")
    expect(panel).not_to_contain_text("both signs right")
    with shown.expect_download() as document:
        button(shown, "Download")
    button(shown, "Start over")
    expect(panel).to_contain_text("0 of 9 done")
    expect(kept).to_have_count(0)
    written = json.loads(document.value.path().read_text())
    written["taken"][0]["then"] = 1.0
    forged: FilePayload = {
        "name": "forged.json",
        "mimeType": "application/json",
        "buffer": json.dumps(written).encode(),
    }
    shown.get_by_label("Commissioning document").set_input_files(forged)
    expect(shown.get_by_text("was changed since it was found")).to_be_visible()
    shown.get_by_role("button", name="Dismiss message").click()
    expect(panel).to_contain_text("0 of 9 done")
    shown.get_by_label("Commissioning document").set_input_files(document.value.path())
    expect(panel).to_contain_text("2 of 9 done")
    expect(kept).to_be_visible()
