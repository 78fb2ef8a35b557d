"""The API held to its OpenAPI document by generated requests, and to its word by hostile ones."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from schemathesis import Case, GenerationMode

from motionlab.service.app import create_app
from motionlab.service.settings import Settings
from tests.paths import ROOT
from tests.service.live import API, Live
from tests.service.openapi import Contract
from tests.service.servers import PATIENCE, Server

EXAMPLES = 15
DOCUMENT = create_app().openapi()
CONFIG = schemathesis.Config.from_path(ROOT / "schemathesis.toml")
SCHEMA = schemathesis.openapi.from_dict(DOCUMENT, config=CONFIG)
OPERATIONS = {
    operation["operationId"]: SCHEMA[path][method.upper()]
    for path, operations in DOCUMENT["paths"].items()
    for method, operation in operations.items()
}
OF_A_SESSION = [name for name, o in OPERATIONS.items() if "{session_id}" in o.path]
TAKES_A_BODY = [name for name, o in OPERATIONS.items() if o.body]
TAKES_INPUT = [n for n, o in OPERATIONS.items() if o.body or o.query or o.path_parameters]
CAN_BE_WRONG = [n for n in TAKES_INPUT if n != "parseScenario"]  # which takes any bytes
READS_JSON = [n for n in TAKES_A_BODY if n != "parseScenario"]
NEVER_GUESSED = {"login", "getScenario", "getJob", "cancelJob", "parseScenario", "changeParameters"}
NEVER_GUESSED |= {f"{verb}Trajectory" for verb in ("slow", "get", "delete")} | {"identify"}
NEVER_GUESSED |= {"checkTrajectory", "tune", "landscape", "getResponse", "getAccuracy", "sweepLoop"}
NEVER_GUESSED |= {"computeMap", "previewMap", "mapField", "getMap", "getMapFile", "deleteMap"}
NEVER_GUESSED |= {"fitMap", "shareForce", "reproduce", "planIdentification", "sweep"}
"""Operations that need a token, a name, an identifier, a TOML text, values that fit a path, an axis
that moves, a law that can be linearised, or speeds that fit the stroke and the bounds below, which
leave no force map to compute."""
JSON = {"content-type": "application/json"}
LONGEST = Settings(direct_max=5.0, work_max=60.0, map_vertices_max=1)
"""Bounds under which no generated request simulates for long."""

fuzzed = settings(
    max_examples=EXAMPLES,
    derandomize=True,
    database=None,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)


@pytest.fixture(scope="module")
def bounded() -> Iterator[Server]:
    server = Server(LONGEST)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def caller(bounded: Server, contract: Contract) -> Iterator[httpx.Client]:
    """Return a client of the bounded server; its every answer is checked as well."""
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    with httpx.Client(base_url=bounded.url, event_hooks=hooks, timeout=PATIENCE) as client:
        yield client


@pytest.fixture
def session(caller: httpx.Client) -> Iterator[Live]:
    """Return a session of the circle with a change to undo; see to it that no session stays."""
    live = Live.create(caller)
    live.change({"plant.x.mass": 6.0})
    yield live
    for info in caller.get(f"{API}/sessions").json():
        Live(caller, f"{API}/sessions/{info['id']}").delete()


def answers_as_documented(
    caller: httpx.Client, name: str, mode: GenerationMode, session: Live | None = None
) -> list[int]:
    """Ask with generated requests, of a session if one is given; schemathesis checks each answer.

    Returns
    -------
    list of int
        Status of every answer.
    """
    fixed = {"session_id": session.id} if session else None
    codes: list[int] = []
    base = str(caller.base_url).rstrip("/")
    connection = requests.Session()

    @fuzzed
    @given(case=OPERATIONS[name].as_strategy(mode, path_parameters=fixed))
    def ask(case: Case) -> None:
        response = case.call(base_url=base, session=connection, timeout=PATIENCE)
        codes.append(response.status_code)
        case.validate_response(response)
        if response.status_code == 201:
            Live(caller, response.headers["location"][0]).delete()

    with connection:
        ask()
    return codes


@pytest.mark.parametrize("name", OPERATIONS)
def test_what_the_document_allows(caller: httpx.Client, session: Live, name: str) -> None:
    codes = answers_as_documented(caller, name, GenerationMode.POSITIVE)
    if name in OF_A_SESSION:
        codes += answers_as_documented(caller, name, GenerationMode.POSITIVE, session)
    if name not in NEVER_GUESSED:
        assert any(200 <= code < 300 for code in codes), codes


@pytest.mark.parametrize("name", CAN_BE_WRONG)
def test_what_the_document_forbids(caller: httpx.Client, session: Live, name: str) -> None:
    codes = answers_as_documented(caller, name, GenerationMode.NEGATIVE)
    if name in OF_A_SESSION and name in TAKES_A_BODY:
        codes += answers_as_documented(caller, name, GenerationMode.NEGATIVE, session)
        assert any(code in {400, 415, 422} for code in codes), codes


# -- hostile requests -----------------------------------------------------------------------------


def ask(session: Live, name: str, **options: Any) -> httpx.Response:
    """Ask for an operation, of the session where it is one of sessions."""
    operation = OPERATIONS[name]
    path = operation.path.replace("{session_id}", session.id)
    return session.client.request(operation.method.upper(), path, **options)


HOSTILE = {
    "NaN": "NaN",
    "-Infinity": "-Infinity",
    "beyond-double": "1e999",
    "number": "-0.0",
    "text": '"circle"',
    "true": "true",
    "list": "[]",
    "prototype": '{"__proto__": {"polluted": true}}',
    "constructor": '{"constructor": {"prototype": {}}}',
    "dunder": '{"__class__": "x", "model_config": {}}',
    "half-a-pair": '{"\\udc00": "\\ud800"}',
    "null-byte": '{"\\u0000": 1}',
    "long-key": '{"' + 900_000 * "k" + '": 1}',
    "long-text": '{"scenario": "' + 900_000 * "a" + '", "x": 1}',
}


@pytest.mark.parametrize("text", HOSTILE.values(), ids=HOSTILE)
@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_that_is_none(session: Live, name: str, text: str) -> None:
    response = ask(session, name, content=text, headers=JSON)
    assert response.status_code == 422, response.text[:300]
    errors = response.json()["errors"]
    assert errors
    assert all(error["loc"] and error["message"] for error in errors)


@pytest.mark.parametrize("text", ["", " ", "null"], ids=["empty", "blank", "null"])
@pytest.mark.parametrize("name", READS_JSON)
def test_no_body(session: Live, name: str, text: str) -> None:
    response = ask(session, name, content=text, headers=JSON)
    optional = name in {"play", "step"} and text != " "
    assert response.status_code == 200 if optional else response.status_code in {400, 422}


@pytest.mark.parametrize("opening", ["[", '{"set":', '{"a":[', '[{"":'])
@pytest.mark.parametrize("name", READS_JSON)
def test_nesting_without_end(session: Live, name: str, opening: str) -> None:
    closing = "".join({"[": "]", "{": "}"}.get(mark, "") for mark in reversed(opening))
    for text in (10_000 * opening, 10_000 * opening + "1" + 10_000 * closing):
        response = ask(session, name, content=text, headers=JSON)
        assert response.status_code in {400, 422}, response.text[:300]


@pytest.mark.parametrize("name", READS_JSON)
def test_a_key_that_comes_twice(session: Live, name: str) -> None:
    before = session.info()
    for text in (
        '{"a": 1, "a": 1}',
        '{"set": {"seed": 1, "seed": 2}}',
        '[{"a": {"b": 1, "b": 1}}]',
    ):
        response = ask(session, name, content=text, headers=JSON)
        assert response.status_code == 400
        assert "comes twice" in response.json()["detail"]
    assert session.info() == before


@pytest.mark.parametrize(
    ("body", "why"), [(b'{"set": ' + 5000 * b"9" + b"}", "5000 digits"), (b'{"\xff": 1}', "0xff")]
)
@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_that_cannot_be_read(session: Live, name: str, body: bytes, why: str) -> None:
    response = ask(session, name, content=body, headers=JSON)
    assert response.status_code == 400
    assert why in response.json()["detail"]


@pytest.mark.parametrize("media", ["text/plain", "application/xml", "application/jsonp", "x"])
@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_of_another_type(session: Live, name: str, media: str) -> None:
    response = ask(session, name, content="{}", headers={"content-type": media})
    assert response.status_code == 415
    assert repr(media) in response.json()["detail"]


@pytest.mark.parametrize("value", ["5.0", "5", "5e0"])
def test_a_whole_number_may_have_a_point(session: Live, value: str) -> None:
    before = session.tick
    ask(session, "step", content=f'{{"ticks": {value}}}', headers=JSON).raise_for_status()
    assert session.tick == before + 5


@pytest.mark.parametrize("points", ['"100"', "true", "100.5", "9", "20001", "1e300"])
def test_points_that_are_none(session: Live, points: str) -> None:
    response = ask(session, "whatIf", content=f'{{"points": {points}}}', headers=JSON)
    assert response.status_code == 422
    assert [error["loc"] for error in response.json()["errors"]] == ["points"]


@pytest.mark.parametrize("method", ["GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"])
@pytest.mark.parametrize("path", DOCUMENT["paths"])
def test_a_method_that_a_path_does_not_know(session: Live, path: str, method: str) -> None:
    known = {known.upper() for known in DOCUMENT["paths"][path]}
    if "GET" in known:
        known.add("HEAD")
    if method in known:
        return
    # Not by the client that checks every answer: one to HEAD has no body.
    url = session.client.base_url.join(path.replace("{session_id}", session.id))
    response = httpx.request(method, url, timeout=PATIENCE)
    assert response.status_code == 405
    assert set(response.headers["allow"].split(", ")) == known


@pytest.mark.parametrize("method", ["TRACE", "CONNECT", "PROPFIND"])
def test_a_method_that_nobody_knows(session: Live, method: str) -> None:
    response = session.client.request(method, session.path)
    assert response.status_code == 405
    assert response.headers["allow"] == "DELETE, GET, HEAD"


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE", "TRACE"])
@pytest.mark.parametrize("path", ["/nowhere", "/sessions/a/b/c", "/%2e%2e/%2e%2e/etc/passwd"])
def test_a_path_of_the_api_that_is_none(caller: httpx.Client, path: str, method: str) -> None:
    assert caller.request(method, API + path).status_code == 404
