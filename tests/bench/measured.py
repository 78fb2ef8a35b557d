"""How often the 95 % intervals of an identification from a measurement hold the truth.

``make bench BENCH=measured`` moves `DRAWS` motors by an integrator that is not the lab's, writes
what a rig would log of each as CSV, imports it and identifies from it: by currents and by the force
command in turns. The variable ``MOTIONLAB_DRAWS`` gives another number. Friction parameters are
within a quarter of the nominal ones, the mass within a tenth, and half have a load up to 0.3 N.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import NamedTuple

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.studies.identify.documents import read_request
from motionlab.studies.identify.experiment import plan_identification, run_identification
from tests.bench.table import Row
from tests.studies.identify.independent_rig import recorded, reference, sines
from tests.studies.identify.measured_runs import imported

DRAWS = 48
SEED = 60_000
"""Of the first draw; none of them was looked at when the method was chosen."""

_NAMES = ("F_c", "F_s", "v_s", "sigma_2", "f_0", "M", "sigma_0", "sigma_1")
_LOW, _HIGH = 0.93, 0.97
_LOAD = 0.3  # N


class Outcome(NamedTuple):
    """What became of one draw: error, half of the interval and true value by name."""

    force: str
    parameters: dict[str, tuple[float, float, float]]

    def holds(self, name: str) -> bool:
        """Return whether the interval of a parameter holds its true value."""
        error, half, _ = self.parameters[name]
        return abs(error) <= half


def outcome(seed: int) -> Outcome:
    """Measure one motor, identify it, and compare with what it is."""
    rng = np.random.default_rng(seed)
    nominal = load_scenario("circle").plant.x
    true = {
        name: getattr(nominal.friction, name) * rng.uniform(0.75, 1.25)
        for name in ("F_c", "F_s", "v_s", "sigma_2", "sigma_0", "sigma_1")
    }
    true["M"] = nominal.mass * rng.uniform(0.9, 1.1)
    true["f_0"] = rng.uniform(-_LOAD, _LOAD) if seed // 2 % 2 else 0.0
    force = ("currents", "M.x.force_command")[seed % 2]
    with tempfile.TemporaryDirectory() as folder:
        os.environ["MOTIONLAB_DATA"] = folder
        run = imported(Path(folder), recorded(true, reference(sines(rng)), seed=seed))
        request = {"run": run, "axis": "x", "record": {"force": force}}
        found = run_identification(plan_identification(read_request(request))).axes["x"]
    assert found.presliding is not None
    parameters: dict[str, tuple[float, float, float]] = {}
    for name, p in {**found.sliding.parameters, **found.presliding.parameters}.items():
        half = np.inf if p.high is None else p.high - p.value
        parameters[name] = (p.value - true[name], half, true[name])
    return Outcome(force, parameters)


def measured() -> Iterator[Row]:
    """Measure many motors, one process a core; count what the intervals hold."""
    count = int(os.environ.get("MOTIONLAB_DRAWS", DRAWS))
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as pool:
        outcomes = [*pool.map(outcome, range(SEED, SEED + count))]
    yield _held(f"all: {count} draws", [(o, name) for o in outcomes for name in _NAMES], True)
    for name in _NAMES:
        for force in ("currents", "M.x.force_command"):
            yield _held(f"  {name}, {force}", [(o, name) for o in outcomes if o.force == force])


def _held(label: str, cases: list[tuple[Outcome, str]], judged: bool = False) -> Row:
    held = sum(o.holds(name) for o, name in cases)
    share = held / len(cases) if cases else float("nan")
    text = f"{share:.1%}"
    if cases and not judged:
        error = np.array([o.parameters[n][0] for o, n in cases])
        half, true = (np.median([o.parameters[n][k] for o, n in cases]) for k in (1, 2))
        scale, unit = (1.0, " N") if cases[0][1] == "f_0" else (true, "")
        text += f", +-{half / scale:.1e}{unit}, low {int(np.sum(error < 0.0))}"
        text += f", mean {error.mean() / scale:+.1e}"
    return Row(
        label,
        f"{_LOW:.0%} to {_HIGH:.0%}" if judged else "",
        text,
        f"{held} of {len(cases)}",
        "",
        _LOW <= share <= _HIGH if judged else None,
    )
