"""What a 3-D view is told to show, and the forces of phases that it shows, over REST."""

from __future__ import annotations

from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from tests.scene3d.viewers import Viewer
from tests.server.live import Live, until
from tests.server.servers import Server

VIEWER = "abcd0123"
TICKS = 1411


def test_forces_of_phases_are_those_of_the_newest_tick(live: Live, client: httpx.Client) -> None:
    path = f"{live.path}/phase-forces"
    early = client.get(path)
    assert early.status_code == 409
    assert "no sample yet" in early.json()["detail"]
    live.step(TICKS)
    found = client.get(path).raise_for_status().json()
    assert (found["tick"], found["time"]) == (TICKS - 1, (TICKS - 1) * 5e-4)
    assert found["air_gap"] == {"x": 0.3e-3, "y": 0.3e-3}
    recording = run(prepare(load_scenario("circle")), stop=TICKS)
    for variant, axis in ((v, a) for v in "AB" for a in "xy"):
        mover = found["variants"][variant][axis]

        def channel(name: str, variant: str = variant, axis: str = axis) -> float:
            return float(recording.variants[variant].channel(name, axis)[-1])

        for name in ("position", "following_error", "thrust", "normal_force", "friction"):
            assert mover[name] == channel(name)
        assert mover["current"] == [channel(f"current_{phase}") for phase in "abc"]
        assert sum(mover["phase_thrust"]) == pytest.approx(mover["thrust"], rel=1e-3, abs=1e-3)
        assert sum(mover["phase_normal_force"]) == pytest.approx(mover["normal_force"], rel=1e-3)
        # A phase pulls towards its aligned position, with whatever current.
        pulls, way = np.array(mover["phase_thrust"]), np.array(mover["to_aligned"])
        assert (pulls[np.abs(pulls) > 1e-6] * way[np.abs(pulls) > 1e-6] > 0).all()
        assert max(np.abs(way)) <= 3.6e-3


def test_what_is_chosen_is_shown(server: Server, live: Live, client: httpx.Client) -> None:
    path = f"{live.path}/view3d/{VIEWER}"
    chosen = {"camera": "section", "machine": "B", "axis": "y"}
    nobody = client.put(path, json=chosen)
    assert nobody.status_code == 404
    assert "not shown in 3-D" in nobody.json()["detail"]
    live.step(10)
    nodes: set[str] = set()

    def told(viewer: Viewer) -> bool:
        nodes.update(message["name"] for message in viewer.window() if "name" in message)
        return any(name.startswith("/section-y/") for name in nodes)

    address = f"ws://127.0.0.1:{server.port}/scene/{live.id}/{VIEWER}"
    with Viewer(address).look() as viewer:
        viewer.positions("/lab/A/y")
        assert not any(name.startswith("/section") for name in nodes)
        assert client.put(path, json=chosen).status_code == 204
        until(lambda: told(viewer))


@pytest.mark.parametrize(
    ("wrong", "place"),
    [
        ({"camera": "behind"}, "camera"),
        ({"machine": "first"}, "machine"),
        ({"magnification": 0.5}, "magnification"),
        ({"arrows": ["thrust", "wind"]}, "arrows.1"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_a_choice_that_is_none_is_refused(
    live: Live, client: httpx.Client, wrong: dict[str, Any], place: str
) -> None:
    answer = client.put(f"{live.path}/view3d/{VIEWER}", json=wrong)
    assert answer.status_code == 422
    assert [error["loc"] for error in answer.json()["errors"]] == [place]


def test_a_view_has_a_name_of_its_form(live: Live, client: httpx.Client) -> None:
    assert client.put(f"{live.path}/view3d/A-VIEW", json={}).status_code == 422
