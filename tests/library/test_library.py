"""The library of runs: kept, finished, changed, evicted, removed."""

from __future__ import annotations

import time
from pathlib import Path

import numpy as np
import pytest
from pyarrow import parquet

from motionlab.config.load import load_scenario
from motionlab.errors import Busy, ConfigError, StoreError, StoreFull, Unknown
from motionlab.library import library as library_module
from motionlab.library import spool
from motionlab.library.library import Library
from motionlab.library.new_run import live_run
from motionlab.library.run import Event, RunDetail, new_id
from motionlab.library.spool import Spool
from motionlab.library.telemetry import recording
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document, metadata
from motionlab.simulation.run import run as simulate
from motionlab.telemetry import recorder
from motionlab.telemetry.channels import stream_columns
from tests.simulated import SHORT


@pytest.fixture(scope="module")
def simulated():
    prepared = prepare(load_scenario("circle", SHORT | {"plant.x.mass": 6.0}))
    recording = simulate(prepared)
    return prepared, recording, document(prepared, recording)


def keep(library: Library, simulated, **options) -> RunDetail:
    return library.keep(*simulated, **options)


def spooled(library: Library, simulated, ticks: int = 4000, *, complete: bool = True) -> str:
    """Leave what a server records of a session."""
    prepared, samples, _ = simulated
    run = live_run(prepared.scenario, new_id(), time.time())
    channels = stream_columns(list(prepared.scenario.variants))
    recorded = Spool(library.spools, run, channels, metadata(prepared.scenario))
    columns = np.stack([values for _, _, values in recorder.columns(samples)])
    for first in range(0, ticks, 500):
        recorded.append(first, columns[:, first : first + 500])
    recorded.note(Event(tick=700, kind="push", axis="x", force=2.0, ticks=100))
    library.index.put(run)
    if complete:
        recorded.end(complete=True)
    else:
        recorded.close()
    return run.id


def test_a_simulation_is_kept_as_it_was(library: Library, simulated) -> None:
    _, samples, result = simulated
    kept = keep(library, simulated, name="stiff")
    assert library.complete(kept.id) == kept
    assert (kept.name, kept.kind, kept.state, kept.seed) == (
        "stiff",
        "simulation",
        "complete",
        2019,
    )
    assert kept.result == result
    assert "plant.x.mass" in [each.path for each in kept.differences]
    assert kept.metrics["B.x.max_abs_following_error"] > 0
    assert kept.ticks == samples.ticks
    assert set(kept.thumbnail) == {"reference", "A", "B"}
    with library.files.open(kept.id) as file:
        back = recording(file, kept.variants, 100, 300)
    assert back.first_tick == samples.first_tick + 100
    for name, record in samples.variants.items():
        assert np.array_equal(back.variants[name].samples, record.samples[..., 100:300])
    assert list(library.spools.iterdir()) == []


def test_what_a_session_recorded_becomes_a_run(library: Library, simulated) -> None:
    run_id = spooled(library, simulated)
    library.change(run_id, {"tags": ["rig"], "note": "while it was recorded", "pinned": True})
    kept = library.finish(run_id)
    assert kept is not None
    assert library.get(run_id) == kept
    assert (kept.state, kept.reason, kept.ticks, kept.duration) == ("complete", "", 4000, 2.0)
    assert (kept.tags, kept.note, kept.pinned) == (["rig"], "while it was recorded", True)
    assert [event.kind for event in kept.events] == ["push"]
    assert kept.metrics
    assert spool.waiting(library.spools) == []
    assert library.finish(run_id) is None


def test_a_change_while_a_recording_is_made_a_run_stays(
    library: Library, simulated, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = spooled(library, simulated)
    put = library.files.put

    def put_late(name: str, part: Path) -> int:
        library.change(name, {"tags": ["rig"], "note": "just now", "pinned": True})
        return put(name, part)

    monkeypatch.setattr(library.files, "put", put_late)
    kept = library.finish(run_id)
    assert kept is not None
    assert library.get(run_id) == kept
    assert (kept.state, kept.tags, kept.note) == ("complete", ["rig"], "just now")
    assert (kept.pinned, kept.kept) == (True, True)


def test_what_a_killed_server_left_is_partial_and_opens_without_being_asked_for(
    library: Library, simulated
) -> None:
    run_id = spooled(library, simulated, complete=False)
    assert library.get(run_id).state == "recording"
    opened = library.complete(run_id)
    assert opened.state == "partial"
    assert "cut off" in opened.reason
    other = spooled(library, simulated, complete=False)
    assert library.recover() == [other]
    assert library.recover() == []


def test_a_run_that_is_being_recorded_is_busy(library: Library, simulated) -> None:
    run_id = spooled(library, simulated, complete=False)
    with spool.claimed(library.spools, run_id):
        with pytest.raises(Busy, match="is being recorded"):
            library.complete(run_id)
        with pytest.raises(Busy):
            library.delete(run_id)
        assert library.recover() == []


def test_nothing_recorded_is_no_run(library: Library, simulated) -> None:
    run_id = spooled(library, simulated, ticks=0)
    assert library.recover() == []
    assert spool.waiting(library.spools) == []
    with pytest.raises(Unknown):
        library.get(run_id)


def test_metrics_after_a_gap_are_of_what_came_after_it(library: Library, simulated) -> None:
    prepared, samples, _ = simulated
    run = live_run(prepared.scenario, new_id(), time.time())
    channels = stream_columns(list(prepared.scenario.variants))
    recorded = Spool(library.spools, run, channels, metadata(prepared.scenario))
    columns = np.stack([values for _, _, values in recorder.columns(samples)])
    recorded.append(0, columns[:, :1000])
    recorded.append(3000, columns[:, 3000:4000])
    recorded.note(Event(tick=1000, kind="gap", ticks=2000, reason="the disk was full"))
    recorded.end(complete=True)
    kept = library.finish(run.id)
    assert kept is not None
    assert (kept.state, kept.reason) == ("partial", "1 s are missing: the disk was full")
    assert kept.ticks == 4000
    assert all(value is not None and np.isfinite(value) for value in kept.metrics.values())
    assert kept.result["window"] == {"start": 1.5, "end": 2.0}
    with library.files.open(kept.id) as file:
        back = recording(file, kept.variants, 0, kept.ticks)
    assert all(record.diverged is None for record in back.variants.values())
    assert np.isnan(back.variants["A"].channel("position", "x")[1000:3000]).all()


def test_metrics_end_at_a_stop(library: Library, simulated) -> None:
    prepared, samples, _ = simulated
    run = live_run(prepared.scenario, new_id(), time.time())
    channels = stream_columns(list(prepared.scenario.variants))
    recorded = Spool(library.spools, run, channels, metadata(prepared.scenario))
    columns = np.stack([values for _, _, values in recorder.columns(samples)])
    recorded.append(0, columns[:, :4000])
    recorded.note(Event(tick=3000, kind="stop"))
    recorded.end(complete=True)
    kept = library.finish(run.id)
    assert kept is not None
    assert kept.ticks == 4000
    assert kept.result["window"] == {"start": 0.0, "end": 1.5}


def test_deletion_and_its_end(library: Library, simulated, monkeypatch: pytest.MonkeyPatch) -> None:
    kept, restored = keep(library, simulated), keep(library, simulated)
    for run in (kept, restored):
        library.delete(run.id)
        with pytest.raises(Unknown, match="deleted"):
            library.complete(run.id)
        with pytest.raises(Unknown):
            library.delete(run.id)
    deletions = library.index.deleted()
    library.restore(restored.id)
    library.purge()
    assert library.files.names() == sorted([kept.id, restored.id])
    library.purge(*deletions)
    assert library.files.names() == [restored.id]
    with pytest.raises(Unknown):
        library.restore(kept.id)
    assert library.complete(restored.id).deleted is None


def automatic(library: Library, simulated, **changes) -> RunDetail:
    """Keep what the lab records by itself."""
    prepared, samples, result = simulated
    run = live_run(prepared.scenario, new_id(), time.time())
    run = run.model_copy(update={"state": "complete", "ticks": samples.ticks, "result": result})
    about = metadata(prepared.scenario)
    kept = library.keep_file(run, lambda part: recorder.write(samples, part, metadata=about))
    return library.change(kept.id, changes) if changes else kept


@pytest.mark.parametrize(
    "change", [{"pinned": True}, {"name": "mine"}, {"note": "odd"}, {"tags": ["rig"]}]
)
def test_what_a_person_keeps_is_not_evicted_by_what_the_lab_records(
    library: Library, simulated, monkeypatch: pytest.MonkeyPatch, change: dict, caplog
) -> None:
    by_hand = [keep(library, simulated, name="kept"), automatic(library, simulated, **change)]
    by_itself = [automatic(library, simulated) for _ in range(3)]
    size = by_hand[0].size
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", str(int(4.5 * size)))
    library.room.balance()
    by_itself.append(automatic(library, simulated))
    left = [*by_hand, *by_itself[2:]]
    assert library.files.names() == sorted(run.id for run in left)
    gone = library.index.evictions(10)
    assert [each.run for each in gone] == [by_itself[1].id, by_itself[0].id]
    assert all(f"{each.run} {each.name!r} was evicted" in caplog.text for each in gone)
    for _ in range(2):
        keep(library, simulated)
    before = library.files.names()
    assert set(before) > {run.id for run in by_hand}
    for kept in (keep, automatic):
        with pytest.raises(StoreFull, match=r"kept or pinned take \d+, .*: delete some"):
            kept(library, simulated)
    assert library.files.names() == before
    assert list(library.spools.iterdir()) == []
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", "10 GB")
    with pytest.raises(ConfigError, match="MOTIONLAB_RUNS_MAX"):
        keep(library, simulated)


def test_a_change_that_names_nothing_keeps_nothing(library: Library, simulated) -> None:
    run = automatic(library, simulated)
    for change in ({"tags": []}, {"note": ""}, {"deleted": None}, {"pinned": False}):
        assert not library.change(run.id, change).kept
    assert library.change(run.id, {"note": "odd"}).kept
    assert library.change(run.id, {"note": ""}).kept


def test_recordings_count_and_are_made_runs_where_kept_ones_leave_little(
    library: Library, simulated, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = spooled(library, simulated)
    recorded = library.room.recorded()
    assert recorded > 100_000
    old = automatic(library, simulated)
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", str(recorded + old.size // 2))
    assert library.room.balance(run_id) == recorded + old.size // 2
    assert library.files.names() == []
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", str(recorded))
    finished = library.finish(run_id)
    assert finished is not None
    assert not finished.kept
    assert library.room.recorded() == 0


def test_a_nearly_full_disk_refuses(
    library: Library, simulated, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(library_module, "FREE_LEAST", 1 << 62)
    with pytest.raises(StoreFull, match="nearly full"):
        keep(library, simulated)
    assert library.files.names() == []
    run_id = spooled(library, simulated)
    assert library.finish(run_id) is not None  # it is on the disk already, and becomes smaller


def test_a_recording_beyond_the_quota_waits_until_there_is_room(
    library: Library, simulated, monkeypatch: pytest.MonkeyPatch
) -> None:
    run_id = spooled(library, simulated)
    monkeypatch.setenv("MOTIONLAB_RUNS_MAX", "1000")
    assert library.recover() == []
    assert spool.waiting(library.spools) == [run_id]
    monkeypatch.delenv("MOTIONLAB_RUNS_MAX")
    assert library.recover() == [run_id]


def test_telemetry_that_is_damaged_or_gone_is_said_without_a_path(
    library: Library, simulated
) -> None:
    run_id = keep(library, simulated).id
    place = Path(library.files.path(run_id))
    if not place.is_file():
        pytest.skip("its telemetry is no file of this machine")

    for damage, reason in (
        (lambda: place.write_bytes(place.read_bytes()[:1000]), "Parquet magic bytes not found"),
        (lambda: place.write_bytes(b""), "Parquet file size is 0 bytes"),
        (place.unlink, "its file is missing"),
        (place.mkdir, "its file"),
    ):
        damage()
        with pytest.raises(StoreError, match=reason) as caught:
            library.files.open(run_id)
        assert str(place.parent) not in str(caught.value)


def test_telemetry_on_another_disk(tmp_path: Path, simulated, monkeypatch) -> None:
    other = Path("/dev/shm")
    if not other.is_dir() or other.stat().st_dev == tmp_path.stat().st_dev:
        pytest.skip("no other file system to write to")
    folder = other / f"motionlab-{new_id()}"
    monkeypatch.setenv("MOTIONLAB_RUNS_URL", str(folder))
    library = Library(tmp_path / "data")
    try:
        kept = keep(library, simulated)
        with library.files.open(kept.id) as file:
            assert file.metadata.num_rows == kept.ticks
        assert parquet.read_metadata(folder / f"{kept.id}.parquet").num_rows == kept.ticks
        assert [path.name for path in folder.iterdir()] == [f"{kept.id}.parquet"]
    finally:
        library.close()
        for path in folder.iterdir():
            path.unlink()
        folder.rmdir()


def test_an_address_of_telemetry_that_is_none_tells_no_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for address in ("s3://KEY:secret@/", "nowhere://KEY:secret@bucket", "nowhere://bucket"):
        monkeypatch.setenv("MOTIONLAB_RUNS_URL", address)
        with pytest.raises(ConfigError, match="MOTIONLAB_RUNS_URL") as refused:
            Library(tmp_path)
        assert "secret" not in str(refused.value)
