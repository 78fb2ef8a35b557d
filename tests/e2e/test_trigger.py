"""The trigger of the scopes: hits of a record and of a running session, and what is around them."""

from __future__ import annotations

import re
import time

import httpx
import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from motionlab.analysis.glitches import reversals
from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.timing import CONTROL_PERIOD
from tests.e2e.actions import API, LONG, button, region
from tests.e2e.conftest import Server

TOLD = re.compile(r"^Peak of .*: .* at [\d.]+ s")
LENGTH = 0.2
BEFORE = 0.25
"""Of a capture: s, and the share of it before the trigger, as the page proposes them."""


def trigger(page: Page) -> Locator:
    return page.get_by_role("region", name="Trigger", exact=True)


def readings(page: Page, trace: str) -> dict[str, str]:
    table = region(page, "Measurements as numbers")
    row = table.get_by_role("row", name=trace)
    heads = [head.strip() for head in table.locator("thead th").all_inner_texts()]
    cells = [text.replace("−", "-") for text in row.locator("td").all_inner_texts()]  # noqa: RUF001
    return dict(zip(heads[1:], cells, strict=True))


def test_the_glitch_is_found_and_its_height_is_the_recording_s(page: Page) -> None:
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
    for place, turn in enumerate(turns):
        expect(panel).to_contain_text(f"{place + 1} of {len(turns)}", timeout=LONG)
        at = re.search(r"at\s([\d.]+) s", panel.inner_text())
        assert at and float(at[1]) == pytest.approx(turn * CONTROL_PERIOD, abs=1e-9)
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
        if place < len(turns) - 1:
            button(panel, "Next capture")
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


def test_a_level_with_hysteresis_in_what_is_visible(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    button(region(page, "Scopes"), "Trigger")
    panel = trigger(page)
    panel.get_by_role("combobox", name="Condition 1", exact=True).select_option("level")
    channel = panel.get_by_role("combobox", name="Channel of condition 1")
    channel.select_option("A.x.following_error")
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


def test_a_session_is_captured_as_it_runs_and_the_capture_stands(
    page: Page, server: Server, refusals: list[str]
) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.keyboard.press("l")
    button(region(page, "Scopes"), "Trigger")
    panel = trigger(page)
    most = panel.get_by_role("textbox", name="Most captures")
    most.fill("3")
    most.press("Enter")
    panel.get_by_role("checkbox", name="keep as runs").check()
    button(panel, "Arm")
    expect(panel.get_by_role("status")).to_have_text("Armed: waiting")
    button(region(page, "Scenario"), "Play")
    status = panel.get_by_role("status")
    expect(status).to_have_text("Done: 3 captured", timeout=LONG)
    standing = panel.locator(".count").inner_text()
    found = re.search(r"3 of 3\sat ([\d.]+) s", standing)
    assert found
    # Where the reference of the scenario turns, to the tick.
    velocity = np.asarray(prepare(load_scenario("circle")).reference.velocity[:, 0])
    turns = [turn.tick * CONTROL_PERIOD for turn in reversals(velocity)]
    assert float(found[1]) == pytest.approx(turns[2], abs=1e-9)
    page.wait_for_timeout(500)
    assert panel.locator(".count").inner_text() == standing
    kept = panel.get_by_role("button", name=re.compile("^r-"))
    run_id = kept.inner_text()
    turn = round(turns[2] / CONTROL_PERIOD)
    answer = httpx.get(f"{server.url}{API}/runs/{run_id}").json()
    assert (answer["tags"], answer["ticks"]) == (["capture"], round(LENGTH / CONTROL_PERIOD))
    assert answer["note"].startswith("Trigger: reversal of x.velocity_reference.\n")
    listed = httpx.get(f"{server.url}{API}/runs?q=tag:capture").json()["runs"]
    assert len([each for each in listed if each["note"].endswith(answer["note"][-20:])]) == 3
    file = httpx.get(
        f"{server.url}{API}/runs/{run_id}/telemetry?format=csv&columns=x.velocity_reference"
    )
    assert int(file.text.splitlines()[1].split(",")[0]) == turn - round(
        BEFORE * LENGTH / CONTROL_PERIOD
    )
    refusals += ["404"]  # of the session that is gone
    name = page.evaluate("new URL(location.href).searchParams.get('session')")
    httpx.delete(f"{server.url}{API}/sessions/{name}").raise_for_status()
    expect(page).not_to_have_url(re.compile(f"session={name}"), timeout=LONG)
    expect(page.locator(".clock")).to_contain_text("0:00.000")
    expect(panel.locator(".count")).to_have_text(standing)
    kept.click()
    expect(region(page, "Run").get_by_role("region", name="Following error x")).to_be_visible()
