"""Bounds on bodies: what is too deep, too many or too long gets a short 422."""

from __future__ import annotations

import json

import httpx
import pytest

from motionlab.config.bounds import TEXT_MAX
from motionlab.errors import SHOWN_MAX
from motionlab.server.http.strict_json import MEMBERS_MAX
from tests.server.live import API, Live


def refused(response: httpx.Response) -> str:
    assert response.status_code == 422, response.text
    assert len(response.content) < 20_000
    return response.json()["detail"]


@pytest.mark.parametrize("text", ["a." * 100_000 + "a=1", "x='" + TEXT_MAX * "y" + "'"])
def test_a_toml_text_is_bounded(client: httpx.Client, text: str) -> None:
    response = client.post(f"{API}/scenarios/parse", content=text)
    assert "body: " in refused(response)


def test_a_body_is_bounded_in_depth_and_members(client: httpx.Client) -> None:
    deep = '{"a":' * 20 + "1" + "}" * 20
    deeper = "[" * 40_000 + "]" * 40_000
    many = json.dumps([0] * (MEMBERS_MAX + 1))
    for content, reason in ((deep, "deeply"), (deeper, "deeply"), (many, "members")):
        for path in ("simulate", "design", "maps/preview"):
            body = f'{{"scenario": {content}}}'
            headers = {"content-type": "application/json"}
            response = client.post(f"{API}/{path}", content=body, headers=headers)
            assert reason in refused(response)


def test_a_path_is_bounded_in_depth(client: httpx.Client, live: Live) -> None:
    changes = {"set": {"plant." + ".".join("a" * 5000): 1}}
    for response in (
        client.patch(f"{live.path}/parameters", json=changes),
        client.post(f"{API}/simulate", json=changes),
        client.post(f"{API}/whatif", json=changes),
    ):
        assert "too many parts" in refused(response)


def test_wrong_values_are_counted(client: httpx.Client, live: Live) -> None:
    changes = {"set": {f"plant.x.key{n}": 210 * "x" for n in range(4000)}}
    response = client.patch(f"{live.path}/parameters", json=changes)
    assert refused(response).endswith(f"and {4000 - SHOWN_MAX} more")
    errors = response.json()["errors"]
    assert len(errors) == SHOWN_MAX
    assert all(len(error["value"]) <= 200 for error in errors)


def test_what_is_echoed_is_short(client: httpx.Client) -> None:
    for value in (100_000 * "x", [1000 * "x"] * 400, {1000 * "k": 1}):
        body = {"scenario": "circle", "points": value, "columns": value}
        refused(client.post(f"{API}/whatif", json=body))
    refused(client.post(f"{API}/simulate", json={"set": {"plant." + 10_000 * "k": 1}}))
    many = {"columns": [{"a": 1}] * 500}
    detail = refused(client.post(f"{API}/whatif", json=many))
    assert detail.endswith(f"{SHOWN_MAX} errors and {500 - SHOWN_MAX} more")
