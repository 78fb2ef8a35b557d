"""Answers held against the server's own OpenAPI document."""

from __future__ import annotations

import atexit
import fcntl
import json
import os
import re
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import httpx
from jsonschema_rs import Draft202012Validator

from motionlab.server.app import create_app

PROBLEM = "application/problem+json"
HEADERS = {
    "content-security-policy": "default-src 'self'; script-src 'self' 'wasm-unsafe-eval'; "
    "style-src 'self' 'unsafe-inline'; img-src 'self' data:; object-src 'none'; base-uri 'none'; "
    "form-action 'self'; frame-ancestors 'self'",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "same-origin",
    "x-content-type-options": "nosniff",
    "x-frame-options": "SAMEORIGIN",
}


@cache
def document() -> dict[str, Any]:
    """Return the document of a server without a token, made once for all workers of a run."""
    run = os.environ.get("PYTEST_XDIST_TESTRUNUID")
    if run is None:
        return create_app().openapi()
    path = Path(tempfile.gettempdir()) / f"motionlab-openapi-{run}.json"
    with path.open("a+", encoding="utf-8") as file:
        fcntl.flock(file, fcntl.LOCK_EX)  # who comes second waits for the first
        file.seek(0)
        if text := file.read():
            return json.loads(text)
        made = create_app().openapi()
        json.dump(made, file)
    atexit.register(path.unlink, missing_ok=True)
    return made


def body_examples(document: dict[str, Any], operation_id: str) -> list[Any]:
    """Return the examples of an operation's request body."""

    def of(schema: dict[str, Any]) -> list[Any]:
        if "examples" in schema:
            return schema["examples"]
        if "$ref" in schema:
            return of(document["components"]["schemas"][schema["$ref"].rsplit("/", 1)[1]])
        return [example for member in schema.get("anyOf", ()) for example in of(member)]

    (operation,) = (
        operation
        for path in document["paths"].values()
        for operation in path.values()
        if operation["operationId"] == operation_id
    )
    return [
        e for media in operation["requestBody"]["content"].values() for e in of(media["schema"])
    ]


class Contract:
    """What the OpenAPI document promises of every answer.

    Parameters
    ----------
    document : dict
        The OpenAPI document.
    """

    def __init__(self, document: dict[str, Any]) -> None:
        self.document = document
        self.answered: set[tuple[str, int]] = set()
        self._validators: dict[str, Draft202012Validator] = {}
        self._paths = [
            (re.compile(re.sub(r"\{\w+\}", r"[^/]+", path)), operations)
            for path, operations in sorted(document["paths"].items(), key=lambda p: "{" in p[0])
        ]

    @property
    def operations(self) -> set[str]:
        """Return the name of every operation."""
        return {o["operationId"] for path in self.document["paths"].values() for o in path.values()}

    def operation(self, request: httpx.Request) -> dict[str, Any] | None:
        """Return the operation that a request asks for."""
        for pattern, operations in self._paths:
            if pattern.fullmatch(request.url.path):
                return operations.get(request.method.lower())
        return None

    def check(self, response: httpx.Response) -> None:
        """Fail unless an answer is one that the document describes; an httpx response hook."""
        response.read()
        for name, value in HEADERS.items():
            assert response.headers[name] == value
        assert "server" not in response.headers
        assert response.status_code < 500, response.text
        operation = self.operation(response.request)
        media = response.headers.get("content-type", "").split(";")[0]
        if response.status_code >= 400:
            assert media == PROBLEM, response.text
            self._validate({"$ref": "#/components/schemas/Problem"}, response.json())
            assert response.json()["status"] == response.status_code
        if operation is None:
            return
        described = operation["responses"]
        status = str(response.status_code)
        assert status in described, f"{operation['operationId']}: {status} is not documented"
        self.answered.add((operation["operationId"], response.status_code))
        content = described[status].get("content", {})
        if not content:
            assert response.status_code == 204
            assert not response.content
            return
        assert media in content, f"{media} is not one of {list(content)}"
        for header in described[status].get("headers", {}):
            assert header in response.headers
        if media in {"application/json", PROBLEM}:
            self._validate(content[media]["schema"], response.json())

    def schema(self, name: str, value: Any) -> None:
        """Fail unless a value is what a named component describes."""
        self._validate({"$ref": f"#/components/schemas/{name}"}, value)

    def _validate(self, schema: dict[str, Any], value: Any) -> None:
        key = repr(schema)
        if key not in self._validators:
            whole = {**schema, "components": self.document["components"]}
            self._validators[key] = Draft202012Validator(whole)
        self._validators[key].validate(value)
