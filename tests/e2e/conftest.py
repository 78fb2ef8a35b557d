"""A server and a browser for tests of what a person does."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
from collections.abc import Iterator
from ctypes.util import find_library
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Page, expect, sync_playwright

ROOT = Path(__file__).parents[2]
CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Instead of --disable-gpu where something is drawn in 3-D."""

PATIENCE = 20_000
"""ms, for an expectation on a machine that has other work; a sound run waits far less."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests of this folder."""
    for item in items:
        if item.path.is_relative_to(Path(__file__).parent):
            item.add_marker(pytest.mark.browser)


def missing(reason: str) -> None:
    """Skip a test, or fail it where continuous integration has to have everything."""
    if os.environ.get("CI") == "true":
        pytest.fail(reason, pytrace=False)
    pytest.skip(reason)


class Server:
    """A server process that can be ended and started again on the same port."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None
        self.port = 0
        self.starts = 0
        self.start()

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.port}"

    @property
    def pid(self) -> int:
        assert self._process is not None
        return self._process.pid

    def start(self) -> None:
        command = [sys.executable, "-m", "motionlab", "serve", "--port", str(self.port)]
        environment = {k: v for k, v in os.environ.items() if k != "MOTIONLAB_TOKEN"}
        self._process = subprocess.Popen(
            command, stderr=subprocess.PIPE, text=True, env=environment
        )
        assert self._process.stderr is not None
        line = self._process.stderr.readline()
        found = re.search(r":(\d+)/", line)
        assert found, line
        self.port = int(found[1])
        self.starts += 1

    def stop(self) -> None:
        if self._process is None:
            return
        self._process.terminate()
        self._process.wait(20)
        assert self._process.stderr is not None
        self._process.stderr.close()
        self._process = None


@pytest.fixture(scope="session")
def server() -> Iterator[Server]:
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        missing("the page is not built: frontend/npm run build")
    server = Server()
    yield server
    server.stop()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    if CHROMIUM is None:
        missing("no Chromium on this machine: make browser installs Debian's")
    if find_library("atomic") is None:
        missing("the driver of the browser needs libatomic: make browser installs it")
    expect.set_options(timeout=PATIENCE)
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        yield browser
        browser.close()


@pytest.fixture
def refusals() -> list[str]:
    """What the browser may write to its console in this test: an answer 4xx is an error to it."""
    return []


@pytest.fixture
def page(browser: Browser, server: Server, refusals: list[str]) -> Iterator[Page]:
    """The lab, loaded and connected; any error on its console fails the test."""
    starts = server.starts
    context = browser.new_context(viewport={"width": 1440, "height": 900}, accept_downloads=True)
    page = context.new_page()
    complaints: list[str] = []
    page.on("console", lambda m: complaints.append(m.text) if m.type == "error" else None)
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.set_default_timeout(PATIENCE)
    page.goto(server.url)
    page.get_by_text("connected", exact=True).wait_for()
    yield page
    session = page.evaluate("new URL(location.href).searchParams.get('session')")
    context.request.delete(f"{server.url}/api/v1/sessions/{session}")
    context.close()
    # Requests that fail while the server is away, or after it has forgotten, are to be expected.
    if server.starts > starts:
        refusals += ["ERR_CONNECTION_REFUSED", "404"]
    assert [c for c in complaints if not any(word in c for word in refusals)] == []
