"""The same calls against a server, and a live session as arrays."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import motionlab
from motionlab.scripting.http_client import ServerRefused
from motionlab.server.settings import Settings
from tests.server.live import until
from tests.server.servers import Server

K_P = "variants.B.controller.x.k_p"
ERRORS = ("A.x.following_error", "B.x.following_error")


@pytest.fixture(scope="module")
def lab(server: Server) -> motionlab.Client:
    return motionlab.Client(server.url)


def test_a_run_is_the_run_of_this_process(lab: motionlab.Client) -> None:
    there, here = lab.run("circle", {K_P: 4e5}), motionlab.run("circle", {K_P: 4e5})
    assert there.document == here.document
    before = len(lab.runs())
    for name in here:
        np.testing.assert_array_equal(there[name], here[name])
    assert there.scenario == here.scenario
    assert len(lab.runs()) == before, "what was kept to be read is deleted again"


def test_a_kept_run_is_found(lab: motionlab.Client) -> None:
    run = lab.run("circle", keep=True, name="of the client")
    assert run.id is not None
    assert lab.runs()[0]["name"] == "of the client"
    np.testing.assert_array_equal(lab.kept(run.id)[ERRORS[1]], run[ERRORS[1]])


def test_studies_are_jobs_or_answers(lab: motionlab.Client) -> None:
    grid = {K_P: [1e5, 4e5]}
    assert lab.sweep("circle", grid).document == motionlab.sweep("circle", grid).document
    assert lab.design().document == motionlab.design().document


def test_a_job_that_is_interrupted_is_cancelled(
    lab: motionlab.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(_: float) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("motionlab.scripting.client.time.sleep", interrupt)
    with pytest.raises(KeyboardInterrupt):
        lab.montecarlo("circle", cases=3000)
    monkeypatch.undo()
    jobs = lab._server.call("GET", "/jobs?kind=monte-carlo")
    until(lambda: lab._server.call("GET", f"/jobs/{jobs[0]['id']}")["state"] == "cancelled")


def test_a_live_session_is_recorded_as_it_is_simulated(lab: motionlab.Client) -> None:
    expected = motionlab.run("circle")
    with lab.session("circle") as session:
        block = session.record(*ERRORS, seconds=1.0, speed=10.0)
        assert list(block) == list(ERRORS)
        for name in ERRORS:
            np.testing.assert_array_equal(block[name], expected[name][:2000])
        np.testing.assert_array_equal(block.time, expected.time[:2000])
        session.pause()
        assert session.info["state"] == "paused"
        first = block.ticks.stop
        assert session.set({K_P: 4e5}) >= first
        session.undo()
        assert session.info["scenario"] == session.info["base"]
        assert len(session.latest().ticks) == session.info["tick"]
        with pytest.raises(ServerRefused, match="paused: play"):
            session.record(*ERRORS, seconds=0.1)
        with pytest.raises(motionlab.ConfigError, match=r"seconds: is out of range; got nan"):
            session.record(*ERRORS, seconds=float("nan"))
        with pytest.raises(motionlab.ConfigError, match=r"channels: no channel.*'B\.x\.error'"):
            session.record("B.x.error", seconds=0.1, speed=1.0)
    with pytest.raises(ServerRefused, match="no session"):
        _ = session.info


def test_a_stream_follows_changes_and_ends_with_the_stop(lab: motionlab.Client) -> None:
    with lab.session("circle") as session:
        session.play(10.0)
        session.push("x", 2.0)
        blocks = session.stream("B.x.velocity", from_tick=0)
        some = list(itertools.islice(blocks, 3))
        for before, after in itertools.pairwise(some):
            assert after.first == before.ticks.stop
        assert set(session.metrics()) >= {"variants", "comparison"}
        session.stop()
        rest = list(blocks)
        assert abs(rest[-1]["B.x.velocity"][-1]) < 1e-3
        assert rest[-1].ticks.stop == session.info["tick"]
        again = list(session.stream("B.x.velocity", from_tick=0))
        assert (again[0].first, again[-1].ticks.stop) == (0, rest[-1].ticks.stop)
        with pytest.raises(ServerRefused, match="frame_ticks: Input should be greater"):
            next(session.stream("B.x.velocity", frame_ticks=0))
        session.reset()
        session.step(5)
        assert session.info["tick"] == 5


def test_a_stream_ends_with_its_session(lab: motionlab.Client) -> None:
    session = lab.session("circle")
    session.play()
    for number, _ in enumerate(session.stream(*ERRORS)):
        if number == 2:
            lab._server.call("DELETE", session._path)
    with pytest.raises(ServerRefused, match="no session"):
        _ = session.info


def test_refusals_name_the_field_as_here(lab: motionlab.Client) -> None:
    with pytest.raises(motionlab.ConfigError, match=r"plant\.x\.mass: is out of range; got 0"):
        lab.run("circle", {"plant.x.mass": 0})
    with pytest.raises(motionlab.ConfigError, match=r"thrust on y at t = "):
        lab.run("circle", {"trajectory.frequency": 5.0})
    with pytest.raises(motionlab.ConfigError, match="url: is no address"):
        motionlab.Client("127.0.0.1:8000")
    with pytest.raises(ServerRefused, match="does not answer"):
        motionlab.Client("http://127.0.0.1:9").run()


def test_a_token_is_presented_to_calls_and_streams() -> None:
    server = Server(Settings(token="a-token-of-some-length"))
    try:
        with pytest.raises(ServerRefused, match="MOTIONLAB_TOKEN"):
            motionlab.Client(server.url).runs()
        with motionlab.Client(server.url, "a-token-of-some-length").session() as session:
            assert len(session.record(*ERRORS, seconds=0.01, speed=1.0).time) == 20
    finally:
        server.stop()
