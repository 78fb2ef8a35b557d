"""What a person does in the lab, in a real browser."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.conftest import ROOT, Server

AXE = ROOT / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
LONG = 20_000  # ms; a wait that ends sooner in every sound run


def state(page: Page, name: str) -> None:
    expect(page.locator(".bar").get_by_role("status")).to_have_text(name, timeout=LONG)


def clock(page: Page) -> float:
    minutes, seconds = page.locator(".clock").inner_text().replace("s", "").strip().split(":")
    return 60.0 * float(minutes) + float(seconds)


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def metric(page: Page, name: str, column: int) -> str:
    row = page.get_by_role("region", name="Metrics").locator("tr", has_text=name).first
    return row.locator("td").nth(column).inner_text()


def wait_for_clock(page: Page, seconds: float) -> None:
    page.wait_for_function(
        "least => { const [m, s] = document.querySelector('.clock').innerText.split(':');"
        " return 60 * +m + parseFloat(s) > least }",
        arg=seconds,
        timeout=LONG,
    )


def set_field(page: Page, label: str, value: str) -> None:
    field = page.get_by_role("textbox", name=label, exact=True)
    field.fill(value)
    field.press("Enter")


def test_play_shows_b_better_than_a(page: Page) -> None:
    state(page, "paused")
    button(page, "Play")
    state(page, "playing")
    wait_for_clock(page, 2.5)
    expect(page.get_by_role("region", name="Metrics")).to_contain_text("B vs A")
    assert float(metric(page, "max |e", 0)) > 3.0 * float(metric(page, "max |e", 1))
    button(page, "Pause")
    state(page, "paused")
    page.wait_for_timeout(300)
    still = clock(page)
    page.wait_for_timeout(300)
    assert clock(page) == still


def test_a_gain_changed_live_is_listed_and_undone(page: Page) -> None:
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "312")
    changes = page.get_by_role("region", name="Changes")
    expect(changes).to_contain_text("312", timeout=LONG)
    button(page, "Undo")
    expect(changes).to_contain_text("None", timeout=LONG)


def test_what_if_answers_before_anything_is_applied(page: Page) -> None:
    page.keyboard.press("w")
    region = page.get_by_role("region", name="Metrics")
    expect(region).to_contain_text("2.57", timeout=LONG)
    set_field(page, "B k_p x, N/mm", "400")
    expect(region).not_to_contain_text("2.57", timeout=LONG)
    assert float(metric(page, "max |e", 1)) == pytest.approx(1.35, abs=0.1)
    button(page, "Apply 1 to session")
    expect(page.get_by_role("region", name="Changes")).to_contain_text("400", timeout=LONG)


def test_a_push_moves_both(page: Page) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    page.get_by_role("textbox", name="Force on x, N").fill("8")
    page.get_by_role("button", name="Push x").click()
    page.wait_for_timeout(600)
    assert float(metric(page, "max |e", 0)) > 25.0
    assert float(metric(page, "max |e", 1)) > 5.0


def test_samples_and_scenario_are_downloaded(page: Page, tmp_path: Path) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    button(page, "Pause")
    with page.expect_download() as csv:
        page.get_by_role("link", name="CSV").click()
    csv.value.save_as(tmp_path / "run.csv")
    assert (tmp_path / "run.csv").read_text().startswith('"tick [1]","time [s]"')
    with page.expect_download() as toml:
        page.get_by_role("link", name="TOML").click()
    toml.value.save_as(tmp_path / "circle.toml")
    assert "[variants.B.controller" in (tmp_path / "circle.toml").read_text()


def test_stop_acts_at_once_and_only_a_reset_leaves_it(page: Page) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    button(page, "STOP")
    state(page, "stopped")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_disabled()
    page.get_by_role("region", name="Scenario").get_by_role("button", name="Reset").click()
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)


def test_a_reload_loses_nothing(page: Page) -> None:
    page.keyboard.press("l")
    set_field(page, "A k_p x, N/mm", "250")
    button(page, "Play")
    wait_for_clock(page, 1.0)
    button(page, "Pause")
    state(page, "paused")
    page.wait_for_timeout(300)
    before = clock(page)
    page.reload()
    state(page, "paused")
    assert clock(page) == before
    expect(page.get_by_role("region", name="Changes")).to_contain_text("250", timeout=LONG)


def test_a_server_that_restarts_gets_the_session_back(page: Page, server: Server) -> None:
    page.keyboard.press("l")
    set_field(page, "A k_p x, N/mm", "250")
    button(page, "Play")
    wait_for_clock(page, 0.5)
    server.stop()
    connection = page.locator(".connection")
    expect(connection).to_have_text("connection lost, trying again", timeout=LONG)
    server.start()
    expect(connection).to_have_text("connected", timeout=LONG)
    expect(page.get_by_text(re.compile("session was gone"))).to_be_visible(timeout=LONG)
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)
    expect(page.get_by_role("region", name="Changes")).to_contain_text("250", timeout=LONG)


def test_everything_by_keyboard(page: Page) -> None:
    page.keyboard.press("Space")
    state(page, "playing")
    wait_for_clock(page, 0.3)
    page.keyboard.press("Space")
    state(page, "paused")
    before = clock(page)
    page.keyboard.press("S")
    page.wait_for_function(
        "before => parseFloat(document.querySelector('.clock').innerText.split(':')[1]) > before",
        arg=before,
        timeout=LONG,
    )
    page.keyboard.press("?")
    expect(page.get_by_role("dialog")).to_be_visible()
    page.keyboard.press("Escape")
    expect(page.get_by_role("dialog")).to_be_hidden()
    page.keyboard.press("w")
    page.keyboard.press("l")
    page.keyboard.press("Escape")
    state(page, "stopped")
    page.keyboard.press("r")
    state(page, "paused")


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_serious(page: Page, theme: str) -> None:
    page.emulate_media(color_scheme="dark" if theme == "dark" else "light")
    button(page, "Play")
    wait_for_clock(page, 1.0)
    button(page, "Pause")
    page.add_script_tag(path=AXE)
    found = page.evaluate("axe.run()")["violations"]
    serious = [v["id"] for v in found if v["impact"] in {"serious", "critical"}]
    assert serious == []
