"""What one language takes from another: generated types, binary fixtures, the stream's messages."""

from __future__ import annotations

import json
import re
import struct
import subprocess
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.reports.problems import BY_STATUS, TYPES, Kind
from motionlab.server.live.messages import CLIENT_MESSAGES, SERVER_MESSAGES, asyncapi
from motionlab.server.prometheus import Monitor
from motionlab.server.settings import Bounds
from motionlab.server.settings_sources import PREFIX as VARIABLE
from motionlab.server.settings_sources import ServerSettings, unit_and_range
from tests.fixtures.__main__ import QUESTION, WHAT_IF, what_if
from tests.paths import ROOT

NPM = ROOT / "frontend" / "npm"
API_TYPES = ROOT / "frontend" / "src" / "app" / "api"
REST = (ROOT / "docs" / "rest.md").read_text()
DEPLOY = (ROOT / "docs" / "deploy.md").read_text()
PREFIX = "/api/v1"


# -- TypeScript -----------------------------------------------------------------------------------


def test_the_types_of_the_page_are_those_of_the_document(
    document: dict[str, Any], tmp_path: Path
) -> None:
    node = subprocess.run([NPM, "--version"], capture_output=True, text=True, check=False)
    if node.returncode != 0:
        pytest.skip(f"node cannot be had: {node.stderr.strip()[-200:]}")
    source, made = tmp_path / "openapi.json", tmp_path / "schema.d.ts"
    source.write_text(json.dumps(document))
    command = [NPM, "exec", "--", "openapi-typescript", source, "--output", made]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    lines = (done.stdout + done.stderr).lower().splitlines()
    assert [line for line in lines if "warn" in line and not line.startswith("npm")] == []
    assert made.read_text() == (API_TYPES / "schema.d.ts").read_text(), "run make types"


def test_the_stream_client_uses_the_generated_messages() -> None:
    types = (API_TYPES / "types.ts").read_text()
    for union, models in (("ServerMessage", SERVER_MESSAGES), ("ClientMessage", CLIENT_MESSAGES)):
        definition = re.search(rf"export type {union} =([^;]+);", types)
        assert definition is not None
        used = re.findall(r"Schemas\['(\w+)'\]", definition[1])
        assert sorted(used) == sorted(model.__name__ for model in models)
    assert "type Schemas = components['schemas'];" in types
    client = (ROOT / "frontend" / "src" / "app" / "stream" / "stream-client.ts").read_text()
    assert re.search(
        r"import type \{[^}]*ClientMessage, ServerMessage[^}]*\} from '../api/types'", client
    )


# -- AsyncAPI -------------------------------------------------------------------------------------


def references(node: Any) -> Iterator[str]:
    """Yield every reference in a document."""
    if isinstance(node, dict):
        if isinstance(node.get("$ref"), str):
            yield node["$ref"]
        for value in node.values():
            yield from references(value)
    elif isinstance(node, list):
        for value in node:
            yield from references(value)


def resolved(document: dict[str, Any], reference: str) -> Any:
    """Return what a reference points to."""
    here: Any = document
    for key in reference.removeprefix("#/").split("/"):
        here = here[key]
    return here


def test_every_reference_of_asyncapi_resolves() -> None:
    document = asyncapi(__version__)
    found = set(references(document))
    assert len(found) > len(SERVER_MESSAGES) + len(CLIENT_MESSAGES)
    for reference in found:
        assert isinstance(resolved(document, reference), dict), reference


def test_asyncapi_is_of_the_form_that_it_claims() -> None:
    document = asyncapi(__version__)
    assert document["asyncapi"] == "3.0.0"
    assert set(document["info"]) >= {"title", "version"}
    for channel in document["channels"].values():
        assert set(re.findall(r"\{(\w+)\}", channel["address"])) == set(channel["parameters"])
        for message in channel["messages"].values():
            assert set(message) >= {"name", "payload"}
    for operation in document["operations"].values():
        assert operation["action"] in {"send", "receive"}
        channel = operation["channel"]["$ref"]
        assert resolved(document, channel) in document["channels"].values()
        for message in operation["messages"]:  # each has to be one of the channel's own
            assert message["$ref"].startswith(f"{channel}/messages/")
    for schema in document["components"]["schemas"].values():
        Draft202012Validator.check_schema(schema)


def test_both_documents_name_the_same_models(document: dict[str, Any]) -> None:
    stream = asyncapi(__version__)["components"]["schemas"]
    rest = document["components"]["schemas"]
    assert {name: rest.get(name) for name in stream} == stream


# -- a what-if answer -----------------------------------------------------------------------------


def read(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
    """Return the JSON of a what-if answer, and minima and maxima of each column; docs/rest.md."""
    length, zero = struct.unpack_from("<II", data)
    assert zero == 0
    assert length % 8 == 0
    head = json.loads(data[8 : 8 + length].decode())
    values = np.frombuffer(data, "<f4", offset=8 + length)
    count = head["time"]["count"]
    curves = {}
    for index, column in enumerate(head["columns"]):
        assert column["minimum"] == 2 * index * count
        assert column["maximum"] == column["minimum"] + count
        curves[column["name"]] = np.stack(
            [values[column[end] : column[end] + count] for end in ("minimum", "maximum")]
        )
    assert len(values) == 2 * count * len(curves)
    return head, curves


def test_the_fixture_of_a_what_if_byte_by_byte() -> None:
    head, curves = read(WHAT_IF.read_bytes())
    assert (head["how"], head["begin"]) == ("whole", 0.0)
    assert head["time"] == {"start": 0.0, "step": 0.001, "count": 20}
    assert head["result"]["window"] == {"start": 0.0, "end": 0.02}
    assert list(head["result"]["variants"]) == ["A", "B"]
    assert [column["name"] for column in head["columns"]] == QUESTION["columns"]
    assert {column["unit"] for column in head["columns"]} == {"m"}
    # The same numbers as in frontend/src/app/api/curves-answer.test.ts.
    for name, low, high in (
        ("x.position_reference", 1.4e-4, 1.45e-4),
        ("A.x.following_error", 3.145e-5, 3.225e-5),
        ("B.x.following_error", 9.6e-6, 1.065e-5),
    ):
        assert curves[name][:, 19] == pytest.approx([low, high], abs=1e-10)
        assert curves[name][0, 0] == 0.0


def test_the_fixture_of_a_what_if_is_what_its_command_writes(document: dict[str, Any]) -> None:
    head, curves = read(WHAT_IF.read_bytes())
    fresh, computed = read(what_if())
    assert head.keys() == fresh.keys()
    assert head["columns"] == fresh["columns"]
    assert head["time"] == fresh["time"]
    for name, curve in curves.items():
        # Another processor may round otherwise; one count of the encoder is 5e-8 m.
        assert computed[name] == pytest.approx(curve, abs=1e-7), "run python -m tests.fixtures"
    schema = {"$ref": "#/components/schemas/ResultDocument", "components": document["components"]}
    for result in (head["result"], fresh["result"]):
        Draft202012Validator(schema).validate(result)


def test_the_page_describes_the_layout_of_a_what_if() -> None:
    rows = re.findall(r"^\| (0|4|8|8 \+ L) \| (\S+?(?: bytes)?) \|", REST, re.MULTILINE)
    assert rows == [("0", "uint32"), ("4", "uint32"), ("8", "L bytes"), ("8 + L", "float32[]")]


# -- the page on REST -----------------------------------------------------------------------------


def test_the_page_names_every_call_and_no_other(document: dict[str, Any]) -> None:
    calls = set(re.findall(r"`((?:GET|POST|PUT|PATCH|DELETE) /(?!api/|metrics`)[^` ?]*)`", REST))
    described = {
        f"{method.upper()} {path.removeprefix(PREFIX)}"
        for path, operations in document["paths"].items()
        for method in operations
    }
    assert calls == described, "docs/rest.md"


def test_the_page_lists_every_call_once() -> None:
    listed = re.findall(r"^\| `([A-Z]+ /\S*?)`", REST, re.MULTILINE)
    assert [call for call in listed if listed.count(call) > 1] == []


def test_the_page_names_every_query_and_key(document: dict[str, Any]) -> None:
    for path in document["paths"].values():
        for operation in path.values():
            for parameter in operation.get("parameters", []):
                name = parameter["name"]
                if parameter["in"] == "query":
                    assert f"`?{name}=" in REST, name
                elif parameter["in"] == "header":
                    assert f"`{name.capitalize()}: " in REST, name
    for name, schema in document["components"]["schemas"].items():
        if name.endswith("Request"):
            for key in schema["properties"]:
                assert f'"{key}"' in REST, f"{name}.{key}"


def test_the_page_tells_every_status_of_a_failure(document: dict[str, Any]) -> None:
    told = {str(kind.status) for kind in TYPES.values()}
    answered = {
        status
        for path in document["paths"].values()
        for operation in path.values()
        for status in operation["responses"]
        if status >= "400"
    }
    assert told == answered | {"405", "500"}


def test_the_page_tells_every_type_of_a_problem() -> None:
    rows = [
        f"| `{name}` | {kind.status} | {kind.title} | {kind.meaning} |"
        for name, kind in TYPES.items()
    ]
    told = [line for line in REST.splitlines() if re.match(r"\| `[a-z-]+` \| \d\d\d \|", line)]
    assert told == rows
    assert set(TYPES) == set(get_args(Kind))
    assert {status: TYPES[name].status for status, name in BY_STATUS.items()} == {
        status: status for status in BY_STATUS
    }


def settings_rows(names: Iterable[str]) -> list[str]:
    """Return the rows of a table of settings: name, default, range with unit, meaning."""
    rows = []
    for name in names:
        info = ServerSettings.model_fields[name]
        unit, allowed = unit_and_range(info)
        default = f"{info.default:.0f}" if isinstance(info.default, float) else info.default or ""
        rows.append(
            f"| `{name}` | {default} | {f'{allowed} {unit}'.strip()} | {info.description} |"
        )
    return rows


def test_the_pages_tell_every_setting() -> None:
    others = [name for name in ServerSettings.model_fields if name not in Bounds.model_fields]
    for page, title, names in ((REST, "Limits", Bounds.model_fields), (DEPLOY, "Settings", others)):
        section = page[page.index(f"## {title}\n") :].partition("\n## ")[0]
        told = [line for line in section.splitlines() if line.startswith("| `")]
        assert told == settings_rows(names)


def test_the_page_tells_every_metric() -> None:
    described = re.findall(r"^# HELP (\S+) (.*)$", Monitor().text().decode(), re.MULTILINE)
    told = re.findall(r"^\| `(motionlab_\w+)` \| (.*) \|$", REST, re.MULTILINE)
    assert described == told


def test_every_tag_of_the_document_is_described(document: dict[str, Any]) -> None:
    operations = [each for methods in document["paths"].values() for each in methods.values()]
    used = {tag for operation in operations for tag in operation["tags"]}
    described = {tag["name"] for tag in document["tags"] if tag["description"]}
    assert described == used


def test_every_environment_variable_is_a_setting() -> None:
    sources = [*(ROOT / "backend" / "motionlab").rglob("*.py"), *(ROOT / "frontend").glob("*.ts")]
    used = {name for path in sources for name in re.findall("MOTIONLAB_[A-Z_]+", path.read_text())}
    settings = {VARIABLE + name.upper() for name in ServerSettings.model_fields}
    others = used - settings
    assert others == {
        "MOTIONLAB_LAWS_ACCEPTED",
        "MOTIONLAB_SERVER",
        "MOTIONLAB_SETTINGS",
        "MOTIONLAB_TEST_",
    }
    assert all(f"`{name}`" in DEPLOY for name in others if not name.endswith("_"))
