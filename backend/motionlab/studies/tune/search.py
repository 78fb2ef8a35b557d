"""The search for gains: simplexes from several starts, whose evaluations share batches.

scipy's Nelder-Mead evaluates one point after another. Each start therefore runs in a thread of its
own; an evaluation waits until all other starts wait too or have ended, and then one call computes
all points. The points of a start depend on its own values only, so nothing depends on the order of
threads.
"""

from __future__ import annotations

import functools
import itertools
import math
import threading
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.lanes import model_hash
from motionlab.simulation.result import plant_name
from motionlab.studies.tune.candidate_document import candidate
from motionlab.studies.tune.documents import (
    Candidate,
    PartialGroup,
    PartialTuning,
    TunedGroup,
    TuneDocument,
    TunedStart,
    TuneHistory,
    TuneRequest,
)
from motionlab.studies.tune.evaluation import Group, of_loops, of_trial, with_published
from motionlab.studies.tune.problem import Outcome, TuningProblem, unstable_warnings
from motionlab.timing import CONTROL_PERIOD

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
    """End of a start.

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
    """Barrier at which the starts have their points evaluated together."""

    def __init__(self, parties: int, evaluate: Evaluate) -> None:
        self._evaluate = evaluate
        self._present = set(range(parties))
        self._points: dict[int, Array] = {}
        self._answers: dict[int, float] = {}
        self._condition = threading.Condition()
        self.failure: BaseException | None = None

    def ask(self, start: int, point: Array) -> float:
        """Return the value at a point, once every other start waits for one too."""
        with self._condition:
            self._points[start] = point
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
        if self.failure is not None or not self._points or set(self._points) != self._present:
            return
        questions = sorted(self._points.items())
        try:
            values = self._evaluate(questions)
        except BaseException as error:  # raised in the thread that waits for the starts
            self.failure = error
        else:
            self._answers = {start: v for (start, _), v in zip(questions, values, strict=True)}
        self._points = {}
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
        minimum = _simplex(best, bounds, value, step, evaluations - made)
        made += int(minimum.nfev)
        before, best, least = least, np.asarray(minimum.x), float(minimum.fun)
        converged = bool(minimum.success)
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


Progress = Callable[[float, PartialTuning | None], None]
"""Takes the share done, 0 to 1, and the starts so far when they have changed."""

_TOLD_EVERY = 10
"""Rounds of evaluations between two partial results."""


def tune(problem: TuningProblem, progress: Progress | None = None) -> TuneDocument:
    """Search the gains of a variant by the simplex of Nelder and Mead, from several starts.

    Parameters
    ----------
    problem : TuningProblem
        Of a `TuneRequest`, from `motionlab.studies.tune.problem.plan`.
    progress : callable, optional
        Called with the share done and now and then with the starts so far; what it raises ends the
        search.
    """
    return _Search(problem, progress or (lambda _share, _partial: None)).run()


class _Search:
    def __init__(self, problem: TuningProblem, progress: Progress) -> None:
        assert isinstance(problem.request, TuneRequest)
        self.problem, self.request = problem, problem.request
        self.progress = progress
        joint = len(problem.axes) > 1 and self.request.also
        together = [problem.axes] if joint else [(axis,) for axis in problem.axes]
        self.groups = [Group(problem, axes) for axes in together]
        self.owners = [group for group in self.groups for _ in range(self.request.starts)]
        self.histories = [_nothing_yet(g) for g in self.owners]
        self.tried = self.rounds = 0

    def run(self) -> TuneDocument:
        generator = np.random.default_rng(self.problem.scenario.seed)
        starts = [
            start for group in self.groups for start in group.starts(self.request.starts, generator)
        ]
        ended = search(
            starts,
            [group.bounds for group in self.owners],
            self._values,
            evaluations=self.request.evaluations,
        )
        groups = [self._document(group, ended) for group in self.groups]
        kept = {id(group): why for group in groups if (why := _nothing_better(group))}
        best = [group.candidates[0].set for group in groups if id(group) not in kept]
        scenario, window = self.problem.scenario, self.problem.own.window
        return TuneDocument(
            scenario=scenario.name,
            seed=scenario.seed,
            plant=plant_name(scenario.plant),
            plants=list(self.problem.setups),
            version=__version__,
            model=model_hash(),
            variant=self.problem.variant,
            objective={**self.request.objective},
            window=[tick * CONTROL_PERIOD for tick in window],
            evaluations=self.tried,
            groups=groups,
            set={path: value for some in best for path, value in some.items()},
            warnings=[*unstable_warnings(self.problem), *kept.values()],
        )

    def _values(self, questions: Sequence[tuple[int, Array]]) -> list[float]:
        """Return the value of each start's point, all of them tried side by side."""
        points = [(self.owners[start], self.owners[start].values(p)) for start, p in questions]
        verdicts = [of_loops(group, numbers) for group, numbers in points]
        alive = [i for i, verdict in enumerate(verdicts) if verdict.feasible]
        for i, tried in zip(alive, self._try_out([points[i] for i in alive]), strict=True):
            verdicts[i] = of_trial(verdicts[i], points[i][0], tried)
        for (start, _), (_, numbers), verdict in zip(questions, points, verdicts, strict=True):
            history = self.histories[start]
            for path, number in numbers.items():
                history.gains[path].append(float(f"{number:.6g}"))
            history.cost.append(verdict.cost if verdict.feasible else None)
        self.tried += len(questions)
        self.rounds += 1
        share = self.tried / (self.request.evaluations * len(self.owners))
        self.progress(min(share, 1.0), self._partial() if self.rounds % _TOLD_EVERY == 1 else None)
        return [verdict.value for verdict in verdicts]

    def _try_out(
        self, points: Sequence[tuple[Group, dict[str, float]]]
    ) -> list[dict[tuple[str, str], Outcome]]:
        """Return the outcome of each point on each motor and axis."""
        tried: list[dict[tuple[str, str], Outcome]] = [{} for _ in points]
        movers = self._movers(points)
        controllers = [
            functools.reduce(
                lambda controller, i: points[i][0].controller(points[i][1], controller),
                mover,
                self.problem.controller,
            )
            for mover in movers
        ]
        for name, trials in self.problem.setups.items():
            outcomes = trials.run(controllers) if controllers else []
            for mover, outcome in zip(movers, outcomes, strict=True):
                for i in mover:
                    tried[i].update({(name, axis): outcome[axis] for axis in points[i][0].axes})
        return tried

    def _movers(self, points: Sequence[tuple[Group, dict[str, float]]]) -> list[list[int]]:
        """Return the points that share a mover: one of each group, whose axes do not touch."""
        queues = [
            [i for i, (owner, _) in enumerate(points) if owner is group] for group in self.groups
        ]
        rows = itertools.zip_longest(*queues)
        return [[i for i in row if i is not None] for row in rows]

    def _candidates(
        self, group: Group, ends: Sequence[Array]
    ) -> tuple[Candidate, Candidate, list[Candidate]]:
        """Return the present gains, the paper's, and where each start ended, the best first."""
        published = with_published(self.problem, group.axes)
        numbers = [
            group.values_of(self.problem.controller),
            group.values_of(published),
            *map(group.values, ends),
        ]
        tried = self._try_out([(group, values) for values in numbers])
        verdicts = [
            of_trial(of_loops(group, values), group, outcomes)
            for values, outcomes in zip(numbers, tried, strict=True)
        ]
        present, paper, *judged = zip(numbers, tried, verdicts, strict=True)
        best_first = sorted(range(len(judged)), key=lambda i: judged[i][2].value)
        return (
            candidate(group, *present, "present"),
            candidate(group, *paper, "paper"),
            [candidate(group, *judged[i], "start", i) for i in best_first],
        )

    def _document(self, group: Group, ended: Sequence[SearchEnd]) -> TunedGroup:
        mine = [i for i, owner in enumerate(self.owners) if owner is group]
        present, paper, candidates = self._candidates(group, [ended[i].point for i in mine])
        return TunedGroup(
            axes=list(group.axes),
            present=present,
            paper=paper,
            candidates=candidates,
            starts=[
                TunedStart(
                    **vars(self.histories[i]),
                    ended="converged" if ended[i].converged else "evaluations used up",
                )
                for i in mine
            ],
        )

    def _partial(self) -> PartialTuning:
        return PartialTuning(
            groups=[
                PartialGroup(
                    axes=list(group.axes),
                    starts=[
                        history.model_copy(deep=True)
                        for history, owner in zip(self.histories, self.owners, strict=True)
                        if owner is group
                    ],
                )
                for group in self.groups
            ]
        )


def _nothing_better(group: TunedGroup) -> str | None:
    """Return why the present gains stay, or None if a candidate is better."""
    best, present = group.candidates[0], group.present
    if best.betters(present):
        return None
    axes = " and ".join(group.axes)
    if not best.feasible:
        return f"{axes}: no start holds every constraint; the best: {'; '.join(best.violations)}"
    return f"{axes}: no start betters the present gains, whose cost is {present.cost:.4g}"


def _nothing_yet(group: Group) -> TuneHistory:
    return TuneHistory(gains={field: [] for field in group.fields}, cost=[])
