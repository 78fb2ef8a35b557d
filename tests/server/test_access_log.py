"""The log of requests: what a line says, and what it never says."""

from __future__ import annotations

import io
import json
import logging
import socket
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from motionlab.server.http import access_log
from motionlab.server.settings import Settings
from tests.server.conftest import MakeServer
from tests.server.live import API, Live, until
from tests.server.servers import PATIENCE, Server

Lines = Any
TOKEN = "a-token-of-some-length"


@pytest.fixture
def lines(monkeypatch: pytest.MonkeyPatch) -> Iterator[Lines]:
    """Turn the log on; return what reads its lines."""
    written = io.StringIO()
    log = access_log.LOG
    kept = log.handlers, log.propagate, log.level
    monkeypatch.setattr("sys.stdout", written)
    access_log.install()
    log.setLevel(logging.INFO)
    yield lambda: [json.loads(line) for line in written.getvalue().splitlines()]
    log.handlers, log.propagate = kept[:2]
    log.setLevel(kept[2])
    logging.getLogger("uvicorn.error").filters.clear()


def test_a_line_for_each_request(server: Server, lines: Lines) -> None:
    secret = {"Authorization": "Bearer secret-of-somebody", "Cookie": "motionlab=secret"}
    asked = {"headers": secret | {"X-Request-ID": "from-a.proxy_1"}, "timeout": PATIENCE}
    found = httpx.get(f"{server.url}{API}/health?token=secret", **asked)
    missing = httpx.get(f"{server.url}{API}/nothing%0A", timeout=PATIENCE)
    head = httpx.head(f"{server.url}{API}/health", timeout=PATIENCE)
    refused = httpx.get(f"{server.url}{API}/health", headers={"Host": "evil"}, timeout=PATIENCE)
    until(lambda: len(lines()) == 4)
    first, second, third, fourth = lines()
    assert first == {
        "time": first["time"],
        "method": "GET",
        "path": f"{API}/health",
        "status": 422,  # `token` is no key of its query
        "ms": first["ms"],
        "bytes": len(found.content),
        "client": "127.0.0.1",
        "request": "from-a.proxy_1",
    }
    assert first["ms"] > 0
    assert (second["status"], second["path"]) == (404, f"{API}/nothing\n")
    assert (third["method"], third["bytes"]) == ("HEAD", 0)
    assert fourth["status"] == refused.status_code == 403
    assert "secret" not in json.dumps([first, second, third, fourth])
    for line, answer in zip(lines(), (found, missing, head, refused), strict=True):
        assert answer.headers["X-Request-ID"] == line["request"]
    assert second["request"] != third["request"]


def test_an_identifier_that_is_none_is_replaced(server: Server, lines: Lines) -> None:
    for given in ("two words", "x" * 65, '"}'):
        httpx.get(f"{server.url}{API}/health", headers={"X-Request-ID": given}, timeout=PATIENCE)
    until(lambda: len(lines()) == 3)
    assert [line["request"] for line in lines() if " " in line["request"]] == []
    assert len({line["request"] for line in lines()}) == 3


def of_streams(lines: Lines) -> list[dict[str, Any]]:
    return [line for line in lines() if "event" in line]


def test_a_line_as_a_stream_opens_and_one_as_it_closes(
    server: Server, live: Live, lines: Lines
) -> None:
    with connect(server.stream(live.id)) as socket:
        hello = socket.recv(PATIENCE)
        until(lambda: len(of_streams(lines)) == 1)
    until(lambda: len(of_streams(lines)) == 2)
    opened, closed = of_streams(lines)
    assert (opened["event"], opened["status"]) == ("open", 101)
    assert (closed["event"], closed["method"]) == ("close", "WEBSOCKET")
    assert closed["request"] == opened["request"]
    assert closed["bytes"] >= len(hello)
    assert closed["path"].endswith(f"/{live.id}/stream")


def test_nothing_is_logged_at_the_level_of_warnings(server: Server, lines: Lines) -> None:
    access_log.LOG.setLevel(logging.WARNING)
    answer = httpx.get(f"{server.url}{API}/health", timeout=PATIENCE)
    assert lines() == []
    assert "X-Request-ID" not in answer.headers


def test_lines_that_cannot_be_written_are_lost(server: Server, lines: Lines) -> None:
    class Full(io.StringIO):
        def write(self, _: str) -> int:
            raise OSError(28, "No space left on device")

    access_log.LOG.handlers[0].setStream(Full())  # pyright: ignore[reportAttributeAccessIssue]
    assert httpx.get(f"{server.url}{API}/health", timeout=PATIENCE).status_code == 200
    access_log.LOG.handlers[0].setStream(io.StringIO())  # pyright: ignore[reportAttributeAccessIssue]
    assert lines() == []


def test_clients_without_the_token_have_so_many_lines(
    make_server: MakeServer, lines: Lines, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access_log, "UNKNOWN_MAX", 3)
    monkeypatch.setattr(access_log, "UNKNOWN_SECONDS", 2.0)
    url = make_server(Settings(token=TOKEN)).url
    knows = {"Authorization": f"Bearer {TOKEN}"}
    with httpx.Client(base_url=url, timeout=PATIENCE) as client:
        for _ in range(5):
            assert client.get(f"{API}/scenarios").status_code == 401
            assert client.get(f"{API}/health").status_code == 200
            assert client.get(f"{API}/health", headers={"Host": "evil"}).status_code == 403
        for _ in range(5):
            assert client.get(f"{API}/scenarios", headers=knows).status_code == 200
    until(lambda: any("count" in line for line in lines()))
    until(lambda: sum(line.get("count", 1) for line in lines()) == 20)
    written = [line for line in lines() if "status" in line]
    assert len([line for line in written if line["status"] == 200 and "scen" in line["path"]]) == 5
    assert len(written) < 20


@pytest.mark.usefixtures("lines")
def test_bytes_that_are_no_request_have_so_many_lines(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(access_log, "UNKNOWN_MAX", 3)
    monkeypatch.setattr(access_log, "UNKNOWN_SECONDS", 2.0)
    server = make_server(Settings())
    log, messages = logging.getLogger("uvicorn.error"), list[str]()
    handler = logging.Handler()
    handler.emit = lambda record: messages.append(record.getMessage())  # pyright: ignore
    log.addHandler(handler)
    monkeypatch.setattr(log, "level", logging.INFO)
    log.manager._clear_cache()  # pyright: ignore
    try:
        for _ in range(10):
            with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as client:
                client.sendall(b"\x00\x01 no request\r\n\r\n")
                assert client.recv(100).startswith(b"HTTP/1.1 400")
        with pytest.raises(InvalidStatus):
            connect(server.stream("s-none") + "?token=secret")
        until(lambda: len(messages) >= 4)
        assert messages[:3] == ["Invalid HTTP request received."] * 3
        assert messages[3:] == ["7 more invalid requests within 2 s"]
    finally:
        log.removeHandler(handler)
