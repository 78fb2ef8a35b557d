"""A force-sharing function that is one file more in the package is wherever one can be."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.export.compilers import call, compiler
from tests.one_file import lab_with, printed
from tests.paths import ROOT

FUNCTION = ROOT / "tests" / "fixtures" / "sharing" / "linear.py"


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Return the environment of a lab that has the function."""
    return lab_with("force_sharing/functions", tmp_path_factory.mktemp("lab"), FUNCTION)


def test_it_is_a_field_simulated_and_in_the_module_of_the_page(
    environment: dict[str, str],
) -> None:
    words = ("tests.force_sharing.surfaces", "linear")
    computed: dict[str, Any] = json.loads(printed(environment, *words))
    assert "linear" in computed["choices"]
    assert computed["fields"] == {
        "overlap": ["cubic", "linear", "sine"],
        "advance": ["linear"],
        "rise": ["least-normal-force"],
    }
    assert computed["schema"] and computed["lane_code"]
    assert computed["differs"] > 0.1  # A, against A by least norm
    assert computed["module_error"] < 1e-6


def test_it_is_compared_with_the_others(environment: dict[str, str]) -> None:
    words = ("motionlab", "sharing", "--json", "--set", "law=linear", "--set", "advance=0.02")
    shifted, centred = (json.loads(printed(environment, *some)) for some in (words, words[:-2]))
    assert shifted["law"] == "linear"
    assert shifted["loss"]["relative"] > centred["loss"]["relative"] > 1.0
    assert shifted["believed"]["mean"] == pytest.approx(20.0, abs=0.01)


def test_it_is_exported(environment: dict[str, str], tmp_path: Path) -> None:
    words = ("export-controller", "circle", "-o", str(tmp_path / "new"), "--variant", "B")
    changes = ("sharing.law=linear", "sharing.advance=0.01")
    options = [f"--set=variants.B.controller.{change}" for change in changes]
    more = ("--seconds", "0.5", "--set=trajectory.lead_in=0.1")
    printed(environment, "motionlab", *words, *options, *more)
    checked = call("make", "-C", tmp_path / "new", "check", f"CC={compiler('gcc')}")
    assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr
    code = (tmp_path / "new" / "psrm_controller.c").read_text()
    assert "/* Return the shares, which rise along z. */\nstatic psrm_phases linear(" in code
