"""The thread that writes recordings outlives whatever goes wrong with one of them."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path
from typing import Any

import httpx
import pytest

from motionlab.config.named_configs import data_root
from motionlab.library.library import spools
from motionlab.library.spool import Spool
from motionlab.server.live import run_recorder
from motionlab.server.settings import Settings
from tests.server.conftest import MakeLive, MakeServer
from tests.server.live import API, Live, until


def test_a_run_whose_recording_was_removed_says_so(
    client: httpx.Client, make_live: MakeLive
) -> None:
    live, other = make_live(), make_live()
    for each in (live, other):
        each.do("play")
    run, whole = recorded(live), recorded(other)
    until(lambda: size(run) > 0)
    shutil.rmtree(spools(data_root()) / run)
    until(lambda: "its file was removed" in live.info()["unrecorded"])

    def entry() -> dict[str, Any]:
        return client.get(f"{API}/runs/{run}").json()

    until(lambda: entry()["state"] == "partial")  # while its session goes on
    assert entry()["reason"] == "unrecorded: its recording was removed from the folder of the data"
    assert entry()["ticks"] == 0
    (listed,) = (each for each in client.get(f"{API}/runs").json()["runs"] if each["id"] == run)
    assert (listed["state"], listed["reason"]) == ("partial", entry()["reason"])
    assert client.get(f"{API}/runs/{whole}").json()["state"] == "recording"
    live.do("reset")
    other.do("reset")
    until(lambda: client.get(f"{API}/runs/{whole}").json()["state"] == "complete")
    assert entry()["state"] == "partial"
    answer = client.get(f"{API}/runs/{run}/telemetry", params={"format": "csv"})
    told = f"the telemetry of {run} cannot be read: its file is missing"
    assert (answer.status_code, answer.json()["detail"]) == (404, told)
    assert client.delete(f"{API}/runs/{run}").status_code < 300


def size(run: str) -> int:
    return sum(file.stat().st_size for file in (spools(data_root()) / run).glob("samples*"))


def recorded(live: Live) -> str:
    until(lambda: live.info()["run"] is not None)
    run: str = live.info()["run"]
    until((spools(data_root()) / run).is_dir)
    return run


def test_a_folder_that_has_gone_is_said_once(
    make_server: MakeServer,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
) -> None:
    looked: list[Path] = []

    def has_spools(root: Path) -> bool:
        looked.append(root)
        return original(root)

    original = run_recorder._has_spools
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "gone"))
    monkeypatch.setattr(run_recorder, "_TIDY_PERIOD", 0.01)
    monkeypatch.setattr(run_recorder, "_has_spools", has_spools)
    with caplog.at_level(logging.WARNING):
        make_server(Settings())
        until(lambda: len(looked) > 3)
    said = "runs: the folder of data cannot be used: No such file or directory"
    assert [record.message for record in caplog.records if "runs: " in record.message] == [said]


@pytest.mark.parametrize("error", [ValueError("odd"), RuntimeError("odd"), MemoryError()])
def test_what_fails_for_one_recording_ends_no_other(
    client: httpx.Client,
    make_live: MakeLive,
    monkeypatch: pytest.MonkeyPatch,
    caplog: pytest.LogCaptureFixture,
    error: Exception,
) -> None:
    bad, good = make_live(), make_live()
    for live in (bad, good):
        live.do("play")
    of_bad, of_good = recorded(bad), recorded(good)
    append = Spool.append

    def failing(self: Spool, *arguments: Any) -> None:
        if self.folder.name == of_bad:
            raise error
        append(self, *arguments)

    with monkeypatch.context() as patch, caplog.at_level(logging.WARNING):
        patch.setattr(Spool, "append", failing)
        until(lambda: "the recorder failed" in bad.info()["unrecorded"])
        before = size(of_good)
        until(lambda: size(of_good) > before)
        assert good.info()["unrecorded"] == ""
        assert f"{of_bad} is not being recorded: the recorder failed" in caplog.text
    until(lambda: bad.info()["unrecorded"] == "")
    bad.do("reset")
    until(lambda: client.get(f"{API}/runs/{of_bad}").json()["state"] == "partial")
    run = client.get(f"{API}/runs/{of_bad}").json()
    assert "are missing: the recorder failed" in run["reason"]
    (gap,) = run["events"]
    assert gap["kind"] == "gap"


def test_an_event_that_cannot_be_written_is_named_and_those_after_it_are_kept(
    client: httpx.Client, live: Live, monkeypatch: pytest.MonkeyPatch
) -> None:
    live.do("play")
    run = recorded(live)
    note = Spool.note

    def failing(self: Spool, event: Any) -> None:
        if event.kind == "change":
            raise ValueError("surrogates not allowed: \ud800")
        note(self, event)

    with monkeypatch.context() as patch:
        patch.setattr(Spool, "note", failing)
        live.change({"plant.x.mass": 6.0})
        until(lambda: "a change cannot be written" in live.info()["unrecorded"])
    live.do("push", axis="x", force=1.0, duration=0.05)
    live.do("pause")
    live.do("reset")
    until(lambda: client.get(f"{API}/runs/{run}").json()["state"] == "partial")
    kept = client.get(f"{API}/runs/{run}").json()
    assert kept["reason"].startswith("a change cannot be written")
    assert [event["kind"] for event in kept["events"]] == ["gap", "push"]


def test_a_session_goes_on_where_its_samples_cannot_be_taken(
    live: Live, monkeypatch: pytest.MonkeyPatch, server: Any
) -> None:
    session = server.app.state.sessions.find(live.id)

    def failing(*_: Any) -> None:
        raise MemoryError

    with monkeypatch.context() as patch:
        patch.setattr(type(session.history.ring), "read", failing)
        live.do("play")
        until(lambda: live.tick > 4000)
        assert live.do("stop")["state"] in {"stopping", "stopped"}
        until(lambda: live.state == "stopped")
