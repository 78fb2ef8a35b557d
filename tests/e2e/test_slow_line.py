"""The lab over a line that cannot carry every sample."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.actions import LONG, button, wait_for_clock
from tests.e2e.conftest import VIEW, Server
from tests.server.slow_line import SlowLine

FAST = 1e8  # bytes/s
SLOW = 50e3


@pytest.fixture
def line(server: Server) -> Iterator[SlowLine]:
    with SlowLine(server.port, FAST, 0.04) as line:
        yield line


@pytest.fixture
def far(browser: Browser, line: SlowLine) -> Iterator[Page]:
    """Return the lab as it opens over the line."""
    context = browser.new_context(viewport=VIEW)
    page = context.new_page()
    page.goto(f"http://127.0.0.1:{line.port}/")
    page.get_by_text("connected", exact=True).wait_for()
    yield page
    context.close()


def test_a_slow_line_is_thinned_and_says_so(far: Page, line: SlowLine) -> None:
    expect(far.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    line.rate = SLOW
    button(far, "Play")
    wait_for_clock(far, 0.5)
    said = far.locator("footer").get_by_text(re.compile(r"^thinned to \d+\spoints/s: slow line$"))
    expect(said).to_be_visible(timeout=LONG)
    expect(far.locator("footer")).to_contain_text("0 dropped")
    # A staged gain has its exact result meanwhile.
    far.get_by_role("radio", name="Staged").click()
    with far.expect_response("**/api/v1/whatif", timeout=LONG) as answer:
        far.get_by_role("slider", name="B k_p x", exact=True).press("ArrowRight")
    question = answer.value.request.post_data_json
    assert question is not None
    assert question["points"] < 1000
    expect(far.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    line.rate = FAST
    expect(said).to_have_count(0, timeout=LONG)
    button(far, "Pause")
