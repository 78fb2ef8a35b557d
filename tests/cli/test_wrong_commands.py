"""Wrong commands: each answer names what is wrong, where, and what would be right, in few lines."""

from __future__ import annotations

import json
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest

from motionlab.cli import main

MOST_LINES = 3

GAIN = "variants.B.controller.x.k_p"

WRONG: list[tuple[str, str, str]] = [
    # line, what is wrong and where, what would be right
    ("rnu circle", "no such COMMAND", "'run'"),
    ("simulate circle", "no such COMMAND", "'run'"),
    ("simlate circle", "no such COMMAND", "'run'"),
    ("scenario", "no such COMMAND", "'scenarios'"),
    ("list", "no such COMMAND", "'scenarios'"),
    ("init mine.toml", "no such COMMAND", "'new'"),
    ("validate mine.toml", "no such COMMAND", "'check'"),
    ("chekc circle", "no such COMMAND", "'check'"),
    ("diff a.parquet b.parquet", "no such COMMAND", "'compare'"),
    ("convert run.parquet", "no such COMMAND", "'export'"),
    ("exprot r-aaaaaaaaaaaa a.mat", "no such COMMAND", "'export'"),
    ("margins circle", "no such COMMAND", "'loop'"),
    ("optimise circle", "no such COMMAND", "'tune'"),
    ("monte-carlo circle", "no such COMMAND", "'montecarlo'"),
    ("sever", "no such COMMAND", "'serve'"),
    ("fly", "no such COMMAND; got 'fly'", "motionlab --help"),
    ("--versoin", "no option --versoin", "'--version'"),
    ("trajectory exprot circle a.csv", "no such COMMAND", "'export'"),
    ("trajectory", "COMMAND is missing", "motionlab trajectory --help"),
    ("drive", "ORDER is missing", "motionlab drive --help"),
    ("drive strat", "no such ORDER", "one of status, stop"),
    ("run circle --kepe", "no option --kepe", "'--keep'"),
    ("run circle --sett=a=1", "no option --sett", "'--set'"),
    ("run circle --set", "--set: expected one argument", "motionlab run --help"),
    ("run circle square", "nothing here takes 'square'", "motionlab run --help"),
    ("run circel", "scenario: no shipped scenario of that name", "'circle'"),
    ("run ./circle", "scenario: no shipped scenario of that name", "'circle'"),
    ("run mine", "scenario: no shipped scenario of that name", "the file 'mine.toml'"),
    ("run missing.toml", "missing.toml: cannot be read", "No such file"),
    ("run broken.toml", "broken.toml: is not TOML", "at line 1"),
    ("run circle --set seed", "--set: needs KEY=VALUE", "got 'seed'"),
    ("run circle --set seed=1 --set seed=2", "--set: sets seed twice", "got '2'"),
    ("run circle --set plant.x.mas=5", "plant.x.mas: unknown key", "'mass'"),
    ("run circle --set plant.x.F_c=1", "plant.x.F_c: unknown key", "mean 'friction.F_c'?"),
    ("run circle --set plant.x.mass=-1", "plant.x.mass: is out of range; got -1", ">= 0.001"),
    (f"run circle --set {GAIN}=stiff", f"{GAIN}: must be a number; got 'stiff'", "N/m"),
    ("run circle --set plant=matchd", "plant: no motor of that name", "'matched'"),
    ("run circle --set trajectory=sqare", "trajectory: no trajectory", "one of circle"),
    ("run circle --set seed=1.5", "seed: must be a whole number; got 1.5", "9007199254740991"),
    ("run circle --set trajectory.frequency=3", "thrust on y", "--set trajectory.frequency=1.668"),
    ("run circle --set trajectory.center.x=0.08", "position on x", "-0.085 to 0.085 m"),
    ("run circle --out run.txt", "--out: unknown kind of file", ".parquet or .csv"),
    ("run circle --out no/run.csv", "--out: its folder does not exist", "'no/run.csv'"),
    ("run circle --out there.csv", "--out: is there already", "--overwrite"),
    ("show fig6", "scenario: no shipped scenario", "'fig5'"),
    ("new mine.toml", "FILE: is there already", "--overwrite"),
    ("new mine.json", "FILE: unknown kind of file; got 'mine.json'", ".toml"),
    ("new other.toml --base circel", "scenario: no shipped scenario", "'circle'"),
    ("fields massa", "PATTERN: fits no field", "'mass'"),
    ("fields mass --scenario cicle", "scenario: no shipped scenario", "'circle'"),
    ("check circle --motro fig5", "no option --motro", "'--motor'"),
    ("loop circle --set seed=x", "seed: must be a whole number", "got 'x'"),
    ("plot circle", "--out is missing", "motionlab plot --help"),
    ("plot circle --out fig.gif", "--out: unknown kind of file", ".png or .svg or .pdf"),
    ("plot circle B.x.thrst --out fig.png", "CHANNEL: no such channel", "'B.x.thrust'"),
    ("plot circle --out fig.png --from 99", "--from: leaves nothing to draw", "0 to 10.4995 s"),
    ("export-plant -o there.csv", "--out: unknown kind of file", ".fmu"),
    ("export-plant -o there.fmu", "--out: is there already", "--overwrite"),
    ("docs scenarois", "PAGE: no page of that name", "'scenarios'"),
    ("completion fish", "no such SHELL; got 'fish'", "one of bash, zsh, tcsh"),
    ("compare a.parquet", "B is missing", "motionlab compare --help"),
    ("compare a.txt b.txt", "run: no kept run of that name", ".parquet or .csv"),
    ("compare own own", "run: no kept run of that name; got 'own'", "`motionlab runs` lists them"),
    ("report own --out a.html", "RUN: no kept run of that name", "`motionlab runs` lists them"),
    ("export own a.csv", "RUN: no such file, and no kept run of that name", "`motionlab runs`"),
    ("export mine.toml a.csv", "RUN: is no telemetry", ".parquet or .csv"),
    ("compare a.csv b.csv --tolerance x", "--tolerance: is no tolerance; got 'x'", "ABS,REL"),
    ("spectrum r-aaaaaaaaaaaa", "--column is missing", "motionlab spectrum --help"),
    ("view balbar circle", "no such VIEW", "'ballbar'"),
    ("view ballbar circle --targets 3", "--targets: is of the view positioning", "got 3"),
    ("tune --axis z", "no such --axis; got 'z'", "one of x, y, both"),
    ("tune --starts many", "--starts: is not a whole number", "got 'many'"),
    ("sweep circle", "--grid: is missing", "PATH=FROM:TO:COUNT"),
    ("montecarlo --spec x", "--spec: needs KEY=VALUE", "got 'x'"),
    ("runs --limit 0", "--limit: is out of range; got 0", ">= 1"),
    ("runs foo:bar", "TERM: no such key; got 'foo:bar'", "one of tag, scenario, kind"),
    ("runs tags:rig", "TERM: no such key", "'tag'"),
    ("run circle --name x", "--name: needs --keep", "got 'x'"),
    (f"run circle --keep --name {121 * 'x'}", "--name: is too long; got 121", "<= 120"),
    ("run circle --keep --name 'a\x1bb'", "--name: has a control character", r"got 'a\x1bb'"),
    ("identify --mass 5.9", "--mass: is of a run: it needs --run", "got 5.9"),
    ("identify circle extra", "nothing here takes 'extra'", "motionlab identify --help"),
    ("vdrive --seed -x", "--seed: expected one argument", "motionlab vdrive --help"),
    ("openapi --jsn", "no option --jsn", "motionlab openapi --help"),
]


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in a folder with some files."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))
    (tmp_path / "mine.toml").write_text('base = "circle"\n')
    (tmp_path / "broken.toml").write_text("base = circle\n")
    for name in ("there.csv", "there.fmu"):
        (tmp_path / name).write_text("1\n")
    return tmp_path


def refused(line: str) -> int:
    try:
        return main(shlex.split(line))
    except SystemExit as left:  # of argparse
        assert isinstance(left.code, int)
        return left.code


@pytest.mark.parametrize(("line", "wrong", "right"), WRONG, ids=[line for line, *_ in WRONG])
def test_the_answer_says_what_where_and_what_would_be_right(
    line: str, wrong: str, right: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    files = {path: path.read_bytes() for path in here.iterdir() if path.is_file()}
    assert refused(line) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    lines = printed.err.splitlines()
    assert len(lines) <= MOST_LINES
    assert all(line.startswith(("motionlab", "`motionlab")) for line in lines)
    assert wrong in printed.err
    assert right in printed.err
    assert files == {path: path.read_bytes() for path in here.iterdir() if path.is_file()}


@pytest.mark.parametrize(
    ("line", "loc", "kind"),
    [
        ("run circle --json --set plant.x.mass=-1", "plant.x.mass", "invalid-field"),
        (
            "run circle --json --set trajectory.center.x=0.08",
            "trajectory",
            "infeasible-trajectory",
        ),
        ("tune --axis z --json", "--axis", "invalid-field"),
        ("rnu --json", "COMMAND", "invalid-field"),
        ("show circle --jsn --json", "--jsn", "invalid-field"),
        ("show circle extra --json", "motionlab show", "invalid-field"),
    ],
)
def test_with_json_the_answer_is_a_problem_document(
    line: str, loc: str, kind: str, here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert refused(line) == 2
    printed = capsys.readouterr()
    problem = json.loads(printed.out)
    assert (problem["type"], problem["status"]) == (f"urn:motionlab:problem:{kind}", 422)
    assert problem["errors"][0]["loc"] == loc
    assert set(problem["errors"][0]) >= {"message", "value", "range", "unit", "bounds"}
    assert printed.err.startswith("motionlab")


def test_a_failure_is_a_problem_document_too(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["replay", "r-aaaaaaaaaaaa", "--json"]) == 1
    printed = capsys.readouterr()
    problem = json.loads(printed.out)
    assert (problem["status"], problem["errors"]) == (404, [])
    assert printed.err == f"motionlab: {problem['detail']}\n"


def test_every_line_of_several_errors_has_the_prefix(
    here: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "--set", "plant.x.mass=-1", "--set", f"{GAIN}=stiff"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert all(line.startswith("motionlab: ") for line in lines)


def test_an_interrupt_is_one_line_and_130(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("motionlab.config.load.load_scenario", interrupted)
    assert main(["show", "circle"]) == 130
    assert capsys.readouterr().err == "motionlab: interrupted\n"


def test_a_missing_matplotlib_is_told(
    here: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert main(["plot", "circle", "--out", "fig.png"]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert "plot circle --out fig.png needs the extra notebook: " in line
    assert not (here / "fig.png").exists()
