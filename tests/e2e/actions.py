"""What the browser tests do with the lab, and what they read off it."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any, Literal

from playwright.sync_api import Browser, Locator, Page, Route, expect

from motionlab.drive.virtual.process import VirtualDrive
from tests.e2e.conftest import PATIENCE, ROOT, Server

LONG = PATIENCE
AXE = ROOT / "frontend" / "node_modules" / "axe-core" / "axe.min.js"
API = "/api/v1"
MAX = "max_abs_following_error"
RMS = "rms_following_error"
ANSWERS = """
window.answers = {};
const Own = window.Worker;
window.Worker = class extends Own {
  constructor(...args) {
    super(...args);
    this.addEventListener('message', ({ data: { answer } }) => {
      if (answer?.windows) window.answers[args.length && this.variant] = answer;
    });
  }
  postMessage(message, ...rest) {
    if (message.request.kind === 'run') this.variant = message.request.run.variant;
    super.postMessage(message, ...rest);
  }
};
"""
"""Keeps the latest answer of the page's kernel, by variant."""
DRAFT = """
JSON.parse(
  Object.entries(localStorage).find(([key]) => key.startsWith('motionlab.draft.'))[1],
)
"""
"""What is staged, as the page keeps it."""


def region(page: Page, name: str) -> Locator:
    return page.get_by_role("region", name=name, exact=True)


def state(page: Page, name: str) -> None:
    expect(page.locator(".bar").get_by_role("status")).to_have_text(name, timeout=LONG)


def clock(page: Page) -> float:
    minutes, seconds = page.locator(".clock").inner_text().replace("s", "").strip().split(":")
    return 60.0 * float(minutes) + float(seconds)


def session(page: Page, server: Server) -> dict[str, Any]:
    """Return what the server knows of the session of the page."""
    name = page.evaluate("new URL(location.href).searchParams.get('session')")
    return page.request.get(f"{server.url}{API}/sessions/{name}").json()


def simulated(
    page: Page, server: Server, name: str = MAX, *, axis: str = "x", **gains: float
) -> list[str]:
    """Return a metric of A and of B on the circle as the page shows it, um.

    Parameters
    ----------
    name : str
        Of the metric.
    axis : str
        x or y.
    **gains : float
        Of B's controller on x, SI.
    """
    changes = {f"variants.B.controller.x.{gain}": value for gain, value in gains.items()}
    answer = page.request.post(
        f"{server.url}{API}/simulate", data={"scenario": "circle", "set": changes}
    )
    variants = answer.json()["variants"].values()
    return [f"{1e6 * variant['axes'][axis][name]:.3g}" for variant in variants]


def stands_at(page: Page, server: Server) -> str:
    """Wait until the clock shows where the session stands that was paused; return what it shows."""
    millis = math.floor(1000 * session(page, server)["time"] + 0.5)  # as the page rounds
    minutes, seconds = divmod(millis / 1000, 60.0)
    shown = f"{minutes:.0f}:{seconds:06.3f}"
    expect(page.locator(".clock")).to_contain_text(shown)
    return shown


def until(page: Page, what: str, holds: Callable[[], bool], most: int = LONG) -> None:
    """Wait, at most some ms, for what no expectation of the page tells; fail with its name."""
    for _ in range(most // 250):
        if holds():
            return
        page.wait_for_timeout(250)
    raise AssertionError(f"waited {most} ms in vain: {what}")


def wait_for_clock(page: Page, seconds: float) -> None:
    page.wait_for_function(
        "least => { const [m, s] = document.querySelector('.clock')?.innerText.split(':') ?? [];"
        " return 60 * +m + parseFloat(s) > least }",
        arg=seconds,
        timeout=LONG,
    )


def scenario_control(page: Page) -> Locator:
    """Return the button with the title of the Lab's scenario, which opens the gallery."""
    return page.get_by_role("button", name=re.compile("^Scenario: "))


def choose_scenario(page: Page, name: str) -> None:
    """Choose an example of the gallery, by the name that commands take."""
    scenario_control(page).click()
    page.get_by_role("dialog", name="Examples").locator(f"[data-scenario={name!r}]").click()


def lab_views(page: Page) -> Locator:
    """Have the Lab's second picture show views, in place of the machine."""
    region(page, "Second view").get_by_role("radio", name="Views", exact=True).click()
    return region(page, "Views")


def shipped_only(page: Page, kind: str) -> None:
    """Let the page see no job of a kind but the shipped result."""

    def answer(route: Route) -> None:
        jobs = route.fetch().json()
        route.fulfill(json=[job for job in jobs if job["shipped"]])

    page.route(f"**/api/v1/jobs?kind={kind}", answer)


def button(page: Page | Locator, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def controller(page: Page, variant: str) -> None:
    """Open the panel of a variant's controller, which folds the other."""
    page.get_by_role("button", name=f"Controller {variant}").click()


def set_field(page: Page | Locator, label: str, value: str) -> None:
    field = page.get_by_role("textbox", name=label, exact=True)
    field.fill(value)
    field.press("Enter")


def metric(page: Page, name: str, column: int) -> str:
    row = region(page, "Metrics").locator("tr", has_text=name).first
    return row.locator("td").nth(column).inner_text()


def tab_to(page: Page, name: str) -> None:
    """Press Tab until the control of that name has the focus."""
    for _ in range(200):
        page.keyboard.press("Tab")
        focused = page.evaluate(
            "() => { const e = document.activeElement;"
            " return (e.getAttribute('aria-label') ?? e.innerText ?? '').trim() }"
        )
        if focused == name:
            return
    raise AssertionError(f"Tab does not reach {name!r}")


def press(page: Page, *keys: str) -> None:
    for key in keys:
        page.keyboard.press(key)


def on_a_phone(browser: Browser, server: Server) -> Page:
    """Return the lab on a telephone, in a context of its own, which the caller closes."""
    context = browser.new_context(
        viewport={"width": 390, "height": 844},
        has_touch=True,
        is_mobile=True,
        reduced_motion="reduce",
    )
    page = context.new_page()
    page.goto(server.url)
    page.get_by_text("connected", exact=True).wait_for()
    return page


def command(page: Page, words: str) -> None:
    """Find a screen, a panel, a control or a channel by typing; go there, or do it."""
    page.keyboard.press("Control+k")
    search = page.get_by_role("combobox", name="Find a screen, control or channel")
    expect(search).to_be_focused()
    page.keyboard.type(words)
    page.keyboard.press("Enter")
    expect(search).to_be_hidden()


def type_number(page: Page, text: str) -> None:
    page.keyboard.press("Control+A")
    page.keyboard.type(text)
    page.keyboard.press("Enter")


def asked_for(page: Page, press: Callable[[], object]) -> str:
    """Press what asks for a job; return its id when the page shows that job and no earlier one."""
    with page.expect_response(lambda answer: answer.status == 202) as accepted:
        press()
    job = accepted.value.json()
    page.wait_for_function(
        "({ id, kind }) => localStorage.getItem(`motionlab.job.${kind}`) === JSON.stringify(id)",
        arg=job,
    )
    return job["id"]


STYLED = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"
"""Two frames: by the second one, what a change of theme has begun is among the animations."""


def serious(page: Page, within: str = "") -> list[tuple[str, str]]:
    """Return what axe finds, serious or critical, in both themes, once no colour is in transition.

    The dark one differs in colours alone.
    """
    page.evaluate(AXE.read_text())
    found: list[dict[str, Any]] = []
    themes: list[tuple[Literal["dark", "light"], list[str]]]
    themes = [("dark", ["color-contrast"]), ("light", [])]
    for scheme, rules in themes:
        page.emulate_media(color_scheme=scheme)
        page.evaluate(STYLED)
        page.evaluate("Promise.allSettled(document.getAnimations().map((one) => one.finished))")
        options = {"resultTypes": ["violations"], "preload": False}
        options |= {"runOnly": rules} if rules else {}
        run = "([within, options]) => axe.run(within || document, options)"
        found += page.evaluate(run, [within, options])["violations"]
    return [
        (violation["id"], node["html"][:120])
        for violation in found
        if violation["impact"] in {"serious", "critical"}
        for node in violation["nodes"]
    ]


def link_file(drive: VirtualDrive, folder: Path, *, slow: int = 1) -> Path:
    """Write the shipped drive link with the port and the pace of a virtual drive that runs."""
    shipped = (ROOT / "configs" / "drives" / "virtual.toml").read_text()
    file = folder / "link.toml"
    file.write_text(shipped.replace("port = 34980", f"port = {drive.port}\nslow = {slow}"))
    return file
