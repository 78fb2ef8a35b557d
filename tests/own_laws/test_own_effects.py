"""Effects of one's own: the file to begin with, bad files, and everything that takes them."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

import motionlab
from motionlab.own_laws.check import check_file
from motionlab.own_laws.template import template, write_template
from tests.own_laws.test_check import line_of
from tests.own_laws.test_everywhere import SHORT, command, document
from tests.paths import ROOT

CABLE = template("cable", effect=True)
EFFECTS = 'plant.x.effects=[{effect = "cable"}]'
FORCE = "    force = par.stiffness"
STATE = "class State(NamedTuple):\n" + "".join(f"    s_{i}: Lanes\n" for i in range(9))


def test_the_file_to_begin_with_is_short_and_can_be_taken(tmp_path: Path) -> None:
    path = write_template("my-cable", tmp_path / "laws", effect=True)
    assert path.name == "my_cable.py"
    assert len(path.read_text().splitlines()) <= 15
    result = check_file(path)
    assert (result.name, result.problems) == ("my-cable", ())


@pytest.mark.parametrize(
    ("text", "part", "reason"),
    [
        (CABLE.replace("Resistance(", "Resistance(("), "return Resistance", "SyntaxError"),
        (f"import not_there_at_all\n{CABLE}", "import not", "No module named 'not_there_at_all'"),
        (CABLE.replace("seen.position ", "seen.velocity / (0.0 * seen.h) "), "", "that is nan at"),
        (
            CABLE.replace("    return", "    if force > 0.0:\n        force = -force\n    return"),
            "    if force",
            "used as true or false, which differs from lane to lane: select",
        ),
        (
            CABLE.replace(FORCE, f"    while True:\n        pass\n{FORCE}"),
            "    while",
            "while: a loop",
        ),
        (CABLE.replace("seen.position", "seen.positoin"), FORCE, "positoin"),
        (CABLE.replace('"cable"', '"gms"'), "", "is the name of another effect"),
        (CABLE.replace('unit="N/m", ', ""), "", "stiffness.unit: is missing"),
        (
            CABLE.replace("@compiled", f"{STATE}@compiled").replace("step=", "State=State, step="),
            "",
            "has too many fields; got 9; allowed at most 8",
        ),
        (CABLE.replace(", state  #", "  #"), "", "returns no (Resistance, NoState)"),
        (CABLE.replace("EFFECT =", "EFFECTS ="), "", "LAW: is not declared by this file"),
        (CABLE.replace("stiffness", "effect"), "", "may not be called effect"),
        (f"{CABLE}LAW = EFFECT\n", "", "LAW: is declared beside EFFECT"),
        (CABLE.replace("damping=0.0", "damping=-2.0"), "", "got -2.0; allowed >= 0 N s/m"),
        (
            CABLE.replace("damping=0.0", "damping=seen.h / (0.0 * seen.h)"),
            "",
            "gives a damping at 0.0000 s of a circle, on x",
        ),
    ],
    ids=lambda value: value[-24:] if isinstance(value, str) else "",
)
def test_another_file_has_a_reason_and_a_line(
    tmp_path: Path, text: str, part: str, reason: str
) -> None:
    path = tmp_path / "cable.py"
    path.write_text(text)
    (problem,) = check_file(path).problems
    assert reason in str(problem)
    assert problem.place == (f"{path}:{line_of(text, part)}" if part else problem.place)
    assert problem.place.startswith(str(path))


def test_an_endless_loop_is_ended(tmp_path: Path) -> None:
    path = tmp_path / "cable.py"
    path.write_text(f"while True:\n    pass\n{CABLE}")
    (problem,) = check_file(path, seconds=4.0).problems
    assert problem.message == "has not ended within 4 s: an endless loop"


def test_one_folder_has_laws_and_effects_and_a_run_keeps_their_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    own = tmp_path / "own"
    own.mkdir()
    (own / "mine.py").write_text(template("mine"))
    (own / "z_cable.py").write_text(CABLE)
    data = {"MOTIONLAB_DATA": str(tmp_path / "data"), "MOTIONLAB_LAWS": str(own)}
    law = "variants.B.controller.compensation.law=mine"
    words = ("run", "circle", "--set", law, "--set", SHORT, "--set")
    pulled = document(*words, EFFECTS, "--keep", **data)
    free = document(*words, "plant.x.effects=[]", **data)
    errors = [
        each["variants"]["A"]["axes"]["x"]["max_abs_following_error"] for each in (pulled, free)
    ]
    assert errors[0] != errors[1]
    monkeypatch.setenv("MOTIONLAB_DATA", data["MOTIONLAB_DATA"])
    texts = motionlab.kept(pulled["run"]).detail["laws"]
    assert texts == {"mine": template("mine"), "cable": CABLE}
    assert command("replay", pulled["run"], **data).returncode == 0
    (own / "z_cable.py").write_text(CABLE.replace("par.stiffness *", "2.0 * par.stiffness *"))
    again = command("replay", pulled["run"], **data)
    assert again.returncode == 1
    assert "other law of one's own: kept with mine" in again.stdout + again.stderr


def test_a_law_with_the_name_of_an_effect_is_refused(tmp_path: Path) -> None:
    """A run keeps the texts of both by their names."""
    (tmp_path / "a_law.py").write_text(template("cable"))
    (tmp_path / "z_effect.py").write_text(CABLE)
    refused = command("laws", MOTIONLAB_LAWS=str(tmp_path)).stderr
    assert "a_law.py: cable.name: is the name of an effect; choose another" in refused
    done = command("run", "circle", "--laws", tmp_path, "--set", EFFECTS, "--set", SHORT)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("name", ["run_in", "floor"])
def test_the_effects_of_the_documentation_can_be_taken(name: str) -> None:
    path = ROOT / "tests" / "fixtures" / "effects" / f"{name}.py"
    assert f"```python\n{path.read_text()}```\n" in (ROOT / "docs" / "own-effect.md").read_text()
    assert check_file(path).problems == ()


def test_friction_that_runs_in_and_a_floor_that_shakes_do(monkeypatch: pytest.MonkeyPatch) -> None:
    """By the files' equations, written anew, on a short sine."""
    folder = ROOT / "tests" / "fixtures" / "effects"
    monkeypatch.setenv("MOTIONLAB_LAWS", str(folder))
    words = [sys.executable, "-m", "tests.own_laws.documented_effects"]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    misses = json.loads(done.stdout)
    assert misses["run-in"] < 1e-5
    assert misses["floor"] < 1e-5


def test_its_parameters_have_bounds_and_without_its_file_it_is_none(tmp_path: Path) -> None:
    (tmp_path / "cable.py").write_text(CABLE)
    stiff = EFFECTS.replace("}]", ", stiffness = 1e5}]")
    wrong = command("run", "circle", "--laws", tmp_path, "--set", stiff)
    assert wrong.returncode == 2
    assert "plant.x.effects.0.stiffness" in wrong.stderr and "<= 10000 N/m" in wrong.stderr
    none = command("run", "circle", "--set", EFFECTS)
    assert none.returncode == 2
    assert "plant.x.effects.0.effect: is not one of the choices" in none.stderr
