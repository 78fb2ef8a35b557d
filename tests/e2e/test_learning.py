"""Learning from lap to lap in the Lab screen, in a real browser."""

from __future__ import annotations

import json
from typing import Any

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import (
    API,
    LONG,
    asked_for,
    button,
    command,
    metric,
    region,
    serious,
    session,
    set_field,
    tab_to,
    until,
)
from tests.e2e.conftest import Server

PATIENT = 120_000  # ms; the first study of a new model compiles its kernel
LEARNT = {
    "learnt",
    "variants.B.controller.learnt",
    *(
        f"variants.B.controller.model.{axis}.subdivision.{part}"
        for axis in "xy"
        for part in ("sine", "cosine")
    ),
}


def _open(page: Page, server: Server, scenario: str, controller: str) -> Locator:
    """Open the Lab with that controller as B, and its panel Learning."""
    changes = json.dumps({"variants.B.controller": controller})
    page.goto(f"{server.url}/?scenario={scenario}&set={changes}&mode=whatif")
    page.locator(".badge.exact").first.wait_for(timeout=LONG)
    command(page, "iterative learning")
    panel = region(page, "Learning")
    panel.locator("summary").first.click()
    expect(panel.get_by_role("button", name="Learn", exact=True)).to_be_visible()
    return panel


def _curve(panel: Locator, column: str) -> list[float]:
    """Return a column of the table beside the picture."""
    numbers = panel.get_by_role("button", name="Table of Laps")
    numbers.click()
    table = panel.get_by_role("region", name="Laps as numbers").get_by_role("table")
    names = [name.split()[0] for name in table.locator("thead th").all_inner_texts()]
    cells = table.locator("tbody tr").locator(f":nth-child({names.index(column) + 1})")
    values = [float(text) for text in cells.all_inner_texts()]
    numbers.click()
    return values


def _staged(page: Page) -> set[str]:
    """Return the paths that are staged in the session of the address."""
    return set(
        page.evaluate(
            "Object.keys(JSON.parse(localStorage.getItem("
            "'motionlab.draft.' + new URL(location.href).searchParams.get('session'))))"
        )
    )


def _shows(page: Page, panel: Locator, result: dict[str, Any]) -> None:
    """Curves, sentences and the encoder's error are those that the server has found."""
    for sentence in result["summary"]:
        expect(panel).to_contain_text(sentence)
    for axis in "xy":
        peaks = _curve(panel, axis)
        laps = result["axes"][axis]["laps"]
        assert peaks == pytest.approx([1e6 * lap["peak"] for lap in laps], rel=6e-3)
        assert peaks[0] > 5 * peaks[-1]
    found = panel.get_by_role("table", name="Laps of learning").locator("tbody td:last-child")
    assert [float(text) for text in found.all_inner_texts()] == pytest.approx([40, 40], abs=1)
    for picture in ("Growth", "Force", "Remains", "Laps"):
        panel.get_by_role("radio", name=picture, exact=True).click()
        expect(panel.get_by_role("figure")).to_be_visible()
        expect(panel).not_to_contain_text("Comes with the last lap")
    assert serious(page, within='[aria-label="Learning"]') == []


def _drags(page: Page) -> None:
    """The page computes what a slider shows: the force does not travel while it moves."""
    page.locator(".badge.exact").first.wait_for(timeout=LONG)
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url) if request.post_data else None)
    slider = page.get_by_role("slider", name="B k_p x")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 0.45 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.5 * box["width"], box["y"] + box["height"] / 2, steps=5)
    expect(page.locator(".badge")).to_have_text("preview")
    page.wait_for_timeout(500)
    lanes = [url for url in asked if url.endswith("/whatif/lanes")]
    page.mouse.up()
    assert lanes == []
    page.locator(".badge.exact").first.wait_for(timeout=LONG)
    assert 0 < float(metric(page, "max |ex|", 1)) < 0.2


def _sends(page: Page, server: Server) -> None:
    """A motor that starts anew takes what is staged."""
    before = session(page, server)["id"]
    button(page, "Send 7 to motor")
    expect(page.get_by_text("learnt force hold from the start")).to_be_visible(timeout=LONG)
    now = session(page, server)
    assert now["id"] != before
    assert now["scenario"]["learnt"]["laps"] == 8


def test_a_force_is_learnt_put_into_the_lab_and_forgotten(page: Page, server: Server) -> None:
    panel = _open(page, server, "circle-matched", "lugre-reference")
    set_field(panel, "laps", "8")
    learn = panel.get_by_role("button", name="Learn", exact=True)
    job = asked_for(page, learn.click)
    use = panel.get_by_role("button", name="Put into the Lab")
    expect(use).to_be_enabled(timeout=PATIENT)

    _shows(page, panel, page.request.get(f"{server.url}{API}/jobs/{job}").json()["result"])
    use.click()
    expect(panel).to_contain_text("8 laps of 3.00 s")
    expect(panel.locator("summary").first).to_contain_text("in the Lab")
    chips = page.get_by_role("list", name="Changes, staged first")
    expect(chips).to_contain_text("8 laps")
    assert _staged(page) == LEARNT
    for row in ("max |ex|", "max |ey|"):
        until(page, f"{row} of B is small", lambda row=row: float(metric(page, row, 1)) < 0.2)

    _drags(page)
    expect(panel.locator("summary").first).to_contain_text("stale")
    _sends(page, server)

    page.keyboard.press("w")
    panel.get_by_role("button", name="Forget").click()
    expect(panel.get_by_role("status").first).to_have_text("none")
    assert _staged(page) == {"learnt", "variants.B.controller.learnt"}
    until(page, "max |ey| of B is as before", lambda: float(metric(page, "max |ey|", 1)) > 0.5)
    page.reload()
    page.locator(".badge.exact").first.wait_for(timeout=LONG)
    assert _staged(page) == {"learnt", "variants.B.controller.learnt"}


def test_what_would_diverge_is_refused_at_its_field_and_learnt_anyway(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("422")
    panel = _open(page, server, "circle-resonant", "lugre-reference-notch")
    panel.get_by_text("More settings").click()
    set_field(panel, "learning bandwidth y, Hz", "200")
    set_field(panel, "drawn motors", "4")
    set_field(panel, "laps", "3")
    tab_to(page, "Learn")
    page.keyboard.press("Enter")
    field = panel.get_by_role("textbox", name="learning bandwidth y, Hz")
    expect(field).to_have_attribute("aria-invalid", "true", timeout=LONG)
    expect(panel.get_by_role("alert")).to_contain_text("would grow by")
    assert serious(page, within='[aria-label="Learning"]') == []
    tab_to(page, "Learn anyway")
    page.keyboard.press("Enter")
    expect(panel).to_contain_text("y diverges: at", timeout=PATIENT)
    expect(panel).not_to_contain_text("other settings than the form shows")

    # A bandwidth that converges needs no more than to be asked for.
    set_field(panel, "learning bandwidth y, Hz", "60")
    expect(panel).to_contain_text("other settings than the form shows: bandwidth")
    button(panel, "Learn")
    expect(panel).to_contain_text("y converges: at", timeout=PATIENT)
