"""docs/rig.md as it is written: from a log of a machine that the lab does not know to its gains."""

from __future__ import annotations

import contextlib
import io
import itertools
import json
import math
import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from motionlab.cli.main import main
from motionlab.studies.response.controller_check import OTHER
from tests.paths import ROOT

PAGE = (ROOT / "docs" / "rig.md").read_text()


def printed(command: str) -> str:
    """Run a command of the page here; return what it prints."""
    words = shlex.split(command)
    if words[0] == ".venv/bin/python":
        program = [sys.executable, str(ROOT / words[1]), *words[2:]]
        return subprocess.run(program, check=True, capture_output=True, text=True).stdout
    with contextlib.redirect_stdout(io.StringIO()) as text:
        assert main(words[1:]) == 0
    return text.getvalue()


@pytest.fixture(scope="module")
def answers(tmp_path_factory: pytest.TempPathFactory) -> Iterator[dict[str, Any]]:
    """Of every command, in its order: what it prints, or its document."""
    with contextlib.chdir(tmp_path_factory.mktemp("rig")):
        (toml,) = re.findall(r"^```toml\n(.*?)^```$", PAGE, re.MULTILINE | re.DOTALL)
        Path("rig.toml").write_text(toml)
        commands = re.findall(r"^    (\S.*)$", PAGE, re.MULTILINE)
        made = {}
        for each in commands:
            study = each.split()[1] in {"friction-models", "response", "shape"}
            text = printed(each + " --json" if study else each)
            made[each] = json.loads(text) if study else text
        yield made


def of(answers: dict[str, Any], start: str, *words: str) -> Any:
    """Return the last answer whose command begins so and has these words."""
    there = [each for each in answers if each.startswith(start)]
    return answers[[each for each in there if all(word in each for word in words)][-1]]


def truth(answers: dict[str, Any], pattern: str) -> list[float]:
    """Return numbers that the machine of the first log says of itself."""
    text = answers[".venv/bin/python examples/rig.py"]
    return [float(each) for each in re.findall(pattern, text)]


def test_the_friction_is_that_of_the_machine(answers: dict[str, Any]) -> None:
    result = of(answers, "motionlab friction-models")
    assert result["selected"] == "lugre-load"
    values = result["models"][-1]["parameters"]
    for name, pattern in (("M", r"mass (\S+) kg"), ("F_c", r"F_c (\S+) N"), ("mu", r"mu ([\d.]+)")):
        assert [values[name]["value"]] == pytest.approx(truth(answers, pattern), rel=0.03), name


def test_the_response_has_its_margins_and_mode(answers: dict[str, Any]) -> None:
    result = of(answers, "motionlab response")
    crossovers = truth(answers, r"crossover (\S+) Hz")
    assert [each["frequency"] for each in result["crossings"]] == pytest.approx(
        crossovers, rel=0.01
    )
    phase = truth(answers, r"crossover .* margin (\S+) deg")[0]
    assert math.degrees(result["margins"]["phase_margin"]["value"]) == pytest.approx(phase, abs=0.5)
    (gain,) = truth(answers, r"gain margin (\S+) dB")
    low, high = (20.0 * math.log10(end) for end in result["margins"]["gain_margin"]["interval"])
    assert low < gain < high
    fitted = result["fitted"]
    assert fitted["mass"]["value"] == pytest.approx(5.3, rel=0.002)
    assert fitted["lag"]["value"] == pytest.approx(0.15e-3, abs=0.02e-3)
    (mode,) = fitted["modes"]
    assert mode["frequency"]["value"] == pytest.approx(140.0, abs=0.2)
    assert mode["damping"]["value"] == pytest.approx(0.02, abs=0.002)
    assert not [note for note in result["warnings"] if "reverses" in note]


def test_the_gains_proposed_are_confirmed_by_a_second_log(answers: dict[str, Any]) -> None:
    result = of(answers, "motionlab shape", "--second-run")
    again = of(answers, ".venv/bin/python examples/rig.py", "rig-again.csv")
    for name, gain in (("k-p", "k_p"), ("k-d", "k_d")):
        (used,) = re.findall(rf"--{name} (\S+)", PAGE)
        assert result["changes"][f"variants.A.controller.x.{gain}"] == pytest.approx(float(used))
    assert result["check"]["holds"] is True
    (gain,) = re.findall(r"gain margin (\S+) dB", again)
    measured = 20.0 * math.log10(result["check"]["margins"]["gain_margin"]["value"])
    assert measured == pytest.approx(float(gain), abs=0.3)


A = "--axis x --variant A --from 24.5 --to 33.5 --lines 100"


@pytest.mark.parametrize(
    ("options", "note"),
    [
        ("", ""),
        ("--set variants.A.controller.x.k_p=30000", "it differs by"),
        ("--set variants.A.controller.delay=1", "it is 0.5 ms earlier, as a command"),
        (
            "--set variants.A.controller.x.k_p=45000 --set variants.A.controller.x.k_d=550",
            "it is 2 times that",
        ),
    ],
)
@pytest.mark.usefixtures("answers")
def test_a_controller_that_did_not_run_is_noted(options: str, note: str) -> None:
    document = json.loads(printed(f"motionlab response rig.toml --run rig {A} {options} --json"))
    there = [each for each in document["warnings"] if each.startswith(OTHER)]
    assert bool(there) == bool(note)
    assert all(note in each for each in there)


LATE = "--set variants.A.controller.x.filter_1.poles_frequency=300"


def test_the_loop_of_a_record_has_its_margins_whatever_the_scenario_says(
    answers: dict[str, Any],
) -> None:
    """Of another structure of the controller, here one with a filter that the machine has not."""
    document = json.loads(printed(f"motionlab response rig.toml --run rig {A} {LATE} --json"))
    phase = truth(answers, r"crossover .* margin (\S+) deg")[0]
    own, margins = document["own_margins"]["phase_margin"], document["margins"]["phase_margin"]
    assert math.degrees(own["value"]) == pytest.approx(phase, abs=0.7)
    assert own["model"] == margins["value"]
    assert math.degrees(margins["value"]) < phase - 5.0
    (note,) = [each for each in document["warnings"] if each.startswith(OTHER)]
    assert f"phase margin, deg {math.degrees(own['value']):.3g} in place of" in note


@pytest.mark.usefixtures("answers")
def test_nothing_is_shaped_from_a_controller_that_did_not_run() -> None:
    with contextlib.redirect_stderr(io.StringIO()) as text:
        assert main(shlex.split(f"shape rig.toml --run rig {A} {LATE}")) != 0
    assert "run: was not under the controller of variant A" in text.getvalue()


@pytest.mark.usefixtures("answers")
def test_a_friction_of_uniform_motions_says_what_it_has_not() -> None:
    document = json.loads(printed("motionlab identify --run rig --axis x --to 24 --json"))
    assert any("M.x.normal_force, takes no part" in each for each in warnings_of(document))
    assert any(
        "neither a delay nor a mode" in each for each in document["motor"]["origin"]["notes"]
    )


def warnings_of(document: Any) -> list[str]:
    """Return all warnings within a document."""
    if isinstance(document, dict):
        own = document.get("warnings", [])
        return [*own, *itertools.chain.from_iterable(map(warnings_of, document.values()))]
    if isinstance(document, list):
        return list(itertools.chain.from_iterable(map(warnings_of, document)))
    return []


@pytest.mark.usefixtures("answers")
def test_a_force_at_its_limit_is_noted() -> None:
    head, *rows = Path("rig.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    for row in cells:
        row[3] = f"{max(-6.0, min(6.0, float(row[3]))):.3f}"
    Path("limited.csv").write_text("\n".join([head, *map(",".join, cells)]))
    printed("motionlab import limited.csv --name limited")
    document = json.loads(printed(f"motionlab response rig.toml --run limited {A} --json"))
    assert any("M.x.thrust is at its largest value, 6 N" in each for each in document["warnings"])


@pytest.mark.usefixtures("answers")
def test_a_force_of_the_other_sign_is_refused() -> None:
    printed("motionlab import rig.csv --name turned --map 'force=M.x.thrust[-1 N]'")
    with contextlib.redirect_stderr(io.StringIO()) as text:
        assert main(shlex.split(f"response rig.toml --run turned {A}")) != 0
    assert "force_column: acts against the following error" in text.getvalue()


@pytest.mark.usefixtures("answers")
def test_a_second_record_with_the_old_gains_confirms_nothing() -> None:
    text = printed(f"motionlab shape rig.toml --run rig --second-run rig {A} --json")
    check = json.loads(text)["check"]
    assert not check["holds"]
    assert OTHER in check["text"]
