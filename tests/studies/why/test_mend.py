"""The smallest change that mends a peak: it does, keeps the margins, and a smaller one does not."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.loop.family import LoopFamily
from motionlab.reports.document_text import document_text
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.why.documents import WhyDocument
from motionlab.studies.why.study import WhyStudy

LAP = {"trajectory.laps": 1}


def why(**request: Any) -> WhyDocument:
    """Return an explanation of an error on x of the circle."""
    study = WhyStudy()
    asked: dict[str, Any] = {"scenario": "circle", "set": LAP, "variant": "B", "axis": "x"}
    return study.run(study.plan(asked | request), lambda *_: None)


def largest(changes: dict[str, Any], window: bool = True) -> float:
    """Return the largest error of a whole run on x, by the recording of it."""
    prepared = prepare(load_scenario("circle", LAP | changes))
    error = run(prepared).variants["B"].channel("following_error", "x")
    return float(np.abs(error[slice(*prepared.window)] if window else error).max())


def test_the_change_mends_it_and_a_smaller_one_does_not() -> None:
    found = why()
    assert found.mend is not None
    assert found.why_not == ""
    assert found.goal == pytest.approx(0.5 * found.peak)
    assert max(found.mend.error, found.mend.window_error) <= found.goal
    assert largest(found.mend.set) == pytest.approx(found.mend.window_error, rel=1e-6)
    if found.mend.factor is not None:
        smaller = {path: value / found.mend.factor**0.2 for path, value in found.mend.set.items()}
        assert largest(smaller) > found.goal


def test_the_margins_of_the_change_are_those_of_its_loop_and_hold() -> None:
    found = why(limits={"gain_margin": 2.0, "phase_margin": math.radians(40.0)})
    assert found.mend is not None
    assert found.mend.gain_margin is not None
    assert found.mend.phase_margin is not None
    assert found.mend.phase_margin >= math.radians(40.0)
    scenario = load_scenario("circle", LAP | found.mend.set)
    gains = scenario.variants["B"].controller.x
    figures = LoopFamily.of(scenario, "B", "x").figures(gains.k_p, gains.k_d)
    assert found.mend.gain_margin == pytest.approx(figures.gain_margin.value)
    assert found.mend.phase_margin == pytest.approx(figures.phase_margin.value)


def test_where_nothing_reaches_the_goal_the_nearest_within_the_margins_is_offered() -> None:
    far = why(goal=1e-12)
    assert far.reached == 0
    assert "None of the" in far.why_not
    assert far.mend is not None
    assert not far.mend.reaches
    assert far.mend.window_error < 0.5 * far.peak
    assert largest(far.mend.set) == pytest.approx(far.mend.window_error, rel=1e-6)
    assert far.mend.phase_margin is not None
    assert far.mend.phase_margin >= math.radians(30.0)


def test_two_changes_reach_what_none_alone_does() -> None:
    both = why(goal=0.2e-6)
    assert both.mend is not None
    assert both.mend.reaches
    assert both.mend.factor is None
    assert " and feedforward on" in both.mend.label
    assert both.why_not == ""
    assert largest(both.mend.set) == pytest.approx(both.mend.window_error, rel=1e-6)


def test_the_nearest_keeps_a_margin_that_all_that_reach_the_goal_break() -> None:
    near = why(goal=0.4e-6, limits={"gain_margin": 7.28, "phase_margin": None})  # 7.29 as it is
    assert near.reached > 0
    assert near.mend is not None
    assert not near.mend.reaches
    assert "none of them keeps the margins" in near.why_not
    assert near.mend.gain_margin is not None
    assert near.mend.gain_margin >= 7.28


def test_a_change_with_which_the_run_diverges_later_mends_nothing() -> None:
    late = {"divergence_error": 1e-3, "load.steps": [{"time": 8.0, "x": 100.0}]}
    with_load = why(set=late, time=5.0)
    assert with_load.mend is None
    assert with_load.window_peak is None
    assert with_load.reached == 0
    json.loads(with_load.model_dump_json(), parse_constant=pytest.fail)
    assert "nan " not in document_text(with_load)


@pytest.mark.parametrize(("share", "size"), [(0.6, 0.537), (0.9, 0.020)])
def test_no_smaller_change_of_any_number_mends_it(share: float, size: float) -> None:
    """Sizes by a search of every number at every per cent."""
    whole: dict[str, Any] = {"set": {}}
    peak = why(**whole).peak
    mend = why(goal=share * peak, **whole).mend
    assert mend is not None and mend.factor is not None
    assert abs(math.log(mend.factor)) <= size + 0.005


def test_gains_that_break_a_limit_as_they_are_get_a_change_that_makes_nothing_worse() -> None:
    present = LoopFamily.of(load_scenario("circle"), "B", "y").figures(280.5e3, 1080.0)
    assert present.phase_margin.value < 0.5236
    mended = why(set={}, axis="y").mend
    assert mended is not None and mended.eased
    assert mended.phase_margin is not None and mended.gain_margin is not None
    assert mended.phase_margin >= present.phase_margin.value * (1.0 - 1e-5)
    assert mended.gain_margin >= min(2.0, present.gain_margin.value) * (1.0 - 1e-5)
    kept = why(set={"variants.B.controller.y.k_d": 3500.0}, axis="y").mend
    assert kept is not None and not kept.eased


def test_a_moment_of_a_motion_that_goes_on_is_that_of_its_period() -> None:
    early, late = why(time=2.3), why(time=2.3 + 40 * 3.0)
    assert late.period == pytest.approx(3.0)
    assert (late.time, late.peak) == (early.time, early.peak)


def test_equal_requests_give_equal_documents() -> None:
    assert why().model_dump() == why().model_dump()
