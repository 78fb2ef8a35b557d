"""The search for the smallest change that mends a peak within the margins."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError
from motionlab.loop.family import Figures, LoopFamily
from motionlab.loop.linearise import NoLinearisation
from motionlab.simulation.prepare import Prepared
from motionlab.studies.why.cases import Errors, Look, changed, effective, peaks_of
from motionlab.studies.why.causes import SWITCH, Knob, Trial, knobs, look_up, pair, trial, trials
from motionlab.studies.why.documents import MarginLimits, Mend

_Reaching = tuple[Trial, Errors]

_WORK = 2000.0
"""Simulated time of the changes tried, s: about two seconds of two cores."""
_STEPS_LEAST, _STEPS_MOST = 3, 14
_FINEST = 0.01
"""Least step of a size at which every number is tried; larger where runs are long."""
_BLOCK = 8
"""Sizes that are tried at once, and parts of the last step."""
_PARTS = 24
"""Steps between neighbours that are divided, at most."""
_PAIRED = 8
"""Changes that are tried two by two, where none alone mends a peak."""
_WORTH = 0.95
"""A change that leaves more of the error than this share is not offered."""
_SAME = 1e-6
"""Share by which figures of the same loop differ."""


class Search:
    """The search for the smallest change that mends a peak."""

    def __init__(  # noqa: PLR0913 - what a search is about
        self,
        base: Prepared,
        now: Scenario,
        variant: str,
        axis: str,
        look: Look,
        *,
        limits: MarginLimits,
        goal: float,
        present: Errors,
    ) -> None:
        self._base, self._now, self._variant, self._axis = base, now, variant, axis
        self._look, self._limits, self._goal = look, limits, goal
        self._loops: dict[str, LoopFamily] = {}
        self.tried = self.reached = 0
        self.eased = False
        self.notes: list[str] = []
        self._linear = True
        self._present = max(present) if all(map(math.isfinite, present)) else math.inf
        self._lines: dict[tuple[str, float], list[tuple[float, float]]] = {}
        self._all: list[_Reaching] = []

    def smallest(self) -> Mend | None:
        """Return the smallest change that reaches the goal within the margins, if any was found."""
        every = knobs(self._now, self._variant, self._axis)
        tables = self._now.model_dump(mode="json")
        values = {path: float(look_up(tables, path)) for knob in every for path in knob.paths}
        runs = self._base.duration * 2.0 * len(every)
        steps = min(_STEPS_MOST, max(_STEPS_LEAST, int(_WORK / runs)))
        coarse = self._reaching([each for knob in every for each in trials(knob, values, steps)])
        best = self._smallest(coarse, self._limits)
        # Each number has a grid of its own there, and what mends may lie between its points: every
        # number is tried at the same sizes below that of the best so far, the smallest first.
        movable = [knob for knob in every if any(values[path] != 0.0 for path in knob.paths)]
        most = best[0].size if best else SWITCH
        step = max(_FINEST, most * runs / _WORK)
        sizes = [k * step for k in range(1, math.ceil(most / step) + 1)]
        fine: list[_Reaching] = []
        for k in range(0, len(sizes), _BLOCK):
            block = [
                trial(knob, values, math.exp(sign * size))
                for size in sizes[k : k + _BLOCK]
                for knob in movable
                if size <= math.log(knob.most)
                for sign in (1.0, -1.0)
            ]
            fine += self._reaching(block, lines=True)
            better = self._smallest(fine, self._limits)
            if better and (best is None or better[0].size < best[0].size):
                best = better
                break
        between = self._between(movable, values, best[0].size if best else most)
        better = self._smallest(self._reaching(between), self._limits)
        if better and (best is None or better[0].size < best[0].size):
            best = better
        if best is not None:
            return self._document(*best)
        eased = self._eased()
        self.eased = eased is not None
        limits = eased or self._limits
        best = self._smallest(coarse + fine, limits) if eased else None
        if best is None and self._present > self._goal:
            pairs = self._reaching(self._pairs(limits))
            best = self._smallest(pairs, limits) or self._nearest(limits)
        return None if best is None else self._document(*best)

    def _helpful(self, limits: MarginLimits, most: int) -> list[_Reaching]:
        """Return the changes that leave the least error within some limits, one of a label."""
        best: dict[str, _Reaching] = {}
        for each, peak in sorted(self._all, key=lambda item: (max(item[1]), item[0].size)):
            if max(peak) > _WORTH * self._present or len(best) == most:
                break
            if each.label not in best and self._holds(each.set, limits)[0]:
                best[each.label] = (each, peak)
        return list(best.values())

    def _pairs(self, limits: MarginLimits) -> list[Trial]:
        """Return the changes that help most, two by two."""
        some = [each for each, _ in self._helpful(limits, _PAIRED)]
        pairs = [pair(one, other) for one, other in itertools.combinations(some, 2)]
        return [each for each in pairs if each is not None]

    def _nearest(self, limits: MarginLimits) -> tuple[Trial, Errors, Figures | None] | None:
        """Return the change that comes nearest to the goal within some limits."""
        for each, peak in self._helpful(limits, 1):
            return each, peak, self._holds(each.set, limits)[1]
        return None

    def why_not(self, peak: float) -> str:
        """Say why nothing mends the peak."""
        if peak <= self._goal:
            return "The peak is within the goal as it is."
        if self.reached == 0:
            return f"None of the {self.tried} changes tried reaches the goal."
        return (
            f"{self.reached} of the {self.tried} changes tried reach the goal, but none of them "
            "keeps the margins."
        )

    def _between(self, knobs: list[Knob], values: dict[str, float], most: float) -> list[Trial]:
        """Return trials between neighbours of the even grid where the goal may be reached.

        Between two errors the least is taken to fall no faster than about them.
        """
        parts: list[tuple[float, float, Knob, float]] = []
        for knob in knobs:
            for sign in (1.0, -1.0):
                line = [(0.0, self._present), *self._lines.get((knob.label, sign), ())]
                slopes = [
                    abs(after - before) / (end - begin)
                    for (begin, before), (end, after) in itertools.pairwise(line)
                ]
                for k, ((begin, before), (end, after)) in enumerate(itertools.pairwise(line)):
                    fall = max(slopes[max(k - 1, 0) : k + 2]) * (end - begin)
                    if begin < most and 0.5 * (before + after - fall) <= self._goal:
                        parts.append((begin, end, knob, sign))
        parts.sort(key=lambda part: part[0])
        return [
            trial(knob, values, math.exp(sign * (begin + (end - begin) * k / _BLOCK)))
            for begin, end, knob, sign in parts[:_PARTS]
            for k in range(1, _BLOCK)
        ]

    def _reaching(self, some: list[Trial], *, lines: bool = False) -> list[_Reaching]:
        """Return the changes that reach the goal, with the errors that they leave.

        With `lines` the errors of all are kept by number and direction, in order of size.
        """
        some = [each for each in some if self._possible(each)]
        peaks = peaks_of(self._base, [each.set for each in some], self._look)
        self.tried += len(some)
        self._all += [
            (each, peak)
            for each, peak in zip(some, peaks, strict=True)
            if all(math.isfinite(error) for error in peak)
        ]
        for each, peak in zip(some, peaks, strict=True):
            if lines and each.factor is not None and all(math.isfinite(error) for error in peak):
                line = self._lines.setdefault(
                    (each.knob.label, math.copysign(1.0, math.log(each.factor))), []
                )
                line.append((each.size, max(peak)))
        # Of a run that diverges an error is NaN, which is within no goal.
        good = [
            (each, peak)
            for each, peak in zip(some, peaks, strict=True)
            if all(error <= self._goal for error in peak)
        ]
        self.reached += len(good)
        return good

    def _smallest(
        self, reaching: list[_Reaching], limits: MarginLimits
    ) -> tuple[Trial, Errors, Figures | None] | None:
        """Return the smallest change whose loop keeps some limits, and its worst margins."""
        for each, peak in sorted(reaching, key=lambda item: (item[0].size, item[1])):
            holds, figures = self._holds(each.set, limits)
            if holds:
                return each, peak, figures
        return None

    def _eased(self) -> MarginLimits | None:
        """Return limits that the loop holds as it is; None where it is unstable or holds them."""
        holds, figures = self._holds({}, self._limits)
        if holds or figures is None:
            return None
        limits = self._limits.model_dump()
        for name in ("gain_margin", "phase_margin"):
            least = limits[name]
            if least is not None:
                limits[name] = min(least, getattr(figures, name).value * (1.0 - _SAME))
        if limits["Ms"] is not None:
            limits["Ms"] = max(limits["Ms"], figures.Ms.value * (1.0 + _SAME))
        return MarginLimits.model_construct(**limits)

    def _possible(self, each: Trial) -> bool:
        """Return whether a change changes something, and to what a controller may be."""
        if not effective(self._now, each.set):
            return False
        try:
            changed(self._now, each.set)
        except ConfigError:
            return False  # such as stiction below Coulomb friction
        return True

    def _holds(
        self, changes: Mapping[str, Any], limits: MarginLimits
    ) -> tuple[bool, Figures | None]:
        """Return whether the loop with changes keeps every limit, and its worst margins."""
        scenario = changed(self._now, changes)
        gains = getattr(scenario.variants[self._variant].controller, self._axis)
        other = {path: x for path, x in changes.items() if not path.endswith((".k_p", ".k_d"))}
        try:
            if str(other) not in self._loops:
                self._loops[str(other)] = LoopFamily.of(scenario, self._variant, self._axis)
        except NoLinearisation:
            if self._linear:
                self.notes.append("The law has no linearisation: margins were not looked at.")
            self._linear = False
            return True, None
        family = self._loops[str(other)]
        if family.radius(np.array(gains.k_p), np.array(gains.k_d)) >= 1.0:
            return False, None
        figures = family.figures(gains.k_p, gains.k_d)
        holds = (
            figures.gain_margin.value >= (limits.gain_margin or 0.0)
            and figures.phase_margin.value >= (limits.phase_margin or 0.0)
            and figures.Ms.value <= (limits.Ms or math.inf)
        )
        return holds, figures

    def _document(self, each: Trial, peak: Errors, figures: Figures | None) -> Mend:
        margins = {} if figures is None else figures._asdict()
        values = {name: worst.value for name, worst in margins.items()}
        return Mend(
            reaches=all(error <= self._goal for error in peak),
            label=each.label,
            set=each.set,
            factor=None if each.beside else each.factor,
            error=peak[0],
            window_error=peak[1],
            eased=self.eased,
            **{
                name: values[name] if math.isfinite(values.get(name, math.inf)) else None
                for name in ("gain_margin", "phase_margin", "Ms")
            },
        )
