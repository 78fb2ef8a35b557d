"""Exported C agrees with the simulation, for every law, sharing function, map and switch."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

import pytest

from motionlab.config.controller import SharingLaw
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.export.export import export_controller
from motionlab.laws import LAWS
from tests.export.compilers import SOURCES, STRICT, built, call, compiler

SECONDS = 0.2
CONTROLLER = "variants.A.controller"
MOVING = {"trajectory.laps": 1, "trajectory.lead_in": 0.1}
"""The circle soon at its full speed."""

TABLES = {
    f"{place}.{axis}.force_map": {"kind": "table", "name": "new-design", "offset": 3e-5}
    for place in ("plant", f"{CONTROLLER}.model")
    for axis in AXES
}
FORMULA: dict[str, Any] = {
    f"{place}.{axis}.force_map.{name}": value
    for place in ("plant", f"{CONTROLLER}.model")
    for axis in AXES
    for name, value in {"h_2": 0.03, "h_3": 0.039, "offset": 5e-5}.items()
}
NOTCH = {f"{CONTROLLER}.{axis}.notch.gain": 0.1 for axis in AXES} | {
    f"{CONTROLLER}.{axis}.filter_{number}.poles_frequency": 300.0 + 150.0 * number
    for axis in AXES
    for number in (1, 2, 3)
}
"""A notch and three low-passes."""
SWITCHES: dict[str, dict[str, Any]] = {
    "everything": NOTCH
    | {
        f"{CONTROLLER}.feedforward": True,
        f"{CONTROLLER}.disturbance_observer.enabled": True,
        f"{CONTROLLER}.compensation.law": "residual-k",
        f"{CONTROLLER}.compensation.velocity": "reference",
    },
    "delay": {
        f"{CONTROLLER}.delay": 1,
        f"{CONTROLLER}.disturbance_observer.enabled": True,
        f"{CONTROLLER}.compensation.law": "canudas-de-wit",
    },
    "ideal force": {"plant.force": "ideal", f"{CONTROLLER}.compensation.law": "residual-k"},
    "no friction": {
        f"{place}.{axis}.friction.enabled": False
        for place in ("plant", f"{CONTROLLER}.model")
        for axis in AXES
    },
    "k_d share": {
        f"{CONTROLLER}.compensation.law": "reversed-k",
        f"{CONTROLLER}.compensation.k_d_share": 1e-3,
    },
    "force at its limit": {
        f"{CONTROLLER}.compensation.law": "residual-k",
        f"{CONTROLLER}.force_limit": 12.0,
    },
    "force at its limit, shared by force per ampere": {
        f"{CONTROLLER}.force_limit": 12.0,
        f"{CONTROLLER}.sharing.law": "force-per-ampere",
    },
    "currents at their limit": {f"{CONTROLLER}.current_limit": 4.0},
    "residual-k at rest": {
        f"{CONTROLLER}.compensation.law": "residual-k",
        "trajectory": {"kind": "dwell", "duration": 1.0},
    },
    "estimate not added": {
        f"{CONTROLLER}.compensation.law": "lugre-observer",
        f"{CONTROLLER}.compensation.enabled": False,
    },
}


def passes(folder: Path, changes: Mapping[str, Any]) -> str:
    """Export a changed circle, run its check, which has to pass, and return what it printed."""
    resting = "trajectory" in changes
    # Limits are to be met here, not kept clear of.
    changes = {"thrust_reserve": 0.0, **changes}
    scenario = load_scenario("circle", changes if resting else MOVING | changes)
    export_controller(scenario, "A", folder, seconds=1.0 if resting else SECONDS)
    built(compiler("gcc"), *STRICT, "-O2", *SOURCES, "-lm", "-o", "check", cwd=folder)
    done = call("./check", "vectors.bin", cwd=folder)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.mark.parametrize("sharing", get_args(SharingLaw))
@pytest.mark.parametrize("law", list(LAWS))
def test_every_law_and_sharing_function(law: str, sharing: str, tmp_path: Path) -> None:
    """Both kinds of map by turns: each meets every law and every sharing function."""
    turn = list(LAWS).index(law) + get_args(SharingLaw).index(sharing)
    changes = {f"{CONTROLLER}.compensation.law": law, f"{CONTROLLER}.sharing.law": sharing}
    maps = TABLES if turn % 2 else FORMULA
    printed = passes(tmp_path, maps | changes)
    assert "400 periods, 0 numbers beyond" in printed


@pytest.mark.parametrize("switch", SWITCHES)
def test_every_switch(switch: str, tmp_path: Path) -> None:
    passes(tmp_path, FORMULA | SWITCHES[switch])
