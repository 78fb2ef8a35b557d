"""Motors of one's own: saved, listed, found by name in scenarios, deleted, refused."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import httpx
import pytest

from motionlab.config.named_configs import data_root

MOTORS = "/api/v1/motors"
FIT = {"value": 6.1, "low": 6.0, "high": 6.2, "before": 5.9, "unit": "kg"}
ORIGIN = {
    "run": "r-abcdefghijkl",
    "run_name": "circle A on Virtual drive",
    "recorded": "2026-11-23T14:44:16+00:00",
    "fits": {"x.mass": FIT},
    "residual": {"x": {"before": 4e-6, "after": 2e-8}},
    "notes": [],
}
HEAVIER: dict[str, Any] = {"plant": {"base": "nominal", "x": {"mass": 6.1}}, "origin": ORIGIN}


@pytest.fixture
def named(client: httpx.Client) -> Iterator[httpx.Client]:
    yield client
    client.delete(f"{MOTORS}/rig-7")


def test_a_motor_is_kept_with_its_origin_and_named_by_scenarios(named: httpx.Client) -> None:
    saved = named.put(f"{MOTORS}/rig-7", json=HEAVIER)
    assert saved.status_code == 200, saved.text
    assert named.get(f"{MOTORS}/rig-7").json()["origin"] == ORIGIN
    assert named.get(f"{MOTORS}/nominal").json()["plant"]["x"]["mass"] == 5.9
    listed = {each["name"]: each["shipped"] for each in named.get(MOTORS).json()}
    assert (listed["nominal"], listed["rig-7"]) == (True, False)
    parts = named.get("/api/v1/parts").json()["motors"]
    assert "rig-7" in {each["name"] for each in parts}
    body = {"scenario": "circle", "set": {"plant": "rig-7", "trajectory.laps": 1}}
    found = named.post("/api/v1/simulate", json=body)
    assert found.json()["plant"] == "rig-7"
    changed = body | {"set": body["set"] | {"plant.x.mass": 6.3}}
    assert named.post("/api/v1/simulate", json=changed).json()["plant"] == "rig-7 (changed)"


def test_a_motor_of_the_same_name_is_replaced_and_deleted(named: httpx.Client) -> None:
    named.put(f"{MOTORS}/rig-7", json=HEAVIER)
    named.put(f"{MOTORS}/rig-7", json={"plant": "not a table"})
    assert named.get(f"{MOTORS}/rig-7").json()["plant"]["x"]["mass"] == 6.1
    named.put(f"{MOTORS}/rig-7", json={"plant": {"base": "matched"}})
    replaced = named.get(f"{MOTORS}/rig-7").json()
    assert replaced["origin"] is None
    assert replaced["plant"]["x"]["friction"]["F_s"] == 3.7251
    assert named.delete(f"{MOTORS}/rig-7").status_code == 204
    assert named.delete(f"{MOTORS}/rig-7").status_code == 404
    assert named.get(f"{MOTORS}/rig-7").status_code == 404
    refused = named.post("/api/v1/simulate", json={"set": {"plant": "rig-7"}})
    assert "no motor of that name" in refused.json()["detail"]


@pytest.mark.parametrize(
    ("name", "body", "status", "told"),
    [
        ("nominal", HEAVIER, 409, "ships with the project"),
        ("Rig 7", HEAVIER, 422, "name"),
        ("rig-7", {"plant": {"base": "nominal", "x": {"mass": -1.0}}}, 422, "x.mass"),
        ("rig-7", {"plant": {"base": "none-such"}}, 422, "no motor of that name"),
        ("rig-7", {"plant": {"x": {}}}, 422, "is missing"),
        ("rig-7", HEAVIER | {"origin": {"run": "r"}}, 422, "is missing"),
    ],
)
def test_what_is_no_motor_is_refused(
    named: httpx.Client, name: str, body: dict[str, Any], status: int, told: str
) -> None:
    refused = named.put(f"{MOTORS}/{name}", json=body)
    assert refused.status_code == status, refused.text
    assert told in refused.text
    assert named.delete(f"{MOTORS}/nominal").status_code == 409
    assert "rig-7" not in {each["name"] for each in named.get(MOTORS).json()}


def test_a_damaged_file_is_listed_and_told(named: httpx.Client) -> None:
    named.put(f"{MOTORS}/rig-7", json=HEAVIER)
    (data_root() / "motors" / "rig-7.toml").write_text("x = [")
    entry = next(each for each in named.get(MOTORS).json() if each["name"] == "rig-7")
    assert "is not TOML" in entry["description"]
    assert named.get(f"{MOTORS}/rig-7").status_code == 422
    assert named.get("/api/v1/parts").status_code == 200
