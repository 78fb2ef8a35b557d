"""``motionlab export`` and ``motionlab import``."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import scipy.io

from motionlab.__main__ import main
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.library.library import library
from motionlab.library.run import new_id
from motionlab.library.search import Search
from motionlab.simulation.prepare import prepare
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
        (["nowhere.parquet", "out.csv"], "RUN: no such file, and no kept run"),
        (["r-aaaaaaaaaaaa", "out.csv"], "RUN: no run 'r-aaaaaaaaaaaa'"),
        (["run.parquet", "out.csv", "--columns", "x.nothing"], "no column of that name"),
        (["run.parquet", "out.csv", "--from", "0.3", "--to", "0.2"], "no sample lies there"),
        (["run.parquet", "out.csv", "--from", "nan"], "is not finite"),
    ],
)
def test_bad_input(
    here: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], why: str
) -> None:
    def files() -> list[Path]:
        return sorted(path for path in here.iterdir() if path.name != "data")

    before = files()
    assert main(["export", *arguments]) == 2
    assert why in capsys.readouterr().err
    assert files() == before


def test_a_full_disk_leaves_nothing_half_written(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import errno

    from motionlab.exchange import exports

    def fail(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(exports, "batches", fail)
    (here / "out.csv").write_text("before")
    assert main(["export", "run.parquet", "out.csv", "--overwrite"]) == 1
    assert "No space left on device" in capsys.readouterr().err
    assert (here / "out.csv").read_text() == "before"
    assert sorted(path.name for path in here.iterdir()) == ["out.csv", "run.parquet"]


@pytest.mark.parametrize("ending", ["mat", "parquet"])
def test_a_csv_file_is_exported_again(here: Path, ending: str) -> None:
    assert main(["export", "run.parquet", "run.csv"]) == 0
    part = ["--columns", "x.load_force", "--from", "0.1"]
    assert main(["export", "run.csv", f"b.{ending}", *part]) == 0
    wanted = recorder.read("run.parquet")["x.load_force"]
    if ending == "mat":
        run = scipy.io.loadmat("b.mat", squeeze_me=True, struct_as_record=False)["run"]
        assert (run.x_load_force == wanted.values[200:]).all()
        assert run.units.x_load_force == wanted.unit
    else:
        assert (recorder.read("b.parquet")["x.load_force"].values == wanted.values[200:]).all()


def test_a_name_that_one_run_has_stands_for_it(
    kept: str, capsys: pytest.CaptureFixture[str]
) -> None:
    library().change(kept, {"name": "own"})
    assert main(["compare", "own", kept]) == 0
    assert main(["export", "own", "a.csv", "--columns", "x.load_force"]) == 0
    assert main(["report", "own", "--out", "a.html"]) == 0
    assert main(["glitches", "own"]) == 0
    assert main(["spectrum", "own", "--column", "B.x.thrust"]) == 0
    run = library().get(kept)
    library().index.put(run.model_copy(update={"id": new_id()}))
    capsys.readouterr()
    for arguments in (["compare", "own", kept], ["export", "own", "b.csv"], ["replay", "own"]):
        assert main(arguments) == 2
        assert "is the name of several runs; got 'own'" in capsys.readouterr().err


# -- import ---------------------------------------------------------------------------------------

GERMAN = "Zeit;Sollposition X [µm];Istposition X;Temp\n" + "".join(
    f"0,00{i};{i},5;{i},25;20\n" for i in range(10)
)


def imported(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    capsys.readouterr()
    assert main(["import", "rig.csv", "--json", *arguments]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_measurement_becomes_a_run(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("rig.csv").write_text(GERMAN, encoding="utf-8")
    preview = imported(capsys, "--preview")
    assert preview["run"] is None
    assert library().index.page(Search()).total == 0
    document = imported(capsys, "--map", "Temp=-", "--name", "rig 7")
    assert document["rate"] == 1000
    run = library().get(document["run"])
    assert (run.name, run.kind) == ("rig 7", "measurement")
    assert run.metrics["M.x.max_abs_following_error"] == pytest.approx(0.25e-6)
    assert main(["export", run.id, "back.csv"]) == 0
    back = recorder.read("back.csv")
    assert list(back) == [
        "tick",
        "time",
        "x.position_reference",
        "M.x.position_measured",
        "M.x.following_error",
    ]
    assert back["M.x.position_measured"].values == pytest.approx(
        [(i + 0.25) * 1e-6 for i in range(10)]
    )


def test_what_was_guessed_is_printed(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Path("rig.csv").write_text(GERMAN.replace("0,003", "0,013"), encoding="utf-8")
    lines = [line for line in GERMAN.splitlines() if not line.startswith("0,003")]
    Path("rig.csv").write_text("\n".join(lines), encoding="utf-8")
    assert main(["import", "rig.csv"]) == 0
    printed = capsys.readouterr().out
    assert "csv, semicolon, decimal comma: 9 rows" in printed
    assert "1000 Hz from Zeit" in printed
    assert "gap of 1 sample from 0.002 s to 0.004 s" in printed
    assert "M.x.following_error: computed" in printed
    assert "kept as r-" in printed


@pytest.mark.parametrize(
    ("text", "arguments", "why"),
    [
        (GERMAN.replace("0,003;3,5", "0,003;oops"), [], "line 5, column 'Sollposition X [µm]'"),
        ("x [mm]\n1\n2\n", [], "there is no column of time"),
        ("x [mm]\n1\n2\n", ["--rate", "0"], "rate: is out of range"),
        (GERMAN, ["--map", "Temp=M.x.nothing"], "no channel of that name"),
        (GERMAN, ["--map", "Druck=-"], "no column of that name"),
        ("", [], "has no line of numbers"),
    ],
)
def test_an_import_that_is_refused(
    here: Path, capsys: pytest.CaptureFixture[str], text: str, arguments: list[str], why: str
) -> None:
    Path("rig.csv").write_text(text, encoding="utf-8")
    assert main(["import", "rig.csv", *arguments]) == 2
    assert why in capsys.readouterr().err
    assert library().index.page(Search()).total == 0


def test_a_file_that_is_none(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "nowhere.csv"]) == 2
    assert "FILE: is no file" in capsys.readouterr().err


# -- runs -----------------------------------------------------------------------------------------


def test_a_list_of_runs_has_heads_and_no_orders_to_a_terminal(
    kept: str, capsys: pytest.CaptureFixture[str]
) -> None:
    library().change(kept, {"name": "a\x1b[31mb\nc"})
    capsys.readouterr()
    assert main(["runs"]) == 0
    heads, row = capsys.readouterr().out.splitlines()
    assert heads.split()[:5] == ["run", "began", "kind", "duration", "name"]
    assert r"a\x1b[31mb\nc" in row
    assert main(["runs", "zzz"]) == 0
    assert capsys.readouterr().out == "no run meets 'zzz'\n"
    assert main(["runs", "'foo:bar'"]) == 0  # in quotes of its own


@pytest.mark.parametrize("name", ["a\x1bb", 121 * "x", 5])
def test_what_is_no_name_of_a_run_is_refused(here: Path, name: Any) -> None:
    prepared = prepare(load_scenario("circle"))
    with pytest.raises(ConfigError, match="name: "):
        library().keep(prepared, noise(TICKS), {}, name=name)
