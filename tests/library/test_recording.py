"""Live sessions are recorded while they happen, whatever becomes of their server and its disk."""

from __future__ import annotations

import os
import random
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from pyarrow import parquet

from motionlab.cli import main
from motionlab.library.database import index_url
from motionlab.library.index import Index
from motionlab.library.run import RunDetail
from tests.library.served import API, PATIENCE, Served, serve
from tests.library.test_spool import small_disk

SECOND = 2000  # ticks


@pytest.fixture
def served(tmp_path: Path) -> Iterator[Served]:
    served = Served(tmp_path / "data")
    yield served
    served.kill()


def until(holds: Any) -> None:
    end = time.monotonic() + PATIENCE
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def listed(data: Path, run_id: str | None) -> RunDetail | None:
    """Return what the index has of a run, read without a server."""
    index = Index(index_url(data))
    run = None if run_id is None else index.get(run_id)
    index.close()
    return run


def kept(data: Path, run_id: str) -> tuple[RunDetail, dict[str, NDArray[Any]]]:
    """Return a run and its samples, read without a server."""
    run = listed(data, run_id)
    assert run is not None
    table = parquet.read_table(data / "runs" / f"{run_id}.parquet")
    return run, {name: table[name].to_numpy() for name in table.column_names}


def differing(served: Served) -> dict[str, Any]:
    """Return what the list says of the only run: fields that are not the shipped ones."""
    (run,) = served.runs()
    return {each["path"]: each["value"] for each in run["differences"]}


def test_a_session_is_recorded_with_all_that_was_done_to_it(served: Served, tmp_path: Path) -> None:
    client = served.client
    answer = client.post(f"{API}/sessions", json={}).raise_for_status()
    path = answer.headers["location"]
    changed = {"set": {"plant.x.mass": 6.0}}
    client.patch(f"{path}/parameters", json=changed).raise_for_status()
    assert served.session(path)["run"] is None
    assert served.runs() == []  # nothing has been played
    client.post(f"{path}/step", json={"ticks": 3000}).raise_for_status()
    run_id = served.session(path)["run"]
    begun = client.get(f"{API}/runs/{run_id}")  # at once: it waits for the index
    assert begun.status_code == 200, begun.text
    assert [run["id"] for run in served.runs("state:recording")] == [run_id]
    until(lambda: differing(served) == {"plant.x.mass": 6.0})
    assert client.get(f"{API}/runs/{run_id}/window?columns=A.x.position").status_code == 409
    push = {"axis": "y", "force": 2.0, "duration": 0.05}
    assert client.post(f"{path}/push", json=push).json()["tick"] == 3000
    changed = {"set": {"plant.y.mass": 7.0}}
    client.patch(f"{path}/parameters", json=changed).raise_for_status()
    until(lambda: differing(served) == {"plant.x.mass": 6.0, "plant.y.mass": 7.0})
    client.post(f"{path}/undo").raise_for_status()
    until(lambda: differing(served) == {"plant.x.mass": 6.0})
    client.post(f"{path}/step", json={"ticks": 20000}).raise_for_status()
    named = {"name": "while it runs", "tags": ["rig"]}
    client.patch(f"{API}/runs/{run_id}", json=named).raise_for_status()
    telemetry = client.get(f"{path}/telemetry?format=parquet").raise_for_status().content
    client.post(f"{path}/reset").raise_for_status()
    assert served.session(path)["run"] is None
    (run,) = served.settled()
    assert (run["id"], run["state"], run["ticks"]) == (run_id, "complete", 23000)
    assert (run["name"], run["tags"]) == ("while it runs", ["rig"])
    assert differing(served) == {"plant.x.mass": 6.0}
    detail, columns = kept(tmp_path / "data", run_id)
    assert [(e.kind, e.tick) for e in detail.events] == [
        ("change", 0),
        ("push", 3000),
        ("change", 3000),
        ("change", 3000),
    ]
    assert detail.events[0].set == {"plant.x.mass": 6.0}
    assert detail.events[0].previous == {"plant.x.mass": pytest.approx(5.8, abs=5.0)}
    (tmp_path / "ring.parquet").write_bytes(telemetry)
    ring = parquet.read_table(tmp_path / "ring.parquet")
    for name in ring.column_names:
        assert np.array_equal(columns[name], ring[name].to_numpy(), equal_nan=True), name
    client.post(f"{path}/step", json={"ticks": 100}).raise_for_status()
    assert served.session(path)["run"] not in {None, run_id}
    client.delete(path).raise_for_status()
    until(lambda: [r["ticks"] for r in served.runs()] == [100, 23000])


def test_a_pause_writes_everything_and_ten_times_real_time_loses_nothing(
    served: Served, tmp_path: Path
) -> None:
    path = served.play(10.0)
    time.sleep(4)
    served.client.post(f"{path}/pause").raise_for_status()
    tick = served.session(path)["tick"]
    run_id = served.session(path)["run"]
    time.sleep(1)
    served.kill()
    assert main_in(tmp_path, "runs") == 0
    run, columns = kept(tmp_path / "data", run_id)
    assert (run.state, run.ticks, run.events) == ("partial", tick, [])
    assert np.array_equal(columns["tick"], np.arange(tick))
    assert not np.isnan(columns["x.position_reference"]).any()


def main_in(folder: Path, *arguments: str) -> int:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("MOTIONLAB_DATA", str(folder / "data"))
        return main(list(arguments))


def ended(data: Path, run_id: str) -> bool:
    """Tell whether a run is in the index as one that is recorded no more."""
    run = listed(data, run_id)
    return run is not None and run.state != "recording"


def test_stop_and_server_end_are_complete_ends(tmp_path: Path) -> None:
    served = Served(tmp_path / "data")
    stopped, going_on = served.play(), served.play()
    time.sleep(1.0)
    served.client.post(f"{stopped}/stop").raise_for_status()
    until(lambda: served.session(stopped)["state"] == "stopped")
    until(lambda: [run["state"] for run in served.runs("state:complete")] == ["complete"])
    ids = [served.runs("state:complete")[0]["id"], served.session(going_on)["run"]]
    served.end()
    # What takes the server longer than it has becomes a run with the next command, once the worker
    # that was at it is gone.
    until(lambda: main_in(tmp_path, "runs") == 0 and all(ended(tmp_path / "data", i) for i in ids))
    for run_id, events, by in zip(ids, [["stop"], []], ["STOP", ""], strict=True):
        run, columns = kept(tmp_path / "data", run_id)
        assert (run.state, run.reason, run.stopped) == ("complete", "", by)
        assert [event.kind for event in run.events] == events
        assert np.array_equal(columns["tick"], np.arange(run.ticks))


def test_a_killed_server_loses_less_than_a_second_and_no_other_run(tmp_path: Path) -> None:
    data = tmp_path / "data"
    chance = random.Random(11)
    sizes: dict[str, tuple[int, int]] = {}  # ticks, bytes
    for _ in range(4):
        served = Served(data)
        before = {run["id"]: run["ticks"] for run in served.settled()}
        assert before == {run_id: ticks for run_id, (ticks, _) in sizes.items()}
        path = served.play()
        until(lambda path=path, served=served: listed(data, served.session(path)["run"]))
        time.sleep(chance.uniform(0.0, 3.0))
        session = served.session(path)
        served.kill()
        assert main_in(tmp_path, "runs") == 0
        run, columns = kept(data, session["run"])
        assert run.state == "partial"
        assert run.ticks > session["tick"] - SECOND
        assert np.array_equal(columns["tick"], np.arange(run.ticks))
        for other, (ticks, size) in sizes.items():
            assert kept(data, other)[0].ticks == ticks
            assert (data / "runs" / f"{other}.parquet").stat().st_size == size
        sizes[run.id] = (run.ticks, (data / "runs" / f"{run.id}.parquet").stat().st_size)


def test_a_full_disk_leaves_a_gap_and_the_session_goes_on(tmp_path: Path) -> None:
    with small_disk(tmp_path / "data", "size=300m") as data:
        served = Served(data, NUMBA_CACHE_DIR=os.environ.get("NUMBA_CACHE_DIR", ""))
        path = served.play()
        until(lambda: served.session(path)["tick"] > 1000)
        filler = data / "filler"
        with filler.open("wb") as file:
            os.posix_fallocate(file.fileno(), 0, 150_000_000)
        until(lambda: served.session(path)["unrecorded"])
        assert "No space" in served.session(path)["unrecorded"]
        tick = served.session(path)["tick"]
        change = {"set": {"plant.x.mass": 6.0}}
        changed = served.client.patch(f"{path}/parameters", json=change).json()["tick"]
        until(lambda: served.session(path)["tick"] > tick + SECOND)
        keep = {"set": {"trajectory.laps": 1}, "keep": True}
        assert served.client.post(f"{API}/simulate", json=keep).status_code == 507
        filler.unlink()
        until(lambda: not served.session(path)["unrecorded"])
        tick = served.session(path)["tick"]
        until(lambda: served.session(path)["tick"] > tick + 100)
        served.client.delete(path).raise_for_status()
        (listed,) = served.settled()
        assert listed["state"] == "partial"
        assert "are missing: No space" in listed["reason"]
        served.end()
        run, columns = kept(data, listed["id"])
        assert np.array_equal(columns["tick"], np.arange(run.ticks))
        gap, change_event = run.events
        assert (gap.kind, change_event.kind, change_event.tick) == ("gap", "change", changed)
        assert gap.ticks is not None
        missing = np.isnan(columns["x.position_reference"])
        assert np.array_equal(np.flatnonzero(missing), np.arange(gap.tick, gap.tick + gap.ticks))


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    with small_disk(tmp_path / "data", "size=300m") as data:
        first = Served(data)
        path = first.play()
        until(lambda: first.session(path)["tick"] > 1000)
        first.client.delete(path).raise_for_status()
        first.settled()  # what is no run yet could not become one soon in a read-only folder
        remount = ["mount", "-o", "remount,ro", str(data)]
        # What is open for writing keeps a file system writable, so the server is new; a worker of
        # the one before may have a file open for a moment longer.
        first.end()
        until(lambda: subprocess.run(remount, check=False).returncode == 0)
        told = tmp_path / "told"
        told.mkdir()
        served = Served(told, MOTIONLAB_DATA=str(data))
        path = served.play()
        until(lambda: served.session(path)["unrecorded"])
        assert "Read-only file system" in served.session(path)["unrecorded"]
        tick = served.session(path)["tick"]
        until(lambda: served.session(path)["tick"] > tick + 100)
        subprocess.run([*remount[:2], "remount,rw", str(data)], check=True)
        until(lambda: not served.session(path)["unrecorded"])
        tick = served.session(path)["tick"]
        until(lambda: served.session(path)["tick"] > tick + 100)
        served.client.delete(path).raise_for_status()
        until(lambda: len(served.settled()) == 2)
        assert served.runs()[0]["state"] == "partial"  # its beginning is missing
        served.end()


# -- two servers ----------------------------------------------------------------------------------


def test_the_second_server_of_a_folder_says_so_and_ends(served: Served, tmp_path: Path) -> None:
    environment = os.environ | {"MOTIONLAB_DATA": str(tmp_path / "data")}
    with (tmp_path / "told").open("wb") as stderr:
        assert serve(environment, stderr).wait(PATIENCE) == 2
    (line,) = (tmp_path / "told").read_text().splitlines()
    assert "MOTIONLAB_DATA" in line
    assert "another server uses this folder" in line
    path = served.play()  # the first is none the worse
    until(lambda: served.session(path)["tick"] > 0)
    kept_beside = ["run", "circle", "--set", "trajectory.laps=1", "--keep", "--name", "beside"]
    assert main_in(tmp_path, *kept_beside) == 0
    assert [run["name"] for run in served.runs("beside")] == ["beside"]


def test_the_lock_ends_with_a_killed_server(tmp_path: Path) -> None:
    Served(tmp_path / "data").kill()
    Served(tmp_path / "data").end()
    shutil.rmtree(tmp_path / "data")
