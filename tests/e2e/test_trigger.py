"""The trigger of the scopes: hits of a record and of a running session, and what is around them."""

from __future__ import annotations

import re
import time

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.results.glitches import reversals
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.e2e.actions import LONG, button, region

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
        part = error[turn - before : turn - before + count]
        wanted = 1e6 * float(np.ptp(part))
        end = time.monotonic() + 1e-3 * LONG
        read = readings(page, "Following error x A")
        while float(read["p-p"]) != pytest.approx(wanted, rel=0.006) and time.monotonic() < end:
            page.wait_for_timeout(100)  # readings change a few times a second
            read = readings(page, "Following error x A")
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


def test_a_session_is_captured_as_it_runs_and_the_capture_stands(page: Page) -> None:
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.keyboard.press("l")
    button(region(page, "Scopes"), "Trigger")
    panel = trigger(page)
    most = panel.get_by_role("textbox", name="Most captures")
    most.fill("3")
    most.press("Enter")
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
    button(panel, "Off")
    expect(panel.locator(".count")).to_have_count(0)
