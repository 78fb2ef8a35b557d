"""What a person does in the lab, in a real browser."""

from __future__ import annotations

import re
from pathlib import Path

from playwright.sync_api import Browser, Page, Route, expect

from tests.e2e.actions import (
    API,
    LONG,
    RMS,
    button,
    choose_scenario,
    metric,
    region,
    serious,
    session,
    set_field,
    simulated,
    stands_at,
    state,
    wait_for_clock,
)
from tests.e2e.conftest import Server

FIRST_LOAD = 130
"""Of the page's files without the kernel's module, as they are sent, kB."""


def test_a_first_load_is_small(browser: Browser, server: Server) -> None:
    context = browser.new_context()
    page = context.new_page()
    codings: dict[str, str | None] = {}
    page.on(
        "response",
        lambda answer: codings.update({answer.url: answer.headers.get("content-encoding")}),
    )
    page.goto(server.url)
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    sizes: dict[str, int] = page.evaluate(
        """() => Object.fromEntries(performance.getEntriesByType('resource')
          .filter(({ name }) => name.includes('/assets/'))
          .map(({ name, encodedBodySize }) => [name, encodedBodySize]))"""
    )
    context.close()
    assert {codings[name] for name in sizes} == {"br"}
    assert not [name for name in sizes if re.search("link|Panel|Sheet", name)]
    assert 0 < sum(size for name, size in sizes.items() if "wasm" not in name) < FIRST_LOAD * 1e3


def test_play_shows_b_better_than_a(page: Page, server: Server) -> None:
    state(page, "paused")
    button(page, "Play")
    state(page, "playing")
    wait_for_clock(page, 2.5)
    button(page, "Pause")
    state(page, "paused")
    still = stands_at(page, server)
    metrics = region(page, "Metrics")
    expect(metrics).to_contain_text(re.compile(r" to (\d\d|[2-9])[.\d]* s"))
    expect(metrics).to_contain_text("B vs A")
    assert float(metric(page, "max |e", 0)) > 3.0 * float(metric(page, "max |e", 1))
    page.wait_for_timeout(300)
    assert stands_at(page, server) == still
    expect(region(page, "Plane")).to_contain_text("error × 200")  # noqa: RUF001
    expect(region(page, "Scopes")).to_contain_text(re.compile(r"A.\S?\d+(\.\d+)?.µm"))


def test_a_gain_changed_live_is_listed_and_undone(page: Page) -> None:
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "312")
    changes = region(page, "Changes")
    expect(changes).to_contain_text("312", timeout=LONG)
    button(page, "Undo")
    expect(changes).to_contain_text("None", timeout=LONG)


def test_what_if_answers_before_anything_is_applied(page: Page, server: Server) -> None:
    page.keyboard.press("w")
    metrics = region(page, "Metrics")
    _, before = simulated(page, server)
    _, after = simulated(page, server, k_p=400e3)
    expect(metrics).to_contain_text(before, timeout=LONG)
    set_field(page, "B k_p x, N/mm", "400")
    expect(metrics).to_contain_text(after, timeout=LONG)
    expect(metrics).not_to_contain_text(before, timeout=LONG)
    button(page, "Send 1 to motor")
    expect(region(page, "Changes")).to_contain_text("400", timeout=LONG)


def test_a_notch_is_added_tuned_applied_and_removed(page: Page, server: Server) -> None:
    page.keyboard.press("w")
    metrics, changes = region(page, "Metrics"), region(page, "Changes")
    _, without = simulated(page, server, axis="y")
    expect(metrics).to_contain_text(without, timeout=LONG)
    notch = page.get_by_role("checkbox", name="B notch", exact=True)
    field = page.get_by_role("textbox", name="B notch frequency x, Hz")
    expect(field).to_have_count(0)
    notch.check()
    expect(changes).to_contain_text("B notch gain x", timeout=LONG)
    set_field(page, "B notch frequency x, Hz", "150")
    set_field(page, "B notch gain x", "0.5")
    expect(metrics).to_contain_text("exact", timeout=LONG)
    expect(metrics).not_to_contain_text(without)
    button(page, "Send 3 to motor")  # Two gains and a frequency.
    expect(page.get_by_role("button", name="Send to motor")).to_be_disabled(timeout=LONG)
    page.keyboard.press("l")
    expect(changes).to_contain_text("150")
    notch.uncheck()
    expect(field).to_have_count(0)
    expect(changes).not_to_contain_text("B notch gain", timeout=LONG)
    button(page, "Undo")
    expect(field).to_have_value("150", timeout=LONG)


def test_force_sharing_and_force_map_are_chosen_and_kept_in_a_set(page: Page) -> None:
    page.keyboard.press("w")
    changes = region(page, "Changes")
    sharing = page.get_by_role("combobox", name="B force sharing")
    sharing.select_option("sine")
    expect(changes).to_contain_text("force sharing", timeout=LONG)
    set_field(page, "B overlap, % of pitch", "10")
    expect(changes).to_contain_text("16.67")
    button(page, "Sets…")
    page.get_by_role("textbox", name="Name of the set").fill("sine")
    button(page, "Save present values")
    button(page, "Close")
    button(page, "Discard")
    expect(sharing).to_have_value("least-norm")
    button(page, "Sets…")
    button(page, "Use sine")
    expect(sharing).to_have_value("sine")
    page.get_by_text("More imperfections").click()
    page.get_by_role("combobox", name="Force map of the plant").select_option("new-design")
    expect(changes).to_contain_text("new-design", timeout=LONG)
    expect(region(page, "Plant")).to_contain_text("map gain")
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("combobox", name="Force map of the plant").select_option("formula")
    expect(changes).not_to_contain_text("new-design")


def test_a_push_moves_both(page: Page) -> None:
    for _ in range(5):
        page.keyboard.press("S")
    expect(region(page, "Metrics")).to_contain_text("0 to 0.5 s")
    before = [float(metric(page, "max |e", column)) for column in (0, 1)]
    page.get_by_role("textbox", name="Force on x, N").fill("8")
    page.get_by_role("button", name="Push x").click()
    expect(region(page, "Scopes")).to_be_visible()
    page.get_by_role("button", name="Step", exact=True).press("S")
    expect(region(page, "Metrics")).to_contain_text("0 to 0.6 s")
    after = [float(metric(page, "max |e", column)) for column in (0, 1)]
    assert [b - a > 4.0 for a, b in zip(before, after, strict=True)] == [True, True]


def test_samples_and_scenario_are_downloaded(
    page: Page, tmp_path: Path, refusals: list[str]
) -> None:
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
    text = (tmp_path / "circle.toml").read_text()
    assert "[variants.B.controller" in text
    (tmp_path / "seven.toml").write_text(text.replace("seed = 2019", "seed = 7"))
    page.get_by_label("Scenario file").set_input_files(tmp_path / "seven.toml")
    expect(page.get_by_role("textbox", name="seed")).to_have_value("7", timeout=LONG)
    refusals.append("422")
    (tmp_path / "bad.toml").write_text(text.replace("k_p = 200300", "k_p = -5"))
    page.get_by_label("Scenario file").set_input_files(tmp_path / "bad.toml")
    expect(page.locator(".message")).to_contain_text("B k_p x: Is out of range: ", timeout=LONG)
    expect(page.get_by_role("textbox", name="seed")).to_have_value("7")


def test_stop_acts_at_once_and_only_a_reset_leaves_it(page: Page) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    button(page, "Sets…")
    expect(page.get_by_role("dialog", name="Gain sets")).to_be_visible()
    button(page, "STOP")
    state(page, "stopped")
    button(page, "Close")
    expect(page.get_by_role("button", name="Play", exact=True)).to_be_disabled()
    region(page, "Changes").get_by_role("button", name="Reset").click()
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)


def _hold_new_sessions(page: Page) -> list[Route]:
    """Keep what would make a session from the server until the test lets it go."""
    held: list[Route] = []

    def hold(route: Route) -> None:
        held.append(route) if route.request.method == "POST" else route.continue_()

    page.route("**/api/v1/sessions", hold)
    return held


def test_play_right_after_choosing_plays_what_was_chosen(page: Page) -> None:
    held = _hold_new_sessions(page)
    before = page.url
    choose_scenario(page, "rhombus")
    button(page, "Play")
    held[0].continue_()
    expect(region(page, "Trajectory")).to_contain_text("polygon", timeout=LONG)
    assert page.url != before
    wait_for_clock(page, 0.5)
    state(page, "playing")
    expect(region(page, "Trajectory")).to_contain_text("polygon")


def test_stop_takes_back_a_play_that_waits_for_its_session(page: Page) -> None:
    held = _hold_new_sessions(page)
    choose_scenario(page, "rhombus")
    button(page, "Play")
    button(page, "STOP")
    state(page, "stopped")
    held[0].continue_()
    expect(region(page, "Trajectory")).to_contain_text("polygon", timeout=LONG)
    button(page, "Step")  # Neither a button nor a server that plays would take that.
    expect(page.locator(".clock")).to_contain_text("0:00.001")
    state(page, "paused")


def test_a_refused_value_is_named_where_it_stands(page: Page, refusals: list[str]) -> None:
    refusals.append("422")
    set_field(page, "B k_p x, N/mm", "-5")
    field = page.get_by_role("textbox", name="B k_p x, N/mm")
    told = region(page, "Controllers").get_by_role("alert")
    expect(told).to_have_text(
        re.compile("^Is out of range: .5 N/mm. Allowed: 0 to 1000000 N/mm.$"), timeout=LONG
    )
    expect(field).to_have_attribute("aria-invalid", "true")
    expect(region(page, "Metrics")).to_contain_text("not computed")
    set_field(page, "B k_p x, N/mm", "400")
    expect(told).to_have_count(0, timeout=LONG)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)


def test_two_cursors_measure_time_values_and_statistics(page: Page, server: Server) -> None:
    metrics, scopes = region(page, "Metrics"), region(page, "Scopes")
    expect(metrics).to_contain_text("exact", timeout=LONG)
    error = region(page, "Following error x, what-if").locator(".legend")
    page.get_by_role("combobox", name="What the readings tell").select_option("rms")
    # What is visible is the window of the metrics: theirs and ours are the same number.
    a, b = simulated(page, server, RMS)
    readings = re.compile(rf"A.{re.escape(a)}.µm.*B.{re.escape(b)}.µm")
    expect(error).to_contain_text(readings, timeout=LONG)
    assert metric(page, "RMS e", 0) == a
    box = page.locator(".chart").first.bounding_box()
    assert box is not None
    left, right, y = box["x"] + 66, box["x"] + box["width"] - 62, box["y"] + 20
    for share in (0.25, 0.75):
        page.mouse.click(left + share * (right - left), y)
    expect(scopes).to_contain_text("Δt 3.0", timeout=LONG)
    page.mouse.move(left + 0.75 * (right - left), y)
    page.mouse.down()
    page.mouse.move(left + 0.35 * (right - left), y, steps=3)
    page.mouse.up()
    expect(scopes).to_contain_text("Δt 0.6", timeout=LONG)
    expect(error).not_to_contain_text("15.2")  # Of what lies between them.
    page.get_by_role("combobox", name="What the readings tell").select_option("value")
    expect(error).to_contain_text("Δ", timeout=LONG)
    page.mouse.click(left + 0.9 * (right - left), y)
    expect(scopes).not_to_contain_text("Δt")


def test_wheel_and_drag_zoom_and_numbers_follow(page: Page) -> None:
    scopes = region(page, "Scopes")
    scopes.get_by_role("button", name="Table").click()
    table = region(page, "Scopes as numbers")
    expect(table.get_by_role("rowheader", name="5", exact=True)).to_be_visible(timeout=LONG)
    scopes.get_by_role("button", name="Table").click()
    expect(table).to_be_hidden()
    box = page.locator(".chart").first.bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.wheel(0, -900)
    page.mouse.down()
    page.mouse.move(x + 100, y, steps=4)
    page.mouse.up()
    scopes.get_by_role("button", name="Table").click()
    expect(table.get_by_role("rowheader", name=re.compile(r"^7\.\d\d"))).not_to_have_count(
        0, timeout=LONG
    )
    expect(table.get_by_role("rowheader", name="5", exact=True)).to_have_count(0)
    scopes.get_by_role("button", name="Reset").click()
    expect(table.get_by_role("rowheader", name="5", exact=True)).to_be_visible(timeout=LONG)


def test_a_scenario_tells_its_schedule_and_where_the_model_errs(page: Page) -> None:
    choose_scenario(page, "fig5")
    scenario = region(page, "Scenario")
    expect(scenario).to_contain_text("At 90 s: A compensation on", timeout=LONG)
    expect(region(page, "Plant")).to_contain_text("≠ the controllers' model")
    expect(region(page, "Metrics")).to_contain_text("174 to 180 s", timeout=LONG)


def test_named_sets_are_kept_and_used(page: Page) -> None:
    set_field(page, "B k_p x, N/mm", "400")
    button(page, "Sets…")
    sheet = page.get_by_role("dialog", name="Gain sets")
    sheet.get_by_role("textbox", name="Name of the set").fill("stiff")
    sheet.get_by_role("button", name="Save present values").click()
    sheet.get_by_role("button", name="Close").click()
    button(page, "Discard")
    expect(region(page, "Changes")).to_contain_text("None")
    button(page, "Sets…")
    stiff = sheet.get_by_role("article", name="gain set stiff")
    expect(stiff).to_contain_text("B kp x 400 N/mm", timeout=LONG)
    expect(stiff).to_contain_text("max |ex|")
    sheet.get_by_role("button", name="Use stiff").click()
    expect(region(page, "Changes")).to_contain_text("400")
    button(page, "Sets…")
    sheet.get_by_role("button", name="Delete the gain set stiff").click()
    expect(stiff).to_have_count(0, timeout=LONG)


def test_a_reload_loses_nothing(page: Page, server: Server) -> None:
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "250")
    button(page, "Play")
    wait_for_clock(page, 1.0)
    button(page, "Pause")
    state(page, "paused")
    before = stands_at(page, server)
    page.reload()
    state(page, "paused")
    assert stands_at(page, server) == before
    expect(region(page, "Changes")).to_contain_text("250", timeout=LONG)


def test_a_server_that_restarts_gets_the_session_back(page: Page, server: Server) -> None:
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "250")
    button(page, "Play")
    wait_for_clock(page, 0.5)
    server.stop()
    connection = page.locator(".connection")
    try:
        expect(connection).to_have_text("connection lost, trying again", timeout=LONG)
        button(page, "STOP")
        expect(page.locator("button.stop")).to_contain_text("not sent, trying", timeout=LONG)
    finally:
        server.start()
    expect(connection).to_have_text("connected", timeout=LONG)
    expect(page.get_by_text(re.compile("session was gone"))).to_be_visible(timeout=LONG)
    expect(page.locator("button.stop")).to_have_text("STOP", timeout=LONG)
    state(page, "paused")
    expect(page.locator(".clock")).to_contain_text("0:00.000", timeout=LONG)
    expect(region(page, "Changes")).to_contain_text("250", timeout=LONG)


def test_axe_finds_nothing_serious(page: Page) -> None:
    button(page, "Play")
    wait_for_clock(page, 1.0)
    button(page, "Pause")
    state(page, "paused")
    assert serious(page) == []
    for toggle in page.get_by_role("button", name="Table").all():
        toggle.click()
    button(page, "Sets…")
    expect(page.get_by_role("dialog", name="Gain sets")).to_be_visible()
    assert serious(page) == []


def test_a_command_before_there_is_a_session(browser: Browser, server: Server) -> None:
    page = browser.new_page()
    page.route("**/api/v1/scenarios", lambda _: None)  # the server takes its time
    page.goto(server.url)
    page.get_by_role("heading", name="Motion Lab").wait_for()
    page.keyboard.press("Space")
    expect(page.get_by_text("There is no session yet")).to_be_visible(timeout=LONG)
    button(page, "STOP")
    expect(page.get_by_text("STOP was not taken. There is no session yet")).to_be_visible()
    page.close()


def test_another_tab_keeps_its_session(page: Page, server: Server) -> None:
    other = page.context.new_page()
    other.goto(page.url)
    other.get_by_text("connected", exact=True).wait_for()
    choose_scenario(page, "rhombus")
    expect(region(page, "Trajectory")).to_contain_text("polygon", timeout=LONG)
    other.keyboard.press("S")
    wait_for_clock(other, 0.09)
    name = session(other, server)["id"]
    other.close()
    page.request.delete(f"{server.url}{API}/sessions/{name}")
