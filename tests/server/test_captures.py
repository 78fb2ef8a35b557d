"""Captures of sessions and what-ifs: runs from the moment they are taken."""

from __future__ import annotations

import io
from typing import Any

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from motionlab.analysis.glitches import glitches, reversals
from motionlab.config.load import load_scenario
from motionlab.library.stability_margins import stability_margins
from motionlab.server.routes import captures as captures_route
from motionlab.timing import CONTROL_PERIOD
from tests.server.live import API, Live, until
from tests.server.offline import RING, offline
from tests.server.servers import Server


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
    assert kept["metrics"] == stability_margins(load_scenario("circle"))
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


def test_a_capture_tells_its_peaks_and_the_glitch_of_its_reversal(live: Live) -> None:
    live.step(6000)
    recording = offline("circle").recording
    velocity = np.asarray(recording.references[1, 0], dtype=float)
    turn = next(turn for turn in reversals(velocity) if 200 < turn.tick < 5000)
    start, stop = turn.tick - 100, turn.tick + 300
    math = "ex in um=B.x.following_error * 1e6"
    columns = ["B.x.thrust", math]
    asked = {"from_tick": start, "to_tick": stop, "trigger_tick": turn.tick, "columns": columns}
    answer = live.client.post(f"{live.path}/captures", json=asked)
    assert answer.status_code == 201, answer.text
    capture = answer.json()["capture"]
    assert capture["origin"] == live.client.get(live.path).json()["run"]
    assert (capture["from_tick"], capture["trigger_tick"]) == (start, turn.tick)
    errors = {
        f"{name}.{axis}.following_error": recording.variants[name].channel("following_error", axis)
        for name in "AB"
        for axis in "xy"
    }
    assert set(capture["peaks"]) == {*errors, *columns}
    for name, values in errors.items():
        part = values[start:stop]
        assert capture["peaks"][name] == float(part[np.abs(part).argmax()])
    error = errors["B.x.following_error"][start:stop].astype(float)
    assert capture["peaks"][math] == pytest.approx(1e6 * error[np.abs(error).argmax()], rel=1e-6)
    assert set(capture["glitches"]) == {"A.x.following_error", "B.x.following_error"}
    count = load_scenario("circle").plant.x.encoder.resolution
    (glitch,) = glitches(velocity[start:stop], error, count=count, period=CONTROL_PERIOD)
    assert capture["glitches"]["B.x.following_error"] == pytest.approx(glitch.height, rel=1e-6)
    listed = live.client.get(f"{API}/runs?q=tag:capture&limit=1").json()["runs"]
    assert listed[0]["capture"] == capture
    for wrong, field in (
        ({"trigger_tick": stop}, "trigger_tick"),
        ({"columns": ["C.x.thrust"]}, "columns.0"),
        ({"columns": ["B.x.thrust"] * 5}, "columns"),
    ):
        refused = live.client.post(f"{live.path}/captures", json=asked | wrong)
        assert refused.status_code == 422, refused.text
        assert field in [each["loc"] for each in refused.json()["errors"]]


def test_a_capture_of_a_what_if_is_kept(live: Live) -> None:
    changes = {"plant.x.mass": 6.0}
    asked = {
        "scenario": "circle",
        "set": changes,
        "from_tick": 1000,
        "to_tick": 1400,
        "trigger_tick": 1100,
        "name": "a reversal",
    }
    answer = live.client.post(f"{API}/whatif/captures", json=asked)
    assert answer.status_code == 201, answer.text
    kept = answer.json()
    assert (kept["kind"], kept["tags"], kept["kept"]) == ("simulation", ["capture"], True)
    assert (kept["name"], kept["capture"]["trigger_tick"]) == ("a reversal", 1100)
    assert [each["path"] for each in kept["differences"]] == list(changes)
    table = samples_of(live.client, kept)
    assert table["tick"].to_pylist() == list(range(1000, 1400))
    live.change(changes)
    live.step(1400)
    ticks = {"from_tick": 1000, "to_tick": 1400}
    same = live.client.post(f"{live.path}/captures", json=ticks).raise_for_status().json()
    assert samples_of(live.client, same).equals(table)
    for wrong, field in (({"to_tick": 1000}, "to_tick"), ({"to_tick": 60_000}, "to_tick")):
        refused = live.client.post(f"{API}/whatif/captures", json=asked | wrong)
        assert refused.status_code == 422
        assert field in [each["loc"] for each in refused.json()["errors"]]


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
