"""The page /docs: Swagger UI on this server's API, without anything from elsewhere."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.conftest import PATIENCE, Server
from tests.e2e.test_policy import RECORD


@pytest.fixture(scope="module")
def docs(browser: Browser, server: Server) -> Iterator[Page]:
    """The page, loaded; an error on its console, or a request that leaves the origin, fails."""
    context = browser.new_context(viewport={"width": 1440, "height": 900})
    page = context.new_page()
    page.set_default_timeout(PATIENCE)
    complaints: list[str] = []
    asked: list[str] = []
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: asked.append(request.url))
    page.add_init_script(RECORD)
    page.goto(f"{server.url}/docs")
    yield page
    context.close()
    assert complaints == []
    assert f"{server.url}/openapi.json" in asked
    elsewhere = ("data:", "blob:")  # pictures of the style sheet, and what was received
    assert [url for url in asked if not url.startswith((f"{server.url}/", *elsewhere))] == []


def test_an_operation_is_opened_and_executed(docs: Page) -> None:
    expect(docs.get_by_role("heading", name="PSRM Motion Lab")).to_be_visible()
    docs.locator("[id^=operations-][id$=-listScenarios] .opblock-summary-control").click()
    docs.get_by_role("button", name="Try it out").click()
    docs.get_by_role("button", name="Execute").click()
    answer = docs.locator(".live-responses-table .response")
    expect(answer.locator(".response-col_status")).to_contain_text("200")
    expect(answer.locator(".response-col_description")).to_contain_text('"name": "circle"')


def test_an_operation_far_below_is_reached_by_its_address(docs: Page, server: Server) -> None:
    """From 150 tags and operations on Swagger UI draws only those in view."""
    docs.goto(f"{server.url}/docs#/simulate/predictMinute")
    docs.reload()
    operation = docs.locator("[id^=operations-][id$=-predictMinute]")
    expect(operation).to_be_in_viewport()
    expect(operation.get_by_role("button", name="Try it out")).to_be_visible()


def test_every_script_is_a_file_of_the_server(docs: Page) -> None:
    """A Content-Security-Policy with script-src 'self' has to let the page work."""
    scripts = docs.locator("script").all()
    assert scripts
    for script in scripts:
        own = docs.evaluate("location.origin")
        assert script.evaluate("(each) => each.src").startswith(f"{own}/assets/")


def test_the_page_keeps_to_its_policy(docs: Page) -> None:
    expect(docs.locator(".swagger-ui").first).to_be_visible()
    assert docs.evaluate("violations") == []
