"""Keys of a query that an operation does not know, or that come twice, are refused by name."""

from __future__ import annotations

import json

import httpx
import pytest
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from motionlab import Client
from motionlab.errors import ConfigError
from tests.server.live import Live
from tests.server.servers import Server


@pytest.mark.parametrize(
    ("path", "key", "allowed"),
    [
        ("/api/v1/runs?nme=x", "nme", "one of cursor, limit, q, sort"),
        ("/api/v1/runs?limit=1&Q=x", "Q", "one of cursor, limit, q, sort"),
        ("/api/v1/scenarios?name=circle", "name", "no query"),
        ("/api/v1/jobs?knd=tune", "knd", "one of kind"),
        ("/api/v1/fields?x", "x", "no query"),
        ("/api/v1/fields?x=1", "x", "no query"),
    ],
)
def test_an_unknown_key_is_named(client: httpx.Client, path: str, key: str, allowed: str) -> None:
    answer = client.get(path)
    assert answer.status_code == 422
    problem = answer.json()
    assert problem["type"] == "urn:motionlab:problem:invalid-field"
    assert [(each["loc"], each["range"]) for each in problem["errors"]] == [(key, allowed)]


def test_a_known_key_is_taken(client: httpx.Client) -> None:
    assert client.get("/api/v1/runs?limit=1").status_code == 200


def test_a_key_that_comes_twice_is_named(client: httpx.Client) -> None:
    answer = client.get("/api/v1/runs?limit=1&q=a&limit=2")
    assert answer.status_code == 422
    assert [each["loc"] for each in answer.json()["errors"]] == ["limit"]


def test_stop_is_taken_whatever_stands_beside_it(client: httpx.Client, live: Live) -> None:
    assert client.post(f"/api/v1/sessions/{live.id}/stop?x=1&x=2").status_code == 200


def test_a_stream_has_no_query(server: Server, live: Live) -> None:
    address = f"{server.url.replace('http', 'ws')}/api/v1/sessions/{live.id}/stream?from_tick=3"
    with pytest.raises(InvalidStatus) as refused:
        connect(address)
    answer = refused.value.response
    assert answer.status_code == 422
    assert [(each["loc"], each["range"]) for each in json.loads(answer.body)["errors"]] == [
        ("from_tick", "no query")
    ]


def test_the_client_raises(server: Server) -> None:
    with pytest.raises(ConfigError, match="nme"):
        Client(server.url).runs(nme="x")
