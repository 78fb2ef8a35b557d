"""The frame of the Lab: one scope forward, one controller open, a bar of changes at its foot."""

from __future__ import annotations

from playwright.sync_api import Locator, Page, expect

from tests.e2e.actions import LONG, button, controller, region, state

REMEMBER = """() => {
  const controls = document.querySelectorAll(
    ':is(main, .bar) :is(button, input, select, a, summary, [role="slider"])');
  window.places = [...controls].map((control) => [control, control.getBoundingClientRect()])
    .filter(([, { width, height }]) => width > 0 && height > 0);
  return window.places.length;
}"""
MOVED = """() => window.places.flatMap(([control, before]) => {
  const now = control.getBoundingClientRect();
  if (!control.isConnected || now.width === 0) return [];
  const far = Math.max(Math.abs(now.x - before.x), Math.abs(now.y - before.y));
  const name = control.ariaLabel || control.title || control.textContent;
  const [x, y] = [now.x - before.x, now.y - before.y].map(Math.round);
  return far > 0.5 ? [`${name.trim()}: ${x}, ${y}`] : [];
})"""


def size(locator: Locator) -> tuple[float, float, float]:
    """Return left edge, width and height of what is shown."""
    box = locator.bounding_box()
    assert box is not None
    return box["x"], box["width"], box["height"]


def exact(page: Page) -> None:
    expect(page.locator(".badge.exact")).to_be_visible(timeout=LONG)


def stage(page: Page, name: str, key: str = "Shift+ArrowRight") -> None:
    page.get_by_role("slider", name=name, exact=True).press(key)


def test_no_control_moves_while_changes_come_and_go(page: Page) -> None:
    exact(page)
    assert page.evaluate(REMEMBER) > 60

    def still(what: str) -> None:
        page.wait_for_timeout(150)
        assert page.evaluate(MOVED) == [], what

    stage(page, "B k_p x")
    still("one change staged")
    for name in ("B k_d x", "B k_p y", "B k_d y"):
        stage(page, name)
    exact(page)
    still("four changes staged, their result exact")
    page.get_by_role("checkbox", name="B feedforward", exact=True).check()
    still("feedforward staged")
    button(page, "Undo")
    still("undone")
    button(page, "Discard")
    still("discarded")
    stage(page, "B k_p x")
    button(page, "Send 1 to motor")
    expect(page.get_by_role("button", name="Send to motor")).to_be_disabled(timeout=LONG)
    still("sent")
    button(page, "Play")
    state(page, "playing")
    page.wait_for_timeout(1500)
    still("playing, live")
    stage(page, "B k_p x")
    page.wait_for_timeout(1500)
    still("changed live")
    button(page, "Undo")
    page.wait_for_timeout(500)
    still("undone live")
    button(page, "Pause")
    state(page, "paused")
    still("paused")
    page.get_by_role("radio", name="Staged").click()
    exact(page)
    still("back to what is staged")
    for _ in range(2):
        page.keyboard.press("m")
    still("two cursors")
    page.keyboard.press("M")
    expect(page.get_by_role("button", name="Next peak")).to_be_visible(timeout=LONG)
    still("measured")
    page.keyboard.press("k")
    still("at a peak")
    button(page, "Trigger")
    expect(region(page, "Trigger")).to_be_visible(timeout=LONG)
    still("trigger")


def test_a_strip_comes_forward_and_the_scopes_fill_the_page(page: Page) -> None:
    exact(page)
    panel = region(page, "Scopes")
    forward = panel.locator(".scopes section")
    expect(forward).to_have_count(1)
    plot = forward.locator("canvas")
    assert size(plot)[2] > 260 + 22  # curve, and the time axis below it
    page.set_viewport_size({"width": 1280, "height": 720})
    assert size(plot)[2] > 180 + 22
    page.get_by_role("button", name="Following error y", exact=True).press("Enter")
    expect(forward).to_have_attribute("aria-label", "Following error y, what-if")
    expect(forward).to_have_count(1)
    page.get_by_role("region", name="Phase currents B x, what-if").dblclick(
        position={"x": 4, "y": 4}
    )
    expect(forward).to_have_attribute("aria-label", "Phase currents B x, what-if")
    page.keyboard.press("F")
    left, width, height = size(panel)
    assert (left, width) == (0, 1280)
    assert height > 640
    page.keyboard.press("F")
    assert size(panel)[1] < 800
    page.reload()
    exact(page)
    expect(forward).to_have_attribute("aria-label", "Phase currents B x, what-if")


def test_a_small_error_has_an_axis_of_its_own(page: Page) -> None:
    exact(page)
    legend = page.get_by_role("toolbar", name="Traces of Following error x")
    expect(legend).to_contain_text("axis ±5 µm")  # B, beside 25 um of A
    controller(page, "A")
    page.get_by_role("combobox", name="A compensation law").select_option("lugre-observer")
    page.get_by_role("checkbox", name="A compensation", exact=True).check()
    expect(legend).not_to_contain_text("±", timeout=LONG)  # as large as the other


def test_a_change_is_taken_from_the_bar_and_a_gesture_is_one_undo(page: Page) -> None:
    exact(page)
    changes = region(page, "Changes")
    page.get_by_role("slider", name="B k_p x", exact=True).focus()
    for _ in range(6):
        page.keyboard.press("ArrowRight")
    stage(page, "B k_d x")
    expect(changes.locator(".chip")).to_have_count(2)
    changes.get_by_role("button", name="Do not stage B k_p x").click()
    expect(changes.locator(".chip")).to_have_count(1)
    button(page, "Undo")  # what was taken from the bar
    button(page, "Undo")  # k_d x
    expect(changes.locator(".chip")).to_have_count(1)
    button(page, "Undo")  # six presses of a key
    expect(changes.locator(".chip")).to_have_count(0)
