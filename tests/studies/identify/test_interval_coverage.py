"""That the intervals of an identification hold the truth, on a few drawn motors."""

from __future__ import annotations

from tests.bench.coverage import draws, outcome

COUNT = 4
"""Draws: a motor each of x and y, with noise and without; `make bench` takes 200."""

LEAST = 28
"""Of 32 intervals 30 are expected to hold the truth; were each 79 % sure, 25 would."""


def test_intervals_of_drawn_motors_hold_the_truth() -> None:
    outcomes = [outcome(draw) for draw in draws(COUNT, 300, {"time_max": 2.0})]
    held = [(name, o.holds(name)) for o in outcomes for name in o.parameters]
    assert len(held) == 8 * COUNT
    lost = [name for name, holds in held if not holds]
    assert len(held) - len(lost) >= LEAST, lost
