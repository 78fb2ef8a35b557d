"""The kernel in the page: previews while a gain is dragged, and what is left to the server."""

from __future__ import annotations

import itertools
import json
import math
import struct
from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from tests.e2e.actions import API, LONG, MAX, region, set_field
from tests.e2e.conftest import Server

COUNT = 50e-9
"""One count of the encoder, m."""
LISTEN = """
window.answers = {};
window.runs = [];
const Own = window.Worker;
window.Worker = class extends Own {
  constructor(...given) {
    super(...given);
    this.addEventListener('message', ({ data: { answer } }) => {
      if (answer?.windows) window.runs.push(answer.windows);
      if (answer?.windows) window.answers[window.answers.A ? 'B' : 'A'] = answer;
    });
  }
};
"""
DRAG = """
async (values) => {
  const slider = document.querySelector('input[type=range][aria-label="B k_p x"]');
  for (const share of values) {
    window.answers.B = undefined;
    slider.value = String(Number(slider.min) + share * (slider.max - slider.min));
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    while (!window.answers.B) await new Promise((resolve) => setTimeout(resolve, 5));
  }
  slider.dispatchEvent(new Event('change', { bubbles: true }));
  return window.answers.B;
}
"""


def statusbar(page: Page) -> Any:
    return page.get_by_role("contentinfo").locator("span", has_text="what-if").first


def staged(page: Page, server: Server) -> dict[str, Any]:
    """Return what the server computes of the gain that the page shows."""
    shown = page.get_by_role("textbox", name="B k_p x, N/mm").input_value()
    changes = {"variants.B.controller.x.k_p": 1e3 * float(shown)}
    body = {"scenario": "circle", "set": changes}
    return page.request.post(f"{server.url}{API}/simulate", data=body).json()


@pytest.mark.usefixtures("fresh", "unopened")
def test_a_dragged_gain_is_previewed_in_the_page(page: Page, server: Server) -> None:
    page.add_init_script(LISTEN)
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url.removeprefix(server.url)))
    page.goto(server.url)
    page.get_by_text("connected", exact=True).wait_for()
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    page.wait_for_function("() => window.answers.B", timeout=LONG)
    requests.clear()
    previewed = page.evaluate(DRAG, [0.3, 0.4, 0.5])
    expect(statusbar(page)).to_contain_text("page")
    # One exact result at the end; nothing while the gain moved.
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    assert requests.count(f"{API}/whatif") <= 2, requests
    assert not [each for each in requests if each.endswith("/whatif/lanes")][1:]
    exact = staged(page, server)["variants"]["B"]
    assert previewed["diverged"] is exact["diverged"] is None
    (window,) = previewed["windows"]
    for axis, metrics in exact["axes"].items():
        for name in (MAX, "rms_following_error", "max_abs_position_error"):
            assert abs(window["axes"][axis][name] - metrics[name]) <= COUNT, (axis, name)
    for name, value in exact["contour"].items():
        assert abs(window["contour"][name] - value) <= COUNT, name


@pytest.mark.usefixtures("fresh", "unopened")
def test_margins_follow_a_dragged_gain_without_the_server(page: Page, server: Server) -> None:
    page.add_init_script(LISTEN)
    page.goto(server.url)
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    page.wait_for_function("() => window.answers.B", timeout=LONG)
    page.route(f"**{API}/loop", lambda _: None)  # never answered
    own = page.evaluate(DRAG, [0.3, 0.4, 0.5])["loops"]["axes"]["x"]
    shown = page.get_by_role("textbox", name="B k_p x, N/mm").input_value()
    body = {"scenario": "circle", "set": {"variants.B.controller.x.k_p": 1e3 * float(shown)}}
    loops = page.request.post(f"{server.url}{API}/loop", data=body).json()["variants"]
    exact = loops["B"]["axes"]["x"]
    worst = exact["worst"]
    for name in ("gain_margin", "phase_margin", "Ms"):
        assert own["worst"][name]["value"] == pytest.approx(worst[name]["value"], rel=1e-3)
    for name in ("k_p_limit", "k_d_limit"):
        assert own[name] == pytest.approx(exact[name], rel=1e-3)
    line = page.get_by_role("group", name="B x margins")
    expect(line).to_contain_text(f"{own['worst']['Ms']['value']:.2f}")
    expect(line).to_contain_text(f"{math.degrees(own['worst']['phase_margin']['value']):.1f}°")


def agree(own: dict[str, Any], exact: dict[str, Any]) -> bool:
    """Whether the metrics of one variant over one window agree."""
    pairs = [(own["contour"][name], value) for name, value in exact["contour"].items()]
    for axis, metrics in exact["axes"].items():
        pairs += [(own["axes"][axis][name], value) for name, value in metrics.items()]
    return all(itertools.starmap(nearly, pairs))


def read(content: bytes) -> dict[str, Any]:
    (length,) = struct.unpack_from("<I", content)
    return json.loads(content[8 : 8 + length])["result"]


def nearly(a: float | None, b: float | None) -> bool:
    """Whether a metric of the page is the server's: to two counts of the encoder, two hundredths.

    Rounding, other on each processor, moves single readings by a count, and with them peak forces.
    """
    if a is None or b is None:
        return a is b
    return abs(a - b) <= 2 * COUNT + 0.02 * abs(b)


@pytest.mark.usefixtures("fresh", "unopened")
@pytest.mark.parametrize(
    ("scenario", "changes"),
    [
        ("fig5", {"variants.B.controller.x.k_p": 201e3}),  # from a stored state, and with segments
        ("stair-y-50mm", {}),  # with holds
        ("rhombus", {}),
        ("circle", {"plant.force_map": "new-design", "load.noise": 0.5}),
        ("circle", {"divergence_error": 1e-5}),  # A diverges
    ],
)
def test_every_metric_of_a_preview_is_nearly_the_servers(
    page: Page, server: Server, scenario: str, changes: dict[str, Any]
) -> None:
    body = {"scenario": scenario, "set": changes}
    session = page.request.post(f"{server.url}{API}/sessions", data=body).json()
    page.add_init_script(LISTEN)
    page.route(f"**{API}/whatif", lambda _: None)  # or it might be there before the preview
    page.goto(f"{server.url}/?session={session['id']}&mode=whatif")
    page.wait_for_function("() => window.runs.length >= 2", timeout=LONG)
    expect(statusbar(page)).to_contain_text("page")
    question = {"scenario": session["scenario"]}
    exact = read(page.request.post(f"{server.url}{API}/whatif", data=question).body())
    segments = [each for each in exact["segments"] if each["window"] != exact["window"]]
    runs = page.evaluate("window.runs.slice(0, 2)")
    for variant in exact["variants"]:
        expected = [each["variants"][variant] for each in (exact, *segments)]
        # Workers answer in any order.
        assert any(
            all(map(agree, windows, expected)) for windows in runs if len(windows) == len(expected)
        ), variant


@pytest.mark.usefixtures("fresh", "unopened")
def test_without_its_module_the_server_previews(
    page: Page, server: Server, refusals: list[str]
) -> None:
    refusals.append("Failed to load resource")

    def blocked(route: Route) -> None:
        route.abort()

    page.route("**/*.wasm", blocked)
    page.goto(server.url)
    page.get_by_text("connected", exact=True).wait_for()
    with page.expect_request(f"**{API}/whatif"):
        set_field(page, "B k_p x, N/mm", "312")
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    expect(statusbar(page)).to_contain_text("server")


def test_a_refused_change_keeps_the_curves(page: Page, refusals: list[str]) -> None:
    refusals.append("status of 422")
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    before = region(page, "Metrics").locator("tr").nth(1).inner_text()
    set_field(page, "B k_p x, N/mm", "-5")
    expect(page.locator(".badge.failed").first).to_have_text("not computed", timeout=LONG)
    assert region(page, "Metrics").locator("tr").nth(1).inner_text() == before
    set_field(page, "B k_p x, N/mm", "312")
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
