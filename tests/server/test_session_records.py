"""What a session hands out: metrics, recordings, its scenario; how many there may be, how long."""

from __future__ import annotations

import io
import json
import math
import time
import tomllib
from typing import Any

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from motionlab.analysis.metrics import variant_metrics
from motionlab.analysis.variant_comparison import compare
from motionlab.config.load import load_scenario
from motionlab.server.live.session import METRICS_SECONDS
from motionlab.server.live.sessions import IDLE_SECONDS, SPARE_SECONDS
from motionlab.server.routes import captures as captures_route
from motionlab.server.settings import Settings
from motionlab.telemetry import recorder
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live, Stream, until
from tests.server.offline import COLUMNS, RING, assert_offline, expected, offline
from tests.server.servers import PATIENCE, Server
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


def test_a_capture_is_a_run_with_every_channel(live: Live) -> None:
    live.step(3000)
    asked = {"from_tick": 1000, "to_tick": 1400, "name": "turn", "note": "reversal of x"}
    answer = live.client.post(f"{live.path}/captures", json=asked)
    assert answer.status_code == 201, answer.text
    kept = live.client.get(answer.headers["location"]).json()
    assert (kept["kind"], kept["state"], kept["tags"]) == ("live", "complete", ["capture"])
    origin = live.client.get(live.path).json()["run"]
    assert kept["note"] == f"reversal of x\n0.5 to 0.7 s of {origin}."
    assert kept["ticks"] == 400
    name = "B.y.following_error"
    file = live.client.get(f"{answer.headers['location']}/telemetry?format=csv&columns={name}")
    rows = [line.split(",") for line in file.text.splitlines()]
    assert [int(row[0]) for row in rows[1:]] == list(range(1000, 1400))
    wanted = offline("circle").recording.variants["B"].channel("following_error", "y")[1000:1400]
    assert np.array_equal(np.array([row[2] for row in rows[1:]], dtype=np.float32), wanted)
    again = live.client.post(f"{answer.headers['location']}/replay")
    assert again.status_code == 409
    assert "no scenario" in again.json()["detail"]
    for wrong, field in (
        ({"from_tick": 0, "to_tick": 3001}, "to_tick"),
        ({"from_tick": 5, "to_tick": 5}, "to_tick"),
        ({"from_tick": 3000, "to_tick": 3000}, "from_tick"),
    ):
        refused = live.client.post(f"{live.path}/captures", json=wrong)
        assert refused.status_code == 422
        assert field in [each["loc"] for each in refused.json()["errors"]]
    for wrong in ({"from_tick": True, "to_tick": 5}, {"from_tick": "0", "to_tick": 5}):
        refused = live.client.post(f"{live.path}/captures", json=wrong)
        assert "must be a whole number" in refused.text


def samples_of(client: httpx.Client, run: dict[str, Any]) -> pa.Table:
    answer = client.get(f"{API}/runs/{run['id']}/telemetry").raise_for_status()
    return pq.read_table(io.BytesIO(answer.content))


def test_a_capture_can_be_kept_however_old_it_is(live: Live) -> None:
    """The ring holds 60,000 ticks, at ten times real time 3 s; the recording holds all."""
    live.step(1000)
    live.change({"plant.x.mass": 6.0})
    live.step(RING + 3000)
    asked = {"from_tick": 700, "to_tick": 1200, "automatic": True}
    answer = live.client.post(f"{live.path}/captures", json=asked)
    assert answer.status_code == 201, answer.text
    kept = answer.json()
    assert not kept["kept"]
    table = samples_of(live.client, kept)
    assert table["tick"].to_pylist() == list(range(700, 1200))
    reference = offline("circle").recording.variants["B"].channel("following_error", "y")
    held = table["B.y.following_error"].to_numpy()
    assert np.array_equal(held[:300], reference[700:1000])
    across = {"from_tick": 2500, "to_tick": 2500 + RING}  # partly in the ring alone, just now
    live.step(500)
    kept = live.client.post(f"{live.path}/captures", json=across).raise_for_status().json()
    assert kept["kept"]
    assert kept["ticks"] == RING
    longer = {"from_tick": 0, "to_tick": RING + 1}
    refused = live.client.post(f"{live.path}/captures", json=longer)
    assert refused.status_code == 422
    assert "more than 30 s" in refused.json()["detail"]


def test_a_capture_of_before_a_reset_is_kept_as_it_was(live: Live) -> None:
    live.change({"plant.x.mass": 6.0})
    live.step(1000)
    before = live.client.get(live.path).json()
    ticks = {"from_tick": 100, "to_tick": 200}
    first = live.client.post(f"{live.path}/captures", json=ticks).raise_for_status().json()
    live.client.post(f"{live.path}/reset")
    live.change({"plant.x.mass": 5.0})
    live.step(1000)
    for _ in range(2):  # while the recording is made a run, and of the run
        body = ticks | {"timeline": before["timeline"]}
        answer = live.client.post(f"{live.path}/captures", json=body)
        assert answer.status_code == 201, answer.text
        kept = answer.json()
        assert kept["note"] == first["note"] == f"0.05 to 0.1 s of {before['run']}."
        assert samples_of(live.client, kept).equals(samples_of(live.client, first))
        assert kept["differences"] == first["differences"] != []
        run = f"{API}/runs/{before['run']}"
        until(lambda run=run: live.client.get(run).json()["state"] == "complete")
    now = live.client.get(live.path).json()["timeline"]
    other = live.client.post(f"{live.path}/captures", json=ticks | {"timeline": now})
    assert not samples_of(live.client, other.raise_for_status().json()).equals(
        samples_of(live.client, first)
    )


def test_a_capture_that_is_nowhere_is_refused_in_words(
    live: Live, server: Server, monkeypatch: pytest.MonkeyPatch
) -> None:
    live.step(1000)
    (session,) = [s for s in server.app.state.sessions.all() if s.id == live.id]
    monkeypatch.setattr(captures_route, "_PAUSE", 0.0)
    until(lambda: session.records[0].kept is not None)
    session.records.clear()
    live.step(RING)
    ticks = {"from_tick": 100, "to_tick": 200}
    refused = live.client.post(f"{live.path}/captures", json=ticks)
    assert refused.status_code == 422
    (error,) = refused.json()["errors"]
    assert error["loc"] == "from_tick"
    assert error["message"] == (
        "the samples of 0.05 to 0.1 s are gone: the session holds 0.5 to 30.5 s, and they were "
        "not recorded"
    )
