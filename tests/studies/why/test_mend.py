"""The smallest change that mends a peak: it does, keeps the margins, and a smaller one does not."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.loop.family import LoopFamily
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.why.document import WhyDocument
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


def test_it_says_when_nothing_mends_it() -> None:
    far = why(goal=1e-12)
    assert far.mend is None
    assert far.reached == 0
    assert "None of the" in far.why_not
    margins = why(limits={"gain_margin": 90.0})
    assert margins.mend is None
    assert margins.reached > 0
    assert "none of them keeps the margins" in margins.why_not


def test_equal_requests_give_equal_documents() -> None:
    assert why().model_dump() == why().model_dump()
