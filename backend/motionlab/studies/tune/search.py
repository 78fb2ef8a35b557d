"""The complete search: parallel starts and their document."""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.lanes import model_hash
from motionlab.simulation.result import plant_name
from motionlab.studies.tune.axis_group import Group, with_published
from motionlab.studies.tune.candidates import candidate
from motionlab.studies.tune.document import (
    Candidate,
    PartialGroup,
    PartialTuning,
    TunedGroup,
    TuneDocument,
    TunedStart,
    TuneHistory,
)
from motionlab.studies.tune.evaluation import of_loops, of_trial
from motionlab.studies.tune.problem import TuningProblem, unstable_warnings
from motionlab.studies.tune.request import TuneRequest
from motionlab.studies.tune.simplex import SearchEnd, search
from motionlab.studies.tune.trials import Outcome

Array = NDArray[np.float64]
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

    Returns
    -------
    TuneDocument
        The same for the same request on the same machine.
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
        """Return which points share a mover: one of each group, whose axes do not touch."""
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
        present, paper, *found = zip(numbers, tried, verdicts, strict=True)
        best_first = sorted(range(len(found)), key=lambda i: found[i][2].value)
        return (
            candidate(group, *present, "present"),
            candidate(group, *paper, "paper"),
            [candidate(group, *found[i], "start", i) for i in best_first],
        )

    def _document(self, group: Group, ended: Sequence[SearchEnd]) -> TunedGroup:
        mine = [i for i, owner in enumerate(self.owners) if owner is group]
        present, paper, found = self._candidates(group, [ended[i].point for i in mine])
        return TunedGroup(
            axes=list(group.axes),
            present=present,
            paper=paper,
            candidates=found,
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
