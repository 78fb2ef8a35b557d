"""``motionlab export`` and ``motionlab import``."""

from __future__ import annotations

from pathlib import Path

import pytest
import scipy.io

from motionlab.__main__ import main
from motionlab.config.load import load_scenario
from motionlab.runs.library import library
from motionlab.runs.search import Search
from motionlab.simulation.result import metadata
from motionlab.telemetry import recorder
from tests.recordings import noise

TICKS = 500


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in an empty folder with a data folder of its own and a recording."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))
    recorder.write(noise(TICKS), "run.parquet", metadata=metadata(load_scenario("circle")))
    return tmp_path


@pytest.fixture
def kept(here: Path) -> str:
    changes = ["--set", "trajectory.laps=1", "--set", "trajectory.lead_in=0.5"]
    assert main(["run", "circle", *changes, "--keep"]) == 0
    (run,) = library().index.page(Search()).runs
    return run.id


@pytest.mark.parametrize("ending", ["csv", "parquet"])
def test_a_part_of_a_file(here: Path, ending: str) -> None:
    file = f"out.{ending}"
    part = ["--columns", "x.load_force,B.y.K", "--from", "0.1", "--to", "0.2"]
    assert main(["export", "run.parquet", file, *part]) == 0
    back, whole = recorder.read(file), recorder.read("run.parquet")
    assert list(back) == ["tick", "time", "x.load_force", "B.y.K"]
    assert all((back[name].values == whole[name].values[200:401]).all() for name in back)


def test_a_kept_run(here: Path, kept: str) -> None:
    assert main(["export", kept, "out.mat", "--columns", "A.x.following_error"]) == 0
    run = scipy.io.loadmat("out.mat", squeeze_me=True, struct_as_record=False)["run"]
    assert run.metadata.run == kept
    with library().files.open(kept) as file:
        wanted = file.read(["A.x.following_error"])["A.x.following_error"].to_numpy()
    assert (run.A_x_following_error == wanted).all()


@pytest.mark.parametrize(
    ("arguments", "why"),
    [
        (["run.parquet", "out.txt"], "FILE: unknown kind of file"),
        (["run.parquet", "nowhere/out.csv"], "FILE: its folder does not exist"),
        (["nowhere.parquet", "out.csv"], "RUN: is no run"),
        (["r-aaaaaaaaaaaa", "out.csv"], "RUN: no run 'r-aaaaaaaaaaaa'"),
        (["run.parquet", "out.csv", "--columns", "x.nothing"], "no column of that name"),
        (["run.parquet", "out.csv", "--from", "0.3", "--to", "0.2"], "no sample lies there"),
        (["run.parquet", "out.csv", "--from", "nan"], "is not finite"),
    ],
)
def test_bad_input(
    here: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], why: str
) -> None:
    before = sorted(here.iterdir())
    assert main(["export", *arguments]) == 2
    assert why in capsys.readouterr().err
    assert [path for path in sorted(here.iterdir()) if path.name != "data"] == before


def test_a_full_disk_leaves_nothing_half_written(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import errno

    from motionlab.runs import exports

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(exports, "batches", fail)
    (here / "out.csv").write_text("before")
    assert main(["export", "run.parquet", "out.csv"]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert (here / "out.csv").read_text() == "before"
    assert sorted(path.name for path in here.iterdir()) == ["out.csv", "run.parquet"]
