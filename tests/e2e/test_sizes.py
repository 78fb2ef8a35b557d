"""The page on small screens: nothing is clipped or scrolls sideways, every screen is reached."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page, expect

from tests.e2e.actions import (
    LONG,
    STYLED,
    button,
    choose_scenario,
    controller,
    lab_views,
    on_a_phone,
    region,
    set_field,
    state,
    tab_to,
)
from tests.e2e.conftest import CHROMIUM, FLAGS, Server, lab

TEN = {
    "A k_p x, N/mm": "250.5",
    "A k_d x, N s/mm": "2.125",
    "A k_p y, N/mm": "250.5",
    "B k_p x, N/mm": "619.5",
    "B k_d x, N s/mm": "2.912",
    "B k_p y, N/mm": "1500",
    "stiction F_s x, N": "3.612",
    "seed": "20190",
}

CLIPPED = """() => {
  const name = (e) => `${e.tagName} ${e.getAttribute('aria-label') ?? ''} "${
    (e.tagName === 'SELECT' ? e.selectedOptions[0]?.text : e.innerText || e.value || '').trim()
  }"`;
  const canvas = document.createElement('canvas').getContext('2d');
  const found = [];
  for (const e of document.querySelectorAll('body, main, .column, .centre, .panel, ul, .bar')) {
    if (e.scrollWidth > e.clientWidth) found.push(`sideways: ${
      e.className || e.tagName} ${e.scrollWidth} > ${e.clientWidth}`);
  }
  for (const e of document.querySelectorAll(
    'button, select, input[type=text], label, summary, h2, h3, th, td, li, p, .note, .label, .unit'
  )) {
    const box = e.getBoundingClientRect();
    // Names in a strip give way to its values; its menu has them whole.
    if (box.width === 0 || e.closest('.hidden, .skips, .strip') || !e.checkVisibility()) continue;
    const style = getComputedStyle(e);
    let cut = e.scrollWidth > e.clientWidth + 1 && style.display !== 'inline';
    if (e.tagName === 'SELECT') {
      canvas.font = style.font;
      const arrow = 18, sides = parseFloat(style.paddingLeft) + parseFloat(style.paddingRight);
      const text = canvas.measureText(e.selectedOptions[0]?.text ?? '').width;
      cut = text + arrow + sides > e.clientWidth;
    }
    const panel = e.closest('.panel, .bar')?.getBoundingClientRect();
    if (panel && (box.right > panel.right + 0.5 || box.left < panel.left - 0.5)) cut = true;
    if (cut) found.push(`clipped: ${name(e)}`);
  }
  return found;
}"""
"""Texts that are cut off, and boxes that scroll sideways."""


SMALL = """() => [...document.querySelectorAll(
  'button, summary, input:is([type=checkbox], [type=radio]), select, a, [role=tab], [role=option]'
)].filter((e) => {
  const { width, height } = e.getBoundingClientRect();
  const shown = e.checkVisibility({ visibilityProperty: true }) && !e.closest('.hidden, .skips');
  // A link in a sentence is exempt.
  const prose = e.tagName === 'A' && getComputedStyle(e).display === 'inline';
  return shown && width > 0 && !prose && (width < 23.9 || height < 23.9);
}).map((e) => `${e.tagName} ${e.ariaLabel ?? e.innerText} ${e.className}`)"""
"""What a finger misses: WCAG 2.2, 2.5.8."""

LONG_LISTS = """() => [...document.querySelectorAll('select')]
  .filter((e) => e.options.length > 12).map((e) => e.ariaLabel ?? e.labels[0]?.innerText)"""


@pytest.fixture(scope="module")
def desktop(browser: Browser) -> Iterator[Browser]:
    """A browser whose scrollbars take room, as on a desktop."""
    shown = browser.browser_type.launch(
        executable_path=CHROMIUM, args=FLAGS, ignore_default_args=["--hide-scrollbars"]
    )
    yield shown
    shown.close()


@pytest.fixture(scope="module")
def left_there() -> list[Page]:
    return []


@pytest.fixture
def sized(
    request: pytest.FixtureRequest,
    desktop: Browser,
    server: Server,
    refusals: list[str],
    left_there: list[Page],
) -> Iterator[Page]:
    """The lab in that browser."""
    with lab(request, desktop, server, refusals, left_there) as page:
        yield page


def nothing_is_clipped(page: Page) -> None:
    for width, height in ((1280, 720), (1440, 900)):
        page.set_viewport_size({"width": width, "height": height})
        page.evaluate(STYLED)
        assert page.evaluate(CLIPPED) == [], (width, height)


def test_nothing_is_clipped_with_ten_changes(sized: Page) -> None:
    page = sized
    nothing_is_clipped(page)
    for label, value in sorted(TEN.items(), key=lambda item: item[0].startswith("A")):
        if label.startswith("A") and page.get_by_role("button", name="Controller A").count():
            controller(page, "A")
        set_field(page, label, value)
    page.get_by_role("combobox", name="A compensation law").select_option("residual-k")
    controller(page, "B")
    page.get_by_role("combobox", name="B force sharing").select_option("force-per-ampere")
    expect(region(page, "Changes").get_by_role("listitem")).to_have_count(10)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    nothing_is_clipped(page)
    # The focus must not shift a column either.
    region(page, "Controllers").get_by_role("button", name="Sets…").focus()
    page.keyboard.press("m")
    page.keyboard.press("m")
    nothing_is_clipped(page)
    button(page, "Play with 10 changes")
    state(page, "playing")
    button(page, "Pause")
    state(page, "paused")
    nothing_is_clipped(page)


@pytest.mark.parametrize("scenario", ["stair-y-50mm", "fig5", "circle-resonant"])
def test_no_scenario_is_clipped(sized: Page, scenario: str) -> None:
    page = sized
    page.set_viewport_size({"width": 1280, "height": 720})
    choose_scenario(page, scenario)
    expect(region(page, "Metrics")).to_contain_text("exact", timeout=LONG)
    for summary in page.locator("summary").all():
        summary.click()
    assert page.evaluate(CLIPPED) == []


def test_plots_of_views_fit_a_low_window(sized: Page) -> None:
    page = sized
    page.set_viewport_size({"width": 1280, "height": 720})
    views = lab_views(page)
    for name in ("Ballbar", "Contouring", "Friction", "Positioning", "Spectrum", "XY"):
        views.get_by_role("combobox", name="Kind of view").select_option(name)
        expect(views.locator("figure").last).to_be_visible(timeout=LONG)
        for figure in views.locator("figure").all():
            expect(figure, name).to_be_in_viewport(ratio=0.99)


def test_nothing_lies_over_the_status_bar(sized: Page) -> None:
    page = sized
    page.set_viewport_size({"width": 1280, "height": 720})
    button(page, "Trigger")
    button(page, "Measure")
    expect(region(page, "Measurements as numbers")).to_be_visible(timeout=LONG)
    scopes, main = region(page, "Scopes").bounding_box(), page.locator("main").bounding_box()
    assert scopes is not None
    assert main is not None
    assert scopes["y"] + scopes["height"] <= main["y"] + main["height"]


def test_a_phone_and_a_page_at_200_percent_reach_every_screen(page: Page) -> None:
    screens = page.get_by_role("combobox", name="Screen")
    panels = {"Trajectories": "Path", "Runs": "Find runs", "Tune": "Search", "Lab": "Plane"}
    for width, height in ((390, 844), (720, 450)):
        page.set_viewport_size({"width": width, "height": height})
        for title, what in panels.items():
            screens.select_option(title)
            expect(region(page, what)).to_be_visible(timeout=LONG)
            across = "document.documentElement.scrollWidth <= innerWidth"
            assert page.evaluate(across), (title, width)
        expect(page.get_by_role("button", name="STOP")).to_be_in_viewport(ratio=1)


def test_fingers_hit_every_control_and_long_lists_are_found_by_typing(
    browser: Browser, server: Server
) -> None:
    page = on_a_phone(browser, server)
    screens = page.get_by_role("combobox", name="Screen")
    panels = {
        "Lab": "Metrics",
        "Trajectories": "Path",
        "Runs": "Find runs",
        "Views": "View",
        "Identify": "Found",
        "Tune": "Search",
        "Sweep": "Result",
        "Motor": "Results",
        "Paper": "Run",
        "Drive": "State",
    }
    assert screens.locator("option").all_inner_texts() == list(panels)
    for title, panel in panels.items():
        screens.select_option(title)
        expect(page.get_by_role("region", name=panel).first).to_be_visible(timeout=LONG)
        for summary in page.locator("main summary:visible").all():
            summary.click()
        page.evaluate(STYLED)
        assert page.evaluate(SMALL) == [], title
        assert page.evaluate(LONG_LISTS) == [], title
    page.context.close()


def test_space_plays_after_a_click_in_the_top_bar(page: Page) -> None:
    page.get_by_role("link", name="Motor").click()
    page.get_by_role("link", name="Lab", exact=True).click()
    page.keyboard.press("Space")
    state(page, "playing")
    page.get_by_role("button", name="Dark theme").click()
    page.keyboard.press("Space")
    state(page, "paused")
    expect(page.get_by_role("button", name="Light theme")).to_be_visible()


def test_links_skip_to_the_screen_and_to_the_controllers(page: Page) -> None:
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to Lab")).to_be_focused()
    page.keyboard.press("Tab")
    expect(page.get_by_role("link", name="Skip to the scopes")).to_be_focused()
    page.keyboard.press("Tab")
    page.keyboard.press("Enter")
    page.keyboard.press("Tab")
    focused = page.evaluate("document.activeElement.closest('section')?.ariaLabel")
    assert focused == "Controllers"
    tab_to(page, "B k_p x")


def test_compensation_is_not_ticked_beside_no_compensation(page: Page) -> None:
    controller(page, "A")
    box = page.get_by_role("checkbox", name="A compensation")
    expect(box).not_to_be_checked()
    expect(box).to_be_disabled()
    page.get_by_role("combobox", name="A compensation law").select_option("residual-k")
    expect(box).to_be_checked()
    expect(box).to_be_enabled()
