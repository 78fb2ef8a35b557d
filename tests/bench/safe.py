"""Tuning on machines unlike the model, drawn at random, against the best gains of each."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.loop.family import LoopFamily
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.studies.safe_tune.documents import VARY, SafeTuneDocument, SafeTuneRequest
from motionlab.studies.safe_tune.model import Bench, gains_of
from motionlab.studies.safe_tune.tuning import plan, tune_safely
from tests.bench.table import Row

_DRAWS = int(os.environ.get("MOTIONLAB_DRAWS", "10"))
_SEED = 777  # draws of other seeds were for building it
_CASES = (("circle", "x"), ("circle-resonant", "y"))
_SIDE = np.geomspace(0.25, 25.0, 24)
_WITHIN = 1.1


@dataclass(frozen=True)
class Outcome:
    """What became of one machine; `best` is NaN where no gains keep the limits."""

    motions: int
    beyond: int
    start: float
    reached: float
    best: float

    @property
    def ratio(self) -> float:
        """What was reached over the best."""
        return self.reached / self.best


def safe() -> Iterator[Row]:
    """Rehearse on all, half of them rigid and half with a resonance."""
    begun = time.perf_counter()
    outcomes: dict[str, list[Outcome]] = {}
    for name, axis in _CASES:
        outcomes[f"{name}, {axis}"] = list(_outcomes(name, axis, (_DRAWS + 1) // 2))
    took = (time.perf_counter() - begun) / _DRAWS
    for case, some in outcomes.items():
        ratios = np.array([each.ratio for each in some if np.isfinite(each.best)])
        share = 100.0 * float(np.mean(ratios <= _WITHIN))
        gained = np.median([each.start / each.reached for each in some])
        motions = [each.motions for each in some]
        beyond = sum(each.beyond for each in some)
        yield Row(
            f"within 10 % of the best, {case}",
            "100 % of machines",
            f"{share:.0f} % of {len(ratios)}; ratio {np.median(ratios):.2f}, at most "
            f"{ratios.max():.2f}",
            met=bool(share == 100.0),
        )
        yield Row(
            f"motions, {case}",
            "20",
            f"{np.median(motions):.0f}, at most {max(motions)}; error {gained:.3g} times smaller",
            met=max(motions) <= 20,
        )
        yield Row(f"violations, {case}", "0", f"{beyond} of {sum(motions)}", met=beyond == 0)
    yield Row("a machine, with the search for its best", "", f"{took:.0f} s", met=None)


def _outcomes(name: str, axis: str, count: int) -> Iterator[Outcome]:
    scenario = load_scenario(name)
    tables = scenario.model_dump(mode="json")
    vary = tuple(each for each in VARY if each.path not in missing(tables["plant"], VARY))
    for changes in draw(tables["plant"], vary, cases=count, seed=_SEED):
        request = SafeTuneRequest.model_validate(
            {"scenario": name, "axis": axis, "machine": changes}
        )
        done = tune_safely(plan(request))
        yield _outcome(load_scenario(apply_changes(tables, changes)), request, done)


def _outcome(machine: Scenario, request: SafeTuneRequest, done: SafeTuneDocument) -> Outcome:
    variant = list(machine.variants)[1]
    k_p, k_d = gains_of(machine, variant, request.axis)
    p, d = (each.ravel() for each in np.meshgrid(k_p * _SIDE, k_d * _SIDE))
    margins = LoopFamily.of(machine, variant, request.axis).margins_over(p, d)
    kept = margins["gain_margin"] >= request.gain_margin
    kept &= margins["phase_margin"] >= request.phase_margin
    best = np.nan
    if kept.any():
        metric, error, force = Bench(machine, variant, request.axis, request.metric).measure(
            p[kept], d[kept]
        )
        assert done.error is not None
        within = (error <= done.error) & (force <= done.force)
        best = float(metric[within].min()) if within.any() else np.nan
    assert done.best is not None
    start, reached = done.motions[0].metric, done.motions[done.best].metric
    assert start is not None and reached is not None
    return Outcome(
        len(done.motions),
        sum(not each.within for each in done.motions),
        start,
        reached,
        best,
    )
