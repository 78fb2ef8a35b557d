"""What a session hands out: metrics, recordings, its scenario; how many there may be, how long."""

from __future__ import annotations

import json
import math
import time
import tomllib
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.analysis.metrics import variant_metrics
from motionlab.analysis.variant_comparison import compare
from motionlab.config.load import load_scenario
from motionlab.server.live.session import METRICS_SECONDS
from motionlab.server.live.sessions import IDLE_SECONDS, SPARE_SECONDS
from motionlab.server.settings import Settings
from motionlab.telemetry import recorder
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live, Stream, until
from tests.server.offline import COLUMNS, RING, assert_offline, expected, offline
from tests.server.servers import PATIENCE
from tests.simulated import play

MASS = "plant.x.mass"


def metrics_of(live: Live) -> dict[str, Any]:
    response = live.client.get(f"{live.path}/metrics")
    assert response.status_code == 200, response.text

    def refuse(constant: str) -> None:
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(response.text, parse_constant=refuse)


@pytest.mark.parametrize("name", ["circle", "stair-x-500nm"])
def test_metrics_are_those_of_the_analysis(make_live: MakeLive, name: str) -> None:
    live = make_live(name)
    played = offline(name)
    period = played.prepared.reference.period
    end = 19_000
    live.step(end)
    start = end - (2 * period if period else round(METRICS_SECONDS / CONTROL_PERIOD))
    start = max(0, start)
    got = metrics_of(live)
    assert got["window"] == {"start": start * CONTROL_PERIOD, "end": end * CONTROL_PERIOD}
    wanted = {
        variant: variant_metrics(
            played.recording,
            variant,
            played.prepared.reference,
            (start, end),
            settling_band=played.prepared.scenario.settling_band,
        )
        for variant in "AB"
    }
    for variant, one in wanted.items():
        of_holds = ("steady_state_error", "settling_time", "overshoot", "relative_overshoot")
        for axis, values in one["axes"].items():
            for metric, value in values.items():
                if metric not in of_holds:
                    close = pytest.approx(value, rel=1e-9, abs=1e-15)
                    assert got["variants"][variant]["axes"][axis][metric] == close, metric
        assert got["variants"][variant]["contour"] == pytest.approx(one["contour"], rel=1e-9)
    assert set(got["comparison"]) == set(compare(wanted["A"], wanted["B"]))


def test_metrics_from_the_first_tick_on(live: Live) -> None:
    assert metrics_of(live) == {
        "window": {"start": 0.0, "end": 0.0},
        "variants": {},
        "comparison": {},
    }
    for tick in (1, 2, 3, 10):
        live.step(tick - live.tick)
        got = metrics_of(live)
        assert got["window"] == {"start": 0.0, "end": tick * CONTROL_PERIOD}
        assert set(got["variants"]) == {"A", "B"}
        assert math.isfinite(got["variants"]["A"]["axes"]["x"]["rms_following_error"])


def test_metrics_end_where_a_stop_began(live: Live) -> None:
    live.step(12_000)
    before = metrics_of(live)
    live.do("stop")
    until(lambda: live.state == "stopped")
    assert live.tick > 12_000
    assert metrics_of(live) == before


@pytest.mark.parametrize("kind", ["csv", "parquet"])
def test_telemetry_reopens_with_the_same_values(
    live: Live, kind: str, tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("telemetry")
    for ticks in (0, 1, 2999):
        live.step(ticks)
        response = live.client.get(f"{live.path}/telemetry", params={"format": kind})
        path = folder / f"{live.tick}.{kind}"
        path.write_bytes(response.content)
        columns = recorder.read(str(path))
        assert len(columns) == COLUMNS + 2
        np.testing.assert_array_equal(columns["tick"].values, np.arange(live.tick))
        assert columns["A.x.following_error"].unit == "m"
        for name, values in expected(offline("circle"), 0, live.tick).items():
            np.testing.assert_array_equal(columns[name].values, values)
    assert f"circle-3000.{kind}" in response.headers["content-disposition"]


def test_telemetry_holds_the_last_thirty_seconds(live: Live) -> None:
    live.step(RING + 1500)
    ticks = live.columns()["tick"]
    assert (ticks[0], ticks[-1]) == (1500, RING + 1499)


def test_the_scenario_file_runs_offline_to_the_same_bits(
    make_live: MakeLive, tmp_path_factory: pytest.TempPathFactory
) -> None:
    events = [{"time": 0.25, "set": {"plant.y.mass": 12.0}}]
    live = make_live(changes={"schedule": events, "title": 'Ünï "quoted" \\ #1'})
    live.change({MASS: 7.0, "variants.B.controller.x.k_p": 312_345.678901234})
    text = live.client.get(f"{live.path}/scenario.toml").text
    path = tmp_path_factory.mktemp("scenario") / "kept.toml"
    path.write_text(text, encoding="utf-8")
    scenario = load_scenario(path)
    assert scenario.model_dump(mode="json") == live.info()["scenario"]
    assert tomllib.loads(text)["title"] == 'Ünï "quoted" \\ #1'
    live.do("reset")
    live.step(1500)
    assert_offline(live, play(tomllib.loads(text)))


# -- how many, how long ---------------------------------------------------------------------------


def test_the_number_of_sessions_is_bounded(make_server: MakeServer) -> None:
    server = make_server(Settings(sessions_max=2))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        first, second = Live.create(client), Live.create(client)
        response = client.post(f"{API}/sessions", json={})
        assert response.status_code == 429
        assert "2 sessions" in response.json()["detail"]
        assert "motionlab_sessions 2.0" in client.get("/metrics").text
        first.delete()
        third = Live.create(client)
        assert [s["id"] for s in client.get(f"{API}/sessions").json()] == [second.id, third.id]


def test_an_idle_session_makes_room(make_server: MakeServer) -> None:
    server = make_server(Settings(sessions_max=2))
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        watched, idle = Live.create(client), Live.create(client)
        with Stream(server, watched.id) as stream:
            stream.message("hello")
            for session in server.app.state.sessions.all():
                session.touched -= SPARE_SECONDS + 1.0
            third = Live.create(client)
            assert [s["id"] for s in client.get(f"{API}/sessions").json()] == [watched.id, third.id]
            assert client.get(idle.path).status_code == 404
            assert client.post(f"{API}/sessions", json={}).status_code == 429


def test_sessions_expire_that_nobody_asks_for_or_watches(make_server: MakeServer) -> None:
    server = make_server(Settings())
    sessions = server.app.state.sessions

    async def expire(now: float) -> None:
        sessions.expire(now)

    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        forgotten, watched = Live.create(client), Live.create(client)
        forgotten.do("play")
        before = time.monotonic()
        with Stream(server, watched.id) as stream:
            stream.message("hello")
            server.call(expire(before + IDLE_SECONDS - 1.0))
            assert len(sessions.all()) == 2
            server.call(expire(time.monotonic() + IDLE_SECONDS + 1.0))
            assert [session.id for session in sessions.all()] == [watched.id]
        until(lambda: not sessions.all()[0].listeners)
        assert client.get(forgotten.path).status_code == 404
        now = time.monotonic()
        server.call(expire(now + IDLE_SECONDS - 1.0))
        assert watched.state == "paused"  # it has been asked for: its time begins again
        server.call(expire(now + IDLE_SECONDS))
        assert len(sessions.all()) == 1
        server.call(expire(time.monotonic() + IDLE_SECONDS + 1.0))
        assert sessions.all() == []


def test_the_sweep_ends_idle_sessions(
    make_server: MakeServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("motionlab.server.live.sessions._EVICTION_PERIOD", 0.01)
    server = make_server(Settings())
    with httpx.Client(base_url=server.url, timeout=PATIENCE) as client:
        live = Live.create(client)
        (session,) = server.app.state.sessions.all()
        time.sleep(0.05)
        assert live.state == "paused"
        session.touched -= IDLE_SECONDS + 1.0
        until(lambda: server.app.state.sessions.all() == [])
        assert session.closed
