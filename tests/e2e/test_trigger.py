"""The trigger of the scopes: hits of a record and of a running session, and what is around them."""

from __future__ import annotations

import json
import re
import time
from typing import Any
from urllib.parse import parse_qs, urlparse

import httpx
import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from motionlab.analysis.glitches import glitches, reversals
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD
from tests.e2e.actions import API, LONG, button, region, set_field, until
from tests.e2e.conftest import Server

TOLD = re.compile(r"^Peak of .*: .* at [\d.]+ s")
LENGTH = 0.2
BEFORE = 0.25
"""Of a capture: s, and the share of it before the trigger, as the page proposes them."""


def trigger(page: Page) -> Locator:
    return page.get_by_role("region", name="Trigger", exact=True)


def captures(panel: Locator) -> Locator:
    return panel.get_by_role("table", name="Captures").locator("tr:has(th[scope=row])")


def figures(row: Locator) -> list[float]:
    """Return peak and glitch height of a capture, um."""
    texts = row.locator("td").all_inner_texts()[1:]
    return [float(text.replace("\N{MINUS SIGN}", "-")) for text in texts]


def readings(page: Page, trace: str) -> dict[str, str]:
    table = region(page, "Measurements as numbers")
    row = table.get_by_role("row", name=trace)
    heads = [head.strip() for head in table.locator("thead th").all_inner_texts()]
    cells = [text.replace("−", "-") for text in row.locator("td").all_inner_texts()]  # noqa: RUF001
    return dict(zip(heads[1:], cells, strict=True))


def test_the_glitch_is_found_and_its_height_is_the_recording_s(
    page: Page, refusals: list[str]
) -> None:
    refusals += ["422"]  # a ballbar of less than a lap
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    prepared = prepare(load_scenario("circle"))
    start, stop = prepared.window
    recording = run(prepared)
    velocity = np.asarray(recording.references[1, 0], dtype=float)
    turns = [turn.tick for turn in reversals(velocity) if start <= turn.tick < stop]
    page.get_by_role("combobox", name="Layout of the scopes").select_option("Paper figure")
    page.keyboard.press("M")
    page.keyboard.press("h")
    panel = trigger(page)
    hits = panel.get_by_role("status")
    expect(hits).to_have_text(f"{len(turns)} of {len(turns)} hits", timeout=LONG)
    error = recording.variants["A"].channel("following_error", "x")
    before = round(BEFORE * LENGTH / CONTROL_PERIOD)
    count = round(LENGTH / CONTROL_PERIOD)
    velocities = velocity.astype(np.float32).astype(float)
    count_size = prepared.scenario.plant.x.encoder.resolution
    rows = captures(panel)
    expect(rows).to_have_count(len(turns), timeout=LONG)
    for place, turn in enumerate(turns):
        row = rows.nth(place)
        expect(row.get_by_role("button")).to_have_attribute("aria-current", "true", timeout=LONG)
        expect(row.get_by_role("button")).to_have_text(f"{turn * CONTROL_PERIOD:.4f}")
        ends = ((turn - before) * CONTROL_PERIOD, (turn - before + count) * CONTROL_PERIOD)
        expect(region(page, "Plane")).to_contain_text(
            "{:.6g} to {:.6g} s".format(*(round(end, 2) for end in ends))
        )
        part = error[turn - before : turn - before + count]
        wanted = 1e6 * float(np.ptp(part))
        end = time.monotonic() + 1e-3 * LONG
        read = readings(page, "Following error x of A")
        while float(read["p-p"]) != pytest.approx(wanted, rel=0.006) and time.monotonic() < end:
            page.wait_for_timeout(100)  # readings change a few times a second
            read = readings(page, "Following error x of A")
        assert read["unit"] == "µm"
        assert float(read["p-p"]) == pytest.approx(wanted, rel=0.006)
        assert float(read["most"]) == pytest.approx(1e6 * part.max(), rel=0.006)
        assert float(read["least"]) == pytest.approx(1e6 * part.min(), rel=0.006)
        peak, height = figures(row)
        assert peak == pytest.approx(1e6 * part[np.abs(part).argmax()], rel=0.006)
        around = slice(turn - before, turn - before + count)
        (glitch,) = glitches(
            velocities[around], part.astype(float), count=count_size, period=CONTROL_PERIOD
        )
        assert height == pytest.approx(1e6 * glitch.height, rel=0.006)
        row.get_by_role("button").focus()
        page.keyboard.press("ArrowDown")
    button(panel, "Overlay")
    button(panel, "Average")
    button(panel, "Off")
    expect(hits).to_have_text("")


def peaks_of(values: np.ndarray, prominence: float) -> list[int]:
    """Extremes to which and from which the curve goes by the prominence."""
    found, low, high, way = [], 0, 0, 0
    for i, value in enumerate(values):
        high = i if value > values[high] else high
        low = i if value < values[low] else low
        if way >= 0 and values[high] - value >= prominence:
            found += [high] if way else []
            way, low = -1, i
        elif way <= 0 and value - values[low] >= prominence:
            found += [low] if way else []
            way, high = 1, i
    return found


def test_the_next_peak_is_found_in_every_sample(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    prepared = prepare(load_scenario("circle"))
    start, stop = prepared.window
    error = run(prepared).variants["A"].channel("following_error", "x")
    peaks = peaks_of(error[: stop + 1], 0.1 * float(np.ptp(error[start:stop])))
    at = min(peak for peak in peaks if peak > start)
    page.keyboard.press("k")
    told = page.get_by_text(TOLD)
    text = told.inner_text().replace("\N{MINUS SIGN}", "-").replace("\xa0", " ")
    found = re.search(r"A\.x\.following_error: (-?[\d.]+) µm at ([\d.]+) s", text)
    assert found, text
    assert float(found[2]) == pytest.approx(at * CONTROL_PERIOD, abs=1e-9)
    assert float(found[1]) == pytest.approx(1e6 * error[at], rel=0.006)
    first = re.compile(re.escape(f"at {found[2]} s"))
    page.keyboard.press("k")
    expect(told).not_to_contain_text(first)
    page.keyboard.press("K")
    expect(told).to_contain_text(first)


def test_a_level_with_hysteresis_in_what_is_visible(page: Page, refusals: list[str]) -> None:
    refusals += ["422"]  # a ballbar of less than a lap
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    button(region(page, "Scopes"), "Trigger")
    panel = trigger(page)
    panel.get_by_role("combobox", name="Condition 1", exact=True).select_option("level")
    channel = panel.get_by_role("button", name=re.compile("^Channel of condition 1: "))
    channel.focus()
    page.keyboard.press("ArrowDown")
    page.keyboard.type("following a x")
    page.keyboard.press("ArrowDown")
    page.keyboard.press("ArrowUp")
    found = panel.get_by_role("listbox", name="Channel of condition 1")
    expect(found.get_by_role("option", selected=True)).to_contain_text("A.x.following_error")
    page.keyboard.press("Escape")
    expect(channel).to_be_focused()
    expect(channel).to_have_text("Following error x of A")
    channel.click()
    page.keyboard.type("following b x")
    page.keyboard.press("Enter")
    expect(channel).to_have_text("Following error x of B")
    channel.click()
    page.keyboard.type("following a x")
    found.get_by_role("option", name="A.x.following_error").click()
    expect(channel).to_be_focused()
    level = panel.get_by_role("textbox", name="Level 1")
    level.fill("10")
    level.press("Enter")
    hysteresis = panel.get_by_role("textbox", name=re.compile("^Hysteresis 1"))
    hysteresis.fill("5")
    hysteresis.press("Enter")
    button(panel, "Find")
    prepared = prepare(load_scenario("circle"))
    start, stop = prepared.window
    error = run(prepared).variants["A"].channel("following_error", "x")[start:stop]
    hits, high = 0, bool(error[0] >= 10e-6)
    for value in error:
        if not high and value >= 10e-6:
            hits, high = hits + 1, True
        elif high and value < 5e-6:
            high = False
    assert hits > 0
    expect(panel.get_by_role("status")).to_have_text(f"{hits} of {hits} hits", timeout=LONG)


def armed(page: Page, most: int) -> Locator:
    """Arm the trigger of the session for some reversals of x, and play."""
    page.keyboard.press("l")
    page.keyboard.press("h")
    panel = trigger(page)
    field = panel.get_by_role("textbox", name="Most captures")
    field.fill(str(most))
    field.press("Enter")
    expect(panel.get_by_role("status").first).to_have_text("Armed: waiting")
    button(page, "Play")
    return panel


def test_a_capture_of_a_session_is_a_run_from_the_moment_it_is_taken(
    page: Page, server: Server, refusals: list[str]
) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    panel = armed(page, 3)
    expect(panel.get_by_role("status").first).to_have_text("Done: 3 captured", timeout=LONG)
    # Where the reference of the scenario turns, to the tick.
    velocity = np.asarray(prepare(load_scenario("circle")).reference.velocity[:, 0])
    turns = [turn.tick for turn in reversals(velocity)][:3]
    rows = captures(panel)
    times = [f"{turn * CONTROL_PERIOD:.4f}" for turn in reversed(turns)]
    for place, text in enumerate(times):
        expect(rows.nth(place).get_by_role("button")).to_have_text(text)
    expect(panel.get_by_role("button", name="Open", exact=True)).to_be_enabled(timeout=LONG)
    listed: list[dict[str, Any]] = []
    end = time.monotonic() + 1e-3 * LONG
    while len(listed) < len(turns) and time.monotonic() < end:
        listed = httpx.get(f"{server.url}{API}/runs?q=tag:capture&limit=3").json()["runs"]
        page.wait_for_timeout(100)
    assert [run["capture"]["trigger_tick"] for run in listed] == list(reversed(turns))
    assert {(run["ticks"], run["kept"]) for run in listed} == {(400, False)}
    assert all(
        run["note"].startswith("Trigger: reversal of x.velocity_reference.\n") for run in listed
    )
    # The session goes, the captures stay: listed anew after a reload, and shown from their runs.
    refusals += ["404"]  # of the session that is gone
    name = page.evaluate("new URL(location.href).searchParams.get('session')")
    httpx.delete(f"{server.url}{API}/sessions/{name}").raise_for_status()
    expect(page).not_to_have_url(re.compile(f"session={name}"), timeout=LONG)
    page.reload()
    expect(region(page, "Metrics")).to_be_visible(timeout=LONG)
    page.keyboard.press("l")
    page.keyboard.press("h")
    for place, text in enumerate(times):
        expect(rows.nth(place).get_by_role("button")).to_have_text(text, timeout=LONG)
    rows.nth(0).get_by_role("button").click()
    page.keyboard.press("ArrowDown")
    expect(rows.nth(1).get_by_role("button")).to_be_focused()
    wanted = offline_error(turns[1])
    peak, _ = figures(rows.nth(1))
    assert peak == pytest.approx(1e6 * wanted[np.abs(wanted).argmax()], rel=0.006)
    page.keyboard.press("M")
    read = {"p-p": "nan"}
    end = time.monotonic() + 1e-3 * LONG
    while float(read["p-p"].replace("\N{EN DASH}", "nan")) != pytest.approx(
        1e6 * float(np.ptp(wanted)), rel=0.006
    ):
        assert time.monotonic() < end, read
        page.wait_for_timeout(100)
        read = readings(page, "Following error x of A")
    rows.nth(0).get_by_role("checkbox").check()
    rows.nth(1).get_by_role("checkbox").check()
    button(panel, "Average")
    run_id = listed[1]["id"]
    button(panel, "Open")
    expect(page).to_have_url(re.compile(f"run={run_id}"))
    expect(region(page, "Run").get_by_role("region", name="Following error x")).to_be_visible()


def offline_error(turn: int) -> np.ndarray:
    """Return the error of A along x in a capture at a tick of the circle."""
    error = run(prepare(load_scenario("circle"))).variants["A"].channel("following_error", "x")
    first = turn - round(BEFORE * LENGTH / CONTROL_PERIOD)
    return error[first : first + round(LENGTH / CONTROL_PERIOD)]


def test_a_capture_that_cannot_be_kept_stands_with_the_reason(
    page: Page, refusals: list[str]
) -> None:
    refusals += ["507"]
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    full = {"title": "Insufficient Storage", "status": 507, "detail": "runs take all of their room"}
    page.route(
        re.compile(r"/sessions/[^/]+/captures$"),
        lambda route: route.fulfill(
            status=507, json=full, headers={"content-type": "application/problem+json"}
        ),
    )
    panel = armed(page, 1)
    expect(panel.get_by_role("alert")).to_contain_text("runs take all of their room", timeout=LONG)
    expect(captures(panel).first).to_contain_text("not kept")
    page.unroute_all()
    button(panel, "Keep")
    expect(panel.get_by_role("button", name="Open", exact=True)).to_be_enabled(timeout=LONG)
    expect(panel.get_by_role("alert")).to_have_count(0)


def set_cursors(page: Page, scopes: Locator, *shares: float) -> None:
    """Click at shares of the width of the scope in front."""
    chart = scopes.locator(".chart canvas").first
    box = chart.bounding_box()
    assert box
    for share in shares:
        chart.click(position={"x": share * box["width"], "y": box["height"] / 2})
    page.mouse.move(1, 1)


def cursors_of(page: Page) -> list[float]:
    """Return the cursors that the address of a run has."""
    curves = parse_qs(urlparse(page.url).query)["curves"][0]
    return json.loads(curves).get("cursors", [])


def test_the_link_of_a_capture_shows_it_as_it_is(
    page: Page, server: Server, refusals: list[str]
) -> None:
    page.context.grant_permissions(["clipboard-read", "clipboard-write"])
    refusals += ["404"]  # of the overlaid run, once it is deleted
    body = {"scenario": "circle", "keep": True, "name": "before"}
    overlaid = httpx.post(f"{server.url}{API}/simulate", json=body, timeout=60).json()["run"]
    page.goto(f"{page.url}&overlay={overlaid}")
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    panel = armed(page, 1)
    expect(panel.get_by_role("button", name="Open", exact=True)).to_be_enabled(timeout=LONG)
    set_field(page, "Offset of before, s", "0.1")
    set_cursors(page, region(page, "Scopes"), 0.4, 0.6)
    page.keyboard.press("M")
    expect(region(page, "Measurements as numbers")).to_be_visible(timeout=LONG)
    panel.get_by_role("button", name="Copy link", exact=True).click()
    expect(page.get_by_text("The link is on the clipboard.")).to_be_visible()
    link = page.evaluate("navigator.clipboard.readText()")
    query = {key: value[0] for key, value in parse_qs(urlparse(link).query).items()}
    (run,) = httpx.get(f"{server.url}{API}/runs?q=tag:capture&limit=1").json()["runs"]
    start = run["capture"]["from_tick"] * CONTROL_PERIOD
    assert query["run"] == query["large"] == run["id"]
    name, offset = query["overlay"].split(":")
    assert (name, float(offset)) == (overlaid, pytest.approx(0.1 - start, abs=1e-6))
    # Elsewhere: the same readings at the same cursors, and the run behind it.
    other = page.context.new_page()
    other.goto(link)
    scopes = region(other, "Scopes of the run")
    expect(scopes).to_contain_text("before", timeout=LONG)
    expect(region(other, "Measurements as numbers")).to_be_visible(timeout=LONG)
    columns = ("now", "Δ", "p-p")
    wanted = [readings(page, "Following error x of A")[column] for column in columns]

    def same() -> bool:
        there = readings(other, "Following error x of A")
        return [there.get(column) for column in columns] == wanted

    until(other, "the readings are the same", same)
    # A third click clears the cursors, as in the Lab; the next two set them again.
    assert len(cursors_of(other)) == 2
    set_cursors(other, scopes, 0.5)
    until(other, "no cursor", lambda: len(cursors_of(other)) == 0)
    set_cursors(other, scopes, 0.3, 0.7)
    until(other, "two cursors", lambda: len(cursors_of(other)) == 2)
    # The Lab's own address has cursors and capture.
    until(page, "the address has the capture", lambda: run["id"] in page.url)
    other.goto(re.sub(r"session=[^&]+&?", "", page.url))
    shown = captures(trigger(other)).first.get_by_role("button")
    expect(shown).to_have_attribute("aria-current", "true", timeout=LONG)
    other.close()
    httpx.delete(f"{server.url}{API}/runs/{overlaid}")
