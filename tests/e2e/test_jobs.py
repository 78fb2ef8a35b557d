"""Jobs seen, opened and stopped from any screen."""

from __future__ import annotations

import re

from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import API, LONG, button, region, serious, until
from tests.e2e.conftest import Server

SLOW = 240_000  # ms; a job on a machine that does much else


def tray(page: Page) -> Locator:
    """Open the list of jobs."""
    page.get_by_role("button", name=re.compile("^Jobs:")).click()
    return page.get_by_role("dialog", name="Jobs")


def item(page: Page, name: str) -> Locator:
    return page.get_by_role("dialog", name="Jobs").get_by_role("listitem", name=name)


def test_a_job_is_seen_and_stopped_from_another_screen(page: Page, server: Server) -> None:
    page.goto(f"{server.url}/?screen=paper")
    page.get_by_role("button", name=re.compile("^Compute them")).click()
    expect(page.get_by_role("progressbar", name="Reproduction, share done")).to_be_visible()
    page.get_by_role("link", name="Tune", exact=True).click()
    expect(region(page, "Search")).to_be_visible(timeout=LONG)
    header = page.get_by_role("button", name=re.compile("^Jobs: 1 job runs"))
    expect(header).to_have_text("1")
    header.press("Enter")
    job = item(page, "Reproduction")
    expect(job).to_contain_text(re.compile(r"waits for|\d+\s%"))
    expect(job).to_contain_text("so far", timeout=SLOW)
    assert serious(page) == []
    button(job, "Stop")
    expect(job).to_contain_text("stopped", timeout=LONG)
    expect(page.get_by_role("button", name="Jobs: no jobs run")).to_be_visible()
    page.keyboard.press("Escape")
    page.get_by_role("link", name="Paper", exact=True).click()
    expect(region(page, "Run")).to_contain_text("Cancelled")


def test_one_of_elsewhere_is_opened_at_the_screen_of_its_result(page: Page, server: Server) -> None:
    masses = [5.0 + k / 100 for k in range(200)]
    jobs = tray(page)
    body = {"grid": [{"path": "plant.x.mass", "values": masses}]}
    job = page.request.post(f"{server.url}{API}/sweep", data=body).json()["id"]
    button(item(page, "Sweep").first, "Open")
    expect(jobs).to_be_hidden()
    expect(page).to_have_url(re.compile("screen=sweep"))
    expect(region(page, "Swept fields")).to_contain_text("200 cases", timeout=LONG)
    page.request.delete(f"{server.url}{API}/jobs/{job}")


def test_nothing_is_asked_while_nothing_runs(page: Page) -> None:
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    jobs = tray(page)
    until(page, "the open list asks", lambda: any("/jobs/now" in url for url in asked), LONG)
    expect(page.get_by_role("button", name="Jobs: no jobs run")).to_be_visible(timeout=SLOW)
    expect(jobs).to_be_visible()
    button(jobs, "Close")
    page.wait_for_timeout(1500)
    asked.clear()
    page.wait_for_timeout(3000)
    assert not [url for url in asked if "/jobs/now" in url]
