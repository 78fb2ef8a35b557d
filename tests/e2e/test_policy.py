"""The content security policy: no screen breaks it; and a browser that logs in and out."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, Route, expect

from tests.e2e.actions import LONG, region
from tests.e2e.conftest import Server, missing

TOKEN = "a-token-of-some-length"
RECORD = """
window.violations = [];
document.addEventListener('securitypolicyviolation', (event) =>
  window.violations.push(`${event.violatedDirective} ${event.blockedURI}`));
"""
INJECT = """
document.head.append(
  Object.assign(document.createElement('script'), { textContent: 'window.injected = 1' }));
"""


@pytest.fixture
def watched(fresh: None, unopened: None, page: Page, server: Server) -> Page:
    """The lab, with a record of what its policy refuses."""
    page.add_init_script(RECORD)
    page.goto(server.url)
    page.get_by_text("connected", exact=True).wait_for()
    return page


def test_no_screen_breaks_the_policy(watched: Page, refusals: list[str]) -> None:
    links = watched.get_by_role("navigation", name="Screens").get_by_role("link")
    names = links.all_text_contents()
    assert len(names) >= 5
    for name in names:
        links.filter(has_text=re.compile(f"^{name}$")).click()
        watched.wait_for_load_state("networkidle")
    assert watched.evaluate("violations") == []
    refusals.append("Content Security Policy")
    watched.evaluate(INJECT)
    assert watched.evaluate("window.injected") is None
    assert watched.evaluate("violations") == ["script-src-elem inline"]


@pytest.mark.usefixtures("fresh")
def test_every_screen_has_its_page_of_the_documentation(page: Page, server: Server) -> None:
    """Whose search finds things, under the policy; the last screen is followed by its link."""
    if page.request.get(f"{server.url}/help/").status == 404:
        missing("the documentation is not built: make docs")
    help_link = page.locator(".bar").get_by_role("link", name="Help", exact=True)
    links = page.get_by_role("navigation", name="Screens").get_by_role("link")
    for name in links.all_text_contents():
        links.filter(has_text=re.compile(f"^{name}$")).click()
        address = help_link.get_attribute("href")
        assert page.request.get(f"{server.url}{address}").status == 200, address
    page.context.add_init_script(RECORD)
    with page.expect_popup() as opened:
        help_link.click()
    manual = opened.value
    errors: list[str] = []
    manual.on("console", lambda m: errors.append(m.text) if m.type == "error" else None)
    expect(manual.get_by_role("heading", level=1)).to_contain_text("Drive")
    assert manual.evaluate("violations") == []
    manual.get_by_role("searchbox").or_(manual.get_by_placeholder("Search")).first.fill(
        "presliding"
    )
    manual.keyboard.press("Enter")
    expect(manual.locator("#search-results").get_by_role("link", name="Glossary")).to_be_visible()
    assert manual.evaluate("violations") == []
    assert errors == []


def test_no_link_leads_to_a_documentation_that_is_not_there(page: Page, server: Server) -> None:
    def without(route: Route) -> None:
        answer = route.fetch()
        route.fulfill(response=answer, json=answer.json() | {"help": False})

    page.route("**/api/v1/health", without)
    page.goto(server.url)
    expect(page.get_by_role("button", name="Keys and help")).to_be_visible()
    expect(page.locator(".bar").get_by_role("link", name="Help", exact=True)).to_have_count(0)
    page.keyboard.press("?")
    expect(page.get_by_role("dialog", name="Keys and help")).to_be_visible()
    expect(page.locator('a[href^="/help"]')).to_have_count(0)


def test_the_theme_is_set_before_the_page_loads(page: Page, refusals: list[str]) -> None:
    refusals.append("ERR_FAILED")
    # Parts that come later have come.
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    page.wait_for_load_state("networkidle")
    page.route("**/assets/*.js", lambda route: route.abort())
    page.evaluate("localStorage.setItem('motionlab.theme', 'light')")
    page.goto(page.url)
    assert page.evaluate("document.documentElement.dataset.theme") == "light"


@pytest.fixture
def guarded(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    server = Server(tmp_path_factory.mktemp("data"), MOTIONLAB_TOKEN=TOKEN)
    yield server
    server.stop()


def test_a_browser_logs_in_and_out(browser: Browser, guarded: Server) -> None:
    with browser.new_context() as context:
        page = context.new_page()
        page.goto(guarded.url)
        for given in ("wrong", TOKEN):
            page.get_by_label("Token", exact=True).fill(given)
            page.get_by_role("button", name="Continue").click()
            if given == "wrong":
                expect(page.get_by_role("alert")).to_contain_text("not this server's token")
        expect(page.get_by_text("connected", exact=True)).to_be_visible()
        [cookie] = context.cookies()
        assert TOKEN not in cookie.get("value", "")
        page.get_by_role("button", name="Log out").click()
        expect(page.get_by_role("heading", name="This server asks for its token")).to_be_visible()
        assert context.cookies() == []
