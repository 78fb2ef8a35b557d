"""What the browser tests do with the lab, and what they read off it."""

from __future__ import annotations

from playwright.sync_api import Locator, Page, expect

LONG = 20_000  # ms; a wait that ends sooner in every sound run


def region(page: Page, name: str) -> Locator:
    return page.get_by_role("region", name=name, exact=True)


def state(page: Page, name: str) -> None:
    expect(page.locator(".bar").get_by_role("status")).to_have_text(name, timeout=LONG)


def clock(page: Page) -> float:
    minutes, seconds = page.locator(".clock").inner_text().replace("s", "").strip().split(":")
    return 60.0 * float(minutes) + float(seconds)


def wait_for_clock(page: Page, seconds: float) -> None:
    page.wait_for_function(
        "least => { const [m, s] = document.querySelector('.clock')?.innerText.split(':') ?? [];"
        " return 60 * +m + parseFloat(s) > least }",
        arg=seconds,
        timeout=LONG,
    )


def button(page: Page, name: str) -> None:
    page.get_by_role("button", name=name, exact=True).click()


def set_field(page: Page, label: str, value: str) -> None:
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


def type_number(page: Page, text: str) -> None:
    page.keyboard.press("Control+A")
    page.keyboard.type(text)
    page.keyboard.press("Enter")
