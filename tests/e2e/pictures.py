"""Take the pictures of the docs: python -m tests.e2e.pictures, or some: ... lab view3d."""

from __future__ import annotations

import contextlib
import json
import re
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from urllib.parse import urlencode

from playwright.sync_api import Browser, expect, sync_playwright

from motionlab.drive.virtual.process import VirtualDrive
from tests.e2e.actions import API, LONG, link_file, region, set_field, state
from tests.e2e.conftest import CHROMIUM, FLAGS, ROOT, SOFTWARE_GL, Server

DOCS = ROOT / "docs"
_GARDEN = {
    "kind": "path",
    "points": [
        [0.06, 0.0],
        [0.045, 0.05],
        [0.0, 0.03],
        [-0.03, 0.09],
        [-0.06, 0.04],
        [-0.05, -0.02],
        [-0.065, -0.07],
        [-0.01, -0.05],
        [0.03, -0.1],
        [0.055, -0.05],
    ],
    "closed": True,
    "geometry": "spline",
    "law": "constant_speed",
    "v_max": 0.062,
    "a_max": 0.8,
    "laps": 2,
}


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
                if name == "view3d":
                    flags = [flag for flag in FLAGS if flag != "--disable-gpu"] + SOFTWARE_GL
                browser = playwright.chromium.launch(executable_path=CHROMIUM, args=flags)
                begun = time.time()
                take, files = _TAKES[name]
                take(browser, server)
                browser.close()
                stale = [file for file in files if (DOCS / file).stat().st_mtime < begun]
                assert not stale, f"{name} has not taken {stale}"
    return 0


def _lab(browser: Browser, server: Server) -> None:
    """Drag a gain of B in what-if, in each theme; the picture is taken before it is let go."""
    for theme in ("light", "dark"):
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=theme)
        page.goto(server.url)
        state(page, "paused")
        expect(region(page, "Metrics")).to_contain_text("B vs A", timeout=LONG)
        box = page.get_by_role("slider", name="B k_p x").bounding_box()
        assert box is not None
        height = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + 0.43 * box["width"], height)
        page.mouse.down()
        page.mouse.move(box["x"] + 0.62 * box["width"], height, steps=12)
        page.wait_for_timeout(2500)  # The readings follow the curves within a second.
        page.screenshot(path=DOCS / f"lab-{theme}.png")
        page.mouse.up()
        page.close()


def _learning(browser: Browser, server: Server) -> None:
    """Learn the circle with the reference controller, and put what was learnt into the Lab."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    controller = json.dumps({"variants.B.controller": "lugre-reference"})
    page.goto(f"{server.url}/?{urlencode({'scenario': 'circle-matched', 'set': controller})}")
    page.locator(".badge.exact").first.wait_for(timeout=LONG)
    panel = region(page, "Learning")
    panel.locator("summary").first.click()
    panel.get_by_role("button", name="Learn", exact=True).click()
    panel.get_by_role("button", name="Put into the Lab").click(timeout=120_000)
    expect(panel).to_contain_text("in the Lab", timeout=LONG)
    page.wait_for_timeout(2500)
    page.screenshot(path=DOCS / "learning-light.png")
    page.close()


def _view3d(browser: Browser, server: Server) -> None:
    """Play the circle and cut through the x movers of B, over the whole page."""
    page = browser.new_page(viewport={"width": 1440, "height": 720}, color_scheme="light")
    page.goto(f"{server.url}/?view3d=section.B.x.filled")
    state(page, "paused")
    page.keyboard.press("Space")
    state(page, "playing")
    page.locator("iframe:not([inert])").wait_for(timeout=LONG)
    page.wait_for_timeout(9000)  # Drawing in software is slow.
    page.keyboard.press("Space")
    page.wait_for_timeout(3000)
    page.screenshot(path=DOCS / "3d-view.png")
    page.close()


def _trajectories(browser: Browser, server: Server) -> None:
    """Open a smooth path with one bend that needs too much thrust."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.request.put(f"{server.url}{API}/trajectories/garden", data=_GARDEN)
    page.goto(f"{server.url}/?screen=trajectories")
    page.get_by_role("button", name="Open garden").click()
    limits = region(page, "Limits")
    expect(limits).to_contain_text("y needs too much thrust", timeout=LONG)
    page.wait_for_timeout(1500)
    page.screenshot(path=DOCS / "trajectories-light.png")
    page.close()


def _identify(browser: Browser, server: Server) -> None:
    """Identify the matched motor, compare and apply."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=identify")
    page.get_by_label("motor", exact=True).select_option("matched")
    page.get_by_role("button", name="Identify", exact=True).click()
    page.get_by_role("button", name="Compare old with new").click(timeout=300_000)
    compared = region(page, "Compare").get_by_role("columnheader", name="change")
    compared.wait_for(timeout=120_000)
    page.get_by_role("button", name="Stage in Lab").click()
    page.wait_for_timeout(1500)
    page.screenshot(path=DOCS / "identify-light.png")
    page.close()


def _tune(browser: Browser, server: Server) -> None:
    """Search gains, map the cost, measure the loop and compare."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=tune")
    state(page, "paused")
    for name in ("Search gains", "Map the cost"):
        page.get_by_role("button", name=name, exact=True).click()
    page.get_by_role("progressbar").first.wait_for()
    expect(page.get_by_role("progressbar")).to_have_count(0, timeout=300_000)
    page.get_by_role("button", name="Measure", exact=True).click()
    page.get_by_role("button", name="Compare", exact=True).click()
    page.wait_for_timeout(8000)
    page.screenshot(path=DOCS / "tune.png")
    page.close()


def _sweep(browser: Browser, server: Server) -> None:
    """Search both gains of B on x, for error against margin."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=sweep")
    state(page, "paused")
    page.get_by_role("button", name="Add a field").click()
    page.get_by_label("values", exact=True).select_option(label="searched")
    set_field(page, "samples", "64")
    for number, metric in enumerate(("max |e|", "gain margin"), 1):
        page.get_by_role("button", name="Add an objective").click()
        page.get_by_role("button", name=re.compile(f"^Objective {number}")).click()
        page.keyboard.type(f"B x {metric}")
        page.keyboard.press("Enter")
    page.get_by_role("button", name="Add a limit").click()
    page.get_by_role("button", name="Run", exact=True).click()
    region(page, "Swept fields").get_by_text("took").wait_for(timeout=120_000)
    page.get_by_role("slider").focus()
    for key in ["ArrowRight"] * 2 + ["Shift+ArrowDown"] * 30 + ["Enter", "Escape"]:
        page.keyboard.press(key)  # the end of the front with the least error
    page.get_by_role("heading", name="Result").click()
    page.wait_for_timeout(1500)
    page.screenshot(path=DOCS / "sweep.png")
    page.close()


def _motor(browser: Browser, server: Server) -> None:
    """Size, look at the field of one phase, share a force."""
    for tab in ("sizing", "field", "sharing"):
        theme = "dark" if tab == "field" else "light"
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme=theme)
        name, view = ("maps", "&view=field&map=new-design") if tab == "field" else (tab, "")
        page.goto(f"{server.url}/?screen=motor&tab={name}{view}")
        page.get_by_text("connected", exact=True).wait_for(timeout=120_000)
        if tab == "sizing":
            expect(region(page, "Results")).to_contain_text("stack length", timeout=LONG)
        if tab == "field":
            page.get_by_text("flux linkage").wait_for(timeout=120_000)
        if tab == "sharing":
            page.get_by_role("checkbox", name="sine").check()
            page.get_by_role("figure", name="sine", exact=True).wait_for(timeout=120_000)
        page.wait_for_timeout(2500)
        page.screenshot(path=DOCS / f"motor-{tab}-{theme}.png")
        page.close()


def _paper(browser: Browser, server: Server) -> None:
    """Compute the paper's numbers and look at Table 1."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    page.goto(f"{server.url}/?screen=paper&row=pentagram-y")
    page.get_by_role("button", name="Compute them").click()
    region(page, "Run").get_by_text("took").wait_for(timeout=300_000)
    page.get_by_role("link", name="Position errors").click()
    page.wait_for_timeout(1500)
    page.screenshot(path=DOCS / "paper-light.png")
    page.close()


def _compare(browser: Browser, server: Server) -> None:
    """Compare the shipped circle with a stiffer B."""
    page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
    kept = []
    for name, scenario, gain in (
        ("pentagram", "pentagram", 200.3e3),
        ("stiffer", "circle", 312e3),
        ("shipped", "circle", 200.3e3),
    ):
        changes = {"variants.B.controller.x.k_p": gain}
        body = {"scenario": scenario, "keep": True, "name": name, "set": changes}
        kept.append(page.request.post(f"{server.url}{API}/simulate", data=body).json()["run"])
    rule = {"absolute": 5e-7, "relative": 0.05, "time": 0.0}
    how = {"tolerance": rule | {"absolute": 0.0}, "channels": {"*.following_error": rule}}
    query = urlencode({"run": f"{kept[2]},{kept[1]}", "compare": json.dumps(how)})
    page.goto(f"{server.url}/?screen=runs&{query}")
    compared = region(page, "Compare")
    expect(compared).to_contain_text("channels beyond tolerance", timeout=LONG)
    for unfinished in ("comparing", "reading"):
        expect(compared).not_to_contain_text(unfinished, timeout=LONG)
    page.wait_for_timeout(2500)
    page.screenshot(path=DOCS / "runs-compare.png")
    page.close()


def _report(browser: Browser, server: Server) -> None:
    """Type another gain of A in a report from disk: its following error lies over the recorded."""
    page = browser.new_page(viewport={"width": 1100, "height": 760}, color_scheme="light")
    body = {"scenario": "circle", "keep": True}
    run = page.request.post(f"{server.url}{API}/simulate", data=body).json()["run"]
    with tempfile.NamedTemporaryFile(suffix=".html") as file:
        file.write(page.request.get(f"{server.url}{API}/runs/{run}/report").body())
        file.flush()
        page.goto(Path(file.name).as_uri())
        gain = page.get_by_role("textbox", name="A k_p x, N/mm")
        gain.fill("600")
        gain.press("Enter")
        expect(page.get_by_role("status")).to_contain_text("Computed", timeout=LONG)
        plot = page.locator("figure").filter(
            has=page.locator("title", has_text="Following error x")
        )
        plot.evaluate("(plot) => scrollTo(0, plot.getBoundingClientRect().top + scrollY - 330)")
        page.screenshot(path=DOCS / "report-light.png")
    page.close()


def _drive(browser: Browser, _: Server) -> None:
    """Take control of a virtual drive in real time, arm it, and let a drive fail."""
    with VirtualDrive(priority=70) as drive, tempfile.TemporaryDirectory() as folder:
        server = Server(Path(folder), "--drive", str(link_file(drive, Path(folder))))
        page = browser.new_page(viewport={"width": 1440, "height": 900}, color_scheme="light")
        page.goto(f"{server.url}/?screen=drive")
        headline = region(page, "State").get_by_role("status")
        expect(headline).to_have_text("Ready to arm", timeout=180_000)
        page.wait_for_timeout(60_000)  # The figures are those of a minute.
        page.get_by_role("button", name="Take control").click()
        drive.switch(fault={"node": 5, "code": 0x2310})
        expect(headline).to_contain_text("Fault of drive 5", timeout=LONG)
        page.wait_for_timeout(1500)
        page.screenshot(path=DOCS / "drive-light.png")
        page.close()
        server.stop()


_TAKES: dict[str, tuple[Callable[[Browser, Server], None], tuple[str, ...]]] = {
    "lab": (_lab, ("lab-light.png", "lab-dark.png")),
    "learning": (_learning, ("learning-light.png",)),
    "trajectories": (_trajectories, ("trajectories-light.png",)),
    "identify": (_identify, ("identify-light.png",)),
    "tune": (_tune, ("tune.png",)),
    "sweep": (_sweep, ("sweep.png",)),
    "compare": (_compare, ("runs-compare.png",)),
    "motor": (
        _motor,
        ("motor-sizing-light.png", "motor-field-dark.png", "motor-sharing-light.png"),
    ),
    "report": (_report, ("report-light.png",)),
    "drive": (_drive, ("drive-light.png",)),
    "paper": (_paper, ("paper-light.png",)),
    "view3d": (_view3d, ("3d-view.png",)),
}

PICTURES = {file for _, files in _TAKES.values() for file in files}
"""Every picture of docs/ that is taken here."""


if __name__ == "__main__":
    sys.exit(main())
