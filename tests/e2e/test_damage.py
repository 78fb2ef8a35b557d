"""What a browser has kept from an older version, or damaged; and refusals that read the same."""

from __future__ import annotations

import json
from urllib.parse import quote

import pytest
from playwright.sync_api import Page, expect

from tests.e2e.actions import region, set_field
from tests.e2e.conftest import EMPTY, Server

DAMAGED: dict[str, dict[str, object]] = {
    "sets": {"sets": None},
    "push": {"push": {"x": 5}},
    "trigger": {"trigger": {"conditions": [None], "length": 1e9}},
    "path": {"path": {"kind": "path", "points": 5}},
    "sessions": {"sessions": {"gone": 5}},
    "session": {
        "sessions": ["gone"],
        "session.gone": {"base": {}, "scenario": {}, "paths": 5},
        "draft.gone": None,
    },
}


@pytest.mark.usefixtures("unopened")
@pytest.mark.parametrize("key", DAMAGED)
def test_the_page_opens_over_damaged_storage(
    page: Page, server: Server, refusals: list[str], key: str
) -> None:
    refusals += ["404", "422"]  # of the session that is gone, and of what was kept of it
    opened(page, server, DAMAGED[key])
    page.get_by_role("link", name="Trajectories").click()
    expect(region(page, "Path")).to_be_visible()


def opened(page: Page, server: Server, kept: dict[str, object]) -> None:
    """Open the lab in a browser that has kept this."""
    page.goto(f"{server.url}{EMPTY}")
    entries = {f"motionlab.{name}": json.dumps(value) for name, value in kept.items()}
    page.evaluate("entries => Object.assign(localStorage, entries)", entries)
    page.goto(server.url)
    expect(page.get_by_text("connected", exact=True)).to_be_visible()


SCREENS = {
    "Lab": "Metrics",
    "Trajectories": "Path",
    "Identify": "Experiment",
    "Tune": "Search",
    "Sweep": "Swept fields",
    "Motor": "Numbers",
    "Paper": "Filter",
}
"""A panel of each screen."""

ITEMS: dict[str, dict[str, object]] = {
    "number": {"sweep.fields": [5]},
    "null": {"sweep.fields": [None]},
    "keys": {"sweep.fields": [{"path": 5}]},
    "forms": {
        "study.tune": {"bounds.k_p": 5, "constraints.Ms": "x", "plants": [None]},
        "study.identify": {"presliding.rates": [None], "range.count": "many"},
        "study.design": {"preset": 5, "requirements.x.force": None},
        "study.platform": {"axis": 5, "load.force": "x", "map.name": None},
        "motor.sharing": {"machines": [None], "laws": 5},
        "montecarlo.spec": {"x": "5"},
        "scopes": [None],
        "path-saved": {"name": 5},
    },
}


@pytest.mark.usefixtures("unopened")
@pytest.mark.parametrize("key", ITEMS)
def test_each_screen_opens_over_damaged_items(page: Page, server: Server, key: str) -> None:
    opened(page, server, ITEMS[key])
    visit(page)


@pytest.mark.usefixtures("fresh", "unopened")
def test_each_screen_opens_without_storage(page: Page, server: Server) -> None:
    page.add_init_script(
        "Object.defineProperty(window, 'localStorage', { get() { throw new Error('forbidden') } })"
    )
    page.goto(server.url)
    visit(page)
    dark = page.evaluate("matchMedia('(prefers-color-scheme: dark)').matches")
    page.get_by_role("button", name="Light theme" if dark else "Dark theme").click()
    expect(page.locator("html")).to_have_attribute("data-theme", "light" if dark else "dark")


def visit(page: Page) -> None:
    """Open every screen."""
    for link, panel in SCREENS.items():
        page.get_by_role("link", name=link, exact=True).click()
        expect(region(page, panel)).to_be_visible()


def test_the_same_refusal_of_both_axes_is_shown_once(page: Page, refusals: list[str]) -> None:
    refusals += ["422"]
    for axis in "xy":
        field = f"stiction F_s {axis}, N"
        set_field(page, field, "-1")
        expect(page.get_by_role("textbox", name=field)).to_have_attribute("aria-invalid", "true")
    motor = region(page, "Plant")
    expect(motor.get_by_role("alert")).to_have_count(1)


def test_the_lab_says_why_a_link_is_not_computed(page: Page, refusals: list[str]) -> None:
    refusals += ["422"]
    draft = quote(json.dumps({"variants.Z.controller.x.k_p": 5}))
    page.goto(f"{page.url.split('?')[0]}?scenario=circle&draft={draft}")
    expect(page.get_by_test_id("headline")).to_have_text("Not computed")
    expect(region(page, "Result")).to_contain_text("Is missing")


def test_math_channels_of_one_name_leave_the_others_computed(
    page: Page, refusals: list[str]
) -> None:
    refusals += ["422"]  # before the server has checked them
    math = [quote(text, safe="") for text in ("m=B.x.thrust", "m=B.y.thrust")]
    page.goto(f"{page.url.split('?')[0]}?scopes={quote(','.join(['A.x.thrust', *math]))}")
    expect(region(page, "Metrics")).to_contain_text("exact")


def test_stop_is_whole_at_every_width(page: Page) -> None:
    for width in (320, 401, 481, 640, 720, 861):
        page.set_viewport_size({"width": width, "height": 480})
        box = page.get_by_role("button", name="STOP", exact=True).bounding_box()
        assert box is not None, width
        assert 0 <= box["x"], width
        assert box["x"] + box["width"] <= width
