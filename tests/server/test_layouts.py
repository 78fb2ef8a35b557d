"""Layouts of scopes: kept by name, listed, replaced, deleted, refused."""

from __future__ import annotations

import httpx
import pytest

API = "/api/v1/layouts"
SCOPES = [
    "A.x.following_error,B.x.following_error!~,e%3Dmin%28A.x.K%2C%20B.x.K%29!",
    "x.position_reference@2=-0.01:0.01",
]


@pytest.fixture
def layouts(client: httpx.Client) -> httpx.Client:
    for each in client.get(API).json():  # also those of other tests
        client.delete(f"{API}/{each['name']}")
    return client


def test_a_layout_is_kept_replaced_and_deleted(layouts: httpx.Client) -> None:
    saved = layouts.put(f"{API}/my errors", json={"scopes": SCOPES})
    assert saved.json() == {"name": "my errors", "scopes": SCOPES}
    layouts.put(f"{API}/brakes", json={"scopes": SCOPES[:1]})
    assert [each["name"] for each in layouts.get(API).json()] == ["brakes", "my errors"]
    layouts.put(f"{API}/brakes", json={"scopes": SCOPES[1:]})
    assert layouts.get(API).json()[0]["scopes"] == SCOPES[1:]
    assert layouts.delete(f"{API}/brakes").status_code == 204
    assert layouts.delete(f"{API}/brakes").status_code == 404
    assert [each["name"] for each in layouts.get(API).json()] == ["my errors"]


@pytest.mark.parametrize(
    ("body", "place"),
    [
        ({"scopes": []}, "scopes"),
        ({"scopes": ["A.x.thrust"] * 13}, "scopes"),
        ({"scopes": ["A.x.thrust,,B.x.thrust"]}, "scopes.0"),
        ({"scopes": ["A.x.thrust;B.x.thrust"]}, "scopes.0"),
        ({"scopes": [",".join(["a"] * 17)]}, "scopes.0"),
        ({"scopes": ["<b>"]}, "scopes.0"),
        ({"scopes": SCOPES, "more": 1}, "more"),
        ({}, "scopes"),
    ],
)
def test_what_is_no_layout_is_refused_by_name(
    layouts: httpx.Client, body: dict[str, object], place: str
) -> None:
    answer = layouts.put(f"{API}/wrong", json=body)
    assert answer.status_code == 422
    assert [error["loc"] for error in answer.json()["errors"]] == [place]
    assert layouts.get(API).json() == []
