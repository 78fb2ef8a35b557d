"""Log-ins of browsers: cookies in place of the token, log-out, attempts."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator
from importlib.metadata import version
from typing import Any

import httpx
import pytest
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Subprotocol

from motionlab.server.http import logins
from motionlab.server.settings import Settings
from tests.server.conftest import MakeServer
from tests.server.live import API, Live
from tests.server.servers import PATIENCE, Server
from tests.server.test_access import refused_stream

TOKEN = "a-token-of-some-length"
BEARER = {"authorization": f"Bearer {TOKEN}"}


@pytest.fixture
def server(make_server: MakeServer) -> Server:
    return make_server(Settings(token=TOKEN))


@pytest.fixture
def anyone(server: Server) -> Iterator[httpx.Client]:
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        yield client


def log_in(client: httpx.Client) -> str:
    """Return the cookie of a log-in, as a browser sends it."""
    response = client.post(f"{API}/login", json={"token": TOKEN})
    client.cookies.clear()  # each request says which it has
    assert response.status_code == 204
    return response.headers["set-cookie"].partition(";")[0]


def status(client: httpx.Client, cookie: str) -> int:
    response = client.get(f"{API}/scenarios", headers={"cookie": cookie})
    client.cookies.clear()
    return response.status_code


def test_a_browser_logs_in(server: Server, anyone: httpx.Client) -> None:
    for wrong in ("", "x", TOKEN[:-1], TOKEN + "x", "ü" * 20):
        response = anyone.post(f"{API}/login", json={"token": wrong})
        assert response.status_code == 401
        assert "set-cookie" not in response.headers
    response = anyone.post(f"{API}/login", json={"token": TOKEN})
    assert response.status_code == 204
    cookie, *attributes = response.headers["set-cookie"].split("; ")
    assert cookie.startswith(f"motionlab_{server.port}=")
    assert set(attributes) == {"HttpOnly", "Max-Age=43200", "Path=/", "SameSite=Strict"}
    # What another server of this host has set comes along, whatever it looks like.
    for given in (cookie, f'junk={{"a": 1}}; {cookie}', f"{cookie}; =; a b"):
        assert status(anyone, given) == 200, given


def test_the_cookie_does_not_hold_the_token(anyone: httpx.Client) -> None:
    first, second = log_in(anyone), log_in(anyone)
    assert first != second
    assert TOKEN not in first


@pytest.mark.parametrize("proxies", [set(), {"192.0.2.1"}, {"127.0.0.1"}, {"127.0.0.0/8"}])
def test_only_a_named_proxy_is_believed(
    make_server: MakeServer, caplog: pytest.LogCaptureFixture, proxies: set[str]
) -> None:
    caplog.set_level(logging.INFO, "motionlab")
    url = make_server(Settings(token=TOKEN, proxies=frozenset(proxies))).url
    headers = {"x-forwarded-proto": "https", "x-forwarded-for": "198.51.100.7"}
    response = httpx.post(f"{url}{API}/login", json={"token": TOKEN}, headers=headers)
    named = any(proxy.startswith("127") for proxy in proxies)
    assert response.headers["set-cookie"].endswith("; Secure") == named
    lines = [record.getMessage() for record in caplog.records]
    assert f"log-in from '{'198.51.100.7' if named else '127.0.0.1'}'" in lines


def test_a_changed_cookie_is_none(anyone: httpx.Client) -> None:
    name, _, value = log_in(anyone).partition("=")
    login, expires, signature = value.split(".")
    for changed in (
        f"{login}x.{expires}.{signature}",
        f"{login}.{int(expires) + 1}.{signature}",
        f"{login}.{expires}.{signature[:-1]}",
        f"{login}.{expires}.{'0' * len(signature)}",
        f"{login}.{expires}",
    ):
        assert status(anyone, f"{name}={changed}") == 401, changed


def test_a_cookie_is_of_one_server_and_one_token() -> None:
    value = logins.Logins(TOKEN).issue()
    for other in (TOKEN, TOKEN + "x"):
        assert logins.Logins(other).verify(value) is None


def test_cookies_are_named_by_port() -> None:
    names = {logins.cookie_name(host) for host in ("lab:8000", "lab:8001", "lab", "[::1]:8000")}
    assert names == {"motionlab_8000", "motionlab_8001", "motionlab"}


def test_a_log_in_expires(anyone: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(logins, "LIFETIME", -1)
    assert status(anyone, log_in(anyone)) == 401


def test_a_log_in_in_use_is_renewed(anyone: httpx.Client, monkeypatch: pytest.MonkeyPatch) -> None:
    cookie = log_in(anyone)
    fresh = anyone.get(f"{API}/scenarios", headers={"cookie": cookie})
    assert "set-cookie" not in fresh.headers
    anyone.cookies.clear()
    now = time.monotonic()
    monkeypatch.setattr(logins, "monotonic", lambda: now + 0.75 * logins.LIFETIME)
    ageing = anyone.get(f"{API}/scenarios", headers={"cookie": cookie})
    renewed = ageing.headers["set-cookie"].partition(";")[0]
    anyone.cookies.clear()
    monkeypatch.setattr(logins, "monotonic", lambda: now + 1.25 * logins.LIFETIME)
    assert (status(anyone, cookie), status(anyone, renewed)) == (401, 200)


def test_a_browser_logs_out(server: Server, anyone: httpx.Client) -> None:
    cookie, other = log_in(anyone), log_in(anyone)
    with httpx.Client(base_url=server.url, headers=BEARER, timeout=PATIENCE) as script:
        live = Live.create(script)
    response = anyone.post(f"{API}/logout", headers={"cookie": cookie})
    assert response.status_code == 204
    assert response.headers["set-cookie"].startswith(f"motionlab_{server.port}=; ")
    assert "Max-Age=0" in response.headers["set-cookie"]
    anyone.cookies.clear()
    assert (status(anyone, cookie), status(anyone, other)) == (401, 200)
    assert refused_stream(server, live.id, additional_headers={"cookie": cookie}) == 403
    assert anyone.post(f"{API}/logout", headers=BEARER).status_code == 204
    assert anyone.post(f"{API}/logout").status_code == 401


@pytest.mark.parametrize("path", ["/api/v1/sessions/{id}/stream", "/scene/{id}"])
@pytest.mark.parametrize("how", ["log-out", "expiry"])
def test_a_websocket_ends_with_its_log_in(
    server: Server, anyone: httpx.Client, monkeypatch: pytest.MonkeyPatch, path: str, how: str
) -> None:
    with httpx.Client(base_url=server.url, headers=BEARER, timeout=PATIENCE) as script:
        live = Live.create(script)
    monkeypatch.setattr(logins, "_LOOK", 0.2)
    cookie = log_in(anyone)
    place = f"ws://127.0.0.1:{server.port}{path.format(id=live.id)}"
    protocol = Subprotocol(f"viser-v{version('viser')}")
    options: dict[str, Any] = {"open_timeout": PATIENCE, "proxy": None}
    if path.startswith("/scene"):
        options["subprotocols"] = [protocol]
    with (
        connect(place, additional_headers={"cookie": cookie}, **options) as stream,
        connect(place, additional_headers=BEARER, **options) as other,
    ):
        if how == "log-out":
            answer = anyone.post(f"{API}/logout", headers={"cookie": cookie})
            assert answer.status_code == 204
        else:
            now = time.monotonic()
            monkeypatch.setattr(logins, "monotonic", lambda: now + 1.25 * logins.LIFETIME)
        with pytest.raises(ConnectionClosed) as closed:
            while True:
                stream.recv(timeout=PATIENCE)
        assert closed.value.rcvd is not None
        assert closed.value.rcvd.code == 1008
        other.ping().wait(PATIENCE)
        assert other.close_code is None


def test_a_foreign_page_logs_nobody_out(anyone: httpx.Client) -> None:
    headers = {"cookie": log_in(anyone), "origin": "http://evil.example"}
    assert anyone.post(f"{API}/logout", headers=headers).status_code == 403


def test_attempts_of_a_client_are_limited(anyone: httpx.Client) -> None:
    for _ in range(logins.ATTEMPTS_MAX):
        assert anyone.post(f"{API}/login", json={"token": "wrong"}).status_code == 401
    refused = anyone.post(f"{API}/login", json={"token": "wrong"})
    assert refused.status_code == 429
    assert anyone.post(f"{API}/login", json={"token": TOKEN}).status_code == 204
    anyone.cookies.clear()
    assert 0 < int(refused.headers["retry-after"]) <= logins.ATTEMPTS_SECONDS
    assert anyone.get(f"{API}/scenarios", headers=BEARER).status_code == 200


def test_attempts_of_all_clients_are_limited(monkeypatch: pytest.MonkeyPatch) -> None:
    attempts = logins.Attempts()
    waits = [attempts.take(f"192.0.2.{n}") for n in range(logins.ATTEMPTS_MAX_IN_ALL + 1)]
    assert waits[:-1] == [0.0] * logins.ATTEMPTS_MAX_IN_ALL
    assert waits[-1] > 0
    now = time.monotonic()
    monkeypatch.setattr(logins, "monotonic", lambda: now + logins.ATTEMPTS_SECONDS)
    assert attempts.take("192.0.2.1") == 0.0


def test_log_ins_are_logged_without_the_token(
    anyone: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.INFO, "motionlab")
    anyone.post(f"{API}/login", json={"token": "something-wrong"})
    log_in(anyone)
    told = [record for record in caplog.records if record.name != "motionlab.access"]
    lines = [record.getMessage() for record in told]
    assert lines == ["log-in from '127.0.0.1' failed: wrong token", "log-in from '127.0.0.1'"]


def test_wrong_bearer_tokens_are_logged_up_to_a_number(
    anyone: httpx.Client, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level(logging.WARNING, "motionlab")
    wrong = {"authorization": "Bearer guess"}
    for _ in range(logins.ATTEMPTS_MAX + 5):
        assert anyone.get(f"{API}/scenarios", headers=wrong).status_code == 401
    lines = [record.getMessage() for record in caplog.records]
    assert lines == logins.ATTEMPTS_MAX * ["request of '127.0.0.1' refused: wrong token"]
    assert anyone.get(f"{API}/scenarios", headers=BEARER).status_code == 200
