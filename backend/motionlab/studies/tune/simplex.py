"""Several simplexes at once, whose evaluations are made together.

scipy's Nelder-Mead evaluates one point after another. Each start therefore runs in a thread of its
own; an evaluation waits until all other starts wait too or have ended, and then one call computes
all points. The points of a start depend on its own values only, so nothing depends on the order of
threads.
"""

from __future__ import annotations

import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Evaluate = Callable[[Sequence[tuple[int, Array]]], Sequence[float]]
"""Takes (start, point) pairs and returns their values."""

_NEAR = 5e-3
"""A simplex whose corners differ by less has ended: half a percent of each gain."""
_FIRST_STEP, _NEXT_STEP = 0.7, 0.2
"""Size of the first simplex, in logarithms: twice a gain, and of those that begin where it ended;
less where the bounds are near."""
_WORTH = 1e-3
"""Share of the value by which a simplex must improve on the one before for another one to begin."""


@dataclass(frozen=True)
class SearchEnd:
    """Where a start ended.

    Attributes
    ----------
    point : ndarray, shape (n,)
        Best point.
    evaluations : int
        How many it took.
    converged : bool
        Whether the last simplex shrank to nothing, rather than running out of evaluations.
    """

    point: Array
    evaluations: int
    converged: bool


class _Broken(Exception):
    """Ends a start whose evaluations are used up."""


class _Meeting:
    """Where the starts meet to have their points evaluated."""

    def __init__(self, parties: int, evaluate: Evaluate) -> None:
        self._evaluate = evaluate
        self._present = set(range(parties))
        self._asked: dict[int, Array] = {}
        self._answers: dict[int, float] = {}
        self._condition = threading.Condition()
        self.failure: BaseException | None = None

    def ask(self, start: int, point: Array) -> float:
        """Return the value at a point, once every other start waits for one too."""
        with self._condition:
            self._asked[start] = point
            self._answer_if_complete()
            self._condition.wait_for(lambda: start in self._answers or self.failure is not None)
            if self.failure is not None:
                raise _Broken
            return self._answers.pop(start)

    def leave(self, start: int) -> None:
        """Leave: no more evaluations."""
        with self._condition:
            self._present.discard(start)
            self._answer_if_complete()

    def _answer_if_complete(self) -> None:
        if self.failure is not None or not self._asked or set(self._asked) != self._present:
            return
        questions = sorted(self._asked.items())
        try:
            values = self._evaluate(questions)
        except BaseException as error:  # raised in the thread that waits for the starts
            self.failure = error
        else:
            self._answers = {start: v for (start, _), v in zip(questions, values, strict=True)}
        self._asked = {}
        self._condition.notify_all()


def search(
    starts: Sequence[Array], bounds: Sequence[Array], evaluate: Evaluate, *, evaluations: int
) -> list[SearchEnd]:
    """Run the simplex from every start, side by side.

    Parameters
    ----------
    starts : sequence of ndarray, shape (n,)
        Where each begins: logarithms, inside its bounds. They need not be of one dimension.
    bounds : sequence of ndarray, shape (n, 2)
        Low and high of each number of each start.
    evaluate : callable
        Values of the points of all waiting starts. What it raises ends all.
    evaluations : int
        Largest number for one start.

    Returns
    -------
    list of SearchEnd
        In the order of `starts`.
    """
    meeting = _Meeting(len(starts), evaluate)
    ended: dict[int, SearchEnd] = {}

    def go(start: int) -> None:
        try:
            ended[start] = _descend(
                starts[start],
                bounds[start],
                lambda point: meeting.ask(start, point),
                evaluations,
            )
        except _Broken:
            pass
        finally:
            meeting.leave(start)

    threads = [threading.Thread(target=go, args=(start,)) for start in range(len(starts))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if meeting.failure is not None:
        raise meeting.failure
    return [ended[start] for start in range(len(starts))]


def _descend(
    start: Array, bounds: Array, value: Callable[[Array], float], evaluations: int
) -> SearchEnd:
    """Run the simplex, and anew from where it ended as long as that improves the value.

    A simplex that meets an edge, of the bounds or of a constraint, can collapse against it before
    it has arrived.
    """
    best, least, made, step = start, math.inf, 0, _FIRST_STEP
    while True:
        found = _simplex(best, bounds, value, step, evaluations - made)
        made += int(found.nfev)
        before, best, least = least, np.asarray(found.x), float(found.fun)
        converged = bool(found.success)
        led_on = least < before - _WORTH * abs(before) if math.isfinite(before) else True
        if not converged or not led_on or evaluations - made <= len(start) + 1:
            return SearchEnd(best, made, converged)
        step = _NEXT_STEP


def _simplex(
    start: Array, bounds: Array, value: Callable[[Array], float], step: float, evaluations: int
) -> Any:
    from scipy.optimize import minimize

    way = np.minimum(step, 0.25 * (bounds[:, 1] - bounds[:, 0]))
    way = np.where(start + way > bounds[:, 1], -way, way)
    return minimize(
        lambda point: value(np.array(point)),
        start,
        method="Nelder-Mead",
        bounds=bounds,
        options={
            "initial_simplex": np.vstack([start, start + np.diag(way)]),
            "maxfev": evaluations,
            "xatol": _NEAR,
            "fatol": np.inf,  # a flat floor is no reason to go on
        },
    )
