"""What a constraint costs: nothing where it holds, however well; else by which share."""

from __future__ import annotations

import math

import pytest

from motionlab.loop.family import Figures, VelocityMargin
from motionlab.studies.tune.documents import Constraints
from motionlab.studies.tune.evaluation import (
    ConstraintViolation,
    Verdict,
    margin_violations,
    outcome_violations,
)
from motionlab.studies.tune.problem import DIVERGED, Outcome

WANTED = Constraints(gain_margin=2.0, phase_margin=0.5, Ms=2.0, saturated=0.1, force=10.0)
STILL = Outcome(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, diverged=False)


def figures(gain_margin: float, phase_margin: float, Ms: float) -> Figures:
    return Figures(*(VelocityMargin(value, 0.02) for value in (gain_margin, phase_margin, Ms)))


def shares(violations: list[ConstraintViolation]) -> dict[str, float]:
    return {one.words.split()[0]: one.share for one in violations}


@pytest.mark.parametrize(
    ("margins", "violations"),
    [
        (figures(2.0, 0.5, 2.0), {}),
        (figures(math.inf, math.inf, 1.0), {}),  # no frequency at which it could become unstable
        (figures(1.0, 0.5, 2.0), {"gain_margin": math.log(2.0)}),
        (figures(2.0, 0.25, 4.0), {"phase_margin": math.log(2.0), "Ms": math.log(2.0)}),
    ],
)
def test_margins_that_fall_short(margins: Figures, violations: dict[str, float]) -> None:
    assert shares(margin_violations(WANTED, margins)) == pytest.approx(violations)


def test_no_margin_at_all_is_a_finite_violation() -> None:
    found = shares(margin_violations(WANTED, figures(2.0, 0.0, 2.0)))
    assert math.log(1e3) < found["phase_margin"] < math.inf


def test_a_margin_that_falls_short_is_told_with_its_velocity() -> None:
    (found,) = margin_violations(WANTED, figures(2.0, 0.25, 2.0))
    assert found.words == "phase_margin = 0.250 rad at 20 mm/s, at least 0.500 wanted"


def test_limits_that_are_exceeded() -> None:
    assert outcome_violations(WANTED, STILL) == []
    found = outcome_violations(WANTED, STILL._replace(force=20.0, saturated=0.3))
    assert shares(found) == pytest.approx({"force": math.log(2.0), "saturated": 0.2})
    assert [one.words for one in found] == [
        "saturated = 0.3000, at most 0.1000 wanted",
        "force = 20.00 N, at most 10.00 wanted",
    ]
    assert [one.words for one in outcome_violations(WANTED, DIVERGED)] == ["diverges"]


def verdict(cost: float, *, linear: float = 0.0, tried: float = 0.0) -> Verdict:
    def at(share: float) -> dict[tuple[str, str], list[ConstraintViolation]]:
        return {
            ("nominal", "x"): [ConstraintViolation(share, f"short by {share}")] if share else []
        }

    return Verdict(cost, at(linear), at(tried))


def test_gains_are_ranked_by_cost_then_by_what_they_violate() -> None:
    best_first = [
        verdict(1.0),
        verdict(2.0),
        verdict(0.5, tried=0.1),
        verdict(0.1, tried=0.2),
        verdict(math.nan, linear=0.3),
    ]
    values = [one.value for one in best_first]
    assert values == sorted(values)
    assert [one.feasible for one in best_first] == [True, True, False, False, False]
    assert best_first[2].reasons == ["x on nominal: short by 0.1"]


def test_gains_better_others_that_cost_more_or_are_not_feasible() -> None:
    good, dear, bad, away = (
        one.document()
        for one in (
            verdict(1.0),
            verdict(2.0),
            verdict(0.5, tried=0.1),
            verdict(math.inf, tried=1e3),
        )
    )
    assert good.betters(dear) and good.betters(bad) and good.betters(away)
    assert not (dear.betters(good) or bad.betters(good) or good.betters(good))
    assert (away.cost, away.feasible) == (None, False)
