"""A server and a browser for tests of what a person does."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
import subprocess
import sys
import time
from collections.abc import Generator, Iterator
from ctypes.util import find_library
from pathlib import Path
from typing import Any

import httpx
import pytest
from playwright.sync_api import (
    Browser,
    ConsoleMessage,
    Error,
    Page,
    ViewportSize,
    expect,
    sync_playwright,
)
from playwright.sync_api import (
    TimeoutError as WaitedTooLong,
)

from tests.paths import ROOT

# The first opens a page in less than half the processor time that the others take.
CHROMIUM = (
    shutil.which("chromium-headless-shell")
    or shutil.which("chromium")
    or shutil.which("chromium-browser")
    or shutil.which("google-chrome")
)
FLAGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",  # a container has 64 MB of it
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
]

SOFTWARE_GL = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
"""Instead of --disable-gpu where something is drawn in 3-D."""

PATIENCE = 60_000
"""ms, for an expectation on a machine that has other work; a sound run waits far less."""

KEPT = {
    "sessions": "id",
    "runs": "id",
    "trajectories": "name",
    "maps": "name",
    "motors": "name",
    "gain-sets": "name",
    "layouts": "name",
}
"""What a server keeps of what a person does, and by what it is deleted. Jobs stay."""

EMPTY = "/theme.js"
"""A text: with the storage of the lab, but without its scripts."""

VIEW: ViewportSize = {"width": 1440, "height": 900}
FAILED = pytest.StashKey[bool]()

START = 180.0
"""Seconds for a server to begin and to end, on such a machine."""


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
    """A server process that can be ended and started again on the same port.

    Parameters
    ----------
    data : Path
        Folder of what it keeps, and of what it writes to stderr.
    *options : str
        Of the command.
    python : str
        Interpreter that has the package.
    **variables : str
        Of its environment.
    """

    def __init__(
        self, data: Path, *options: str, python: str = sys.executable, **variables: str
    ) -> None:
        self._program = [python, "-m", "motionlab"]
        self._options = options
        self._variables = variables
        self._process: subprocess.Popen[bytes] | None = None
        self.data = data
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
        command = [*self._program, "serve", "--port", str(self.port), *self._options]
        environment = {k: v for k, v in os.environ.items() if k != "MOTIONLAB_TOKEN"}
        environment |= {"MOTIONLAB_DATA": str(self.data)} | self._variables
        told = self.data / "stderr.txt"  # a pipe that nobody reads would fill up and block it
        with told.open("wb") as stderr:
            self._process = subprocess.Popen(command, stderr=stderr, env=environment)
        end = time.monotonic() + START
        while not (found := re.search(r"^Serving .*:(\d+)/", told.read_text(), re.MULTILINE)):
            if self._process.poll() is not None or time.monotonic() > end:
                self.stop()
                raise AssertionError(f"the server did not start: {told.read_text()}")
            time.sleep(0.02)
        self.port = int(found[1])
        self.starts += 1

    def stop(self) -> None:
        if self._process is None:
            return
        process, self._process = self._process, None
        process.terminate()
        try:
            process.wait(START)
        finally:
            process.kill()
            process.wait()


@pytest.fixture(scope="session")
def shared_server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Server]:
    if not (ROOT / "frontend" / "dist" / "index.html").is_file():
        missing("the page is not built: make frontend/dist/index.html")
    server = Server(tmp_path_factory.mktemp("data"))
    yield server
    server.stop()


@pytest.fixture(scope="module")
def server(shared_server: Server) -> Server:
    """The server for the tests of a file, without anything that those of another have kept."""
    with httpx.Client(base_url=f"{shared_server.url}/api/v1", timeout=START) as client:

        def kept(what: str) -> list[dict[str, Any]]:
            answer = client.get(f"/{what}").raise_for_status().json()
            found = answer["runs"] if what == "runs" else answer
            return [each for each in found if not each.get("shipped")]

        end = time.monotonic() + START
        for what, key in KEPT.items():
            while found := kept(what):
                for each in found:
                    answer = client.delete(f"/{what}/{each[key]}")
                    if answer.status_code != httpx.codes.CONFLICT or time.monotonic() > end:
                        answer.raise_for_status()
                    else:
                        time.sleep(0.1)  # a run is written to its end first
    return shared_server


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


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Item, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """Note which test has failed: its page is not used again."""
    report = yield
    if report.failed:
        item.stash[FAILED] = True
    return report


@pytest.fixture(scope="session")
def left(browser: Browser) -> Iterator[list[Page]]:
    """The page that an earlier test has left as good as new, if any has."""
    pages: list[Page] = []
    yield pages
    for page in pages:
        page.context.close()


@pytest.fixture
def fresh(left: list[Page]) -> Iterator[None]:
    """For a test that sets on its page what stays there: scripts at the start, listeners."""
    kept = left.copy()
    left.clear()
    yield
    left[:] = kept


@pytest.fixture
def address() -> str:
    """What follows the address of the server where the page opens; a file may have its own."""
    return ""


@pytest.fixture
def unopened() -> None:
    """For a test that opens the page itself, at what it has made first."""


@pytest.fixture
def page(
    request: pytest.FixtureRequest,
    browser: Browser,
    server: Server,
    refusals: list[str],
    left: list[Page],
    address: str,
) -> Iterator[Page]:
    """The lab, loaded and connected; any error on its console fails the test.

    The page of the test before is loaded again where nothing of it is left, since then the browser
    has the scripts compiled; `fresh` is for a test that leaves something else.
    """
    with lab(request, browser, server, refusals, left, address) as page:
        yield page


@contextlib.contextmanager
def lab(
    request: pytest.FixtureRequest,
    browser: Browser,
    server: Server,
    refusals: list[str],
    left: list[Page],
    address: str = "",
) -> Iterator[Page]:
    """Open the page that is left, or another, for a test, and leave it as good as new."""
    starts = server.starts
    if left:
        page = left.pop()
    else:
        page = browser.new_context(
            viewport=VIEW, accept_downloads=True, reduced_motion="reduce"
        ).new_page()
    complaints: list[str] = []

    def told(message: ConsoleMessage) -> None:
        if message.type == "error":
            complaints.append(message.text)

    def thrown(error: Error) -> None:
        complaints.append(str(error))

    page.on("console", told)
    page.on("pageerror", thrown)
    page.set_default_timeout(PATIENCE)
    try:
        if "unopened" not in request.fixturenames:
            page.goto(f"{server.url}/{address}")
            connected(page)
        yield page
        session = page.evaluate("new URL(location.href).searchParams.get('session')")
        # Away from it first, or it would miss its session, say so, and make another.
        if "fresh" in request.fixturenames or request.node.stash.get(FAILED, False):
            page.close()
        else:
            emptied(page, server)
            page.remove_listener("console", told)
            page.remove_listener("pageerror", thrown)
            left.append(page)
        page.context.request.delete(f"{server.url}/api/v1/sessions/{session}")
    finally:
        if page not in left:
            page.context.close()
    # Requests that fail while the server is away, or after it has forgotten, are to be expected.
    if server.starts > starts:
        refusals += ["ERR_CONNECTION", "ERR_EMPTY_RESPONSE", "ERR_SOCKET_NOT_CONNECTED", "404"]
    assert [c for c in complaints if not any(word in c for word in refusals)] == []


def connected(page: Page) -> None:
    """Wait for the page's connection; without one, say how busy the machine is, and with what."""
    try:
        page.get_by_text("connected", exact=True).wait_for()
    except WaitedTooLong as error:
        busiest = subprocess.run(
            ["ps", "-eo", "pcpu,etimes,pid,args", "--sort=-pcpu"],
            capture_output=True,
            text=True,
            check=False,
        ).stdout.splitlines()[:9]
        shown = page.inner_text("body")[:400]
        load = " ".join(f"{each:.1f}" for each in os.getloadavg())
        lines = [str(error), f"load {load}", *(line[:150] for line in busiest), shown]
        raise AssertionError("\n".join(lines)) from None


def emptied(page: Page, server: Server) -> None:
    """Leave the lab, and nothing on the page or in its context that a test can have set."""
    page.unroute_all(behavior="ignoreErrors")
    page.context.unroute_all(behavior="ignoreErrors")
    for other in page.context.pages:
        if other != page:
            other.close()
    page.goto(f"{server.url}{EMPTY}")
    page.evaluate("localStorage.clear(); sessionStorage.clear()")
    page.context.clear_cookies()
    page.context.clear_permissions()
    page.mouse.move(0, 0)
    page.emulate_media(media="null", color_scheme="light")
    page.set_viewport_size(VIEW)
