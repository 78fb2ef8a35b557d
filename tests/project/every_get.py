"""Everything that a served lab answers to GET, asked for once."""

from __future__ import annotations

import json
import re
import time
from collections.abc import Callable
from typing import Any

Ask = Callable[..., tuple[int, bytes]]
"""Sends method, path and possibly a body as JSON; returns status and content."""

QUERIES = dict.fromkeys(("/window", "/spectrum"), "?columns=A.x.following_error")
"""What calls need that cannot be without, by the end of their path."""

NO_DRIVE = "/api/v1/drive"
"""What only a server with a drive link has."""

UNDESCRIBED = ("/", "/docs", "/asyncapi.json", "/metrics", "/scene/")
NAMED = {"/api/v1/fields": "tune"}
"""Something of collections that do not list what they have."""
SHORT = {"trajectory": {"kind": "point", "duration": 0.16}}  # as a spectrum needs
_PATIENCE = 300.0
_ENDED = {"done", "failed", "cancelled"}


def look_at_everything(ask: Ask) -> list[str]:
    """Ask for every GET of the OpenAPI document, for the pages and for what they load.

    Returns
    -------
    list of str
        The paths that were asked for; each answered 200.
    """

    def got(path: str) -> bytes:
        status, content = ask("GET", path)
        assert status == 200, f"{path}: {status} {content[:500]!r}"
        asked.append(path)
        return content

    def first(collection: str) -> str:
        if collection in NAMED:
            return NAMED[collection]
        content: Any = json.loads(got(collection))
        if "laws" in content:
            content = content["laws"]
        if "runs" in content:  # of those that are being recorded nothing can be read
            content = [run for run in content["runs"] if run["state"] == "complete"]
        entry = content[0]
        return entry.get("id") or entry["name"]

    asked: list[str] = []
    job = _created(ask, "/api/v1/reproduce", {"only": ["turns"]}, 202)
    begun = time.monotonic()
    while (report := json.loads(got(f"/api/v1/jobs/{job}")))["state"] not in _ENDED:
        assert time.monotonic() - begun < _PATIENCE, report
        time.sleep(0.2)
    assert report["state"] == "done", report
    kept, answer = ask("POST", "/api/v1/simulate", {"set": SHORT, "keep": True})
    assert kept == 200, answer[:500]
    gains = {"values": {"variants.B.controller.x.k_p": 312000.0}, "set": SHORT}
    assert ask("PUT", "/api/v1/gain-sets/kept", gains)[0] == 200
    session = f"/api/v1/sessions/{_created(ask, '/api/v1/sessions', {}, 201)}"
    assert ask("POST", f"{session}/step", {"ticks": 20})[0] == 200
    for path, operations in json.loads(got("/openapi.json"))["paths"].items():
        if "get" in operations and not path.startswith(NO_DRIVE):
            collection, parameter, rest = path.partition("/{")
            below = rest.partition("}")[2]
            query = QUERIES.get(below, "")
            got(f"{collection}/{first(collection)}{below}{query}" if parameter else path)
    assert ask("GET", NO_DRIVE)[0] == 404
    for path in UNDESCRIBED:
        page = got(path).decode()
        for asset in re.findall(r'(?:src|href)="\.(/assets/[^"]+)"', page):
            got(asset)
    return asked


def _created(ask: Ask, path: str, body: dict[str, Any], expected: int) -> str:
    status, content = ask("POST", path, body)
    assert status == expected, content
    return json.loads(content)["id"]
