"""Lane parameters that the page makes: under a moving field, the server is asked for no preview."""

from __future__ import annotations

from typing import Any

import pytest
from playwright.sync_api import Page, Route, expect

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from tests.e2e.actions import ANSWERS, API, DRAFT, LONG, MAX, RMS, set_field
from tests.e2e.conftest import Server

COUNT = 50e-9
"""One count of the encoder, m."""
BRISTLE = "variants.B.controller.compensation.bristle_limit"
NOTCH = {f"variants.B.controller.{axis}.notch.gain": 0.2 for axis in "xy"}


def opened(page: Page, server: Server, changes: dict[str, Any]) -> list[str]:
    """Open a session of the changed circle; return the list of what the page asks from then on."""
    body = {"scenario": "circle", "set": changes}
    session = page.request.post(f"{server.url}{API}/sessions", data=body).json()
    page.add_init_script(ANSWERS)
    requests: list[str] = []
    page.on("request", lambda request: requests.append(request.url.removeprefix(server.url)))
    page.goto(f"{server.url}/?session={session['id']}&mode=whatif")
    page.get_by_text("connected", exact=True).wait_for()
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    page.wait_for_function("() => window.answers.A && window.answers.B", timeout=LONG)
    requests.clear()
    return requests


@pytest.mark.usefixtures("fresh", "unopened")
@pytest.mark.parametrize(
    ("field", "path", "changes"),
    [
        ("Coulomb F_c x, N", "plant.x.friction.F_c", {}),
        ("mass x, kg", "plant.x.mass", {}),
        ("B bristle limit", BRISTLE, {BRISTLE: 1.5}),
        ("B notch frequency x, Hz", "variants.B.controller.x.notch.frequency", NOTCH),
    ],
)
def test_a_moved_field_asks_for_the_exact_result_alone(
    page: Page, server: Server, field: str, path: str, changes: dict[str, Any]
) -> None:
    requests = opened(page, server, changes)
    box = page.locator(f'input[type=text][aria-label="{field}"]')
    box.evaluate("(box) => box.closest('details')?.setAttribute('open', '')")
    box.focus()
    for _ in range(4):
        page.evaluate("() => (window.answers.B = undefined)")
        box.press("ArrowUp")
        page.wait_for_function("() => window.answers.B", timeout=LONG)
    expect(page.locator(".badge.exact").first).to_be_visible(timeout=LONG)
    asked = [each for each in requests if "/whatif" in each]
    assert asked and set(asked) == {f"{API}/whatif"}, asked

    draft = page.evaluate(DRAFT)
    assert list(draft) == [path]
    body = {"scenario": "circle", "set": changes | draft}
    exact = page.request.post(f"{server.url}{API}/simulate", data=body).json()["variants"]
    for name, answer in page.evaluate("window.answers").items():
        for axis, metrics in exact[name]["axes"].items():
            own = answer["windows"][0]["axes"][axis]
            for metric in (MAX, RMS, "max_abs_position_error"):
                assert abs(own[metric] - metrics[metric]) <= COUNT, (name, axis, metric)


@pytest.mark.usefixtures("fresh", "unopened")
@pytest.mark.parametrize(
    ("field", "value", "change"),
    [
        ("stiction F_s x, N", "0.1", {"plant.x.friction.F_s": 0.1}),
        ("mass x, kg", "0.1", {"plant.x.mass": 0.1}),
        ("mass x, kg", "2000", {"plant.x.mass": 2000.0}),
    ],
)
def test_the_page_refuses_in_the_servers_words(
    page: Page, server: Server, refusals: list[str], field: str, value: str, change: dict[str, Any]
) -> None:
    refusals.append("Failed to load resource")
    opened(page, server, {})

    def blocked(route: Route) -> None:
        route.abort()

    page.route(f"**{API}/whatif**", blocked)
    set_field(page, field, value)
    badge = page.locator(".badge.failed").first
    expect(badge).to_have_text("not computed", timeout=LONG)
    own = badge.get_attribute("title")
    page.unroute(f"**{API}/whatif**")
    with page.expect_response(f"**{API}/whatif") as response:
        set_field(page, field, value + "0" if "." in value else value + ".0")
    assert response.value.status == 422
    expect(badge).to_have_attribute("title", own or "", timeout=LONG)
    with pytest.raises(ConfigError) as refusal:
        load_scenario("circle", change)
    assert response.value.json()["errors"][0]["message"] == refusal.value.errors[0].message
