"""Tuning on a machine: what its runs lead to, and rehearsals on machines unlike the model."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.safe_tune.documents import SafeTuneDocument, SafeTuneRequest
from motionlab.studies.safe_tune.report import report
from motionlab.studies.safe_tune.search import Limits, Measured, _discrepancy
from motionlab.studies.safe_tune.tuning import plan, tune_safely

pytest.importorskip("sklearn")
GAINS = "variants.B.controller.x"


@pytest.fixture(autouse=True)
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))


def carried_out(**request: Any) -> SafeTuneDocument:
    return tune_safely(plan(SafeTuneRequest.model_validate({"axis": "x", **request})))


def number(value: float | None) -> float:
    assert value is not None
    return value


def test_a_rehearsal_improves_within_every_limit() -> None:
    done = carried_out(
        machine={"plant": "matched", "plant.x.mass": 6.2}, motions=5, measure=False, motors=4
    )
    assert len(done.motions) == 5
    assert done.ended == "5 motions are made, as many as were requested"
    assert all(each.within for each in done.motions)
    first, best = done.motions[0], done.motions[done.best or 0]
    assert number(best.metric) < 0.4 * number(first.metric)
    gains = np.array([[each.k_p, each.k_d] for each in done.motions])
    for k in range(1, 5):
        apart = np.abs(np.log(gains[:k] / gains[k])).max(axis=1).min()
        assert apart <= np.log(1.5) + 1e-3
    assert done.changes == {f"{GAINS}.k_p": best.k_p, f"{GAINS}.k_d": best.k_d}
    assert "5 motions are made" in report(done)


def test_a_limit_on_force_is_kept_where_more_gain_would_break_it() -> None:
    machine = {"plant": "matched"}
    free = carried_out(machine=machine, motions=6, measure=False, motors=2)
    forces = [number(each.force) for each in free.motions]
    bound = min(forces) + 0.3 * (max(forces) - min(forces))
    held = carried_out(machine=machine, motions=6, measure=False, motors=2, force=bound)
    assert all(each.within for each in held.motions)
    assert "force" in held.examined.refused


def test_a_rehearsal_that_diverges_ends() -> None:
    resonance = {"frequency": 200.0, "damping": 0.001, "coupling": -0.9}
    machine = {"plant.x.resonance": resonance}
    done = carried_out(scenario="circle-resonant", machine=machine, measure=False, motors=2)
    (only,) = done.motions
    assert not only.within and only.metric is None
    assert done.ended.startswith("motion 1 diverged")
    assert "diverged" in report(done)
    assert done.model_dump_json()


def test_the_first_proposal_is_the_present_gains() -> None:
    first = carried_out(scenario="circle", motors=2)
    assert first.proposal is not None
    assert first.proposal.changes == {}
    assert first.proposal.beyond
    assert first.error is None


def kept_run(changes: dict[str, Any]) -> str:
    prepared = prepare(load_scenario("circle", changes))
    return library().keep(prepared, run(prepared), {}, name="a motion").id


def test_runs_lead_to_the_next_gains() -> None:
    first = kept_run({})
    step = carried_out(runs=[first], motors=2)
    assert step.proposal is not None
    assert step.proposal.beyond
    assert "beyond every motion made: k_p" in step.proposal.text
    assert step.error == pytest.approx(2.0 * number(step.motions[0].error))
    assert step.error is not None
    assert step.proposal.error_high <= step.error
    second = kept_run(step.proposal.changes)
    after = carried_out(runs=[first, second], motors=2)
    assert after.best == 1
    assert after.motions[1].metric == pytest.approx(step.proposal.expected, rel=0.1)


def test_a_run_of_another_motion_or_controller_is_refused() -> None:
    other = kept_run({"variants.B.controller.compensation.law": "off"})
    with pytest.raises(ConfigError, match=r"runs\.0.*compensation\.law"):
        carried_out(runs=[other])
    slower = kept_run({"trajectory.frequency": 0.7})
    with pytest.raises(ConfigError, match=r"runs\.0.*trajectory"):
        carried_out(runs=[slower])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"machine": {"variants.B.controller.x.k_p": 1.0}}, "is not of the machine"),
        ({"machine": {}, "runs": ["r-abcdefghijkl"]}, "leave out runs and response"),
        ({"runs": ["r-abcdefghijkl"]}, r"runs\.0"),
        ({"set": {f"{GAINS}.k_p": 0.0}}, "must be above 0"),
        ({"scenario": "trapezoid-y"}, "does not move"),
        ({"variant": "C"}, "is no variant"),
        ({"vary": [{"path": "friction.F_x", "kind": "value", "value": 1.0}]}, r"vary\.0\.path"),
        ({"set": {"variants.B.controller": "published-k"}}, "linearis"),
    ],
)
def test_what_cannot_be_tuned_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        carried_out(**wrong)


def test_the_discrepancy_is_unknown_where_nothing_was_measured() -> None:
    at = np.log([[1.0, 1.0], [1.5, 1.0], [1.0, 1.5]])
    mean, spread = _discrepancy(at, np.full(3, 0.4), np.log([[1.0, 1.0], [20.0, 20.0]]))
    assert mean[0] == pytest.approx(0.4, abs=0.02)
    assert spread[0] < 0.03
    assert spread[1] > 1.5 * spread[0]


def test_limits_count_error_and_force() -> None:
    outputs = np.array([[1.0, 1.0, 1.0], [1.0, 3.0, 1.0], [1.0, 1.0, 3.0]])
    kept = Limits(2.0, 2.0).keep(Measured(np.ones((3, 2)), outputs))
    assert kept.tolist() == [True, False, False]
