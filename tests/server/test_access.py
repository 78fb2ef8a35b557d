"""Who may ask: tokens, origins, hosts; and what `motionlab serve` refuses to begin with."""

from __future__ import annotations

import contextlib
import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import httpx
import pytest
from websockets.exceptions import InvalidStatus

from motionlab.cli import main
from motionlab.server.http.security import OPEN_PATHS
from motionlab.server.settings import LOOPBACK, Settings
from tests.processes import children_of
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live, Stream
from tests.server.openapi import HEADERS, PROBLEM, Contract
from tests.server.servers import PATIENCE, Server

TOKEN = 'tk-"0123;456,\\89={~'  # all that a header can carry
BEARER = {"authorization": f"Bearer {TOKEN}"}


@pytest.fixture(scope="module")
def guarded() -> Iterator[Server]:
    """Return a server that asks for a token and has a further name."""
    server = Server(Settings(token=TOKEN, hosts=LOOPBACK | {"lab.example"}))
    yield server
    server.stop()


@pytest.fixture
def anyone(guarded: Server) -> Iterator[httpx.Client]:
    """Return a client of that server that knows nothing."""
    with httpx.Client(base_url=guarded.url, timeout=PATIENCE) as client:
        yield client


def asked(server: Server, path: str, headers: dict[str, str], method: str = "GET") -> int:
    """Return the status that a request gets whose path and headers nobody tidies up."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    try:
        connection.putrequest(method, path, skip_host=True)
        for name, value in headers.items():
            connection.putheader(name, value)
        connection.endheaders()
        response = connection.getresponse()
        response.read()
        return response.status
    finally:
        connection.close()


def refused_stream(server: Server, session: str, **options: Any) -> int:
    """Return the status with which a stream is refused."""
    with pytest.raises(InvalidStatus) as refusal:
        Stream(server, session, **options)
    return refusal.value.response.status_code


# -- tokens ---------------------------------------------------------------------------------------


def test_every_route_needs_the_token(anyone: httpx.Client, contract: Contract) -> None:
    for path, operations in contract.document["paths"].items():
        for method in operations:
            response = anyone.request(method, re.sub(r"\{\w+\}", "nowhere", path))
            if path in OPEN_PATHS:
                assert response.status_code != 401 or path.endswith("login")
                continue
            assert response.status_code == 401, path
            assert response.headers["www-authenticate"] == "Bearer"
            assert response.headers["content-type"] == PROBLEM
            assert "token" in response.json()["detail"]
            for name, value in HEADERS.items():
                assert response.headers[name] == value
    for path in ("/docs", "/openapi.json", "/asyncapi.json", "/metrics", "/docs/assets/x.css"):
        assert anyone.get(path).status_code == 401, path
    assert anyone.get(f"{API}/health").status_code == 200


def test_the_document_says_who_is_asked(guarded: Server, contract: Contract) -> None:
    asks = [{"bearer": []}, {"cookie": []}]
    assert contract.document["security"] == [*asks, {}]  # its server has no token
    document = guarded.app.openapi()
    assert document["security"] == asks
    schemes = document["components"]["securitySchemes"]
    assert (schemes["bearer"]["type"], schemes["bearer"]["scheme"]) == ("http", "bearer")
    assert (schemes["cookie"]["in"], schemes["cookie"]["name"]) == ("cookie", "motionlab_8000")
    for path, operations in document["paths"].items():
        for operation in operations.values():
            assert operation.get("security") == ([] if path in OPEN_PATHS else None), path
            for refused in ("400", "401", "403"):
                assert list(operation["responses"][refused]["content"]) == [PROBLEM], path


@pytest.mark.parametrize("scheme", ["Bearer", "bearer", "BEARER"])
def test_the_token_as_bearer(anyone: httpx.Client, scheme: str) -> None:
    headers = {"authorization": f"{scheme} {TOKEN}"}
    for path in (f"{API}/scenarios", "/docs", "/openapi.json", "/metrics"):
        assert anyone.get(path, headers=headers).status_code == 200


@pytest.mark.parametrize(
    "headers",
    [
        {"authorization": "Bearer"},
        {"authorization": f"Bearer {TOKEN[:-1]}"},
        {"authorization": f"Bearer {TOKEN}x"},
        {"authorization": f"Bearer {TOKEN.upper()}"},
        {"authorization": f"Basic {TOKEN}"},
        {"authorization": TOKEN},
        {"authorization": b"Bearer \xff\xfe"},
        {"cookie": "{cookie}="},
        {"cookie": "{cookie}=wrong"},
        {"cookie": f"{{cookie}}={TOKEN}"},
        {"cookie": "{cookie}=x.1e999.0"},
        {"cookie": "{cookie}=..\xff"},
        {"cookie": f"other={TOKEN}"},
        {"cookie": b"\xff=\xfe; ;;=;"},
        {"x-token": TOKEN},
    ],
    ids=str,
)
def test_what_is_not_the_token(
    guarded: Server, anyone: httpx.Client, headers: dict[str, Any]
) -> None:
    if isinstance(headers.get("cookie"), str):
        own = f"motionlab_{guarded.port}"
        headers = {"cookie": headers["cookie"].replace("{cookie}", own).encode("latin-1")}
    assert anyone.get(f"{API}/scenarios", headers=headers).status_code == 401
    assert anyone.get(f"{API}/scenarios?token={TOKEN}").status_code == 401


def test_a_stream_needs_the_token(guarded: Server, anyone: httpx.Client) -> None:
    anyone.headers.update(BEARER)
    live = Live.create(anyone)
    for headers in ({}, {"authorization": "Bearer wrong"}, {"cookie": "motionlab=wrong"}):
        assert refused_stream(guarded, live.id, additional_headers=headers) == 403
    login = anyone.post(f"{API}/login", json={"token": TOKEN})
    cookie = {"cookie": login.headers["set-cookie"].rsplit("; HttpOnly", 1)[0]}
    for headers in (BEARER, cookie):
        with Stream(guarded, live.id, additional_headers=headers) as stream:
            assert stream.message("hello")["session"]["id"] == live.id
    live.delete()


@pytest.mark.parametrize(
    "path",
    [
        "//api/v1/scenarios",
        "/./api/v1/scenarios",
        "/x/../api/v1/scenarios",
        "/API/v1/scenarios",
        "/%61pi/v1/scenarios",
        "/api%2fv1/scenarios",
        "/api/v1/health/../scenarios",
        "/api/v1/health%2f..%2fscenarios",
        "/api/v1/login/../../v1/scenarios",
        "/%2fapi/v1/scenarios",
        "/metrics/",
        "/%6detrics",
    ],
)
def test_no_other_spelling_of_a_path_gets_past(guarded: Server, path: str) -> None:
    assert asked(guarded, path, {"host": "127.0.0.1"}) in {401, 404}


def test_the_page_may_be_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "index.html").write_text("<title>the page</title>")
    (tmp_path / "page.js").write_text("1")
    monkeypatch.setattr("motionlab.server.http.page.page_root", lambda: tmp_path)
    server = Server(Settings(token=TOKEN))
    try:
        with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
            for path in ("/", "/index.html", "/page.js"):
                response = client.get(path)
                assert response.status_code == 200
                assert HEADERS.items() <= dict(response.headers).items()
            assert client.get(f"{API}/scenarios").status_code == 401
            assert client.get("/../../etc/passwd").status_code == 404
        for path in ("/../pyproject.toml", "/%2e%2e/pyproject.toml", "//etc/passwd"):
            assert asked(server, path, {"host": "127.0.0.1"}) == 404
    finally:
        server.stop()


# -- origins --------------------------------------------------------------------------------------

FOREIGN = [
    "null",
    "",
    "http://evil.example",
    "http://127.0.0.1",
    "http://127.0.0.1:1",
    "http://localhost:{port}",
    "http://user@127.0.0.1:{port}",
    "http://127.0.0.1:{port}.evil.example",
    "http://evil.example/127.0.0.1:{port}",
    "http://evil.example#@127.0.0.1:{port}",
    "127.0.0.1:{port}",
    "http://[",
    "file://",
]


@pytest.mark.parametrize("origin", FOREIGN)
def test_a_foreign_origin_may_not_write(server: Server, live: Live, origin: str) -> None:
    headers = {"origin": origin.format(port=server.port)}
    before = live.info()
    for method, path in (
        ("POST", "/step"),
        ("POST", "/reset"),
        ("PATCH", "/parameters"),
        ("DELETE", ""),
    ):
        response = live.client.request(method, live.path + path, headers=headers)
        assert response.status_code == 403
        assert "origin" in response.json()["detail"]
    for path in ("simulate", "sessions", "login"):
        assert live.client.post(f"{API}/{path}", json={}, headers=headers).status_code == 403
    assert live.info() == before
    assert refused_stream(server, live.id, additional_headers=headers) == 403
    read = live.client.get(live.path, headers=headers)
    assert read.status_code == 403
    assert not [name for name in read.headers if name.startswith("access-control")]
    asks = live.client.options(
        live.path, headers=headers | {"access-control-request-method": "PUT"}
    )
    assert not [name for name in asks.headers if name.startswith("access-control")]


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_page_of_another_site_starts_nothing(make_server: MakeServer, site: str) -> None:
    server = make_server(Settings())
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        live = Live.create(client)
        foreign = {"sec-fetch-site": site}, {"origin": "http://evil.example"}
        for path in ("/scene", "/scene/", f"/scene/{live.id}/", f"{live.path}/telemetry"):
            for method in ("GET", "HEAD"):
                for headers in foreign:
                    assert client.request(method, path, headers=headers).status_code == 403
        assert server.app.state.scenes.all() == []
        for own in ("same-origin", "none"):
            assert client.get(live.path, headers={"sec-fetch-site": own}).status_code == 200
        # A link to the page from elsewhere is no harm.
        assert client.get("/docs", headers={"sec-fetch-site": site}).status_code == 200


@pytest.mark.parametrize("scheme", ["http", "https"])
def test_the_page_itself_may_write(server: Server, live: Live, scheme: str) -> None:
    headers = {"origin": f"{scheme}://127.0.0.1:{server.port}"}
    assert live.client.post(f"{live.path}/step", headers=headers).status_code == 200
    with Stream(server, live.id, additional_headers=headers) as stream:
        stream.message("hello")


# -- hosts ----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "host",
    [
        "127.0.0.1",
        "127.0.0.1:8000",
        "localhost",
        "LocalHost:8000",
        "[::1]",
        "[::1]:8000",
        "lab.example",
        "Lab.Example:443",
    ],
)
def test_names_of_this_server(guarded: Server, host: str) -> None:
    assert asked(guarded, f"{API}/health", {"host": host}) == 200
    origin = {"origin": f"http://{host}", "content-length": "0"} | BEARER
    assert asked(guarded, f"{API}/sessions/x/stop", {"host": host} | origin, "POST") == 404


@pytest.mark.parametrize(
    "host",
    [
        "",
        "evil.example",
        "evil.example:8000",
        "127.0.0.1.evil.example",
        "localhost.evil.example",
        "xlab.example",
        "127.0.0.1:80:80",
        "127.0.0.1:",
        "127.0.0.2",
        "::1",
        "[::1",
        "[::2]",
        "user@localhost",
        "localhost/",
        "0.0.0.0",
    ],
)
def test_names_of_another_server(guarded: Server, host: str) -> None:
    """A page that has bound its own name to this address, which makes Origin and Host agree."""
    for path in (f"{API}/health", "/", "/docs"):
        assert asked(guarded, path, {"host": host} | BEARER) == 403, path
    headers = {"host": host, "origin": f"http://{host}"} | BEARER
    assert asked(guarded, f"{API}/sessions", headers, "POST") == 403


@pytest.mark.parametrize("hosts", [[], ["127.0.0.1", "evil.example"], 2 * ["127.0.0.1"]], ids=len)
@pytest.mark.parametrize("method", ["GET", "POST"])
def test_a_request_has_one_host(server: Server, hosts: list[str], method: str) -> None:
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=PATIENCE)
    with contextlib.closing(connection):
        connection.putrequest(method, f"{API}/sessions", skip_host=True)
        for host in hosts:
            connection.putheader("Host", host)
        connection.endheaders()
        response = connection.getresponse()
        assert response.status == 400
        assert response.headers["content-type"] == PROBLEM
        assert json.load(response)["detail"].startswith(f"{len(hosts)} Host headers")


def test_a_stream_under_another_name(server: Server, make_live: MakeLive) -> None:
    live = make_live()
    request = (
        f"GET {live.path}/stream HTTP/1.1\r\nHost: evil.example\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n"
        "Sec-WebSocket-Version: 13\r\n\r\n"
    )
    for text, status in ((request, b"403"), (request.replace("evil.example", "localhost"), b"101")):
        with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as connection:
            connection.sendall(text.encode())
            assert connection.recv(1000).split()[1] == status


# -- the command ----------------------------------------------------------------------------------


@pytest.fixture
def no_server(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail, instead of serving for ever, where a refusal is missing."""

    def run(*_: Any, **__: Any) -> None:
        raise AssertionError("it serves")

    monkeypatch.setattr("uvicorn.Server.run", run)
    monkeypatch.delenv("MOTIONLAB_TOKEN", raising=False)


@pytest.mark.usefixtures("no_server")
@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.0.2.1", "lab.example"])
def test_another_address_than_loopback_needs_a_token(
    capsys: pytest.CaptureFixture[str], host: str
) -> None:
    assert main(["serve", "--port", "0", "--host", host]) == 2
    told = capsys.readouterr().err
    assert "MOTIONLAB_TOKEN" in told
    assert host in told


@pytest.mark.usefixtures("no_server")
@pytest.mark.parametrize(
    ("token", "reason"),
    [
        ("brief", "16 characters"),
        (15 * "x", "16 characters"),
        (20 * "x" + "\n", "header"),
        ("many words in one token", "header"),
        (20 * "ü", "header"),
        (20 * "€", "header"),
    ],
)
def test_a_token_that_cannot_serve_as_one(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, token: str, reason: str
) -> None:
    monkeypatch.setenv("MOTIONLAB_TOKEN", token)
    for host in ("127.0.0.1", "0.0.0.0"):
        assert main(["serve", "--port", "0", "--host", host]) == 2
        told = capsys.readouterr().err
        assert reason in told
        assert token not in told


@pytest.mark.usefixtures("no_server")
def test_an_address_that_cannot_be_had(capsys: pytest.CaptureFixture[str], server: Server) -> None:
    assert main(["serve", "--port", str(server.port)]) == 2
    told = capsys.readouterr().err
    assert "in use" in told
    assert str(server.port) in told
    assert "free port" in told


@pytest.mark.usefixtures("no_server")
@pytest.mark.parametrize("host", ["192.0.2.1", "no such host", 70 * "x" + ".example", "\u2028"])
def test_a_host_that_is_none(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, host: str
) -> None:
    monkeypatch.setenv("MOTIONLAB_TOKEN", 16 * "x")
    assert main(["serve", "--port", "0", "--host", host]) == 2
    assert "cannot listen" in capsys.readouterr().err


def test_the_command_serves_and_ends() -> None:
    command = [sys.executable, "-m", "motionlab", "serve", "--port", "0", "--name", "Lab.Example"]
    environment = os.environ | {"MOTIONLAB_TOKEN": TOKEN}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment) as process:
        try:
            assert process.stderr is not None
            told = process.stderr.readline()
            address = re.search(r"http://127\.0\.0\.1:\d+", told)
            assert address is not None, told
            assert TOKEN not in told
            with httpx.Client(base_url=address[0], timeout=PATIENCE) as client:
                assert client.get(f"{API}/health").status_code == 200
                assert client.get(f"{API}/scenarios").status_code == 401
                named = {"host": "lab.example"} | BEARER
                assert client.get(f"{API}/scenarios", headers=named).status_code == 200
                elsewhere = {"host": "other.example"} | BEARER
                assert client.get(f"{API}/scenarios", headers=elsewhere).status_code == 403
                assert client.head("/scene/", headers=BEARER).status_code == 200
            children = children_of(process.pid, "")
            assert children
            for child in children:
                assert b"MOTIONLAB_TOKEN" not in Path(f"/proc/{child}/environ").read_bytes()
            process.send_signal(signal.SIGINT)
            assert process.wait(PATIENCE) == 0
            assert process.stderr.read() == ""
        finally:
            process.kill()
