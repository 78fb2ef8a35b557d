"""The commands ``compare`` and ``replay``: exit codes, tables, documents."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from motionlab.cli.main import main
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from tests.library.test_replay import altered, keep, rewrite

QUICK = ["--set", "trajectory.laps=1", "--set", "trajectory.lead_in=0.5"]


@pytest.fixture(scope="module")
def kept() -> RunDetail:
    return keep()


def test_a_run_against_its_file(
    kept: RunDetail, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    csv = str(tmp_path / "same.csv")
    assert main(["run", "circle", *QUICK, "--out", csv]) == 0
    capsys.readouterr()
    assert main(["compare", kept.id, csv]) == 0
    assert "identical on 8 of 8" in capsys.readouterr().out
    exact = ["compare", kept.id, csv, "--exact"]
    assert main(exact) == 0
    out = capsys.readouterr().out
    assert "identical on 108 of 108" in out
    assert f"{kept.ticks} instants from 0.0000 s" in out
    assert "108 channels are equal; --all lists them" in out
    assert "within" not in out
    assert main([*exact, "--all"]) == 0
    assert capsys.readouterr().out.count("within") == 108


def test_a_script_holds_a_regression(
    kept: RunDetail, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = str(tmp_path / "other.parquet")
    main(["run", "circle", *QUICK, "--set", "variants.B.controller.x.k_p=210000", "--out", other])
    capsys.readouterr()
    errors = ["compare", kept.id, other, "--exact", "--only", "*.x.following_error"]
    assert main(errors) == 1
    out = capsys.readouterr().out
    assert "B.x.following_error  out-of-tolerance" in out
    assert re.search(r"differs: e_x of B by \S+ [nµ]m at \S+ s, 1 of 2 channels beyond", out)
    assert "1 channel is equal" in out
    assert "A.x.following_error" not in out
    loose = "B.x.following_error=2e-6,0"
    assert main([*errors, "--tolerance", "0,0.01", "--tolerance", loose, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [c["tolerance"]["absolute"] for c in found["channels"]] == [0.0, 2e-6]
    assert [c["tolerance"]["relative"] for c in found["channels"]] == [0.01, 0.0]
    short = [*errors, "--tolerance", f"{loose},0.002", "--interpolation", "*.x.*=hold", "--json"]
    assert main(short) == 0
    found = json.loads(capsys.readouterr().out)["channels"]
    assert [c["tolerance"]["time"] for c in found] == [0.0, 0.002]
    assert [c["interpolation"] for c in found] == ["hold", "linear"]  # a name goes first
    by_place = ["--align", "reference", "--time-tolerance", "0.001", "--samples", "intersection"]
    assert main([*errors, *by_place, "--json"]) in {0, 1}
    found = json.loads(capsys.readouterr().out)
    assert (found["align"], found["samples"]) == ("reference", "intersection")
    assert found["channels"][0]["tolerance"]["time"] == 0.001
    assert main([*errors, "--offset", "100"]) == 1  # nothing could be compared
    assert "ranges-differ" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--tolerance", "1e-6"], "--tolerance: is no tolerance"),
        (["--tolerance", "A=x,0"], "--tolerance: is no tolerance"),
        (["--tolerance=-1,0"], "tolerance.absolute"),
        (["--tolerance", "nan,0"], "tolerance.absolute"),
        (["--tolerance", "C.*=1,0"], "channels.C.*: fits no channel"),
        (["--tolerance", "A=1,0,0,0"], "--tolerance: is no tolerance"),
        (["--interpolation", "*=spline"], "--interpolation: is no interpolation"),
        (["--only", "z"], "only.z: fits no channel"),
        (["--offset", "inf"], "offset"),
        (["--from", "1", "--to", "0.5"], "end: is before the start; got 0.5; allowed >= 1 s"),
        (["--variant", "A"], "--variant: is no pair of letters; got 'A'"),
        (["--variant", "A=B", "--variant", "A=C"], "--variant: says the same variant twice"),
        (["--variant", "a=B"], "variants.a: is not of the allowed form; got 'a'; allowed one"),
        (["--variant", "A=BB"], "variants.A: is not of the allowed form; got 'BB'; allowed one"),
        (["--variant", "M=B"], "variants.M: is no variant of the candidate; got 'M'; allowed A, B"),
        (["--offset", "1", "--align", "index"], "offset: only moves runs aligned by time"),
    ],
)
def test_bad_input(
    kept: RunDetail, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", kept.id, kept.id, *arguments]) == 2
    assert said in capsys.readouterr().err


def test_a_variant_of_one_stands_for_another(
    kept: RunDetail, capsys: pytest.CaptureFixture[str]
) -> None:
    exchanged = ["compare", kept.id, kept.id, "--variant", "A=B", "--variant", "B=A", "--json"]
    exchanged.append("--exact")
    assert main([*exchanged, "--only", "*.x.following_error"]) == 1
    first, second = json.loads(capsys.readouterr().out)["channels"]
    assert first["largest"] == -second["largest"] != 0.0
    part = ["--from", "0.25", "--to", "0.5"]
    assert main(["compare", kept.id, kept.id, *part]) == 0
    assert "501 instants from 0.2500 s to 0.5000 s" in capsys.readouterr().out


def test_replay(capsys: pytest.CaptureFixture[str]) -> None:
    run = keep({"seed": 3})
    assert main(["replay", run.id]) == 0
    assert capsys.readouterr().out == f"identical: 108 channels, {run.ticks} ticks\n"
    rewrite(run, lambda table: altered(table, 700, "A.x.thrust", 2.0))
    assert main(["replay", run.id]) == 1
    out = capsys.readouterr().out
    assert "first at tick 700, t = 0.3500 s: A.x.thrust was 2, is " in out
    assert main(["replay", run.id, "--json"]) == 1
    assert json.loads(capsys.readouterr().out)["first"]["tick"] == 700
    library().delete(run.id)
    assert main(["replay", run.id]) == 1
    assert "it is deleted" in capsys.readouterr().err
