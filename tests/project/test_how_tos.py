"""Figures and verdicts of the how-tos; test_documented_commands.py runs their commands."""

from __future__ import annotations

import re
import runpy
import sys
import tomllib
from pathlib import Path

import pytest

import motionlab
from motionlab.config.load import load_scenario
from tests.paths import ROOT
from tests.project.printed_output import approx

FENCE = re.compile(r"```(?:toml|python)\n(.*?)```", re.DOTALL)


def page(name: str) -> str:
    return (ROOT / "docs" / f"{name}.md").read_text()


def block(name: str) -> str:
    return FENCE.findall(page(name))[0]


def error(changes: dict[str, str]) -> float:
    found = motionlab.run("circle", changes).metrics["B"]["x"]["max_abs_following_error"]
    assert found is not None
    return 1e6 * found


def test_an_own_motor_has_the_errors_of_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    (tmp_path / "motors").mkdir()
    (tmp_path / "motors" / "stage.toml").write_text(block("own-motor"))
    own = {"plant": "stage"}
    told = re.findall(r"([\d.]+) um", page("own-motor"))
    modelled = own | {"variants.B.controller.model": "stage"}
    assert [f"{error(own):.3g}", f"{error(modelled):.3g}"] == told


def test_the_scenario_of_a_file_is_the_one_shown(tmp_path: Path) -> None:
    points = re.findall(r"printf '(.*?)'", page("trajectory-file"))[0].split(r"\n")[1:5]
    shown = tomllib.loads(block("trajectory-file"))["trajectory"]["points"]
    assert [[float(v) / 1000 for v in point.split(",")] for point in points] == shown
    (tmp_path / "shown.toml").write_text(block("trajectory-file"))
    assert load_scenario(tmp_path / "shown.toml").trajectory.kind == "path"


def test_the_check_fails_when_an_error_has_grown(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    scenario = tmp_path / "press.toml"
    baseline = tmp_path / "press.baseline.json"
    scenario.write_text(block("regression"))

    def check(*arguments: str) -> tuple[object, str, str]:
        monkeypatch.setattr(sys, "argv", ["regression.py", *arguments])
        with pytest.raises(SystemExit) as ended:
            runpy.run_path(str(ROOT / "examples" / "regression.py"), run_name="__main__")
        printed = capsys.readouterr()
        return ended.value.code, printed.out, printed.err

    file = str(scenario)
    code, _, refused = check(file)
    assert (code, baseline.exists()) == (2, False)
    assert refused == f"regression: {baseline} is not there: --write writes it, once\n"
    assert check(file, "--write") == (0, f"wrote {baseline}, 8 errors: commit it\n", "")
    assert check(file) == (0, "8 errors, none has grown by more than 5 %\n", "")
    (change,) = re.findall(r"`(disturbance_observer[^`]*)`", page("regression"))
    scenario.write_text(block("regression").replace('"lugre-full" }', f'"lugre-full", {change} }}'))
    code, _, grown = check(file)
    assert code == 1
    assert "B.x.rms_following_error" in grown
    assert "A.x" not in grown

    written = baseline.read_text()
    scenario.write_text(block("regression") + '[variants.B.controller.x]\nk_d = "stiff"\n')
    for bad in ([file], [file, "--write"], [str(tmp_path / "no.toml"), "--write"], []):
        code, printed, refused = check(*bad)
        assert (code, printed) == (2, "")
        assert "Traceback" not in refused
    assert baseline.read_text() == written
    diverging = runpy.run_path(str(ROOT / "examples" / "regression.py"), run_name="__x__")["write"]
    with pytest.raises(ValueError, match="diverged"):
        diverging(baseline, {"B.x.rms_following_error": None})
    for broken in ('{"B.x.rms_following_error": null}', "[1]", "{"):
        baseline.write_text(broken)
        code, _, refused = check(file)
        assert (code, refused.count("\n")) == (2, 1)


def test_the_notebook_of_the_tutorial_has_the_error_of_its_slider() -> None:
    text = page("tutorial")
    names: dict[str, object] = {}
    (code,) = FENCE.findall(text)
    exec(code, names)
    run = names["run"]
    found = run.metrics["B"]["x"]["max_abs_following_error"]  # pyright: ignore
    for words in (r"falls to ([\d.]+) um; A", r"# ([\d.]+)e-06, m"):
        told = re.findall(words, text)
        assert [float(each) for each in told] == [approx(1e6 * found)]
