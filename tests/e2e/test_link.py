"""A network that dies silently: the page says so, and STOP is sent until it is answered."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import LONG, button, session, state, until, wait_for_clock
from tests.e2e.conftest import Server

NO_DATA = re.compile(r"^no data since \d+ s$")
Fault = Callable[[Page, Server], AbstractContextManager[None]]
UNSENT = re.compile(r"not sent, trying")


@pytest.fixture
def refusals() -> list[str]:
    return ["ERR_INTERNET_DISCONNECTED", "ERR_TIMED_OUT", "ERR_ABORTED", "ERR_NETWORK_CHANGED"]


@contextmanager
def offline(page: Page, _: Server) -> Iterator[None]:
    """Take the network away, as a Wi-Fi drop does."""
    browser = page.context.new_cdp_session(page)
    limits = {"latency": 0, "downloadThroughput": -1, "uploadThroughput": -1}
    browser.send("Network.enable")
    browser.send("Network.emulateNetworkConditions", {"offline": True, **limits})
    try:
        yield
    finally:
        browser.send("Network.emulateNetworkConditions", {"offline": False, **limits})
        browser.detach()


@contextmanager
def frozen(_: Page, server: Server) -> Iterator[None]:
    """Freeze the server: connections stay open, and nothing answers."""
    os.kill(server.pid, signal.SIGSTOP)
    try:
        yield
    finally:
        os.kill(server.pid, signal.SIGCONT)


FAULTS = pytest.mark.parametrize("fault", [offline, frozen], ids=["offline", "frozen"])


@FAULTS
def test_stop_without_a_network_stops_once_it_is_back(
    page: Page, server: Server, fault: Fault
) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    header = page.locator(".bar").get_by_role("status")
    stop = page.locator("button.stop")
    with fault(page, server):
        expect(header).to_have_text(NO_DATA, timeout=LONG)
        expect(header).to_have_css("color", "rgb(179, 38, 30)")
        expect(page.get_by_text("connected", exact=True)).to_have_count(0)
        button(page, "STOP")
        expect(stop).to_have_text(UNSENT, timeout=LONG)
        expect(page.get_by_role("alert")).to_contain_text("sent again until it is")
        page.wait_for_timeout(3000)
        expect(stop).to_have_text(UNSENT)
    until(page, "stopped", lambda: session(page, server)["state"] == "stopped")
    state(page, "stopped")
    expect(stop).to_have_text("STOPPED", timeout=LONG)
    expect(page.get_by_text("connected", exact=True)).to_be_visible(timeout=LONG)
    expect(page.locator(".message")).to_have_count(0)


@FAULTS
def test_pause_without_a_network_says_that_it_is_not_sent_again(
    page: Page, server: Server, fault: Fault
) -> None:
    button(page, "Play")
    wait_for_clock(page, 0.5)
    with fault(page, server):
        button(page, "Pause")
        notice = page.get_by_text("Pause was not answered, and is not sent again.")
        expect(notice).to_be_visible(timeout=LONG)


@FAULTS
def test_a_page_at_rest_does_not_claim_a_connection(
    page: Page, server: Server, fault: Fault
) -> None:
    with fault(page, server):
        expect(page.locator(".connection")).not_to_have_text("connected", timeout=LONG)
        expect(page.locator(".bar").get_by_role("status")).to_have_text(
            re.compile(r"^no (answer since|connection)"), timeout=LONG
        )
    expect(page.locator(".connection")).to_have_text("connected", timeout=LONG)
    state(page, "paused")
