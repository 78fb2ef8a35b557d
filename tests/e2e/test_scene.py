"""The 3-D view in a real browser: seen to move, and back after its process was killed."""

from __future__ import annotations

import os
import re
import signal
from collections.abc import Iterator

import numpy as np
import pytest
from imageio.v3 import imread
from numpy.typing import NDArray
from playwright.sync_api import Browser, Page, expect

from tests.e2e.actions import (
    LONG,
    button,
    clock,
    region,
    stands_at,
    state,
    until,
    wait_for_clock,
)
from tests.e2e.conftest import CHROMIUM, FLAGS, SOFTWARE_GL, Server
from tests.processes import children_of

# A page without a GPU says so; viser's own remarks are not the lab's.
HARMLESS = ("GPU", "WebGL", "swiftshader", "WebSocket connection", "503")
BLIND = (*HARMLESS, "THREE", "batched_colors")
"""What viser says besides where nothing can be drawn in 3-D."""


@pytest.fixture(scope="module")
def drawing(browser: Browser) -> Iterator[Browser]:
    """A browser that draws in software; the driver of `browser` starts it."""
    launched = browser.browser_type.launch(
        executable_path=CHROMIUM, args=[f for f in FLAGS if f != "--disable-gpu"] + SOFTWARE_GL
    )
    yield launched
    launched.close()


@pytest.fixture
def stage(drawing: Browser, server: Server) -> Iterator[Page]:
    """The lab in that browser."""
    page = drawing.new_page(viewport={"width": 1280, "height": 720})
    complaints: list[str] = []
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.set_default_timeout(LONG)
    try:
        page.goto(server.url)
        page.get_by_text("connected", exact=True).wait_for()
        yield page
    finally:
        page.close()
    assert [c for c in complaints if not any(word in c for word in HARMLESS)] == []


def seen(page: Page) -> NDArray[np.uint8] | None:
    """Return the pixels of the stages, clear of viser's notes and controls; None of no frame."""
    box = page.evaluate(
        "() => { const box = document.querySelector('iframe')?.getBoundingClientRect();"
        " return box && { x: box.x, y: box.y, width: box.width, height: box.height } }"
    )
    if box is None or box["width"] < 100 or box["height"] < 100:
        return None  # between one process and the next
    clip = {
        "x": box["x"] + 0.45 * box["width"],
        "y": box["y"] + 0.35 * box["height"],
        "width": 0.5 * box["width"],
        "height": 0.6 * box["height"],
    }
    return imread(page.screenshot(clip=clip))[..., :3]  # type: ignore[arg-type]


def shows_a_stage(page: Page) -> bool:
    pixels = seen(page)
    return pixels is not None and len(np.unique(pixels.reshape(-1, 3), axis=0)) > 100


def moves(page: Page) -> bool:
    before = seen(page)
    page.wait_for_timeout(500)
    after = seen(page)
    if before is None or after is None or before.shape != after.shape:
        return False
    return float((np.abs(after.astype(int) - before).max(axis=-1) > 40).mean()) > 1e-3


def scene_processes(server: Server) -> list[int]:
    return children_of(server.pid, "motionlab.scene3d")


def test_the_stage_moves_and_comes_back_when_its_process_is_killed(
    stage: Page, server: Server
) -> None:
    before = scene_processes(server)
    stage.get_by_role("radio", name="3-D view").click()
    stage.get_by_role("button", name="Numbers").click()  # more room for what moves
    until(stage, "the stage is drawn", lambda: shows_a_stage(stage))
    until(stage, "the stage stands still", lambda: not moves(stage))  # once all of it is there
    button(stage, "Play")
    until(stage, "the stage moves", lambda: moves(stage))

    [first] = set(scene_processes(server)).difference(before)
    os.kill(first, signal.SIGKILL)
    wait_for_clock(stage, clock(stage) + 0.5)
    until(
        stage,
        "another process draws",
        lambda: bool(set(scene_processes(server)).difference(before, [first])),
    )
    until(stage, "the stage moves again", lambda: shows_a_stage(stage) and moves(stage))

    # Back on the plane nobody watches, and the session is not kept busy for it.
    stage.get_by_role("radio", name="Plane").click()
    expect(stage.locator("iframe")).to_have_count(0)
    expect(stage.get_by_role("region", name="Plane").locator("canvas")).to_be_visible()


def test_what_is_not_available_is_said_with_a_way_back_and_esc_is_stop(stage: Page) -> None:
    refusal = {"title": "Service Unavailable", "status": 503, "detail": "viser cannot be loaded"}
    stage.route("**/scene/**", lambda route: route.fulfill(status=503, json=refusal))
    stage.get_by_role("radio", name="Plane").press("ArrowRight")
    said = stage.get_by_role("alert").filter(has_text="viser cannot be loaded")
    expect(said).to_be_visible(timeout=LONG)
    stage.unroute("**/scene/**")
    stage.get_by_role("button", name="Try again").press("Enter")
    expect(stage.locator("iframe")).to_be_visible(timeout=LONG)
    stops_after_a_click(stage)


def opened(page: Page) -> Page:
    """Play and open the 3-D view; return the page once the view takes mouse and keys."""
    button(page, "Play")
    state(page, "playing")
    page.get_by_role("radio", name="3-D view").press("Space")
    expect(page.locator("iframe:not([inert])")).to_be_visible(timeout=3 * LONG)
    return page


def focused(page: Page) -> str:
    return page.evaluate("document.activeElement.tagName")


def expect_stopped(page: Page) -> None:
    status = page.locator(".bar").get_by_role("status")
    expect(status).to_have_text(re.compile("stopping|stopped"), timeout=LONG)


def stops_after_a_click(page: Page) -> None:
    """Esc is STOP with the mouse over the stage, which fills the page."""
    opened(page)
    page.frame_locator("iframe").locator("canvas").first.wait_for(timeout=3 * LONG)
    page.keyboard.press("F")  # over the whole page but for the top bar
    size = page.evaluate("() => [innerWidth, innerHeight]")
    box = page.get_by_role("region", name="Plane").bounding_box()
    assert box == {"x": 0, "y": 44, "width": size[0], "height": size[1] - 44}
    page.locator("iframe").click(position={"x": 200, "y": 150})
    until(
        page, "the page has the focus", lambda: focused(page) == "BODY"
    )  # the mouse gives the focus back
    page.keyboard.press("Escape")
    expect_stopped(page)
    page.get_by_role("radio", name="Section").click()
    expect(page.get_by_role("table", name="Phases of A x now")).to_be_visible(timeout=LONG)
    page.get_by_role("radio", name="Overview").click()
    expect(page).to_have_url(re.compile("view3d=overview.A.x.filled"))


def test_keys_act_and_esc_is_stop_while_the_stage_or_a_control_of_it_has_the_focus(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals += (*BLIND, "409")  # phase forces between a reset and the first sample after it
    opened(page)
    view = page.locator("iframe")
    view.focus()
    assert focused(page) == "IFRAME"
    page.keyboard.press("Space")
    state(page, "paused")
    before = stands_at(page, server)
    page.keyboard.press("s")  # the camera's
    page.keyboard.press("S")
    page.keyboard.press("?")
    sheet = page.get_by_role("dialog", name="Keys and help")
    expect(sheet).to_be_visible()
    assert stands_at(page, server) == before
    page.keyboard.press("Escape")
    expect(sheet).to_have_count(0)

    view.focus()  # the same view still: playing and pausing load no other
    page.keyboard.press("Space")
    state(page, "playing")
    page.keyboard.press("Escape")
    expect_stopped(page)

    button(region(page, "Changes"), "Reset")
    state(page, "paused")
    opened(page)
    page.evaluate(
        "() => { const view = document.querySelector('iframe').contentDocument;"
        " view.body.insertAdjacentHTML('beforeend', '<input id=typed>');"
        " view.getElementById('typed').focus() }"
    )
    assert focused(page) == "IFRAME"
    page.keyboard.type("l w")
    assert page.frame_locator("iframe").locator("#typed").input_value() == "l w"
    state(page, "playing")
    page.keyboard.press("Escape")
    expect_stopped(page)
