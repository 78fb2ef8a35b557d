"""Gains, what-if changes and paths that a person made, through whatever is done next."""

from __future__ import annotations

from pathlib import Path

from playwright.sync_api import Browser, Locator, Page, expect

from tests.e2e.actions import (
    API,
    LONG,
    button,
    choose_scenario,
    metric,
    region,
    session,
    set_field,
    simulated,
    state,
    until,
)
from tests.e2e.conftest import Server


def _message(page: Page) -> Locator:
    return page.locator(".message")


def _choose(page: Page, scenario: str) -> None:
    choose_scenario(page, scenario)


def test_another_scenario_says_what_it_leaves_and_undo_brings_it_back(page: Page) -> None:
    changes = region(page, "Changes")
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "619")
    expect(changes).to_contain_text("619", timeout=LONG)
    page.get_by_role("radio", name="Staged").click()
    set_field(page, "B k_d x, N s/mm", "2.9")
    _choose(page, "rhombus")
    expect(_message(page)).to_contain_text(
        "circle was left with 2 changes, 1 of them staged: B kp x, B kd x.", timeout=LONG
    )
    expect(changes).to_contain_text("None")
    changes.get_by_role("button", name="Undo").click()
    expect(changes).to_contain_text("619", timeout=LONG)
    expect(changes).to_contain_text("2.9")
    expect(changes.get_by_role("button", name="Send 1 to motor")).to_be_enabled()
    expect(region(page, "Trajectory")).to_contain_text("circle")


def test_gains_are_taken_along_to_another_scenario(page: Page) -> None:
    set_field(page, "B k_p x, N/mm", "619")
    _choose(page, "circle-matched")
    button(page, "Keep the gains")
    expect(page.get_by_role("textbox", name="B k_p x, N/mm")).to_have_value("619")
    expect(region(page, "Plant").get_by_role("combobox", name="Motor")).to_have_value("matched")


def test_what_if_changes_stay_with_their_session(page: Page, server: Server) -> None:
    set_field(page, "B k_p x, N/mm", "619")
    expect(region(page, "Changes")).to_contain_text("619", timeout=LONG)
    first = page.url
    other = page.request.post(f"{server.url}{API}/sessions", data={}).json()["id"]
    page.goto(f"{server.url}/?session={other}")
    expect(_message(page)).to_contain_text("One staged change waits", timeout=LONG)
    expect(region(page, "Changes")).to_contain_text("None")
    set_field(page, "B k_p y, N/mm", "250")
    button(page, "Go back")
    expect(page.get_by_role("textbox", name="B k_p x, N/mm")).to_have_value("619", timeout=LONG)
    expect(page.get_by_role("textbox", name="B k_p y, N/mm")).to_have_value("280.5")
    assert page.evaluate("new URL(location.href).searchParams.get('session')") in first
    page.request.delete(f"{server.url}{API}/sessions/{other}")


def test_play_says_which_gains_it_runs(page: Page, server: Server) -> None:
    set_field(page, "B k_p x, N/mm", "619")
    set_field(page, "B k_d x, N s/mm", "2.9")
    changes = region(page, "Changes")
    button(page, "Play as it was")
    state(page, "playing")
    assert session(page, server)["scenario"]["variants"]["B"]["controller"]["x"]["k_p"] == 200300
    button(page, "Pause")
    expect(changes.get_by_role("button", name="Play with 2 changes")).to_be_enabled(timeout=LONG)
    page.keyboard.press("Space")
    state(page, "playing")
    assert session(page, server)["scenario"]["variants"]["B"]["controller"]["x"]["k_p"] == 619000
    button(page, "Pause")
    expect(changes.get_by_role("button", name="Play", exact=True)).to_be_enabled(timeout=LONG)


def test_a_path_is_given_by_its_name_and_plays_again_when_it_has_finished(page: Page) -> None:
    page.keyboard.press("l")
    set_field(page, "B k_p x, N/mm", "619")
    expect(region(page, "Changes")).to_contain_text("619", timeout=LONG)
    page.get_by_role("radio", name="Staged").click()
    set_field(page, "B k_d x, N s/mm", "2.9")
    page.get_by_role("link", name="Trajectories").click()
    page.get_by_label("start from").select_option("line")  # It has an end.
    give = page.get_by_role("button", name="Send to motor")
    expect(give).to_be_enabled(timeout=LONG)
    page.get_by_role("textbox", name="Name of the path").fill("my-path")
    button(page, "Save")
    expect(_message(page)).to_contain_text("Saved as my-path")
    give.click()
    expect(region(page, "Trajectory").locator("header")).to_contain_text("my-path", timeout=LONG)
    scenario, changes = region(page, "Scenario"), region(page, "Changes")
    expect(scenario).to_contain_text("my-path in place of its own path")
    expect(changes).to_contain_text("619")
    expect(changes.get_by_role("button", name="Send 1 to motor")).to_be_enabled()
    page.reload()
    expect(scenario).to_contain_text("my-path in place of its own path", timeout=LONG)
    changes.get_by_role("slider", name="speed").press("End")
    button(page, "Play as it was")
    state(page, "finished")
    silent = "all => all.filter(one => !one.title).map(one => one.innerText)"
    assert page.get_by_role("button", disabled=True).evaluate_all(silent) == []
    expect(changes.get_by_role("button", name="Play with 1 change")).to_be_enabled()
    changes.get_by_role("slider", name="speed").press("Home")  # else it has ended when looked at
    button(page, "Play as it was")
    state(page, "playing")


def test_a_new_session_runs_at_real_time(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.get_by_role("slider", name="speed").press("End")
    expect(page.locator(".bar")).to_contain_text("10×")  # noqa: RUF001
    page.reload()
    expect(page.locator(".bar")).to_contain_text("10×")  # noqa: RUF001
    _choose(page, "rhombus")
    expect(page.locator(".bar")).to_contain_text("1.0×", timeout=LONG)  # noqa: RUF001


def test_messages_float_and_go_and_errors_stay(
    page: Page, tmp_path: Path, refusals: list[str]
) -> None:
    refusals.append("422")
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    box = page.locator("main").bounding_box()
    (tmp_path / "letter.toml").write_text("dear = sir\n")
    (tmp_path / "half.toml").write_text("seed = 7\n")
    for name in ("letter.toml", "half.toml"):
        page.get_by_label("Scenario file").set_input_files(tmp_path / name)
        expect(_message(page)).to_contain_text(name, timeout=LONG)
    set_field(page, "seed", "7")
    button(page, "Send 1 to motor")
    expect(_message(page)).to_contain_text("went back to 0 s", timeout=LONG)
    expect(_message(page)).to_have_count(1)
    assert page.locator("main").bounding_box() == box
    button(page, "Show 2 more")
    expect(_message(page)).to_have_count(3)
    letter = page.locator(".message", has_text="letter.toml")
    expect(letter).to_contain_text("letter.toml cannot be read: it is not TOML: ")
    expect(letter).to_contain_text("(at line 1, column 8)")
    expect(page.get_by_role("button", name="STOP")).to_be_in_viewport(ratio=1)
    page.mouse.move(700, 10)
    page.get_by_role("button", name="STOP").focus()
    expect(_message(page)).to_have_count(2, timeout=LONG)  # The notice has gone by itself.
    letter.get_by_role("button", name="Dismiss message").click()
    expect(_message(page)).to_have_count(1)
    expect(_message(page)).to_contain_text("half.toml was not opened")


def test_an_error_is_that_of_the_value_that_stands(page: Page, refusals: list[str]) -> None:
    refusals.append("422")
    set_field(page, "B k_p x, N/mm", "-5")
    field = page.get_by_role("textbox", name="B k_p x, N/mm")
    told = region(page, "Controllers").get_by_role("alert")
    expect(told).to_contain_text("Is out of range", timeout=LONG)
    field.fill("ab")
    expect(told).to_have_count(0)
    set_field(page, "B k_p x, N/mm", "abc")
    expect(told).to_have_text("“abc” is not a number.")
    expect(field).to_have_attribute("aria-invalid", "true")
    set_field(page, "B k_p x, N/mm", "400")
    expect(told).to_have_count(0)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    assert float(metric(page, "max |e", 1)) < 2.0


def test_two_scenarios_on_the_notice_still_brings_the_changes_back(page: Page) -> None:
    changes = region(page, "Changes")
    set_field(page, "B k_p x, N/mm", "619")
    _choose(page, "rhombus")
    expect(_message(page)).to_contain_text("circle was left with one change", timeout=LONG)
    _choose(page, "pentagram")
    expect(region(page, "Scenario")).to_contain_text("pentagram", timeout=LONG)
    undo = changes.get_by_role("button", name="Undo")
    expect(undo).to_have_attribute("title", "Go back to the session before, circle, at 0 s (u)")
    _message(page).get_by_role("button", name="Undo").click()
    expect(page.get_by_role("textbox", name="B k_p x, N/mm")).to_have_value("619", timeout=LONG)
    expect(changes.get_by_role("button", name="Send 1 to motor")).to_be_enabled()


def test_undo_of_apply_makes_what_if_changes_of_it_again(page: Page) -> None:
    changes = region(page, "Changes")
    set_field(page, "B k_p x, N/mm", "619")
    set_field(page, "B k_d x, N s/mm", "2.9")
    button(page, "Play with 2 changes")
    state(page, "playing")
    button(page, "Pause")
    undo = changes.get_by_role("button", name="Undo")
    expect(undo).to_have_attribute(
        "title", "Take back what was sent to the motor: B kp x, B kd x (u)", timeout=LONG
    )
    undo.click()
    expect(changes.get_by_role("button", name="Send 2 to motor")).to_be_enabled(timeout=LONG)
    # What was undone is not played again unasked; the marks of both stay.
    button(page, "Play")
    state(page, "playing")
    button(page, "Pause")
    expect(changes.get_by_role("button", name="Send 2 to motor")).to_be_enabled()
    expect(page.get_by_role("button", name="Play with 2 changes")).to_be_visible()


def test_what_the_schedule_switches_is_no_change_of_ones_own(page: Page, server: Server) -> None:
    _choose(page, "fig5")
    expect(region(page, "Scenario")).to_contain_text("90 s", timeout=LONG)
    ident = page.evaluate("new URL(location.href).searchParams.get('session')")
    for _ in range(10):
        page.request.post(f"{server.url}{API}/sessions/{ident}/step", data={"ticks": 18_100})
    expect(region(page, "Changes")).to_contain_text("B compensation", timeout=LONG)
    _choose(page, "circle")

    def scenario() -> str:
        return (
            session(page, server).get("scenario", {}).get("name", "")
        )  # none while it is replaced

    until(page, "the circle is loaded", lambda: scenario() == "circle")
    expect(region(page, "Changes")).to_contain_text("None", timeout=LONG)
    expect(_message(page)).to_have_count(0)


def test_a_copied_link_opens_the_same_lab_elsewhere(
    page: Page, browser: Browser, server: Server
) -> None:
    """With what the session has, what-if changes, readings and zoom; its session may be gone."""
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    set_field(page, "B k_p x, N/mm", "312")
    button(page, "Send 1 to motor")
    expect(region(page, "Changes")).to_contain_text("Undo")
    set_field(page, "B k_p y, N/mm", "250")
    _, wanted = simulated(page, server, axis="y")
    metrics = region(page, "Metrics")
    expect(metrics).not_to_contain_text(wanted, timeout=LONG)
    expect(metrics).to_contain_text("exact", timeout=LONG)
    scopes = region(page, "Scopes")
    scopes.get_by_role("combobox", name="What the readings tell").select_option("RMS")
    scopes.locator("canvas").first.hover()
    page.mouse.wheel(0, -400)
    expect(scopes.get_by_role("button", name="Reset")).to_be_enabled()
    button(page, "Copy link")
    expect(_message(page)).to_contain_text("on the clipboard")
    link = page.evaluate("navigator.clipboard.readText()")
    assert "session=" not in link
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    try:
        fresh = context.new_page()
        fresh.goto(link)
        opened = region(fresh, "Metrics")
        expect(opened).to_contain_text("exact", timeout=LONG)
        expect(opened).to_have_text(metrics.inner_text(), use_inner_text=True, timeout=LONG)
        for axis, value in (("x", "312"), ("y", "250")):
            field = fresh.get_by_role("textbox", name=f"B k_p {axis}, N/mm")
            expect(field).to_have_value(value)
        expect(region(fresh, "Changes")).to_contain_text("250")
        scopes = region(fresh, "Scopes")
        expect(scopes.get_by_role("button", name="Reset")).to_be_enabled()
        expect(scopes.get_by_role("combobox", name="What the readings tell")).to_have_value("rms")
        fresh.wait_for_url(lambda url: "draft" not in url)  # the zoom stays in it
        context.request.delete(f"{server.url}{API}/sessions/{session(fresh, server)['id']}")
    finally:
        context.close()
