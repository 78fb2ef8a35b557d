"""What a constraint costs: nothing where it holds, however well; else by which share."""

from __future__ import annotations

import math

import pytest

from motionlab.simulation.family import Figures
from motionlab.tune.cost import margin_violations, outcome_violations
from motionlab.tune.request import Constraints
from motionlab.tune.trials import RAN_AWAY, Outcome

WANTED = Constraints(gain_margin=2.0, phase_margin=0.5, Ms=2.0, saturated=0.1, force=10.0)
STILL = Outcome(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, diverged=False)


@pytest.mark.parametrize(
    ("figures", "violations"),
    [
        (Figures(2.0, 0.5, 2.0), {}),
        (Figures(math.inf, math.inf, 1.0), {}),  # no frequency at which it could become unstable
        (Figures(1.0, 0.5, 2.0), {"gain_margin": math.log(2.0)}),
        (Figures(2.0, 0.25, 4.0), {"phase_margin": math.log(2.0), "Ms": math.log(2.0)}),
    ],
)
def test_margins_that_fall_short(figures: Figures, violations: dict[str, float]) -> None:
    assert margin_violations(WANTED, figures) == pytest.approx(violations)


def test_no_margin_at_all_is_a_finite_violation() -> None:
    found = margin_violations(WANTED, Figures(2.0, 0.0, 2.0))
    assert math.log(1e3) < found["phase_margin"] < math.inf


def test_limits_that_are_exceeded() -> None:
    assert outcome_violations(WANTED, STILL) == {}
    assert outcome_violations(WANTED, STILL._replace(force=20.0, saturated=0.3)) == pytest.approx(
        {"force": math.log(2.0), "saturated": 0.2}
    )
    assert list(outcome_violations(WANTED, RAN_AWAY)) == ["diverged"]
