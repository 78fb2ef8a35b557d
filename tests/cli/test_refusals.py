"""Bad input on the command line: exit code 2, what is wrong in full, nothing written."""

from __future__ import annotations

import os
import subprocess
import sys
from json import loads
from pathlib import Path

import pytest

from motionlab.cli import main

GAIN = "variants.B.controller.x.k_p"

# arguments after `run`, and what the complaint must say
BAD: dict[str, tuple[list[str], list[str]]] = {
    "a wrong key": (
        ["circle", "--set", "plant.x.mas=5.0"],
        ["plant.x.mas", "did you mean 'mass'?", "5.0", "mass, stroke"],
    ),
    "a wrong key of a union": (
        ["circle", "--set", "trajectory.raduis=0.01"],
        ["trajectory.raduis", "did you mean 'radius'?", "0.01"],
    ),
    "NaN": (
        ["circle", "--set", "plant.x.mass=nan"],
        ["plant.x.mass", "finite", "nan", ">= 0.001 and <= 1000 kg"],
    ),
    "infinity": (
        ["circle", "--set", f"{GAIN}=inf"],
        [GAIN, "finite", "inf", ">= 0 and <= 1000000000 N/m"],
    ),
    "a negative mass": (
        ["circle", "--set", "plant.x.mass=-5.9"],
        ["plant.x.mass", "out of range", "-5.9", ">= 0.001 and <= 1000 kg"],
    ),
    "a gain as text": (
        ["circle", "--set", f"{GAIN}=stiff"],
        [GAIN, "must be a number", "'stiff'", ">= 0 and <= 1000000000 N/m"],
    ),
    "a gain as quoted text": (
        ["circle", "--set", f'{GAIN}="200300.0"'],
        [GAIN, "must be a number", "'200300.0'", ">= 0 and <= 1000000000 N/m"],
    ),
    "a path outside the stroke": (
        ["circle", "--set", "trajectory.center.x=0.0801"],
        ["position on x", "0.0951 m", "t = 0.0000 s", "x = 0.0951 m", "-0.085 to 0.085 m"],
    ),
    "a path that leaves the stroke on its way": (
        ["circle", "--set", "trajectory.center.y=0.14"],
        ["position on y", "t = ", "x = ", "y = ", "-0.145 to 0.145 m"],
    ),
    "too fast a motion": (
        ["circle", "--set", "trajectory.frequency=3.0"],
        ["thrust on y", " N at t = ", "x = ", "y = ", "allowed -"],
    ),
    "too great a velocity": (
        ["circle", "--set", "plant.y.velocity_max=0.02"],
        ["velocity on y", "t = ", "-0.02 to 0.02 m/s"],
    ),
    "too great an acceleration": (
        ["circle", "--set", "plant.x.acceleration_max=0.05"],
        ["acceleration on x", "t = ", "-0.05 to 0.05 m/s^2"],
    ),
    "too high a step": (
        ["stair-x-500nm", "--set", "trajectory.step.x=11e-6"],
        ["step on x", "1.1e-05 m", "t = 1.0000 s", "-1e-05 to 1e-05 m"],
    ),
    "an unknown scenario": (
        ["circel"],
        ["scenario", "did you mean 'circle'?", "'circel'", "trapezoid-y"],
    ),
    "a path for a name": (["../circle"], ["scenario", "'../circle'", "one of circle"]),
    "a missing file": (["missing.toml"], ["missing.toml", "cannot be read", "No such file"]),
    "an unknown part": (
        ["circle", "--set", "plant=matchd"],
        ["plant", "did you mean 'matched'?", "'matchd'", "nominal"],
    ),
    "an event after the end": (
        ["fig5", "--set", "schedule.0.time=200.0"],
        ["schedule.0.time", "after the end", "200.0", "< 180 s"],
    ),
    "a window after the end": (
        ["circle", "--set", "window.start=1.0", "--set", "window.end=11.0"],
        ["window.end", "after the end", "11.0", "<= 10.5 s"],
    ),
    "no equals sign": (["circle", "--set", "seed"], ["--set", "KEY=VALUE", "'seed'"]),
    "a key set twice": (["circle", "--set", "seed=1", "--set", "seed=2"], ["seed", "twice"]),
    "an unknown kind of file": (
        ["circle", "--out", "run.txt"],
        ["--out", "'run.txt'", ".parquet or .csv"],
    ),
    "a folder that is not there": (
        ["circle", "--out", "no/run.parquet"],
        ["--out", "'no/run.parquet'", "does not exist"],
    ),
}


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in an empty folder far from the checkout."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize("json", [True, False])
@pytest.mark.parametrize("what", BAD)
def test_bad_input(what: str, json: bool, here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, words = BAD[what]
    output = [] if "--out" in arguments else ["--out", "run.csv"]
    assert main(["run", *arguments, *output, *(["--json"] if json else [])]) == 2
    printed = capsys.readouterr()
    if json:
        problem = loads(printed.out)
        assert problem["status"] == 422
        assert problem["title"] in ("Invalid field", "Infeasible trajectory")
        told = [f"motionlab: {line}" for line in problem["detail"].splitlines()]
        assert told == printed.err.splitlines()
        assert problem["errors"]
    else:
        assert printed.out == ""
    assert printed.err.startswith("motionlab: ")
    assert "Traceback" not in printed.err
    for word in words:
        assert word in printed.err
    assert list(here.iterdir()) == []


def test_a_file_that_is_not_toml(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "mine.toml").write_text("base = circle\n")
    assert main(["run", "mine.toml"]) == 2
    assert "mine.toml: is not TOML" in capsys.readouterr().err


def test_every_complaint_is_told(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle", "--set", "plant.x.mass=-1", "--set", f"{GAIN}=stiff"]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 2
    assert "plant.x.mass" in lines[0] + lines[1]
    assert GAIN in lines[0] + lines[1]


def test_as_a_user_meets_it(tmp_path: Path) -> None:
    environment = {key: os.environ[key] for key in ("HOME", "PATH") if key in os.environ}
    done = subprocess.run(
        [Path(sys.executable).with_name("motionlab"), "run", "circle", "--set", f"{GAIN}=stiff"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )
    assert done.returncode == 2
    assert done.stdout == ""
    assert done.stderr.splitlines() == [
        f"motionlab: {GAIN}: must be a number; got 'stiff'; allowed >= 0 and <= 1000000000 N/m"
    ]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--spec", "x"], "motionlab: --spec: needs KEY=VALUE; got 'x'\n"),
        (["--spec", "x=1e-6", "--spec", "x=2e-6"], "motionlab: --spec: sets x twice; got '2e-6'\n"),
    ],
)
def test_montecarlo_names_the_option_that_is_wrong(
    arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["montecarlo", *arguments]) == 2
    assert capsys.readouterr().err == said
