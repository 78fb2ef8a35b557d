"""A report opened from disk: gains are dragged, the page simulates, and goes back."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Locator, Page, expect

from tests.e2e.actions import API, LONG, MAX
from tests.e2e.conftest import Server

COUNT = 50e-9
"""One count of the encoder, m."""
DRAG = """
(slider, share) => {
  slider.value = String(share);
  slider.dispatchEvent(new Event('input', { bubbles: true }));
}
"""


@pytest.fixture
def disk(browser: Browser) -> Iterator[Page]:
    """A page without a network; any error on its console fails the test."""
    context = browser.new_context(offline=True, viewport={"width": 1100, "height": 1000})
    page = context.new_page()
    complaints: list[str] = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    yield page
    context.close()
    assert complaints == []


def computed(page: Page, metric: str) -> Locator:
    return page.locator(f'[data-metric="{metric}"] .computed')


def number(cell: Locator) -> float:
    return float(cell.get_attribute("data-value") or "nan")


def curve(page: Page, title: str) -> Locator:
    plot = page.locator("svg").filter(has=page.locator("title", has_text=title))
    return plot.first.locator(".live.b")


@pytest.mark.usefixtures("unopened")
def test_a_gain_of_a_report_is_dragged(
    page: Page, server: Server, disk: Page, tmp_path: Path
) -> None:
    query = {"scenario": "circle", "keep": True}
    run = page.request.post(f"{server.url}{API}/simulate", data=query).json()["run"]
    file = tmp_path / "report.html"
    file.write_bytes(page.request.get(f"{server.url}{API}/runs/{run}/report").body())
    disk.goto(file.as_uri())
    slider = disk.get_by_role("slider", name="B k_p x", exact=True)
    expect(slider).to_be_visible(timeout=LONG)
    drawn, plane = curve(disk, "Following error x"), curve(disk, "Plane")
    metric = computed(disk, f"B x.{MAX}")
    expect(metric).to_have_count(0)
    slider.evaluate(DRAG, 0.55)
    expect(metric).to_be_visible(timeout=LONG)
    first, path = metric.get_attribute("data-value") or "", drawn.get_attribute("d")
    circle = plane.get_attribute("d")
    slider.evaluate(DRAG, 0.6)
    expect(metric).not_to_have_attribute("data-value", first, timeout=LONG)
    assert drawn.get_attribute("d") != path
    assert plane.get_attribute("d") not in {circle, ""}

    field = disk.get_by_role("textbox", name="B k_p x, N/mm")
    changes: dict[str, Any] = {"variants.B.controller.x.k_p": 1e3 * float(field.input_value())}
    body: dict[str, Any] = {"scenario": "circle", "set": changes}
    exact = page.request.post(f"{server.url}{API}/simulate", data=body).json()["variants"]
    for variant, metrics in exact.items():
        for axis in ("x", "y"):
            for name in (MAX, "rms_following_error", "max_abs_position_error"):
                own = number(computed(disk, f"{variant} {axis}.{name}"))
                assert abs(own - metrics["axes"][axis][name]) <= COUNT, (variant, axis, name)
        for name, value in metrics["contour"].items():
            assert abs(number(computed(disk, f"{variant} contour.{name}")) - value) <= COUNT, name

    status = disk.get_by_role("status")
    field.fill("-5")
    field.press("Enter")
    expect(status).to_contain_text("are allowed")
    assert number(metric) == pytest.approx(exact["B"]["axes"]["x"][MAX], abs=COUNT)

    box = disk.get_by_role("checkbox", name="B compensation", exact=True)
    before = metric.get_attribute("data-value") or ""
    box.uncheck()
    expect(metric).not_to_have_attribute("data-value", before, timeout=LONG)
    changes["variants.B.controller.compensation.enabled"] = False
    switched = page.request.post(f"{server.url}{API}/simulate", data=body).json()["variants"]["B"]
    assert abs(number(metric) - switched["axes"]["x"][MAX]) <= COUNT

    disk.get_by_role("button", name="Back to the recorded gains").click()
    expect(status).to_have_text("The recorded gains.")
    expect(metric).to_have_count(0)
    expect(field).to_have_value("200.3")
    expect(box).to_be_checked()
    assert drawn.get_attribute("d") == plane.get_attribute("d") == ""


@pytest.mark.usefixtures("unopened")
def test_a_gain_of_a_comparison_is_dragged(
    page: Page, server: Server, disk: Page, tmp_path: Path
) -> None:
    gain = "variants.B.controller.x.k_p"
    runs = []
    for changes in ({}, {gain: 250e3}):
        query = {"scenario": "circle", "set": changes, "keep": True}
        runs.append(page.request.post(f"{server.url}{API}/simulate", data=query).json()["run"])
    body: dict[str, Any] = {"a": runs[0], "b": runs[1], "only": ["B.x.following_error"]}
    file = tmp_path / "comparison.html"
    file.write_bytes(page.request.post(f"{server.url}{API}/runs/compare/report", data=body).body())
    disk.goto(file.as_uri())
    field = disk.get_by_role("textbox", name="2 B k_p x, N/mm")
    expect(field).to_have_value("250", timeout=LONG)
    field.fill("200.3")  # as of run 1
    field.press("Enter")
    metrics = [computed(disk, f"{run} B x.{MAX}") for run in (1, 2)]
    expect(metrics[1]).to_be_visible(timeout=LONG)
    assert number(metrics[0]) == number(metrics[1])
    difference = disk.locator("svg").filter(has=disk.locator("title", has_text=": run 2"))
    live = difference.locator(".live").get_attribute("d") or ""
    assert len(set(re.findall(r"[ML][\d.]+ ([\d.]+)", live))) == 1  # zero throughout
    assert "V" not in live
    field.fill("400")
    field.press("Enter")
    expect(difference.locator(".live")).not_to_have_attribute("d", live, timeout=LONG)
    changed = {"scenario": "circle", "set": {gain: 400e3}}
    exact = page.request.post(f"{server.url}{API}/simulate", data=changed).json()["variants"]["B"]
    assert abs(number(metrics[1]) - exact["axes"]["x"][MAX]) <= COUNT


@pytest.mark.usefixtures("unopened")
def test_a_loop_that_amplifies_rounding_is_named(
    page: Page, server: Server, disk: Page, tmp_path: Path
) -> None:
    query = {"scenario": "circle-published-k", "keep": True}
    run = page.request.post(f"{server.url}{API}/simulate", data=query).json()["run"]
    file = tmp_path / "report.html"
    file.write_bytes(page.request.get(f"{server.url}{API}/runs/{run}/report").body())
    disk.goto(file.as_uri())
    expect(disk.get_by_role("status")).to_contain_text("amplifies rounding", timeout=LONG)
    expect(disk.locator(".computed")).to_have_count(0)
