"""Take the pictures of the docs: python -m tests.e2e.pictures, or some: ... lab stage."""

from __future__ import annotations

import contextlib
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Browser, expect, sync_playwright

from tests.e2e.actions import LONG, region, state, wait_for_clock
from tests.e2e.conftest import CHROMIUM, FLAGS, ROOT, SOFTWARE_GL, Server


def main() -> int:
    """Take the pictures that were asked for, or all."""
    if CHROMIUM is None:
        print("no Chromium on this machine: make browser installs Debian's", file=sys.stderr)
        return 1
    unknown = [name for name in sys.argv[1:] if name not in _TAKES]
    if unknown:
        print(f"no picture {unknown[0]!r}: there are {', '.join(_TAKES)}", file=sys.stderr)
        return 2
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as ended:
        server = Server(Path(folder))
        ended.callback(server.stop)
        with sync_playwright() as playwright:
            for name in sys.argv[1:] or _TAKES:
                flags = FLAGS
                if name == "stage":
                    flags = [flag for flag in FLAGS if flag != "--disable-gpu"] + SOFTWARE_GL
                browser = playwright.chromium.launch(executable_path=CHROMIUM, args=flags)
                _TAKES[name](browser, server)
                browser.close()
    return 0


def _lab(browser: Browser, server: Server) -> None:
    """Play the circle for seven seconds in each theme."""
    for theme in ("light", "dark"):
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=theme)
        page.goto(server.url)
        state(page, "paused")
        page.keyboard.press("Space")
        wait_for_clock(page, 7.0)
        page.keyboard.press("Space")
        state(page, "paused")
        page.wait_for_timeout(1200)  # The readings follow the curves within a second.
        page.screenshot(path=ROOT / "docs" / f"lab-{theme}.png")
        page.close()


def _stage(browser: Browser, server: Server) -> None:
    """Play the rhombus until the traces are whole."""
    page = browser.new_page(viewport={"width": 1200, "height": 600})
    page.goto(server.url)
    state(page, "paused")
    region(page, "Scenario").get_by_role("combobox").first.select_option("rhombus")
    expect(region(page, "Trajectory")).to_contain_text("polygon", timeout=LONG)
    page.keyboard.press("Space")
    state(page, "playing")
    page.goto(f"{server.url}/scene/")
    page.wait_for_timeout(9000)  # The trace is 4 s long; drawing in software is slow.
    page.locator(".mantine-Notification-closeButton").first.click()
    page.wait_for_timeout(2500)
    page.screenshot(path=ROOT / "docs" / "stage.png")
    page.close()


def _identify(browser: Browser, server: Server) -> None:
    """Identify the matched motor, compare and apply."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=identify")
    page.get_by_label("motor").select_option("matched")
    page.get_by_role("button", name="Identify", exact=True).click()
    page.get_by_role("button", name="Compare A (old) with B (new)").click(timeout=300_000)
    region(page, "Compare").get_by_text("B vs A").wait_for(timeout=120_000)
    page.get_by_role("button", name="Apply 12 values").click()
    page.wait_for_timeout(1500)
    page.screenshot(path=ROOT / "docs" / "identify-light.png")
    page.close()


def _tune(browser: Browser, server: Server) -> None:
    """Search gains, map the cost, sweep the loop and compare."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=tune")
    state(page, "paused")
    for name in ("Search gains", "Map the cost"):
        page.get_by_role("button", name=name, exact=True).click()
    page.get_by_role("progressbar").first.wait_for()
    page.wait_for_function("!document.querySelector('progress')", timeout=300_000)
    page.get_by_role("button", name="Sweep", exact=True).click()
    page.get_by_role("button", name="Compare", exact=True).click()
    page.wait_for_timeout(8000)
    page.screenshot(path=ROOT / "docs" / "tune.png")
    page.close()


def _motor(browser: Browser, server: Server) -> None:
    """Size, look at the field of one phase, share a force."""
    for tab in ("sizing", "field", "sharing"):
        theme = "dark" if tab == "field" else "light"
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=theme)
        name, view = ("maps", "&view=field&map=new-design") if tab == "field" else (tab, "")
        page.goto(f"{server.url}/?screen=motor&tab={name}{view}")
        page.get_by_text("connected", exact=True).wait_for(timeout=120_000)
        if tab == "field":
            page.get_by_text("flux linkage").wait_for(timeout=120_000)
        if tab == "sharing":
            page.get_by_role("checkbox", name="sine").check()
            page.get_by_role("figure", name="sine", exact=True).wait_for(timeout=120_000)
        page.wait_for_timeout(2500)
        page.screenshot(path=ROOT / "docs" / f"motor-{tab}-{theme}.png")
        page.close()


def _paper(browser: Browser, server: Server) -> None:
    """Compute the paper's numbers and look at Table 1."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=paper&row=pentagram-y")
    page.get_by_role("button", name="Compute them").click()
    region(page, "Run").get_by_text("took").wait_for(timeout=300_000)
    page.get_by_role("link", name="Position errors").click()
    page.wait_for_timeout(1500)
    page.screenshot(path=ROOT / "docs" / "paper-light.png")
    page.close()


_TAKES: dict[str, Callable[[Browser, Server], None]] = {
    "lab": _lab,
    "identify": _identify,
    "tune": _tune,
    "motor": _motor,
    "paper": _paper,
    "stage": _stage,
}


if __name__ == "__main__":
    sys.exit(main())
