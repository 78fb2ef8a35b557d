"""A problem that a server names keeps its type in the document of a command."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest

from motionlab.cli import main
from motionlab.reports.problems import problem_document

PROBLEM = problem_document("drive-link", "not possible while the link is offline")


class _Offline(BaseHTTPRequestHandler):
    """A lab whose drives do not answer: the lease is free, nothing moves."""

    def do_POST(self) -> None:
        self.rfile.read(int(self.headers.get("Content-Length", "0")))
        lease = self.path.endswith("/lease")
        answer = {"lease": "token", "seconds": 2.0} if lease else PROBLEM
        body = json.dumps(answer).encode()
        self.send_response(201 if lease else 409)
        self.send_header("Content-Length", str(len(body)))
        self.end_headers()
        self.wfile.write(body)

    def do_DELETE(self) -> None:
        self.send_response(204)
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:
        """Write nothing."""


@pytest.fixture
def offline() -> Iterator[str]:
    with HTTPServer(("127.0.0.1", 0), _Offline) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()
        thread.join()


@pytest.mark.parametrize("arm", [[], ["--arm"]])
def test_a_link_that_is_offline(
    offline: str, capsys: pytest.CaptureFixture[str], arm: list[str]
) -> None:
    line = ["drive", "run", "circle", "--variant", "A", "--json", "--server", offline, *arm]
    assert main(line) == 1
    problem = json.loads(capsys.readouterr().out)
    assert problem["type"] == "urn:motionlab:problem:drive-link"
    assert problem["status"] == 409
    assert problem["detail"] == "not possible while the link is offline"


def test_a_server_that_does_not_answer(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["drive", "status", "--json", "--server", "http://127.0.0.1:9"]) == 1
    problem = json.loads(capsys.readouterr().out)
    assert (problem["type"], problem["status"]) == ("urn:motionlab:problem:unavailable", 503)
