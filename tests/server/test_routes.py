"""What ships, what describes it, and that every route answers as OpenAPI says."""

from __future__ import annotations

import json
import re
import socket
from typing import Any

import httpx
import pytest
from jsonschema import Draft202012Validator

from motionlab import __version__
from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.config.schema import scenario_schema
from motionlab.server.live.messages import CLIENT_MESSAGES, SERVER_MESSAGES
from tests.paths import DOCS
from tests.server.live import API, Live, Stream
from tests.server.openapi import Contract, body_examples
from tests.server.servers import PATIENCE, Server


def test_health(client: httpx.Client) -> None:
    health = client.get(f"{API}/health").json()
    documented = health.pop("help")
    assert documented == (client.get("/help/").status_code == 200)
    expected = {
        "status": "ok",
        "login": False,
        "drive": False,
        "compiling": False,
        "compiled_share": 1.0,
    }
    assert health == expected | {"version": __version__}


def test_scenarios_are_those_that_ship(client: httpx.Client) -> None:
    entries = client.get(f"{API}/scenarios").json()
    assert [entry["name"] for entry in entries] == names("scenarios")
    for entry in entries:
        scenario = load_scenario(entry["name"])
        assert entry["title"] == scenario.title
        assert entry["description"] == scenario.description.strip()


@pytest.mark.parametrize("name", names("scenarios"))
def test_a_scenario_is_resolved_and_follows_the_schema(client: httpx.Client, name: str) -> None:
    scenario = client.get(f"{API}/scenarios/{name}").json()
    assert scenario == load_scenario(name).model_dump(mode="json")
    Draft202012Validator(client.get(f"{API}/schema").json()).validate(scenario)


def test_the_schema_is_that_of_the_models(client: httpx.Client) -> None:
    assert client.get(f"{API}/schema").json() == scenario_schema()


def test_fields_are_sent_again_only_when_they_differ(server: Server) -> None:
    for path in ("/fields", "/fields/tune"):
        answer = httpx.get(server.url + API + path, timeout=PATIENCE)
        assert answer.status_code == 200
        known = {"If-None-Match": answer.headers["etag"]}
        assert httpx.get(server.url + API + path, headers=known).status_code == 304
    assert httpx.get(f"{server.url}{API}/fields/nothing").status_code == 404


def test_a_message_of_a_stream_that_is_no_short_frame(server: Server, live: Live) -> None:
    channels = ("following_error", "thrust")
    columns = [f"{v}.{axis}.{name}" for v in "AB" for axis in "xy" for name in channels]
    with Stream(server, live.id) as stream:
        stream.message("hello")
        assert len(json.dumps(columns)) > 125
        assert stream.subscribe(columns)["columns"] == columns


def test_runs_of_a_tag_are_listed(client: httpx.Client) -> None:
    answer = client.get(f"{API}/runs", params={"q": "tag:nowhere"})
    assert (answer.status_code, answer.json()["runs"]) == (200, [])


def test_head_is_get_without_its_content(server: Server, live: Live) -> None:
    base = live.path
    paths = [f"{API}/health", f"{API}/scenarios", base, f"{base}/telemetry?format=csv", "/docs"]
    with httpx.Client(
        base_url=server.url, timeout=PATIENCE
    ) as client:  # an answer to HEAD has no problem document
        for path in [*paths, f"{API}/nowhere", f"{API}/sessions/{12 * 'x'}"]:
            get, head = client.get(path), client.head(path)
            assert (head.status_code, head.content) == (get.status_code, b""), path
            for name in ("content-type", "content-length"):
                assert head.headers[name] == get.headers[name], path
        alone = client.head(f"{API}/simulate")
        assert (alone.status_code, alone.headers["allow"]) == (405, "POST")


def test_head_sends_no_byte_beyond_the_head(server: Server) -> None:
    with socket.create_connection(("127.0.0.1", server.port), PATIENCE) as link:
        asks = b"HEAD /api/v1/scenarios HTTP/1.1\r\nHost: 127.0.0.1\r\nConnection: close\r\n\r\n"
        link.sendall(asks)
        answer = b""
        while piece := link.recv(10_000):
            answer += piece
    assert answer.startswith(b"HTTP/1.1 200 ")
    assert answer.endswith(b"\r\n\r\n")
    assert answer.count(b"\r\n\r\n") == 1


def test_every_operation_tells_what_it_does(contract: Contract) -> None:
    for path in contract.document["paths"].values():
        for operation in path.values():
            assert operation["summary"]
            assert operation["description"]
            assert {"401", "403"} <= set(operation["responses"])
            assert "requestBody" not in operation or body_examples(
                contract.document, operation["operationId"]
            )


def test_every_reference_in_the_document_resolves(contract: Contract) -> None:
    text = json.dumps(contract.document)
    for reference in set(re.findall(r'"\$ref": "(.+?)"', text)):
        here: Any = contract.document
        for key in reference.removeprefix("#/").split("/"):
            assert key in here, reference
            here = here[key]


def test_openapi_is_served_and_printed(
    client: httpx.Client, capsys: pytest.CaptureFixture[str], contract: Contract
) -> None:
    assert client.get("/openapi.json").json() == contract.document
    assert main(["openapi"]) == 0
    assert json.loads(capsys.readouterr().out) == contract.document


def test_asyncapi_describes_every_message(client: httpx.Client, contract: Contract) -> None:
    document = client.get("/asyncapi.json").json()
    channel = document["channels"]["stream"]
    models = {model.__name__ for model in (*SERVER_MESSAGES, *CLIENT_MESSAGES)}
    assert set(channel["messages"]) == models | {"frame"}
    for name in models:
        schema = document["components"]["schemas"][name]
        assert schema == contract.document["components"]["schemas"][name]
    operations = document["operations"].values()
    listed = [m["$ref"].rsplit("/", 1)[1] for o in operations for m in o["messages"]]
    assert sorted(listed) == sorted(models | {"frame"})


def test_the_page_on_rest_names_every_route(contract: Contract) -> None:
    text = (DOCS / "rest.md").read_text()
    for path in contract.document["paths"]:
        *_, last = (part for part in path.split("/") if not part.startswith("{"))
        assert last in text, path


def test_a_value_beside_its_range_names_the_range(client: httpx.Client) -> None:
    refused = client.post(f"{API}/whatif", json={"points": 1e9}).json()
    assert [(e["loc"], e["range"]) for e in refused["errors"]] == [("points", "<= 500000")]
