"""Controllers of every shipped scenario, exported as C, agree with their simulations."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.export.export import export_controller
from tests.export.compilers import SOURCES, STRICT, built, call, compiler


@pytest.mark.parametrize("name", names("scenarios"))
def test_every_variant_agrees_for_as_long_as_its_vectors_are(name: str, tmp_path: Path) -> None:
    scenario = load_scenario(name)
    for variant in scenario.variants:
        folder = tmp_path / variant
        export_controller(scenario, variant, folder)
        built(compiler("gcc"), *STRICT, "-O2", *SOURCES, "-lm", "-o", "check", cwd=folder)
        done = call("./check", "vectors.bin", cwd=folder)
        assert done.returncode == 0, done.stdout + done.stderr


def test_an_error_of_a_current_is_found_at_any_size(tmp_path: Path) -> None:
    """Squares allow di = 1e-12 I at full scale I, and sqrt(2e-12) I at no current at all."""
    scenario = load_scenario("circle", {"trajectory.lead_in": 0.1})
    export_controller(scenario, "B", tmp_path, seconds=0.5)
    code = (tmp_path / "psrm_controller.c").read_text()
    assigned = "output->current[k][1] = current.b"
    assert code.count(assigned) == 1
    for change, passes in {
        "* (1.0 + 0.9e-12)": True,
        "* (1.0 + 1.1e-12)": False,
        "+ ((current.b < 1e-9) ? 1.5e-6 : 0.0)": True,
        "+ ((current.b < 1e-9) ? 5e-6 : 0.0)": False,
        "* -1.0": False,
    }.items():
        changed = code.replace(assigned, f"{assigned} {change}")
        (tmp_path / "psrm_controller.c").write_text(changed)
        built(compiler("gcc"), *STRICT, "-O2", *SOURCES, "-lm", "-o", "check", cwd=tmp_path)
        done = call("./check", "vectors.bin", cwd=tmp_path)
        assert (done.returncode == 0) is passes, change + done.stdout
        scale = re.search(r"y +current b squared, A\^2 +(\S+)", done.stdout)
        assert scale is not None and 2.0 < float(scale[1]) < 5.0  # I^2
