"""Friction effects of one's own among the friction models of a record."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from tests.own_laws.test_everywhere import command
from tests.paths import ROOT
from tests.studies.friction.one_axis_machine import PERIOD, sines
from tests.studies.identify.measured_runs import imported

Array = NDArray[np.float64]

EFFECTS = ROOT / "tests" / "fixtures" / "effects"
TRUE = {"dry": 1.0, "drop": 1.5, "v_h": 0.012, "viscous": 15.0}
MASS = 5.0
SINES = [(0.03, 0.3, 2), (0.015, 0.9, 3), (0.003, 0.4, 2), (2e-4, 0.6, 2)]


def imported_rig(folder: Path, unit: str = "N") -> str:
    """Import a rig with the friction of Hess and Soom, written anew; its force by the motion."""
    position, rng = sines(SINES), np.random.default_rng(3)
    velocity = np.gradient(position, PERIOD)
    level = TRUE["dry"] + TRUE["drop"] / (1.0 + (velocity / TRUE["v_h"]) ** 2)
    force = level * np.tanh(velocity / 2e-4) + TRUE["viscous"] * velocity
    force += MASS * np.gradient(velocity, PERIOD) + 0.02 * rng.standard_normal(len(position))
    columns: dict[str, Array] = {
        "time [s]": (np.arange(len(position)) * PERIOD).astype(np.float64),
        "slide [mm]": (1e3 * np.rint(position / 5e-8) * 5e-8).astype(np.float64),
        f"push [{unit}]": force.astype(np.float64),
    }
    return imported(folder, columns, "slide=", "push=")


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "data"
    monkeypatch.setenv("MOTIONLAB_DATA", str(folder))
    return folder


def compared(run: str, data: Path, laws: Path, *words: str) -> Any:
    columns = ("--position-column", "slide", "--force-column", "push")
    return command(
        *("friction-models", run, *columns, "--laws", laws, *words), MOTIONLAB_DATA=str(data)
    )


def test_an_own_friction_is_selected_on_data_made_by_it(data: Path, tmp_path: Path) -> None:
    run = imported_rig(tmp_path)
    words = ("--effect", "hess-soom", "--effect", "run-in", "--json")
    done = compared(run, data, EFFECTS, *words)
    assert done.returncode == 0, done.stderr
    document = json.loads(done.stdout)
    models = {model["name"]: model for model in document["models"]}
    assert document["selected"] == "hess-soom", document["reasons"]
    assert models["stribeck"]["error"] > 3.0 * models["hess-soom"]["error"]
    assert models["run-in"]["error"] > 10.0 * models["hess-soom"]["error"]
    for name, true in (TRUE | {"M": MASS}).items():
        estimate = models["hess-soom"]["parameters"][name]
        half = 2.0 * (estimate["value"] - estimate["low"])  # one record: twice the 95 % interval
        assert estimate["value"] == pytest.approx(true, abs=half, rel=0.003), name
    assert models["hess-soom"]["parameters"]["v_h"]["unit"] == "m/s"


def test_a_file_that_is_wrong_is_the_reason(data: Path, tmp_path: Path) -> None:
    run = imported_rig(tmp_path)
    text = (EFFECTS / "hess_soom.py").read_text()
    laws = tmp_path / "laws"
    laws.mkdir()
    (laws / "hess_soom.py").write_text(text.replace('unit="m/s", ', ""))
    done = compared(run, data, laws, "--effect", "hess-soom")
    assert done.returncode == 2
    assert "effects.0: is no effect; got 'hess-soom'" in done.stderr
    assert "hess_soom.py: hess-soom.v_h.unit: is missing" in done.stderr
    (laws / "hess_soom.py").write_text(text.replace("seen.velocity / par", "seen.current_a / par"))
    done = compared(run, data, laws, "--effect", "hess-soom")
    assert done.returncode == 2
    assert "effects.0: depends on current_a, which is not known of a record" in done.stderr


def test_parameters_of_newtons_are_not_those_of_a_torque(data: Path, tmp_path: Path) -> None:
    run = imported_rig(tmp_path, "A")
    done = compared(run, data, EFFECTS, "--effect", "hess-soom")
    assert done.returncode == 2
    assert "has parameters of m and N, the record is in m and A" in done.stderr
