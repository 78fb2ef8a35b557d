"""A law that is one file more in the package is exported as C, and agrees with its simulation."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

from tests.export.compilers import call, compiler
from tests.paths import ROOT

LAW = '''"""Viscous friction, and a relay that a dead zone keeps from chattering."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, compiled, select
from motionlab.laws.law import Estimate, Law, Parameter, Seen

LEVEL = Parameter("level", "Coulomb friction of the relay", unit="N", default=0.3, ge=0, le=100)
ZONE = Parameter("zone", "Half width of the dead zone", unit="m/s", default=1e-3, ge=0, le=1)


class RelayParameters(NamedTuple):
    """Parameters of each lane."""

    level: Lanes  # Coulomb friction, N
    zone: Lanes  # half width of the dead zone, m/s


class RelayState(NamedTuple):
    """State of each lane."""

    side: Lanes  # -1, 0 or 1: where the relay stands


@compiled
def relay(par: RelayParameters, state: RelayState, seen: Seen) -> tuple[Estimate, RelayState]:
    """Estimate friction as ``level side + sigma_2 v_ref``."""
    side = select(seen.v_ref > par.zone, 1.0, state.side)
    side = select(seen.v_ref < -par.zone, -1.0, side)  # between, it stays
    force = par.level * side + seen.friction.sigma_2 * seen.v_ref
    return Estimate(force, z=0.0, K=0.0), RelayState(side)


LAW = Law(
    name="relay",
    label="viscous and relay",
    description="Viscous friction, and a relay with a dead zone",
    source="a test",
    step=relay,
    Parameters=RelayParameters,
    State=RelayState,
    parameters=(LEVEL, ZONE),
)
'''


def test_a_law_of_ones_own_is_exported(tmp_path: Path) -> None:
    package = tmp_path / "motionlab"
    shutil.copytree(
        ROOT / "backend" / "motionlab", package, ignore=shutil.ignore_patterns("__pycache__")
    )
    shutil.copytree(ROOT / "configs", package / "configs")  # as in a wheel
    (package / "laws" / "relay.py").write_text(LAW)
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "NUMBA_CACHE_DIR": str(tmp_path)}
    words = ("export-controller", "circle", "-o", "new", "--variant", "B", "--seconds", "0.5")
    changes = ("compensation.law=relay", "compensation.level=0.25")
    options = [f"--set=variants.B.controller.{change}" for change in changes]
    done = subprocess.run(
        [sys.executable, "-m", "motionlab", *words, *options, "--set=trajectory.lead_in=0.1"],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    checked = call("make", "-C", tmp_path / "new", "check", f"CC={compiler('gcc')}")
    assert "1000 periods, 0 numbers beyond" in checked.stdout, checked.stdout + checked.stderr
    code = (tmp_path / "new" / "psrm_controller.c").read_text()
    assert "/* Estimate friction as level side + sigma_2 v_ref. */\nstatic void relay(" in code
