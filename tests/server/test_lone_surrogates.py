"""Text that UTF-8 cannot hold enters by no request; one odd session stops no list and no STOP."""

from __future__ import annotations

import dataclasses
import io
import json
from collections.abc import Iterator
from typing import Any
from urllib.parse import quote

import httpx
import pytest
from mcap.writer import Writer

from tests.server.live import API, Live, Stream
from tests.server.openapi import body_examples, document
from tests.server.servers import Server

HALF = "\ud800"
FILLED = {
    "session_id": "{live}",
    "run_id": "r-aaaaaaaaaaaa",
    "name": "halves",
}


def bodies() -> Iterator[tuple[str, str, str]]:
    """Yield method, path and identifier of every operation that takes JSON."""
    for path, operations in document()["paths"].items():
        for method, operation in operations.items():
            content = operation.get("requestBody", {}).get("content", {})
            if "application/json" in content:
                yield method, path, operation["operationId"]


def spoilt(value: Any) -> Iterator[Any]:
    """Yield a body with half of a surrogate pair in each of its texts, and in a key."""
    if isinstance(value, str):
        yield value + HALF
    elif isinstance(value, dict):
        yield value | {HALF: 1}
        for key, item in value.items():
            yield from (value | {key: each} for each in spoilt(item))
    elif isinstance(value, list) and value:
        yield from ([each, *value[1:]] for each in spoilt(value[0]))


@pytest.mark.parametrize(("method", "path", "operation"), list(bodies()))
def test_no_body_brings_half_a_pair(
    client: httpx.Client, live: Live, method: str, path: str, operation: str
) -> None:
    for name, value in FILLED.items():
        path = path.replace(f"{{{name}}}", value.replace("{live}", live.id))
    path = path.replace("{", "").replace("}", "")
    for example in body_examples(document(), operation):
        for body in spoilt(example):
            for content in (json.dumps(body).encode(), _raw(body), _utf16(body)):
                answer = client.request(
                    method, path, content=content, headers={"content-type": "application/json"}
                )
                assert 400 <= answer.status_code < 500, (body, answer.text)
    assert client.get(f"{API}/sessions").status_code == 200


def _raw(body: Any) -> bytes:
    return json.dumps(body, ensure_ascii=False).encode("utf-8", "surrogatepass")


def _utf16(body: Any) -> bytes:
    return json.dumps(body).encode("utf-16-le")


@pytest.mark.parametrize(
    "path",
    ["plant.description", "plant.name", "variants.B.controller.description"],
)
def test_a_session_takes_none_and_says_where(client: httpx.Client, live: Live, path: str) -> None:
    body = json.dumps({"set": {path: HALF}})
    before = [session["id"] for session in client.get(f"{API}/sessions").json()]
    for method, url in (
        ("PATCH", f"{live.path}/parameters"),
        ("POST", f"{API}/sessions"),
        ("POST", f"{API}/simulate"),
        ("POST", f"{API}/whatif"),
    ):
        answer = client.request(
            method, url, content=body, headers={"content-type": "application/json"}
        )
        assert answer.status_code == 422, answer.text
        assert f"body.set.{path}: holds half of a surrogate pair" in answer.json()["detail"]
    assert [session["id"] for session in client.get(f"{API}/sessions").json()] == before
    assert client.post(f"{live.path}/stop").status_code == 200


def test_a_stream_and_a_query_take_none(client: httpx.Client, server: Server, live: Live) -> None:
    with Stream(server, live.id) as stream:
        stream.message("hello")
        stream.socket.send('{"type": "subscribe", "columns": ["\\ud800"]}')
        assert stream.message("error")
    for name in ("note", "q", "sort", "cursor", "name"):
        answer = client.get(f"{API}/runs?{name}={quote(HALF, errors='surrogatepass')}")
        assert answer.status_code < 500


def test_a_session_that_cannot_be_encoded_is_listed_and_stopped(
    client: httpx.Client, server: Server, live: Live
) -> None:
    """However it came in: the list, its state and its stop are still answered."""
    session = server.app.state.sessions.find(live.id)
    plant = session.prepared.scenario.plant.model_copy(update={"description": HALF})
    odd = session.prepared.scenario.model_copy(update={"plant": plant})
    session.prepared = dataclasses.replace(session.prepared, scenario=odd)
    listed = client.get(f"{API}/sessions")
    assert listed.status_code == 200
    assert live.id in [each["id"] for each in json.loads(listed.content)]
    assert client.get(live.path).status_code == 200
    assert client.post(f"{live.path}/play").status_code == 200
    assert client.post(f"{live.path}/stop").json()["state"] in {"stopping", "stopped"}


def test_an_mcap_file_with_half_a_pair_as_key_is_refused(client: httpx.Client) -> None:
    file = io.BytesIO()
    writer = Writer(file)
    writer.start()
    channel = writer.register_channel("/a", "json", schema_id=0)
    for tick in range(4):
        writer.add_message(channel, tick * 500_000, b'{"x\\ud800": 1.5}', tick * 500_000)
    writer.finish()
    headers = {"content-type": "application/octet-stream"}
    for query in ("", "?preview=true"):
        answer = client.post(f"{API}/runs/import{query}", content=file.getvalue(), headers=headers)
        assert answer.status_code == 422, answer.text
        assert "surrogate" in answer.json()["detail"]
