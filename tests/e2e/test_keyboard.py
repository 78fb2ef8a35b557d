"""Everything once more, by keyboard alone."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Page, expect

from tests.e2e.actions import (
    LONG,
    region,
    simulated,
    state,
    tab_to,
    type_number,
    wait_for_clock,
)
from tests.e2e.conftest import Server


def test_a_session_from_play_to_reload_by_keyboard_alone(page: Page, tmp_path: Path) -> None:
    keyboard = page.keyboard
    changes = region(page, "Changes")

    keyboard.press("Space")
    state(page, "playing")
    tab_to(page, "B k_p x")
    keyboard.press("Shift+ArrowRight")
    expect(changes).to_contain_text("220.3", timeout=LONG)
    tab_to(page, "B k_p x, N/mm")
    type_number(page, "312")
    expect(changes).to_contain_text("312", timeout=LONG)

    tab_to(page, "Force on x, N")
    type_number(page, "8")
    tab_to(page, "Push x")
    wait_for_clock(page, 1.0)
    keyboard.press("Enter")
    metrics = region(page, "Metrics")
    page.wait_for_function(  # B's error is 2.6 um without a push
        "() => { const cells = document.querySelectorAll('[aria-label=Metrics] tbody td');"
        " return parseFloat(cells[1]?.innerText) > 5 }",
        timeout=LONG,
    )
    tab_to(page, "Definitions")
    keyboard.press("Enter")
    expect(metrics.get_by_text("largest following error").first).to_be_visible()

    keyboard.press("Escape")
    state(page, "stopped")
    tab_to(page, "CSV ↓")
    with page.expect_download() as csv:
        keyboard.press("Enter")
    csv.value.save_as(tmp_path / "run.csv")
    assert len((tmp_path / "run.csv").read_text().splitlines()) > 1000

    page.reload()
    state(page, "stopped")
    expect(changes).to_contain_text("312", timeout=LONG)
    keyboard.press("r")
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)


def test_what_if_undo_and_apply_by_keyboard_alone(page: Page, server: Server) -> None:
    keyboard = page.keyboard
    changes, metrics = region(page, "Changes"), region(page, "Metrics")
    _, before = simulated(page, server)
    _, after = simulated(page, server, k_p=400e3)
    expect(metrics).to_contain_text(before, timeout=LONG)
    tab_to(page, "B k_p x, N/mm")
    type_number(page, "400")
    expect(metrics).to_contain_text(after, timeout=LONG)
    expect(metrics).to_contain_text("exact", timeout=LONG)
    keyboard.press("Tab")
    keyboard.press("u")
    expect(metrics).to_contain_text(before, timeout=LONG)
    keyboard.press("ArrowRight")
    expect(changes).to_contain_text("1.545", timeout=LONG)
    keyboard.press("a")
    expect(changes.get_by_role("button", name="Send to motor")).to_be_disabled(timeout=LONG)
    keyboard.press("l")
    expect(changes).to_contain_text("1.545")


def test_views_and_help_by_keyboard_alone(page: Page) -> None:
    keyboard = page.keyboard
    scopes = region(page, "Scopes")
    keyboard.press("2")
    expect(scopes.get_by_role("heading", name="Following error x")).to_be_hidden()
    expect(scopes.get_by_role("heading", name="Following error y")).to_be_visible()
    keyboard.press("2")
    expect(scopes.get_by_role("heading", name="Following error x")).to_be_visible()
    keyboard.press("n")
    keyboard.type("velocity reference x")
    keyboard.press("Enter")
    expect(scopes.get_by_role("heading", name="Velocity x")).to_be_visible()
    keyboard.press("Escape")
    expect(scopes.get_by_role("dialog", name="Channels")).to_be_hidden()
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    keyboard.press("m")
    keyboard.press("m")
    expect(scopes).to_contain_text("Δt 2.00 s", timeout=LONG)  # A third of the 6 s shown.
    keyboard.press("<")
    expect(scopes).to_contain_text("Δt 1.97 s", timeout=LONG)
    keyboard.press("v")
    expect(scopes.get_by_role("heading", name="Following error x, mean")).to_be_visible()
    keyboard.press("0")
    expect(scopes).not_to_contain_text("Δt")
    tab_to(page, "Table")
    keyboard.press("Enter")
    numbers = region(page, "Plane as numbers")
    expect(numbers.get_by_role("row", name="most")).to_contain_text("15.0", timeout=LONG)
    keyboard.press("S")
    expect(page.locator(".clock")).to_contain_text("0:00.100")
    keyboard.press("?")
    sheet = page.get_by_role("dialog", name="Keys and help")
    expect(sheet).to_be_visible()
    keyboard.press("Escape")
    expect(sheet).to_be_hidden()
    state(page, "paused")
