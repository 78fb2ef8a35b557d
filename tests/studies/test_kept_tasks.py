"""Parts of long sweeps are kept: asked again after an end, only the others are computed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from motionlab.executors import kept
from motionlab.studies.sweep import run as module
from motionlab.studies.sweep.request import read_request
from motionlab.studies.sweep.run import plan, run

GRID = [{"path": "variants.B.controller.x.k_p", "start": 1e5, "stop": 1e6, "count": 200}]
SET = {"trajectory.laps": 1}


class _Ended(Exception):
    pass


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    monkeypatch.setattr(module, "KEPT_SECONDS", 1.0)
    return tmp_path / kept.FOLDER


def counted(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Return a list that grows by the cases of each task that is computed."""
    sizes: list[int] = []
    compute = module.run_task

    def run_task(task: Any, progress: Any) -> Any:
        sizes.append(len(task.cases.changes))
        return compute(task, progress)

    monkeypatch.setattr(module, "run_task", run_task)
    return sizes


def test_a_sweep_that_ended_goes_on_where_it_was(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    planned = plan(read_request({"set": SET, "grid": GRID}))
    sizes = counted(monkeypatch)

    def end(share: float, _: Any) -> None:
        if share > 0.7:
            raise _Ended

    with pytest.raises(_Ended):
        run(planned, end)
    first = list(sizes)
    assert 0 < sum(first) and len(list(folder.iterdir())) < len(first) + 1
    sizes.clear()
    shares: list[float] = []
    whole = run(planned, lambda share, _: shares.append(share))
    assert 0 < sum(sizes) < 200
    assert shares[0] > 0.0  # what is there counts
    sizes.clear()
    assert run(planned) == whole
    assert sizes == []
    monkeypatch.setattr(module, "KEPT_SECONDS", 1e9)
    assert run(planned) == whole  # computed anew


def test_a_damaged_part_is_computed_again(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    planned = plan(read_request({"set": SET, "grid": GRID}))
    whole = run(planned)
    good = {path: path.read_bytes() for path in folder.iterdir()}
    for damage in (lambda data: data[:100], lambda data: data[:60] + b"~~" + data[62:]):
        for path, data in good.items():
            path.write_bytes(damage(data))
        assert run(planned) == whole
        assert {path: path.read_bytes() for path in folder.iterdir()} == good  # kept anew


def test_another_question_shares_nothing(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    run(plan(read_request({"set": SET, "grid": GRID})))
    sizes = counted(monkeypatch)
    other = run(plan(read_request({"set": SET | {"seed": 2}, "grid": GRID})))
    assert sum(sizes) == 200 and other.seed == 2


def test_the_oldest_go_when_there_is_no_room(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    folder.mkdir(parents=True)
    old, new = folder / "old.npz", folder / "new.npz"
    for age, path in ((50, old), (100, new)):
        path.write_bytes(bytes(1000))
        os.utime(path, (age, age))
    monkeypatch.setattr(kept, "FOLDER_MOST", 1500)
    kept._make_room(folder)
    assert not old.exists() and new.exists()
