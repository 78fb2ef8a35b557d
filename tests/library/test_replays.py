"""Many runs simulated again: which have moved, by how much and why."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest
from pyarrow import parquet

from motionlab.cli.main import main
from motionlab.exchange.measurements.document import ImportOptions
from motionlab.exchange.measurements.runs import import_file
from motionlab.library import replays as module
from motionlab.library.library import library
from motionlab.library.replay import Again, Replay, again
from motionlab.library.replays import Replays, replay_all
from motionlab.library.search import parse
from tests.library.test_replay import altered, begun, ended, keep, rewrite
from tests.server.live import Live

__all__ = ["begun"]  # a fixture
MASS = "plant.x.mass"


def tagged(run_id: str, tag: str) -> None:
    library().change(run_id, {"tags": [tag]})


def tagged_replays(tag: str) -> Replays:
    return replay_all(library(), parse(f"tag:{tag}"))


def test_runs_of_every_kind(client: httpx.Client, tmp_path: Path) -> None:
    simulated = keep({"seed": 11})
    live = Live.create(client)
    live.step(900)
    live.change({MASS: 7.0})
    live.step(900)
    session = ended(live)
    file = tmp_path / "rig.csv"
    rows = [f"{k / 1000},{k * 1e-6},{k * 1e-6 - 1e-7}" for k in range(20)]
    file.write_text("time [s],x_ref [m],x [m]\n" + "\n".join(rows))
    _, measured = import_file(file, ImportOptions(), library=library(), name="rig")
    assert measured is not None
    for run in (simulated, session, measured):
        tagged(run.id, "every-kind")
    found = tagged_replays("every-kind")
    assert {run.run: run.outcome for run in found.runs} == {
        simulated.id: "identical",
        session.id: "identical",
        measured.id: "not replayable",
    }
    assert (found.total, found.identical, found.moved, found.not_replayable) == (3, 2, 0, 1)
    assert not found.interrupted
    refused = next(run for run in found.runs if run.run == measured.id)
    assert refused.reasons == [f"{measured.id} has no scenario: there is nothing to simulate again"]


@pytest.mark.parametrize("error", [MemoryError(), pa.ArrowMemoryError("malloc failed")])
def test_a_run_that_takes_too_much_memory_leaves_the_others_results(
    monkeypatch: pytest.MonkeyPatch, error: MemoryError
) -> None:
    large, small = keep({"seed": 19}), keep({"seed": 20})
    tag = f"memory-{type(error).__name__}"
    for run in (large, small):
        tagged(run.id, tag)
    whole = module.replay

    def replayed(prepared: Again, *others: Any) -> Replay:
        if prepared.run.id == large.id:
            raise error
        return whole(prepared, *others)

    monkeypatch.setattr(module, "replay", replayed)
    runs = {run.run: run for run in tagged_replays(tag).runs}
    assert runs[small.id].outcome == "identical"
    assert runs[large.id].outcome == "not replayable"
    assert "more memory" in runs[large.id].reasons[0]


def test_a_moved_run_has_the_size_of_its_move_in_the_window_of_its_metrics() -> None:
    kept = keep({"seed": 12})
    tagged(kept.id, "one-moved")
    start, end = again(kept).prepared.window
    errors = np.asarray(
        parquet.read_table(library().files.path(kept.id))["B.y.following_error"], dtype=float
    )[start:end]
    peak = start + int(np.argmax(np.abs(errors)))
    higher = float(np.float32(np.abs(errors).max() + 3e-6))
    rewrite(kept, lambda table: altered(table, peak, "B.y.following_error", higher))
    (run,) = tagged_replays("one-moved").runs
    assert (run.outcome, run.samples) == ("moved", 1)
    assert run.first is not None
    assert (run.first.tick, run.first.channel) == (peak, "B.y.following_error")
    by_axis = {(each.variant, each.axis): each for each in run.errors}
    assert set(by_axis) == {(v, a) for v in "AB" for a in "xy"}
    moved = by_axis.pop(("B", "y"))
    assert moved.max_recorded == higher
    assert moved.max_simulated == pytest.approx(np.abs(errors).max(), rel=1e-12)
    assert run.change == pytest.approx(3e-6, rel=1e-6)
    assert moved.rms_simulated == pytest.approx(np.sqrt(np.mean(errors**2)), rel=1e-12)
    # The simulated figures are those that the run was kept with.
    key = "B.y.max_abs_following_error"
    assert moved.max_simulated == pytest.approx(kept.metrics[key], rel=1e-6)
    assert all(each.max_change == each.rms_change == 0.0 for each in by_axis.values())


def test_a_run_of_another_model_has_moved_with_the_model_as_the_reason() -> None:
    """Its record is that of a motor that was heavier; those that moved most come first."""
    nominal = keep({"seed": 13})
    far, near = keep({MASS: 9.0, "seed": 13}), keep({MASS: 6.0, "seed": 13})
    for run in (far, near):
        document = nominal.scenario_document
        other = {"scenario_document": document, "version": "0.0.1", "model": "older"}
        library().index.put(run.model_copy(update=other))
        tagged(run.id, "older")
    found = tagged_replays("older")
    assert [run.run for run in found.runs] == [far.id, near.id]
    assert found.moved == 2
    for run, kept in zip(found.runs, (far, near), strict=True):
        assert [reason.split(":")[0] for reason in run.reasons] == [
            "other version",
            "other model's sources",
        ]
        change = next(e for e in run.errors if (e.variant, e.axis) == ("A", "x"))
        key = "A.x.max_abs_following_error"
        expected = nominal.metrics[key] - kept.metrics[key]
        assert change.max_change == pytest.approx(expected, rel=1e-4, abs=1e-12)
    assert (found.runs[0].change or 0.0) > (found.runs[1].change or 0.0) > 0.0


def test_a_variant_that_no_longer_diverges_comes_first() -> None:
    kept, other = keep({"seed": 14}), keep({"seed": 15})
    rewrite(kept, lambda table: altered(table, kept.ticks - 1, "A.x.following_error", math.nan))
    rewrite(other, lambda table: altered(table, 100, "A.x.following_error", 1.0))
    for run in (kept, other):
        tagged(run.id, "diverges")
    first, second = tagged_replays("diverges").runs
    assert (first.run, second.run) == (kept.id, other.id)
    assert first.change is None
    diverged = next(each for each in first.errors if (each.variant, each.axis) == ("A", "x"))
    assert (diverged.max_recorded, diverged.max_change) == (None, None)
    assert diverged.max_simulated == pytest.approx(kept.metrics["A.x.max_abs_following_error"])


def test_a_record_that_lacks_ticks_or_can_no_longer_be_read() -> None:
    short, damaged, gone = keep({"seed": 16}), keep({"seed": 17}), keep({"seed": 18})
    rewrite(short, lambda table: table.slice(0, short.ticks - 10))
    path = Path(library().files.path(damaged.id))
    content = bytearray(path.read_bytes())
    content[1000:60_000] = bytes(59_000)
    path.write_bytes(content)
    Path(library().files.path(gone.id)).unlink()
    for run in (short, damaged, gone):
        tagged(run.id, "records")
    found = {run.run: run for run in tagged_replays("records").runs}
    assert found[short.id].outcome == "identical"
    for run in (damaged, gone):
        assert found[run.id].outcome == "not replayable"
        assert len(found[run.id].reasons) == 1


def test_an_interruption_keeps_what_is_known(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    runs = [keep({"seed": seed}) for seed in (21, 22, 23)]
    for run in runs:
        tagged(run.id, "interrupted")
    replay, begun = module.replay, []

    def interrupted(*arguments: Any) -> Any:
        begun.append(arguments[0].run.id)
        if len(begun) == 2:
            raise KeyboardInterrupt
        return replay(*arguments)

    monkeypatch.setattr(module, "replay", interrupted)
    assert main(["replay", "--all", "tag:interrupted"]) == 130
    expected = "interrupted: 1 of 3 runs, 1 identical, 0 moved, 0 cannot be simulated again\n"
    assert capsys.readouterr().out == expected
    begun.clear()
    assert main(["replay", "--all", "tag:interrupted", "--json"]) == 130
    found = json.loads(capsys.readouterr().out)
    assert (found["interrupted"], found["total"], len(found["runs"])) == (True, 3, 1)


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept = keep({"seed": 31})
    tagged(kept.id, "commanded")
    assert main(["replay", "--all", "tag:commanded"]) == 0
    out = capsys.readouterr().out
    assert out == "1 run, 1 identical, 0 moved, 0 cannot be simulated again\n"
    table = parquet.read_table(library().files.path(kept.id))
    peak = float(pc.max(pc.abs(table["B.x.following_error"])).as_py())  # pyright: ignore
    tick = again(kept).prepared.window[0]
    rewrite(kept, lambda table: altered(table, tick, "B.x.following_error", 2 * peak + 1e-5))
    assert main(["replay", "--all", "tag:commanded"]) == 1
    out = capsys.readouterr().out
    assert kept.id in out
    assert f"B.x.following_error at {tick * 0.0005:.4f} s" in out
    assert f"B.x -{1e6 * (peak + 1e-5):.3g} um" in out
    assert "none is known: version, model, processor and maps are the same" in out
    assert out.endswith("1 run, 0 identical, 1 moved, 0 cannot be simulated again\n")
    assert main(["replay", "--all", "tag:commanded", "--json"]) == 1
    found = Replays.model_validate_json(capsys.readouterr().out)
    assert [run.outcome for run in found.runs] == ["moved"]
    assert main(["replay", "--all", "tag:none-has-it"]) == 0
    assert capsys.readouterr().out.startswith("0 runs")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([], "RUN: names no single run"),
        (["r-aaaaaaaaaaaa", "r-bbbbbbbbbbbb"], "RUN: names no single run"),
        (["--all", "tga:rig"], "TERM: no such key, did you mean"),
        (["--all", "B.x.max<3kg"], "3kg"),
    ],
)
def test_bad_input(arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["replay", *arguments]) == 2
    assert message in capsys.readouterr().err
