"""What a file of a law of one's own may hold, and where the error of another is."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from motionlab.errors import ConfigError
from motionlab.executors import progress
from motionlab.own_laws import check
from motionlab.own_laws.check import check_file
from motionlab.own_laws.template import template, write_template
from tests.paths import ROOT

MINE = template("mine")
STEP = "    force = par.mine_share"
SELECT = "    force = select(seen.v_ref > 0.0, force, select(seen.v_ref < 0.0, -force, 0.0))"
STATE = "class State(NamedTuple):\n" + "".join(f"    s_{i}: Lanes\n" for i in range(9))


def line_of(text: str, part: str) -> int:
    return text[: text.index(part)].count("\n") + 1


def test_the_file_to_begin_with_has_fifteen_lines_and_can_be_taken(tmp_path: Path) -> None:
    path = write_template("my-law", tmp_path / "laws")
    assert path.name == "my_law.py"
    assert len(path.read_text().splitlines()) == 15
    result = check_file(path)
    assert (result.name, result.problems) == ("my-law", ())
    assert result.ns is not None and result.share is not None
    assert 0.0 <= result.ns * 1e-9 == pytest.approx(result.share * 5e-4, abs=1e-10)


def test_a_check_that_compiles_says_so_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The child of this test says that it compiles, and goes on once that has been passed on."""
    monkeypatch.setattr(progress, "_notes_shown", set())
    passed = tmp_path / "passed"
    said = progress.compiling
    monkeypatch.setattr(check, "compiling", lambda: (said(), passed.touch()))
    child = f"""
import pathlib, sys, time
from motionlab.executors import progress
with progress.first_use():
    progress.compiling()
while not pathlib.Path({str(passed)!r}).exists():
    time.sleep(0.01)
print("answer")
print("trouble", file=sys.stderr)
"""
    with progress.first_use():
        answer = check.answer_of([sys.executable, "-c", child], os.environ, 60.0)
    assert answer == (b"answer\n", "trouble")
    assert capsys.readouterr().err == f"motionlab: {progress.COMPILING}\n"
    with pytest.raises(subprocess.TimeoutExpired):
        check.answer_of(["sleep", "60"], os.environ, 0.2)


@pytest.mark.parametrize("name", ["", "Mine", "1st", "a_b", "x" * 41, "../mine", "mine\n"])
def test_a_name_that_is_none_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ConfigError, match="NAME: is no name for a law"):
        write_template(name, tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_there_stays(tmp_path: Path) -> None:
    (tmp_path / "mine.py").write_text("mine")
    with pytest.raises(ConfigError, match="has a file already"):
        write_template("mine", tmp_path)
    assert (tmp_path / "mine.py").read_text() == "mine"


@pytest.mark.parametrize(
    ("text", "part", "reason"),
    [
        (MINE.replace("Estimate(", "Estimate(("), "return Estimate", "SyntaxError"),
        (f"import not_there_at_all\n{MINE}", "import not", "No module named 'not_there_at_all'"),
        (f"ballast = bytearray(10**10)\n{MINE}", "ballast", "MemoryError"),
        (MINE.replace("seen.friction.F_c", "seen.v / seen.v"), "", "force that is nan at"),
        (
            MINE.replace(SELECT, "    if seen.v_ref < 0.0:\n        force = -force"),
            "    if seen",
            "used as true or false, which differs from lane to lane: select",
        ),
        (
            MINE.replace(STEP, f"    while True:\n        pass\n{STEP}"),
            "    while",
            "while: a loop",
        ),
        (
            MINE.replace(STEP, f"    for _ in range(10**12):\n        pass\n{STEP}"),
            "    for",
            "a loop of 1000000000000 turns",
        ),
        (
            MINE.replace(STEP, f"    for i in range(10**12):\n        pass\n{STEP}"),
            "    for",
            "line 11: loops turn more than 10000 times",
        ),
        (f"{MINE}EFFECT = LAW\n", "", "LAW: is declared beside EFFECT"),
        (MINE.replace("seen.friction", "seen.frictoin"), STEP, "frictoin"),
        (MINE.replace('"mine"', '"residual-k"'), "", "is the name of another law"),
        (MINE.replace('unit="1", ', ""), "", "mine_share.unit: is missing"),
        (MINE.replace(", ge=0, le=2", ""), "", "mine_share: needs a lower bound"),
        (MINE.replace("ge=0, le=2", "ge=2, le=0"), "", "mine_share"),
        (
            MINE.replace("@compiled", f"{STATE}@compiled").replace("step=", "State=State, step="),
            "",
            "has too many fields; got 9; allowed at most 8",
        ),
        (
            MINE.replace("step=", 'resets=("w",), step='),
            "",
            "mine.resets: names no field of its State",
        ),
        (MINE.replace("step=", 'resets="w", step='), "", "mine.resets: is no tuple of names"),
        (MINE.replace(", state  #", "  #"), "", "returns no (Estimate, NoState)"),
        (MINE.replace("LAW =", "LAWS ="), "", "LAW: is not declared by this file"),
        (f"import os\nos._exit(0)\n{MINE}", "", "ends the process that runs it"),
        (f"import sys\nsys.exit('no')\n{MINE}", "sys.exit", "SystemExit: no"),
        ("print('{}')\n" * 3, "", "LAW: is not declared by this file"),
        ("\N{BYTE ORDER MARK}" * 2 + MINE, "", "SyntaxError"),
    ],
    ids=lambda value: value[-24:] if isinstance(value, str) else "",
)
def test_another_file_has_a_reason_and_a_line(
    tmp_path: Path, text: str, part: str, reason: str
) -> None:
    path = tmp_path / "mine.py"
    path.write_text(text)
    (problem,) = check_file(path).problems
    assert reason in str(problem)
    assert problem.place == (f"{path}:{line_of(text, part)}" if part else problem.place)
    assert problem.place.startswith(str(path))


@pytest.mark.parametrize("where", ["", "LAW"])
def test_an_endless_loop_is_ended_and_its_line_named(tmp_path: Path, where: str) -> None:
    path = tmp_path / "mine.py"
    loop = "while True:\n    pass\n"
    path.write_text(MINE.replace("LAW =", f"{loop}LAW =") if where else loop + MINE)
    (problem,) = check_file(path, seconds=12.0).problems
    assert problem.message == "has not ended within 12 s: an endless loop"
    lines = [line_of(path.read_text(), "while"), line_of(path.read_text(), "    pass")]
    assert problem.place in {f"{path}:{line}" for line in lines}


def test_bytes_that_are_no_text_and_a_file_too_large_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_bytes(b"\xff\xfe\x00")
    assert "cannot be read" in str(check_file(path).problems[0])
    path.write_text("#" * (2**20 + 1))
    (problem,) = check_file(path).problems
    assert "is too large; got 1048577; allowed at most 1048576 bytes" in str(problem)


def test_an_answer_is_one_line_of_json(tmp_path: Path) -> None:
    from motionlab.own_laws.check import as_json, from_json

    path = tmp_path / "mine.py"
    path.write_text("x = 1\n")
    result = check_file(path)
    assert "\n" not in as_json(result)
    assert from_json(as_json(result).encode()) == result
    assert json.loads(as_json(result))["problems"][0]["loc"] == "LAW"


def test_the_law_of_the_documentation_can_be_taken() -> None:
    path = ROOT / "tests" / "fixtures" / "laws" / "super_twisting.py"
    assert f"```python\n{path.read_text()}```\n" in (ROOT / "docs" / "own-law.md").read_text()
    assert check_file(path).problems == ()
