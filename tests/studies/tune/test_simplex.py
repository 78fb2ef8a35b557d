"""Several simplexes at once: each as if alone, their questions answered together."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.studies.tune.search import search

Array = NDArray[np.float64]
OPTIMUM = np.array([0.7, -1.2])
BOX = np.array([[-3.0, 3.0], [-3.0, 3.0]])
STARTS = [np.array([-2.0, 2.0]), np.array([2.5, 2.5]), np.array([0.0, 0.0])]


def bowl(point: Array) -> float:
    away = point - OPTIMUM
    return float(away @ away + 0.5 * away[0] * away[1])


class Together:
    """Answers questions and remembers how many came at once."""

    def __init__(self) -> None:
        self.sizes: list[int] = []
        self.asked: dict[int, list[Array]] = {}

    def __call__(self, questions: Sequence[tuple[int, Array]]) -> list[float]:
        self.sizes.append(len(questions))
        for start, point in questions:
            self.asked.setdefault(start, []).append(point)
        return [bowl(point) for _, point in questions]


def test_every_start_finds_a_known_optimum() -> None:
    ended = search(STARTS, [BOX] * 3, Together(), evaluations=200)
    for end in ended:
        assert end.converged
        np.testing.assert_allclose(end.point, OPTIMUM, atol=0.01)


def test_starts_ask_together_and_none_waits_for_one_that_has_ended() -> None:
    together = Together()
    ended = search(STARTS, [BOX] * 3, together, evaluations=200)
    counts = sorted(end.evaluations for end in ended)
    assert together.sizes == sorted(together.sizes, reverse=True)
    assert len(together.sizes) == counts[-1]
    assert sum(together.sizes) == sum(counts)


def test_a_start_goes_the_same_way_alone() -> None:
    together, alone = Together(), Together()
    search(STARTS, [BOX] * 3, together, evaluations=60)
    search(STARTS[1:2], [BOX], alone, evaluations=60)
    np.testing.assert_array_equal(together.asked[1], alone.asked[0])


def test_an_optimum_outside_is_sought_at_the_edge_of_the_box() -> None:
    box = np.array([[-3.0, 0.0], [-3.0, 3.0]])
    together = Together()
    (end,) = search([np.array([-1.0, 0.0])], [box], together, evaluations=200)
    assert end.point[0] == pytest.approx(0.0, abs=0.01)
    assert max(point[0] for point in together.asked[0]) <= 0.0


def test_evaluations_are_bounded() -> None:
    (end,) = search(STARTS[:1], [BOX], Together(), evaluations=12)
    assert not end.converged
    assert end.evaluations <= 13


def test_what_the_evaluation_raises_ends_every_start() -> None:
    asked = 0

    def cancelled(questions: Sequence[tuple[int, Array]]) -> list[float]:
        nonlocal asked
        asked += 1
        if asked == 5:
            raise KeyError("cancelled")
        return [bowl(point) for _, point in questions]

    with pytest.raises(KeyError, match="cancelled"):
        search(STARTS, [BOX] * 3, cancelled, evaluations=200)
    assert asked == 5
