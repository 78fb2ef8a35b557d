"""``motionlab check``, ``motionlab loop``, and what ``motionlab run`` says of unstable loops."""

from __future__ import annotations

import json
import shlex
from pathlib import Path

import pytest

from motionlab.cli import main
from motionlab.config.load import load_scenario
from motionlab.loop.document import loop_document

UNSTABLE = ["--set", "variants.B.controller.x.k_p=1e7"]
QUICK = ["--set", "trajectory.laps=1", "--set", "trajectory.lead_in=0.5"]


def test_a_trajectory_that_can_be_followed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "circle"]) == 0
    first, *_ = capsys.readouterr().out.splitlines()
    assert first == "circle: can be followed; 10.5 s, 0.1178 m in 4.5 s"


@pytest.mark.parametrize(
    "changes",
    [
        "trajectory.frequency=3.0",
        "trajectory=trapezoid-y trajectory.v_max=0.9 trajectory.a_max=9.0",
    ],
)
def test_what_is_said_to_be_slow_enough_is(
    changes: str, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["check", "circle", *(f"--set={change}" for change in changes.split())]
    assert main(arguments) == 1
    text = capsys.readouterr().out
    assert "circle: cannot be followed" in text
    remedy = text.splitlines()[-1]
    assert "times slower it can be followed: --set trajectory." in remedy
    replaced = shlex.split(remedy.partition(": ")[2])
    paths = {text.partition("=")[0] for text in replaced if "=" in text}
    kept = [
        text for text in arguments if text.removeprefix("--set=").partition("=")[0] not in paths
    ]
    assert main([*kept, *replaced]) == 0
    capsys.readouterr()
    # as a document, and where it is met by `run`
    assert main([*arguments, "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert document["slower"]["set"].keys() == paths
    assert document["violation_count"] >= len(document["violations"]) > 0
    assert main(["run", *arguments[1:]]) == 2
    assert capsys.readouterr().err.splitlines()[-1] == f"motionlab: {remedy}"


def test_no_slower_one_helps_beyond_the_stroke(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", "circle", "--set", "trajectory.center.x=0.08"]) == 1
    assert capsys.readouterr().out.splitlines()[-1].startswith("no slower one can be")


def test_a_file_of_a_trajectory_is_checked(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "far.toml"
    file.write_text('kind = "circle"\nradius = 0.2\nfrequency = 0.1\n')
    assert main(["check", str(file), "--json"]) == 1
    document = json.loads(capsys.readouterr().out)
    assert {each["quantity"] for each in document["violations"]} == {"position"}
    file.write_text('kind = "circle"\nradius = 0.02\nfrequency = 0.1\n')
    assert main(["check", str(file)]) == 0


def test_the_loops_of_a_scenario(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["loop", "circle", *UNSTABLE, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    scenario = load_scenario("circle", {"variants.B.controller.x.k_p": 1e7})
    assert document == loop_document(scenario).model_dump(mode="json")
    assert main(["loop", "circle", *UNSTABLE]) == 0
    heads, *rows = capsys.readouterr().out.splitlines()
    assert heads.split() == "axes A x A y B x B y".split()
    assert [row.split() for row in rows if "stable" in row] == [
        ["stable", "yes", "yes", "no", "yes"]
    ] * 3  # sliding, at rest, worst
    crossover = next(row.split() for row in rows if "crossover" in row)
    sliding = document["variants"]["A"]["axes"]["x"]
    assert crossover[1] == "Hz"
    assert float(crossover[2]) == pytest.approx(sliding["crossover"], rel=1e-3)


def test_a_law_without_linearisation_is_noted(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["loop", "circle-published-k"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("B note: ") and "no linearisation" in line for line in lines)


def test_an_unstable_loop_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle", *QUICK, *UNSTABLE]) == 0
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(
        "motionlab: variant B: on x: its linearised loop is unstable while it slides and at "
        "standstill and its command is at a limit "
    )
    assert "% of the time" in line
