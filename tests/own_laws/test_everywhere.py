"""A law of one's own, in a folder, is wherever one that ships is; commands take it by `--laws`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import motionlab
from motionlab.own_laws.template import template
from tests.export.compilers import call, compiler

LAW = "variants.B.controller.compensation.law=mine"
SHORT = "trajectory.laps=1"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder that has a law, and a file that cannot be taken."""
    folder = tmp_path_factory.mktemp("laws")
    (folder / "mine.py").write_text(template("mine"))
    (folder / "broken.py").write_text("1 +\n")
    (folder / "_left_out.py").write_text("1 +\n")
    return folder


def command(*words: str | Path, **variables: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, "-m", "motionlab", *map(str, words)]
    environment = os.environ | variables
    return subprocess.run(line, env=environment, capture_output=True, text=True, check=False)


def document(*words: str | Path, **variables: str) -> Any:
    done = command(*words, "--json", **variables)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def errors(folder: Path, *changes: str) -> float:
    options = [f"--set={change}" for change in (LAW, SHORT, *changes)]
    run = document("run", "circle", "--laws", folder, *options)
    return run["variants"]["B"]["axes"]["x"]["max_abs_following_error"]


def test_it_is_listed_and_a_broken_file_is_named(folder: Path) -> None:
    laws = document("laws", "--laws", folder)
    assert laws[-1]["name"] == laws[-1]["title"] == "mine"
    assert laws[-1]["parameters"][0]["path"] == "mine_share"
    noted = command("laws", MOTIONLAB_LAWS=str(folder)).stderr
    assert f"not taken: {folder / 'broken.py'}:1: broken: SyntaxError" in noted
    assert "_left_out" not in noted


def test_it_compensates_and_its_parameter_has_bounds(folder: Path) -> None:
    whole, none = errors(folder), errors(folder, LAW.replace("law=mine", "mine_share=0"))
    assert whole < 0.98 * none
    wrong = command(
        "run", "circle", f"--laws={folder}", "--set", LAW.replace("law=mine", "mine_share=3")
    )
    assert wrong.returncode == 2
    assert "mine_share" in wrong.stderr and "<= 2" in wrong.stderr


def test_a_parameter_is_a_field(folder: Path) -> None:
    (field,) = document("fields", "B.controller.compensation.mine_share", "--laws", folder)
    assert (field["unit"], field["range"]) == ("", ">= 0 and <= 2")


def test_it_has_margins_and_is_exported_with_vectors(folder: Path, tmp_path: Path) -> None:
    loop = document("loop", "circle", "--laws", folder, "--set", LAW)
    assert loop["variants"]["B"]["axes"]["x"]["phase_margin"] > 0.0
    words = ("export-controller", "circle", "-o", tmp_path / "c", "--variant", "B")
    options = (f"--set={LAW}", "--seconds", "0.5", "--set=trajectory.lead_in=0.1")
    done = command(*words, "--laws", folder, *options)
    assert done.returncode == 0, done.stderr
    checked = call("make", "-C", tmp_path / "c", "check", f"CC={compiler('gcc')}")
    assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr


def test_a_run_keeps_its_source_and_a_replay_says_that_it_has_changed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own"
    own.mkdir()
    file = own / "mine.py"
    file.write_text(template("mine"))
    data = {"MOTIONLAB_DATA": str(tmp_path / "data"), "MOTIONLAB_LAWS": str(own)}
    run = document("run", "circle", "--set", LAW, "--set", SHORT, "--keep", **data)["run"]
    monkeypatch.setenv("MOTIONLAB_DATA", data["MOTIONLAB_DATA"])
    assert motionlab.kept(run).detail["laws"] == {"mine": template("mine")}
    assert command("replay", run, **data).returncode == 0
    file.write_text(template("mine").replace("seen.friction.F_c", "0.5 * seen.friction.F_c"))
    again = command("replay", run, **data)
    assert again.returncode == 1
    assert "other law of one's own: kept with mine" in again.stdout + again.stderr


def test_an_installed_package_has_laws_too(tmp_path: Path) -> None:
    (tmp_path / "their_laws.py").write_text(template("theirs"))
    installed = tmp_path / "their_laws-1.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: their-laws\nVersion: 1\n")
    (installed / "entry_points.txt").write_text("[motionlab.laws]\ntheirs = their_laws\n")
    laws = document("laws", PYTHONPATH=str(tmp_path))
    assert laws[-1]["name"] == "theirs"
    law = LAW.replace("mine", "theirs")
    done = command("run", "circle", "-q", "--set", law, "--set", SHORT, PYTHONPATH=str(tmp_path))
    assert done.returncode == 0, done.stderr


def test_a_law_without_its_file_is_no_law() -> None:
    done = command("run", "circle", "--set", LAW)
    assert done.returncode == 2
    assert "variants.B.controller.compensation.law" in done.stderr
