"""The service worker of a demo, on pages of one script: versions, other demos, no network."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page

from motionlab.server.demo import _service_worker  # pyright: ignore[reportPrivateUsage]
from tests.e2e.test_demo import Files, Host


class Cached(Files):
    """Files that a browser may keep for ten minutes, as GitHub Pages has it."""

    def do_GET(self) -> None:
        """Send the whole file: two versions may have been written in one second."""
        del self.headers["If-Modified-Since"]
        super().do_GET()

    def end_headers(self) -> None:
        """Send how long the file may be kept."""
        kept = self.path.endswith(".js") and not self.path.endswith("sw.js")
        self.send_header("Cache-Control", "max-age=600" if kept else "no-cache")
        super().end_headers()


@pytest.fixture
def host(tmp_path: Path) -> Iterator[Host]:
    host = Host(tmp_path, Cached)
    yield host
    host.stop()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_context().new_page()
    yield page
    page.context.close()


def write(folder: Path, version: str) -> None:
    html = (
        f"<title>{version}</title><meta name='motionlab-demo'><script src='page.js'></script>"
        "<script>navigator.serviceWorker.register('sw.js')</script>"
    )
    files = {"index.html": html.encode(), "page.js": f"window.version = '{version}'".encode()}
    folder.mkdir(exist_ok=True)
    for name, content in {**files, "sw.js": _service_worker(files)}.items():
        (folder / name).write_bytes(content)


def visit(page: Page, url: str) -> tuple[str, str]:
    """Return the versions of page and script."""
    page.goto(url)
    return page.title(), page.evaluate("window.version")


def settled(page: Page) -> None:
    """Wait until the latest worker has its files, and leave: the next page has them."""
    page.evaluate("""async () => {
        const registration = await navigator.serviceWorker.ready;
        await registration.update();
        const { installing } = registration;
        while (installing?.state === 'installing') await new Promise((on) => setTimeout(on, 20));
    }""")
    page.goto("about:blank")
    page.wait_for_timeout(300)  # a worker takes over from another that has no page any more


def test_a_page_and_its_script_are_of_one_version(page: Page, host: Host, tmp_path: Path) -> None:
    write(tmp_path / "demo", "one")
    assert visit(page, f"{host.url}/demo/") == ("one", "one")
    settled(page)
    write(tmp_path / "demo", "two")
    page.goto(f"{host.url}/demo/")
    settled(page)
    pairs: list[tuple[str, str]] = []
    for _ in range(20):
        pairs.append(visit(page, f"{host.url}/demo/"))
        if pairs[-1] == ("two", "two"):
            break
        settled(page)
    print(pairs)
    assert set(pairs) <= {("one", "one"), ("two", "two")}
    assert pairs[-1] == ("two", "two")


def test_demos_on_one_host_keep_their_files(page: Page, host: Host, tmp_path: Path) -> None:
    for name in ("one", "two"):
        write(tmp_path / name, name)
        visit(page, f"{host.url}/{name}/")
        settled(page)
    # A worker removes the caches of older ones when it begins: that of `two` has.
    visit(page, f"{host.url}/two/")
    host.stop()
    for name in ("one", "two"):
        for address in ("", "index.html", "index.html?section=gains", "#gains"):
            page.goto("about:blank")
            assert visit(page, f"{host.url}/{name}/{address}") == (name, name)


def test_it_gives_way_to_what_else_has_its_address(page: Page, host: Host, tmp_path: Path) -> None:
    """A lab on the port that a demo had is the lab."""
    write(tmp_path / "demo", "demo")
    visit(page, f"{host.url}/demo/")
    settled(page)
    (tmp_path / "demo" / "index.html").write_text("<title>lab</title>")
    page.goto(f"{host.url}/demo/")
    assert page.title() == "lab"
    page.goto(f"{host.url}/demo/")
    assert page.title() == "lab"
    assert page.evaluate("navigator.serviceWorker.getRegistration()") is None
