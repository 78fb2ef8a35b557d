"""Force maps in live sessions and what-if: the bits of the offline run."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.config.named_configs import config_root
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import MakeLive
from tests.server.live import API, until
from tests.server.offline import assert_offline
from tests.simulated import play

JSON = {"content-type": "application/json"}
TABLE_IN_THE_PLANT = {"plant.force_map": "new-design"}
"""The controllers keep their analytic map."""


def test_a_session_with_a_table_is_the_offline_run(make_live: MakeLive) -> None:
    live = make_live(changes=TABLE_IN_THE_PLANT)
    live.step(3000)
    assert_offline(live, play("circle", TABLE_IN_THE_PLANT))


def test_maps_and_laws_change_while_a_session_runs(make_live: MakeLive) -> None:
    live = make_live()
    events: list[dict[str, Any]] = []
    for tick, changes in (
        (1000, TABLE_IN_THE_PLANT),
        (2000, {"variants.B.controller.model.force_map": "new-design"}),
        (2500, {"variants.B.controller.sharing.law": "force-per-ampere"}),
        (3000, {"plant.x.force_map": {"kind": "table", "name": "previous-design", "gain": 0.9}}),
    ):
        live.step(tick - live.tick)
        assert live.change(changes) == tick
        events.append({"time": tick * CONTROL_PERIOD, "set": changes})
    live.step(1000)
    assert_offline(live, play("circle", {"schedule": events}))
    live.do("undo")
    assert live.info()["scenario"]["plant"]["x"]["force_map"]["name"] == "new-design"


def test_a_map_that_is_not_there_changes_nothing(make_live: MakeLive, client: httpx.Client) -> None:
    live = make_live(changes=TABLE_IN_THE_PLANT)
    for changes in ({"plant.force_map": "none-such"}, {"plant.x.amplifiers.limit": 20.0}):
        answer = client.patch(f"{API}/sessions/{live.id}/parameters", json={"set": changes})
        assert answer.status_code == 422
    live.step(500)
    assert_offline(live, play("circle", TABLE_IN_THE_PLANT))


def test_what_if_takes_a_table(client: httpx.Client) -> None:
    body = {"scenario": "circle", "set": TABLE_IN_THE_PLANT, "columns": ["A.x.following_error"]}
    answer = client.post(f"{API}/whatif", json=body)
    assert answer.status_code == 200
    assert b'"new-design"' in answer.content


@pytest.fixture
def passing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the file of a computed map, named `passing`, that a test may delete."""
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    (tmp_path / "maps").mkdir()
    shipped = config_root() / "maps" / "new-design.json"
    return Path(shutil.copy(shipped, tmp_path / "maps" / "passing.json"))


def test_a_scheduled_map_is_in_effect_though_it_was_deleted(
    make_live: MakeLive, passing: Path
) -> None:
    event = {"time": 0.5, "set": {"plant.x.force_map": {"kind": "table", "name": "passing"}}}
    live = make_live(changes={"schedule": [event]})
    passing.unlink()
    live.step(2000)
    assert live.info()["scenario"]["plant"]["x"]["force_map"]["name"] == "passing"


def test_a_reset_without_its_map_is_refused_and_changes_nothing(
    make_live: MakeLive, passing: Path
) -> None:
    live = make_live()
    live.step(1000)
    live.change({"plant.x.force_map": {"kind": "table", "name": "passing"}})
    live.do("play")
    passing.unlink()
    refused = live.post("reset")
    assert refused.status_code == 422
    assert refused.json()["errors"][0]["loc"] == "plant.x.force_map.name"
    after = live.info()
    assert after["tick"] >= 1000
    assert (after["state"], after["timeline"]) == ("playing", 0)
    assert [change["tick"] for change in after["changes"]] == [1000]
    until(lambda: live.tick > after["tick"])
    live.change({"plant.x.force_map": {"kind": "table", "name": "new-design"}})
    assert live.do("reset")["tick"] == 0


def weaken(path: Path, share: float) -> None:
    """Let the file of a map hold another one: that share of every force."""
    tables = json.loads(path.read_text())
    for name in ("coenergy", "linkage", "thrust", "normal_force"):
        tables[name] = [[share * value for value in row] for row in tables[name]]
    path.write_text(json.dumps(tables))


def test_a_map_that_changes_under_its_name(client: httpx.Client, passing: Path) -> None:
    """Every answer is that of the same map under a name never asked for before."""
    controllers = {f"variants.{v}.controller.model.force_map": "passing" for v in ("A", "B")}
    circle: dict[str, Any] = {"scenario": "circle", "set": controllers}
    motion = {"kind": "circle", "radius": 0.02, "frequency": 0.5, "laps": 3}
    long: dict[str, Any] = {
        "scenario": {"base": "fig5", "plant": {"base": "nominal", "force_map": "passing"}},
        "columns": ["A.x.following_error"],
    }
    calls = {
        "trajectories/check": circle | {"trajectory": motion},
        "whatif": long,
        "loop": {"set": {"plant.force_map": "passing"}},
        "simulate": circle,
    }

    def ask(name: str) -> dict[str, tuple[int, bytes]]:
        answers = {}
        for call, body in calls.items():
            text = json.dumps(body).replace('"passing"', f'"{name}"')
            answer = client.post(f"{API}/{call}", content=text, headers=JSON)
            content = answer.content.replace(f'"{name}"'.encode(), b'"passing"')
            answers[call] = (answer.status_code, content)
        return answers

    first = ask("passing")
    assert {status for status, _ in first.values()} == {200}
    weaken(passing, 0.04)
    shutil.copy(passing, passing.with_name("another.json"))
    second, fresh = ask("passing"), ask("another")
    for call, answer in second.items():
        assert answer != first[call], call
        assert answer == fresh[call], call
    assert second["simulate"][0] == 422
    assert b"thrust on" in second["simulate"][1]


@pytest.mark.parametrize("call", ["loop", "loop/response", "simulate", "sessions", "whatif"])
@pytest.mark.parametrize("owner", ["plant.x", "variants.B.controller.model.y"])
def test_a_map_that_has_vanished_is_named(
    client: httpx.Client, passing: Path, call: str, owner: str
) -> None:
    body = {"set": {f"{owner}.force_map": {"kind": "table", "name": "passing"}}}
    if call == "loop/response":
        body |= {"scenario": "circle", "variant": "B", "axis": owner[-1]}
    assert client.post(f"{API}/{call}", json=body).status_code in {200, 201}
    passing.unlink()
    answer = client.post(f"{API}/{call}", json=body)
    assert answer.status_code == 422
    (error,) = answer.json()["errors"]
    assert (error["loc"], error["value"]) == (f"{owner}.force_map.name", "passing")
    passing.write_text("{}")
    answer = client.post(f"{API}/{call}", json=body)
    assert answer.status_code == 422
    assert "'passing' cannot be used" in answer.json()["detail"]
