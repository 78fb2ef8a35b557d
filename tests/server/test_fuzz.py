"""The API held to its OpenAPI document by generated requests, and to its word by hostile ones."""

from __future__ import annotations

import re
import shutil
from collections.abc import Iterator
from typing import Any

import httpx
import pytest
import requests
import schemathesis
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from schemathesis import Case, GenerationMode

from motionlab.config.drive import load_drive
from motionlab.motor_design.kept_maps import folders
from motionlab.server.settings import Settings
from tests.paths import ROOT
from tests.server.live import API, Live
from tests.server.openapi import Contract, body_examples, document
from tests.server.servers import PATIENCE, Server

DOCUMENT = document()
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
READS_BYTES = {"parseScenario", "importRun", "importTrajectory"}
READS_JSON = [n for n in TAKES_A_BODY if n not in READS_BYTES]
JSON = {"content-type": "application/json"}
COMPARES = {"compareRuns", "getComparisonReport", "getComparisonWindow"}
EXAMPLES = {name: body_examples(DOCUMENT, name) for name in TAKES_A_BODY}
QUERIES = {
    operation["operationId"]: {
        parameter["name"]: parameter["schema"]["examples"][0]
        for parameter in operation.get("parameters", [])
        if parameter["in"] == "query" and "examples" in parameter["schema"]
    }
    for operations in DOCUMENT["paths"].values()
    for operation in operations.values()
}
"""Examples of query parameters, by operation."""

NEEDS_LEASE = {
    operation["operationId"]
    for operations in DOCUMENT["paths"].values()
    for operation in operations.values()
    if any(each["in"] == "header" for each in operation.get("parameters", []))
} | {"askForControl"}
"""Operations that need the lease of drives, or that somebody else has it; or a version of a law."""

NEEDS_SAMPLES = {"getPhaseForces", "keepCapture"}
"""Operations on a session that has been stepped, as far as their examples go."""

NEEDS_VIEW = {"putView3d"}
"""Operations on a 3-D view that a browser shows: tests/e2e/test_scene.py has one."""

NEEDS_RUN = {"predictMinute", "selectFrictionModel"}
"""Operations whose body names a run, which no request can guess: tests/studies has one."""

DRIVE = load_drive(ROOT / "configs" / "drives" / "virtual.toml")
NOBODY = DRIVE.link.model_copy(update={"port": 9})
BOUNDED = Settings(
    token=EXAMPLES["login"][0]["token"],
    direct_max=30.0,
    drive=DRIVE.model_copy(update={"link": NOBODY}),
)
"""Simulations above 30 s become jobs, which the tests cancel; no drive answers."""

fuzzed = settings(
    max_examples=7,
    derandomize=True,
    database=None,
    deadline=None,
    phases=[Phase.explicit, Phase.generate],
    suppress_health_check=[HealthCheck.filter_too_much, HealthCheck.too_slow],
)


@pytest.fixture(scope="module")
def bounded() -> Iterator[Server]:
    server = Server(BOUNDED)
    yield server
    server.stop()


@pytest.fixture(scope="module")
def caller(bounded: Server, contract: Contract) -> Iterator[httpx.Client]:
    """Return a client of the bounded server; its every answer is checked as well."""
    hooks: dict[str, list[Any]] = {"response": [contract.check]}
    headers = {"authorization": f"Bearer {BOUNDED.token}"}
    with httpx.Client(
        base_url=bounded.url, headers=headers, event_hooks=hooks, timeout=PATIENCE
    ) as client:
        yield client


@pytest.fixture(scope="module")
def unchecked(bounded: Server) -> Iterator[httpx.Client]:
    """Return a client whose answers are not checked: one to HEAD has no body."""
    headers = {"authorization": f"Bearer {BOUNDED.token}"}
    with httpx.Client(base_url=bounded.url, headers=headers, timeout=PATIENCE) as client:
        yield client


@pytest.fixture(scope="module")
def shared(caller: httpx.Client) -> Iterator[Live]:
    """Return a session for requests that are refused; it has to be the same in the end."""
    live = Live.create(caller)
    before = live.info()
    yield live
    assert live.info() == before


@pytest.fixture
def session(caller: httpx.Client, shared: Live) -> Iterator[Live]:
    """Return a session of the circle with a change to undo; end all others but the shared one."""
    live = Live.create(caller)
    live.change({"plant.x.mass": 6.0})
    yield live
    for info in caller.get(f"{API}/sessions").json():
        if info["id"] != shared.id:
            Live(caller, f"{API}/sessions/{info['id']}").delete()


@st.composite
def near_an_example(draw: st.DrawFn, name: str, known: dict[str, str]) -> Case:
    """Generate a request: fields and path parameters of an example, some of them replaced."""
    case = draw(OPERATIONS[name].as_strategy(GenerationMode.POSITIVE))
    for parameter in set(case.path_parameters) & set(known):
        if parameter == "session_id" or draw(st.booleans()):
            case.path_parameters[parameter] = known[parameter]
    for parameter, value in QUERIES[name].items():
        if draw(st.booleans()):
            case.query[parameter] = value
    if name in TAKES_A_BODY:
        example = draw(st.sampled_from(EXAMPLES[name]))
        if name in COMPARES:
            example = example | dict.fromkeys("ab", known["run_id"])
        if isinstance(case.body, dict):
            replaced = st.sets(st.sampled_from(sorted(case.body))) if case.body else st.just(set())
            case.body = example | {field: case.body[field] for field in draw(replaced)}
        elif draw(st.booleans()):
            case.body = example.encode() if isinstance(example, str) else example
    return case


def answers_as_documented(caller: httpx.Client, cases: st.SearchStrategy[Case]) -> list[int]:
    """Send generated requests; schemathesis checks each answer.

    Returns
    -------
    list of int
        Status of every answer.
    """
    codes: list[int] = []
    base = str(caller.base_url).rstrip("/")
    connection = requests.Session()
    headers = {"authorization": caller.headers["authorization"]}

    @fuzzed
    @given(case=cases)
    def ask(case: Case) -> None:
        response = case.call(base_url=base, session=connection, headers=headers, timeout=PATIENCE)
        codes.append(response.status_code)
        case.validate_response(response, headers=headers)
        if location := response.headers.get("location"):
            caller.delete(location[0])

    with connection:
        ask()
    return codes


def kept_names(caller: httpx.Client, path: str) -> dict[str, str]:
    """Keep what a path names, such as a job or a run; return its path parameter."""
    if "/jobs/" in path:
        answer = caller.post(f"{API}/simulate", json={}, headers={"prefer": "respond-async"})
        return {"job_id": answer.json()["id"]}
    if "/trajectories/" in path:
        trajectory = EXAMPLES["putTrajectory"][0]
        caller.put(f"{API}/trajectories/kept", json=trajectory).raise_for_status()
        return {"name": "kept"}
    if "/maps/" in path:
        (shipped, _), (own, _) = folders()
        own.mkdir(parents=True, exist_ok=True)
        shutil.copy(shipped / "new-design.json", own / "kept.json")
        return {"name": "kept"}
    for collection, put in (
        ("gain-sets", "putGainSet"),
        ("layouts", "putLayout"),
        ("motors", "putMotor"),
    ):
        if f"/{collection}/" in path:
            kept = f"{API}/{collection}/kept"
            caller.put(kept, json=EXAMPLES[put][0]).raise_for_status()
            return {"name": "kept"}
    if "/runs/" in path:
        body = {"set": {"trajectory.laps": 1, "trajectory.lead_in": 0.5}, "keep": True}
        run = caller.post(f"{API}/simulate", json=body).raise_for_status().json()["run"]
        return {"run_id": run}
    return {"name": "lugre-observer" if "/laws/" in path else "circle", "kind": "tune"}


@pytest.mark.parametrize("name", OPERATIONS)
def test_what_the_document_allows(caller: httpx.Client, session: Live, name: str) -> None:
    known = kept_names(caller, OPERATIONS[name].path) | {"session_id": session.id}
    if name in NEEDS_SAMPLES:
        session.step(400)
    codes = answers_as_documented(caller, near_an_example(name, known))
    assert (
        any(200 <= code < 300 for code in codes) or name in NEEDS_LEASE | NEEDS_VIEW | NEEDS_RUN
    ), codes


@pytest.mark.parametrize("name", CAN_BE_WRONG)
def test_what_the_document_forbids(caller: httpx.Client, session: Live, name: str) -> None:
    cases = OPERATIONS[name].as_strategy(GenerationMode.NEGATIVE)
    codes = answers_as_documented(caller, cases)
    if name in OF_A_SESSION and name in TAKES_A_BODY:
        fixed = {"session_id": session.id}
        cases = OPERATIONS[name].as_strategy(GenerationMode.NEGATIVE, path_parameters=fixed)
        codes += answers_as_documented(caller, cases)
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


@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_that_is_none(shared: Live, name: str) -> None:
    for what, text in HOSTILE.items():
        response = ask(shared, name, content=text, headers=JSON)
        assert response.status_code == 422, (what, response.text[:300])
        errors = response.json()["errors"]
        assert errors, what
        assert all(error["loc"] and error["message"] for error in errors), what


@pytest.mark.parametrize("name", READS_JSON)
def test_no_body(session: Live, name: str) -> None:
    for text in ("", " ", "null"):
        response = ask(session, name, content=text, headers=JSON)
        optional = name in {"play", "step"} and text != " "
        expected = {200} if optional else {400, 422}
        assert response.status_code in expected, (text, response.text[:300])


@pytest.mark.parametrize("name", READS_JSON)
def test_nesting_without_end(shared: Live, name: str) -> None:
    for opening in ("[", '{"set":', '{"a":[', '[{"":'):
        closing = "".join({"[": "]", "{": "}"}.get(mark, "") for mark in reversed(opening))
        for text in (10_000 * opening, 10_000 * opening + "1" + 10_000 * closing):
            response = ask(shared, name, content=text, headers=JSON)
            assert response.status_code in {400, 422}, (opening, response.text[:300])


@pytest.mark.parametrize("name", READS_JSON)
def test_a_key_that_comes_twice(shared: Live, name: str) -> None:
    for text in (
        '{"a": 1, "a": 1}',
        '{"set": {"seed": 1, "seed": 2}}',
        '[{"a": {"b": 1, "b": 1}}]',
    ):
        response = ask(shared, name, content=text, headers=JSON)
        assert response.status_code == 400
        assert "comes twice" in response.json()["detail"]


@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_that_cannot_be_read(shared: Live, name: str) -> None:
    for body, why in (
        (b'{"set": ' + 5000 * b"9" + b"}", "5000 digits"),
        (b'{"\xff": 1}', "0xff"),
    ):
        response = ask(shared, name, content=body, headers=JSON)
        assert response.status_code == 400, why
        assert why in response.json()["detail"]


@pytest.mark.parametrize("name", READS_JSON)
def test_a_body_of_another_type(shared: Live, name: str) -> None:
    for media in ("text/plain", "application/xml", "application/jsonp", "x"):
        response = ask(shared, name, content="{}", headers={"content-type": media})
        assert response.status_code == 415, media
        assert repr(media) in response.json()["detail"]


@pytest.mark.parametrize("value", ["5.0", "5", "5e0"])
def test_a_whole_number_may_have_a_point(session: Live, value: str) -> None:
    before = session.tick
    ask(session, "step", content=f'{{"ticks": {value}}}', headers=JSON).raise_for_status()
    assert session.tick == before + 5


@pytest.mark.parametrize("points", ['"100"', "true", "100.5", "9", "500001", "1e300"])
def test_points_that_are_none(shared: Live, points: str) -> None:
    response = ask(shared, "whatIf", content=f'{{"points": {points}}}', headers=JSON)
    assert response.status_code == 422
    assert [error["loc"] for error in response.json()["errors"]] == ["points"]


METHODS = {"GET", "HEAD", "POST", "PUT", "PATCH", "DELETE", "OPTIONS"}


def matches(path: str, literal: str) -> bool:
    """Return whether a path with parameters is also that of another one, such as /runs/storage."""
    return re.fullmatch(re.sub(r"\{\w+\}", "[^/]+", path), literal) is not None


@pytest.mark.parametrize("path", DOCUMENT["paths"])
def test_a_method_that_a_path_does_not_know(
    shared: Live, unchecked: httpx.Client, path: str
) -> None:
    known = {known.upper() for known in DOCUMENT["paths"][path]}
    if "GET" in known:
        known.add("HEAD")
    likewise = (other for other in DOCUMENT["paths"] if matches(other, path))
    answered = {known.upper() for other in likewise for known in DOCUMENT["paths"][other]}
    if "GET" in answered:
        answered.add("HEAD")
    for method in sorted(METHODS - known - answered):
        response = unchecked.request(method, path.replace("{session_id}", shared.id))
        assert response.status_code == 405, method
        assert set(response.headers["allow"].split(", ")) == known, method


@pytest.mark.parametrize("method", ["TRACE", "CONNECT", "PROPFIND"])
def test_a_method_that_nobody_knows(shared: Live, method: str) -> None:
    response = shared.client.request(method, shared.path)
    assert response.status_code == 405
    assert response.headers["allow"] == "DELETE, GET, HEAD"


@pytest.mark.parametrize("method", ["GET", "POST", "PUT", "DELETE", "TRACE"])
@pytest.mark.parametrize("path", ["/nowhere", "/sessions/a/b/c", "/%2e%2e/%2e%2e/etc/passwd"])
def test_a_path_of_the_api_that_is_none(caller: httpx.Client, path: str, method: str) -> None:
    assert caller.request(method, API + path).status_code == 404
