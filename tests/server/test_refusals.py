"""What bad input gets: the documented status, and a problem that names field, value and range."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from motionlab.server.settings import Settings
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live
from tests.server.openapi import HEADERS, PROBLEM
from tests.server.servers import PATIENCE

MASS = "plant.x.mass"
JSON = {"content-type": "application/json"}
BODY_MAX = Settings().body_max
WRITES = [
    ("POST", "/simulate"),
    ("POST", "/whatif"),
    ("POST", "/sessions"),
    ("POST", "/login"),
]
REFUSALS = {"invalid-field", "infeasible-trajectory"}
SESSION_WRITES = [
    ("POST", "/play"),
    ("POST", "/step"),
    ("POST", "/push"),
    ("PATCH", "/parameters"),
]


def refused(response: httpx.Response) -> list[dict[str, Any]]:
    """Return the refused fields of a 422."""
    assert response.status_code == 422, response.text
    problem = response.json()
    assert problem["type"].removeprefix("urn:motionlab:problem:") in REFUSALS
    assert problem["detail"]
    assert problem["errors"]
    for error in problem["errors"]:
        assert set(error) == {"loc", "message", "value", "range", "unit", "bounds"}
    return problem["errors"]


def post(client: httpx.Client, text: str | bytes, path: str = "/simulate") -> httpx.Response:
    return client.post(f"{API}{path}", content=text, headers=JSON)


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("NaN", "nan"),
        ("Infinity", "inf"),
        ("-Infinity", "-inf"),
        ("1e999", "inf"),
        ("-1e999", "-inf"),
        ('"5.9"', "5.9"),
        ('"nan"', "nan"),
        ("true", True),
        ("null", "null"),
        ("[]", "[]"),
        ("-1.0", -1.0),
        ("0", 0),
        ("1001", 1001),
        ("1" + 400 * "0", "a whole number of 1329 bits"),
    ],
)
@pytest.mark.parametrize("path", ["/simulate", "/whatif", "/sessions"])
def test_a_value_that_is_no_mass(client: httpx.Client, path: str, text: str, shown: Any) -> None:
    (error,) = refused(post(client, f'{{"set": {{"{MASS}": {text}}}}}', path))
    assert error["loc"] == MASS
    assert error["unit"] == "kg"
    assert error["range"] == ">= 0.001 and <= 1000"
    assert error["value"] == shown
    assert error["message"]


def test_every_wrong_field_is_named(client: httpx.Client) -> None:
    changes = {MASS: -1.0, "variants.B.controller.x.k_p": 1e99, "seed": 0.5, "titel": "x"}
    errors = {e["loc"]: e for e in refused(client.post(f"{API}/simulate", json={"set": changes}))}
    assert set(errors) == set(changes)
    k_p = errors["variants.B.controller.x.k_p"]
    assert (k_p["value"], k_p["unit"]) == (1e99, "N/m")
    assert "<=" in k_p["range"]


@pytest.mark.parametrize(
    ("body", "loc"),
    [
        ({"sett": {}}, "sett"),
        ({"set": {"plant.x.maas": 1.0}}, "plant.x.maas"),
        ({"set": {"variants.b.controller": "pd"}}, "variants.b"),
        ({"set": {"seed.low": 1}}, "seed.low"),
        ({"set": {"": 1}}, ""),
        ({"set": {"base": "fig5"}}, "base"),
        ({"set": []}, "set"),
        ({"set": None}, "set"),
        ({"scenario": None}, "scenario"),
        ({"scenario": 7}, "scenario"),
        ({"scenario": {}}, "plant"),
        ({"scenario": {"base": "circle", "laps": 1}}, "laps"),
        ([], "body"),
        (None, "body"),
        ("circle", "body"),
    ],
)
def test_a_body_of_another_form(client: httpx.Client, body: Any, loc: str) -> None:
    errors = refused(client.post(f"{API}/simulate", json=body))
    assert any(error["loc"].startswith(loc) for error in errors), errors


@pytest.mark.parametrize(
    "name",
    [
        "../../../../etc/passwd",
        "/etc/passwd",
        "circle.toml",
        "./circle",
        "..",
        "",
        "Circle",
        "circle\0",
        "circle\n",
        "c" * 65,
        "nowhere",
        "\ud800",
    ],
)
def test_a_name_that_does_not_ship(client: httpx.Client, name: str) -> None:
    text = json.dumps({"scenario": name})
    (error,) = refused(post(client, text))
    assert error["loc"].removeprefix("body.") == "scenario"
    for path, loc in (
        ("plant", "plant"),
        ("trajectory", "trajectory"),
        ("variants.A.controller", "variants.A.controller"),
        ("variants.A.controller.model", "variants.A.controller.model"),
    ):
        (error, *_) = refused(post(client, json.dumps({"set": {path: name}})))
        assert error["loc"].removeprefix("body.set.").startswith(loc)
        assert "root:" not in error["message"]


@pytest.mark.parametrize(
    "name",
    ["..%2f..%2fetc%2fpasswd", "%2e%2e", "circle.toml", "CIRCLE", "nowhere", "%00", 70 * "a"],
)
def test_a_path_in_the_place_of_a_name(client: httpx.Client, name: str) -> None:
    response = client.get(f"{API}/scenarios/{name}")
    assert response.status_code in {404, 422}
    assert response.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize(
    "text",
    [
        b'{"set":',
        b"{",
        b"{'set': {}}",
        b'{"set": {}} {}',
        b"nonsense",
        b'{"scenario": "\xff"}',
        b'{"set": {"seed": 1' + 5000 * b"0" + b"}}",
    ],
    ids=["cut", "brace", "quotes", "two", "word", "not-utf8", "digits"],
)
@pytest.mark.parametrize("path", ["/simulate", "/whatif", "/sessions", "/login"])
def test_broken_json(client: httpx.Client, path: str, text: bytes) -> None:
    response = post(client, text, path)
    assert response.status_code == 400
    assert response.json()["type"] == "urn:motionlab:problem:invalid-body"


@pytest.mark.parametrize("depth", [100, 400, 700, 960, 1100, 100_000])
@pytest.mark.parametrize("shape", ["tables", "lists", "path"])
def test_deep_nesting(client: httpx.Client, depth: int, shape: str) -> None:
    value, path = "1", MASS
    match shape:
        case "tables":
            value = depth * '{"x":' + value + depth * "}"
        case "lists":
            value = depth * "[" + value + depth * "]"
        case "path":
            path = ".".join(depth * ["plant"])
    for body in (f'{{"set": {{"{path}": {value}}}}}', f'{{"scenario": {{"{path}": {value}}}}}'):
        response = post(client, body)
        assert response.status_code in {400, 422}, response.text[:300]
        assert response.headers["content-type"] == "application/problem+json"


@pytest.mark.parametrize(
    "text",
    [
        '{"set": {"\\ud800": 1}}',
        '{"set": {"title": "\\udfff"}}',
        '{"set": {"plant.x.mass": {"\\ud800": "\\ud801"}}}',
        '{"\\ud800": 1}',
        '{"scenario": {"\\ud800": 1}}',
    ],
)
def test_half_a_surrogate_pair(client: httpx.Client, text: str) -> None:
    refused(post(client, text))
    assert post(client, '{"token": "\\ud800"}', "/login").status_code == 422


@pytest.mark.parametrize("text", [b"{}", b"scenario=circle"])
@pytest.mark.parametrize("media", ["text/plain", "application/x-www-form-urlencoded", ""])
def test_a_body_that_is_not_said_to_be_json(client: httpx.Client, text: bytes, media: str) -> None:
    headers = {"content-type": media} if media else {}
    response = client.post(f"{API}/simulate", content=text, headers=headers)
    # A browser may send these across sites without asking: they must not start anything.
    assert response.status_code in {400, 415, 422}


# -- too much -------------------------------------------------------------------------------------


@pytest.mark.parametrize(("method", "path"), WRITES)
def test_too_large_a_body(client: httpx.Client, method: str, path: str) -> None:
    content = b'{"set": {"title": "' + BODY_MAX * b"a" + b'"}}'
    response = client.request(method, API + path, content=content, headers=JSON)
    assert response.status_code == 413
    assert response.json()["title"]

    def pieces() -> Iterator[bytes]:
        for start in range(0, len(content), 50_000):
            yield content[start : start + 50_000]

    request = client.build_request(method, API + path, content=pieces(), headers=JSON)
    assert "content-length" not in request.headers
    assert client.send(request).status_code == 413


@pytest.mark.parametrize(("method", "path"), SESSION_WRITES)
def test_too_large_a_body_for_a_session(live: Live, method: str, path: str) -> None:
    response = live.client.request(method, live.path + path, content=b" " * (BODY_MAX + 1))
    assert response.status_code == 413


def test_the_largest_body_that_is_taken(client: httpx.Client) -> None:
    text = '{"scenario": "nowhere"}'
    assert post(client, text + (BODY_MAX - len(text)) * " ").status_code == 422
    assert post(client, text + (BODY_MAX + 1 - len(text)) * " ").status_code == 413


def test_too_much_work(make_server: MakeServer) -> None:
    server = make_server(Settings(work_max=7.0))
    changes: dict[str, Any] = {"trajectory": {"kind": "dwell", "duration": 3.0}}
    with httpx.Client(base_url=server.url + API, timeout=PATIENCE) as client:
        for path in ("/simulate", "/whatif", "/sessions"):
            assert client.post(path, json={"set": changes}).is_success
            more = changes | {"variants.C": {"controller": "pd"}}
            (error,) = refused(client.post(path, json={"set": more}))
            assert (error["loc"], error["value"], error["unit"]) == ("trajectory", 9.0, "s")
            assert error["range"] == "<= 7"


# -- motions --------------------------------------------------------------------------------------


def test_a_motion_out_of_the_stroke(client: httpx.Client) -> None:
    (error,) = refused(client.post(f"{API}/simulate", json={"set": {"trajectory.radius": 0.09}}))
    assert error["loc"] == "trajectory"
    assert error["unit"] == "m"
    assert abs(error["value"]) > 0.085
    assert "position on x at t = " in error["message"]
    assert error["range"] == ">= -0.085 and <= 0.085"


def test_a_motion_beyond_the_motor(client: httpx.Client) -> None:
    (error,) = refused(client.post(f"{API}/simulate", json={"set": {"trajectory.frequency": 5.0}}))
    assert error["loc"] == "trajectory"
    assert error["unit"]


# -- sessions -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("action", "body", "loc"),
    [
        ("play", {"speed": 0.09}, "speed"),
        ("play", {"speed": 10.1}, "speed"),
        ("play", {"speed": "1"}, "speed"),
        ("play", {"sped": 1.0}, "sped"),
        ("step", {"ticks": 0}, "ticks"),
        ("step", {"ticks": 20_001}, "ticks"),
        ("step", {"ticks": 1.5}, "ticks"),
        ("step", {"ticks": True}, "ticks"),
        ("push", {"axis": "z", "force": 1.0}, "axis"),
        ("push", {"axis": "x", "force": 101.0}, "force"),
        ("push", {"axis": "x", "force": "1"}, "force"),
        ("push", {"axis": "x", "force": 1.0, "duration": 0.0}, "duration"),
        ("push", {"axis": "x", "force": 1.0, "duration": 11.0}, "duration"),
        ("push", {"axis": "x"}, "force"),
    ],
)
def test_what_a_session_refuses(live: Live, action: str, body: dict[str, Any], loc: str) -> None:
    before = live.info()
    (error,) = refused(live.post(action, **body))
    assert error["loc"] == loc
    assert live.info() == before


@pytest.mark.parametrize("number", ["NaN", "1e999", "-1e999"])
def test_numbers_that_are_none_in_a_session(live: Live, number: str) -> None:
    for path, text in (
        ("play", f'{{"speed": {number}}}'),
        ("push", f'{{"axis": "x", "force": {number}}}'),
        ("push", f'{{"axis": "x", "force": 1.0, "duration": {number}}}'),
    ):
        refused(live.client.post(f"{live.path}/{path}", content=text, headers=JSON))
    text = f'{{"set": {{"{MASS}": {number}}}}}'
    url = f"{live.path}/parameters"
    (error,) = refused(live.client.patch(url, content=text, headers=JSON))
    assert (error["loc"], error["unit"]) == (MASS, "kg")
    assert live.info()["changes"] == []


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"seed": 3},
        {"trajectory.radius": 0.01},
        {"schedule": []},
        {MASS: "6"},
        {MASS: 6.0, "plant.y.mass": -1.0},
        {"variants.B.controller.x.k_p": 1.0, "seed": 3},
        {"variants": {"A": {"controller": "pd"}}},
        {"variants.C": {"controller": "pd"}},
        {"plant": "nowhere"},
        {"plant.x": 1.0},
        {"load.steps.0": {"time": 1.0, "x": 1.0}},
    ],
)
def test_changes_are_all_or_nothing(live: Live, changes: dict[str, Any]) -> None:
    before = live.info()
    refused(live.client.patch(f"{live.path}/parameters", json={"set": changes}))
    assert live.info() == before


def test_a_session_that_is_not_there(client: httpx.Client) -> None:
    gone = Live(client, f"{API}/sessions/nowhere")
    assert client.get(gone.path).status_code == 404
    assert client.delete(gone.path).status_code == 404
    for action in ("play", "pause", "step", "reset", "stop", "undo"):
        assert gone.post(action).status_code == 404
    assert gone.post("push", axis="x", force=1.0).status_code == 404
    assert client.patch(f"{gone.path}/parameters", json={"set": {MASS: 6.0}}).status_code == 404
    for what in ("metrics", "telemetry"):
        assert client.get(f"{gone.path}/{what}").status_code == 404


def test_telemetry_of_another_format(live: Live) -> None:
    response = live.client.get(f"{live.path}/telemetry", params={"format": "xlsx"})
    (error,) = refused(response)
    assert (error["loc"], error["value"]) == ("format", "xlsx")


def test_a_path_that_is_no_route(client: httpx.Client) -> None:
    response = client.get(f"{API}/nowhere")
    assert response.status_code == 404


def test_a_refusal_leaves_nothing_behind(client: httpx.Client, make_live: MakeLive) -> None:
    live = make_live()
    before = client.get(f"{API}/sessions").json()
    refused(client.post(f"{API}/sessions", json={"set": {MASS: -1.0}}))
    assert client.get(f"{API}/sessions").json() == before
    assert live.id in {session["id"] for session in before}


def test_what_fails_in_the_server_is_a_problem_too(make_server: MakeServer) -> None:
    server = make_server(Settings())

    def fail() -> None:
        raise RuntimeError("a secret")

    server.app.router.add_api_route("/api/v1/fail", fail)
    server.app.router.routes.insert(0, server.app.router.routes.pop())  # before the page's files
    response = httpx.get(f"{server.url}/api/v1/fail", timeout=PATIENCE)
    assert response.status_code == 500
    assert response.headers["content-type"] == PROBLEM
    assert "secret" not in response.text
    for name, value in HEADERS.items():
        assert response.headers[name] == value
