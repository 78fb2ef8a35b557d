"""Carrying out a module's job in a browser, by a page of its folder."""

from __future__ import annotations

import base64
import contextlib
import functools
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright
from websockets.sync.client import connect

from tests.e2e.conftest import CHROMIUM, FLAGS
from tests.targets.module_run import Memory

FIREFOX = shutil.which("firefox-esr") or shutil.which("firefox")

_PATIENCE = 120.0  # s
_JOB = """(async () => {
    const { carryOut } = await import('/module_job.mjs');
    const job = await (await fetch('/job.json')).json();
    const read = async (name) => new Uint8Array(await (await fetch(`/${name}`)).arrayBuffer());
    const { seconds, results } = await carryOut(job, read, () => performance.now() / 1000);
    const encoded = results.map((bytes) => {
        let text = '';
        for (const byte of bytes) text += String.fromCharCode(byte);
        return btoa(text);
    });
    return JSON.stringify({ seconds, results: encoded });
})()"""

Evaluate = Callable[[str, str], str]
"""Opens an address, and returns the text that an expression's promise resolves to there."""


def run_in(evaluate: Evaluate, memory: Memory) -> list[float]:
    """Make the calls on a memory in a browser; return the time of each, s."""
    with tempfile.TemporaryDirectory() as name:
        memory.write_job(Path(name))
        shutil.copy(Path(__file__).with_name("module_job.mjs"), name)
        (Path(name) / "index.html").write_text("<!doctype html><title>job</title>")
        with _served(name) as address:
            answer = json.loads(evaluate(address, _JOB))
    memory.take([base64.b64decode(each) for each in answer["results"]])
    return answer["seconds"]


def in_chromium(address: str, expression: str) -> str:
    """Evaluate in Debian's Chromium, by a thread: this one may drive another browser."""
    with ThreadPoolExecutor(1) as own:
        return own.submit(_evaluated, address, expression).result()


def _evaluated(address: str, expression: str) -> str:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        page = browser.new_page()
        page.goto(address)
        text = page.evaluate(expression)
        browser.close()
    return text


def in_firefox(address: str, expression: str) -> str:
    """Evaluate in Debian's Firefox, by WebDriver BiDi."""
    with tempfile.TemporaryDirectory() as profile, _firefox(profile) as socket:
        with connect(f"{socket}/session", max_size=None, open_timeout=_PATIENCE) as connection:

            def command(method: str, **parameters: Any) -> Any:
                message = {"id": 1, "method": method, "params": parameters}
                connection.send(json.dumps(message))
                while "id" not in (answer := json.loads(connection.recv(_PATIENCE))):
                    pass  # an event
                assert answer["type"] == "success", answer
                return answer["result"]

            command("session.new", capabilities={})
            (tab,) = command("browsingContext.getTree")["contexts"]
            command(
                "browsingContext.navigate", context=tab["context"], url=address, wait="complete"
            )
            answer = command(
                "script.evaluate",
                expression=expression,
                target={"context": tab["context"]},
                awaitPromise=True,
            )
    assert answer["type"] == "success", answer
    return answer["result"]["value"]


@contextlib.contextmanager
def _firefox(profile: str) -> Iterator[str]:
    """Yield the address at which a Firefox of a new profile listens."""
    assert FIREFOX is not None
    options = ("--headless", "--no-remote", "--profile", profile, "--remote-debugging-port", "0")
    with subprocess.Popen(
        [FIREFOX, *options],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "HOME": profile},
    ) as process:
        try:
            assert process.stderr is not None
            lines = (re.search(r"listening on (ws://\S+)", line) for line in process.stderr)
            address = next((line[1] for line in lines if line), None)
            assert address is not None, "Firefox ended before it listened"
            yield address
        finally:
            process.terminate()


class _Files(SimpleHTTPRequestHandler):
    def log_message(self, format: str, *args: Any) -> None:
        pass


@contextlib.contextmanager
def _served(folder: str) -> Iterator[str]:
    """Yield the address of a folder's files."""
    server = ThreadingHTTPServer(("127.0.0.1", 0), functools.partial(_Files, directory=folder))
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.server_port}/"
    finally:
        server.shutdown()
        thread.join()
        server.server_close()
