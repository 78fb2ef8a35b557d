"""Live sessions: the bits of the offline run, whatever a session has been through; states."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.server.live.change_log import CHANGES_MAX
from motionlab.simulation.simulation import BRAKING
from motionlab.timing import CONTROL_PERIOD
from tests.server.conftest import MakeLive
from tests.server.live import Live, Stream, until
from tests.server.offline import assert_offline, expected, offline
from tests.server.servers import Server
from tests.simulated import play

MASS = "plant.x.mass"
K_P = "variants.B.controller.x.k_p"
ENDS = {"trajectory": {"kind": "line", "end": {"x": 0.001}, "edge_time": 0.4, "dwell": 0.1}}
"""A motion that ends elsewhere than it began, so that it cannot go on: 0.6 s."""
HOPELESS = {"variants.B.controller.x.k_p": 0.0, "variants.B.controller.x.k_d": 0.0}
"""B does not follow on x at all and has diverged when the circle is 20 mm away."""
COULOMB, STICTION = "plant.x.friction.F_c", "plant.x.friction.F_s"
STICKIER = [{"time": 0.25, "set": {STICTION: 6.0}}, {"time": 0.5, "set": {COULOMB: 5.0}}]
"""A schedule after which the Coulomb force may be larger than the stiction of before."""


# -- the same bits --------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["circle", "circle-matched", "stair-x-500nm"])
def test_every_tick_is_that_of_the_offline_run(make_live: MakeLive, name: str) -> None:
    live = make_live(name)
    played = offline(name)
    for ticks in (1, 2, 700, 4096, 3001, 20_000):
        end = min(live.tick + ticks, played.recording.ticks)
        live.step(end - live.tick)
        assert live.tick == end
        assert_offline(live, played)


def test_a_change_is_that_of_a_schedule(make_live: MakeLive) -> None:
    live = make_live()
    events: list[dict[str, Any]] = []
    for tick, changes in (
        (1234, {K_P: 400_000.0, MASS: 7.5}),
        (4096, {"plant.y.friction.enabled": False}),
        (5001, {"load": {"x": 3.0, "noise": 0.5}}),
        (5002, {"variants.A.controller": "lugre-observer"}),
    ):
        live.step(tick - live.tick)
        assert live.change(changes) == tick
        events.append({"time": tick * CONTROL_PERIOD, "set": changes})
    live.step(3000)
    changed = play("circle", {"schedule": events})
    assert_offline(live, changed)
    before = expected(changed, 0, 1234)
    assert all((before[c] == expected(offline("circle"), 0, 1234)[c]).all() for c in before)


def test_a_change_leaves_the_schedule_to_come(make_live: MakeLive) -> None:
    events = [{"time": 0.5, "set": {MASS: 8.0}}, {"time": 1.5, "set": {K_P: 150_000.0}}]
    live = make_live(changes={"schedule": events})
    live.step(2000)
    live.change({"plant.y.mass": 12.0})
    live.step(3000)
    assert live.info()["scenario"]["plant"]["x"]["mass"] == 8.0
    between = {"time": 1.0, "set": {"plant.y.mass": 12.0}}
    assert_offline(live, play("circle", {"schedule": [events[0], between, events[1]]}))


def test_at_another_speed_and_between_pauses(make_live: MakeLive) -> None:
    live = make_live()
    for speed, ticks in ((10.0, 3000), (0.1, 3005), (3.0, 3600)):
        live.do("play", speed=speed)
        until(lambda ticks=ticks: live.tick >= ticks)
        live.do("pause")
    assert_offline(live, offline("circle"))


def test_a_reset_brings_the_same_ticks_again(make_live: MakeLive) -> None:
    live = make_live()
    live.step(2500)
    live.change({MASS: 9.0})
    live.do("push", axis="y", force=20.0)
    live.step(400)
    live.do("stop")
    until(lambda: live.state == "stopped")
    live.do("reset")
    assert (live.state, live.tick) == ("paused", 0)
    live.step(2000)
    assert_offline(live, play("circle", {MASS: 9.0}))
    live.do("undo")
    live.do("reset")
    live.step(2000)
    assert_offline(live, offline("circle"))


def test_a_circle_goes_on_beyond_its_last_lap(make_live: MakeLive) -> None:
    live = make_live()
    played = offline("circle")
    end, lap = played.recording.ticks, played.prepared.reference.period
    live.step(end + 9000)
    assert (live.state, live.info()["ends"]) == ("paused", None)
    columns = live.columns()
    for name, values in expected(played, 0, end).items():
        assert values.tobytes() == columns[name][:end].tobytes(), name
        if "_reference" in name:  # the last lap again, bit for bit
            again = columns[name][end : end + lap]
            assert again.tobytes() == values[-lap:].tobytes()
    for name in ("A.x", "A.y", "B.x", "B.y"):
        errors = np.abs(columns[f"{name}.following_error"])
        assert errors[end:].max() == pytest.approx(errors[end - lap : end].max(), rel=0.05)


def test_a_push_changes_only_what_comes_after(make_live: MakeLive) -> None:
    live = make_live()
    live.step(3000)
    assert live.do("push", axis="x", force=25.0, duration=0.05) == {"tick": 3000}
    live.step(1000)
    columns = live.columns()
    plain = expected(offline("circle"), 0, 4000)
    load = columns["x.load_force"] - plain["x.load_force"]
    np.testing.assert_array_equal(np.flatnonzero(load), np.arange(3000, 3100))
    assert set(load[3000:3100]) == {-25.0}  # f_d of eq. (16) pushes towards negative positions
    for name, values in plain.items():
        assert values[:3000].tobytes() == columns[name][:3000].tobytes(), name
    assert columns["y.load_force"].tobytes() == plain["y.load_force"].tobytes()
    for variant in "AB":
        pushed = columns[f"{variant}.x.position"] - plain[f"{variant}.x.position"]
        assert pushed[3000:3100].max() > 1e-6


def test_many_sessions_do_not_disturb_each_other(make_live: MakeLive) -> None:
    lives = [make_live(changes={MASS: 5.0 + k}) for k in range(8)]
    for live in lives:
        live.do("play", speed=5.0)
    until(lambda: all(live.tick > 4000 for live in lives))
    for live in lives:
        live.do("pause")
    for k, live in enumerate(lives):
        assert_offline(live, play("circle", {MASS: 5.0 + k}))


# -- states ---------------------------------------------------------------------------------------


def test_paused_playing_paused(live: Live) -> None:
    assert (live.state, live.tick) == ("paused", 0)
    assert live.do("step")["tick"] == 1
    assert live.do("step", ticks=7)["tick"] == 8
    assert live.do("pause")["state"] == "paused"
    info = live.do("play", speed=2.0)
    assert (info["state"], info["speed"]) == ("playing", 2.0)
    assert live.do("play")["speed"] == 2.0
    until(lambda: live.tick > 100)
    assert live.post("step", ticks=1).status_code == 409
    paused = live.do("pause")
    assert paused["state"] == "paused"
    time.sleep(0.05)
    assert live.tick == paused["tick"]
    assert live.info()["time"] == pytest.approx(live.tick * CONTROL_PERIOD)


def test_a_stop_brakes_to_rest_and_releases(live: Live) -> None:
    live.step(3000)
    began = live.tick
    assert live.do("stop")["state"] == "stopping"
    for action in ("play", "pause", "step"):
        assert live.post(action).status_code == 409, action
    assert live.do("stop")["state"] in {"stopping", "stopped"}
    until(lambda: live.state == "stopped")
    for action in ("play", "pause", "step"):
        assert live.post(action).status_code == 409, action
    assert live.do("stop")["state"] == "stopped"
    ended = live.tick
    time.sleep(0.05)
    assert live.tick == ended

    columns = live.columns()
    plain = expected(offline("circle"), 0, began)
    for name, values in plain.items():
        assert values.tobytes() == columns[name][:began].tobytes(), name
    plant = live.info()["scenario"]["plant"]
    for axis in "xy":
        limit = BRAKING * plant[axis]["acceleration_max"]
        velocity = columns[f"{axis}.velocity_reference"].astype(float)
        after = velocity[began:]
        assert np.abs(np.diff(after)).max() <= limit * CONTROL_PERIOD * (1 + 1e-5)
        assert after[-1] == 0.0
        assert np.all(np.diff(np.abs(after)) <= 0.0)
        assert np.abs(columns[f"{axis}.acceleration_reference"][began:]).max() <= limit * (1 + 1e-6)
        moved = np.diff(columns[f"{axis}.position_reference"][began - 1 :].astype(float))
        assert np.abs(moved).max() <= np.abs(velocity[began]) * CONTROL_PERIOD + 1e-8
        for variant in "AB":
            for phase in "abc":
                assert columns[f"{variant}.{axis}.current_command_{phase}"][-1] == 0.0
                assert abs(columns[f"{variant}.{axis}.current_{phase}"][-1]) < 1e-3
            assert any(columns[f"{variant}.{axis}.current_{phase}"][began] > 0.1 for phase in "abc")
    assert live.do("reset")["state"] == "paused"
    assert live.do("step")["tick"] == 1


def test_a_stop_from_rest(live: Live) -> None:
    live.do("stop")
    until(lambda: live.state == "stopped")
    assert live.columns()["A.x.current_command_a"][-1] == 0.0


def test_a_motion_that_ends(make_live: MakeLive) -> None:
    live = make_live(changes=ENDS)
    played = play("circle", ENDS)
    end = played.recording.ticks
    assert live.info()["ends"] == end
    assert live.step(end - 1)["state"] == "paused"
    assert live.step(1)["state"] == "finished"
    assert live.tick == end
    assert_offline(live, played)
    for action in ("play", "step"):
        assert live.post(action).status_code == 409, action
    live.do("reset")
    live.do("play", speed=10.0)
    until(lambda: live.state == "finished")
    assert live.tick == end
    assert_offline(live, played)


def test_a_circle_that_is_not_for_ever_ends_at_rest(make_live: MakeLive) -> None:
    twice = {"trajectory.laps": 2, "trajectory.for_ever": False, "trajectory.lead_in": 0.1}
    live = make_live(changes=twice)
    played = play("circle", twice)
    end = played.recording.ticks
    assert live.info()["ends"] == end == 200 + 2 * 6000 + 200
    live.step(end)
    assert live.state == "finished"
    assert_offline(live, played)
    assert abs(live.columns()["y.velocity_reference"][-1]) < 1e-4
    window = live.client.get(f"{live.path}/metrics").json()["window"]
    assert window == pytest.approx({"start": 3.1, "end": 6.1})  # the last lap, without its end


def test_what_the_documents_say_of_changes(live: Live) -> None:
    base = live.info()
    assert base["changes"] == []
    live.step(10)
    assert live.change({MASS: 7.0, K_P: 300_000.0}) == 10
    live.step(5)
    assert live.change({MASS: 8.0}) == 15
    info = live.info()
    before = load_scenario("circle")
    assert [change["tick"] for change in info["changes"]] == [10, 15]
    assert info["changes"][0]["set"] == {MASS: 7.0, K_P: 300_000.0}
    k_p = before.variants["B"].controller.x.k_p
    assert info["changes"][0]["previous"] == {MASS: before.plant.x.mass, K_P: k_p}
    assert info["changes"][1]["previous"] == {MASS: 7.0}
    assert info["base"] == before.model_dump(mode="json")
    assert info["scenario"]["plant"]["x"]["mass"] == 8.0
    assert info["revision"] > base["revision"]
    live.do("reset")
    assert [change["tick"] for change in live.info()["changes"]] == [0, 0]


def test_undo_takes_back_one_change_at_a_time(live: Live) -> None:
    scenario = live.info()["scenario"]
    assert live.post("undo").status_code == 409
    changes: list[dict[str, Any]] = [
        {MASS: 7.0},
        {"variants.B.controller": "pd", "variants.B.controller.x.k_p": 250_000.0},
        {"load": {"y": 2.0}},
    ]
    seen = [scenario]
    for change in changes:
        live.change(change)
        seen.append(live.info()["scenario"])
        live.step(1)
    for before in reversed(seen[:-1]):
        assert live.do("undo")["scenario"] == before
    assert live.info()["changes"] == []
    assert live.post("undo").status_code == 409


def test_a_reset_drops_a_change_that_only_fits_a_later_schedule(make_live: MakeLive) -> None:
    live = make_live(changes={"schedule": STICKIER})
    live.step(1200)
    live.change({COULOMB: 4.9})
    live.change({MASS: 7.0})
    live.step(100)
    info = live.do("reset")
    assert [change["set"] for change in info["changes"]] == [{MASS: 7.0}]
    assert info["tick"] == 0
    live.step(1200)
    assert_offline(live, play("circle", {"schedule": STICKIER, MASS: 7.0}))


def test_undo_takes_back_the_label_with_the_controller(live: Live) -> None:
    before = live.info()["scenario"]["variants"]["B"]
    live.change({"variants.B.controller": "lugre-full"})
    assert live.info()["scenario"]["variants"]["B"]["label"] == "lugre-full"
    live.do("undo")
    assert live.info()["scenario"]["variants"]["B"] == before


def test_an_undo_that_no_longer_fits_leaves_all_as_it_is(make_live: MakeLive) -> None:
    live = make_live(changes={"schedule": STICKIER})
    live.change({STICTION: 3.7})
    live.step(1200)
    before = live.info()
    response = live.post("undo")
    assert response.status_code == 422
    assert "F_s" in response.json()["detail"]
    assert live.info() == before


def test_the_latest_changes_are_kept_and_the_others_stay_in_effect(live: Live) -> None:
    live.change({K_P: 250_000.0})
    for k in range(CHANGES_MAX):
        live.change({MASS: 5.0 + k / 100})
    info = live.info()
    assert len(info["changes"]) == CHANGES_MAX
    assert info["changes"][0]["set"] == {MASS: 5.0}
    live.do("reset")
    assert live.info()["scenario"] == info["scenario"]
    live.step(100)
    assert_offline(live, play("circle", {K_P: 250_000.0, MASS: 5.0 + (CHANGES_MAX - 1) / 100}))


def test_an_unknown_path_is_named(live: Live) -> None:
    response = live.client.patch(f"{live.path}/parameters", json={"set": {"plant.x.maas": 1.0}})
    assert response.status_code == 422
    assert response.json()["errors"][0]["loc"] == "plant.x.maas"
    assert live.info()["changes"] == []


# -- a variant that diverges ----------------------------------------------------------------------


def test_a_diverging_variant_leaves_the_other_alone(server: Server, make_live: MakeLive) -> None:
    live = make_live()
    live.change(HOPELESS)
    played = play("circle", HOPELESS)
    diverged = played.recording.variants["B"].diverged
    assert diverged is not None
    with Stream(server, live.id) as stream:
        assert stream.message("hello")["session"]["diverged"] == {"A": None, "B": None}
        live.do("play", speed=10.0)
        told = stream.find("session")["session"]
        while told["diverged"]["B"] is None:
            told = stream.find("session")["session"]
        assert told["diverged"] == {"A": None, "B": diverged.tick * CONTROL_PERIOD}
        live.do("pause")
    columns = live.columns()
    for name, values in expected(played, 0, live.tick).items():
        if name.startswith("B."):
            np.testing.assert_array_equal(values, columns[name])
        else:
            assert values.tobytes() == columns[name].tobytes(), name
    alone = expected(offline("circle"), 0, live.tick)
    assert columns["A.x.position"].tobytes() == alone["A.x.position"].tobytes()
    assert np.isnan(columns["B.x.position"][diverged.tick :]).all()
    metrics = live.client.get(f"{live.path}/metrics").json()
    assert metrics["variants"]["A"]["contour"]["max"] > 0
    assert metrics["variants"]["B"]["contour"]["max"] is None
    assert live.do("reset")["diverged"] == {"A": None, "B": None}
