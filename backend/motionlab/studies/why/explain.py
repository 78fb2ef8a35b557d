"""Why a following error peaks: the run again without each cause, and with each possible change."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.loop.family import Figures, LoopFamily
from motionlab.loop.linearise import NoLinearisation
from motionlab.simulation.batch import check_length, run_prepared
from motionlab.simulation.inputs import load_force
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.studies.why.causes import (
    CAUSES,
    SWITCH,
    Knob,
    Trial,
    changes_of,
    knobs,
    look_up,
    trial,
    trials,
)
from motionlab.studies.why.documents import (
    Absent,
    Cause,
    MarginLimits,
    Mend,
    WhyDocument,
    WhyRequest,
)
from motionlab.timing import CONTROL_PERIOD, to_ticks

Source = str | Path | Mapping[str, Any]
Errors = tuple[float, float]
"""Largest about the peak and over the metrics window, m; NaN where the run diverged."""
_Reaching = tuple[Trial, Errors]

REACH = 0.1
"""Errors about a peak are taken so far before and after it, s."""
GOAL = 0.5
"""Goal as a share of the peak, where none is stated."""
DURATION_MAX = 300.0
"""Longest run that is explained, s."""
_WORK = 2000.0
"""Simulated time of the changes tried, s: about two seconds of two cores."""
_STEPS_LEAST, _STEPS_MOST = 3, 14
_FINEST = 0.01
"""Least step of a size at which every number is tried; larger where runs are long."""
_BLOCK = 8
"""Sizes that are tried at once, and parts of the last step."""
_PARTS = 24
"""Steps between neighbours that are divided, at most."""
_SAME = 1e-6
"""Share by which figures of the same loop differ."""


@dataclass(frozen=True)
class WhyPlan:
    """A peak to explain, checked."""

    request: WhyRequest
    base: Prepared
    variant: str
    axes: tuple[str, ...]


def plan(request: WhyRequest, source: Source | None = None) -> WhyPlan:
    """Return the checked plan of a request.

    Raises
    ------
    ConfigError
        Naming every field that is wrong; if the axis does not move, the time is outside of the run,
        or the run is too long.
    Infeasible
        If the motor cannot follow the motion.
    """
    whole = prepare(load_scenario(request.scenario if source is None else source, request.set))
    letters = list(whole.scenario.variants)
    variant = request.variant or letters[min(1, len(letters) - 1)]
    if variant not in letters:
        allowed = "one of " + ", ".join(letters)
        raise ConfigError(
            FieldError("variant", "is no variant of the scenario", variant, range=allowed)
        )
    moving = whole.reference.moving
    if not moving or (request.axis is not None and request.axis not in moving):
        allowed = "one of " + ", ".join(moving) if moving else "none moves"
        message = "does not move in this scenario"
        raise ConfigError(FieldError("axis", message, request.axis, range=allowed))
    check_length(whole.reference.ticks)
    if whole.duration > DURATION_MAX:
        bounds = {"maximum": DURATION_MAX}
        message = "simulated time is too large for an explanation"
        raise ConfigError(
            FieldError("trajectory", message, whole.duration, unit="s", bounds=bounds)
        )
    request = _within(request, whole)
    if request.time is not None and request.time >= whole.duration:
        message, bounds = "lies after the end of the run", {"maximum": whole.duration}
        raise ConfigError(FieldError("time", message, request.time, unit="s", bounds=bounds))
    axes = tuple(moving) if request.axis is None else (request.axis,)
    return WhyPlan(request, _alone(whole, variant), variant, axes)


def _within(request: WhyRequest, whole: Prepared) -> WhyRequest:
    """Return a request about a motion that repeats with its time in the last period of the run."""
    period = whole.reference.period * CONTROL_PERIOD
    if request.time is None or not period or request.time < whole.duration:
        return request
    laps = math.floor((request.time - whole.duration) / period) + 1
    return request.model_copy(update={"time": request.time - laps * period})


def explain(planned: WhyPlan) -> WhyDocument:
    """Return the contribution of each cause to a peak, and the smallest change that removes it.

    With ``E = max abs(e)`` within `REACH` of the peak, the share of a cause is ``1 - E_without/E``.
    Causes act on one another: shares need not add up to one. A change mends the peak if both E and
    the largest error over the metrics window reach the goal, and the worst margins, at standstill
    and from 0.5 to 4 Stribeck velocities, hold the limits. Of those the smallest is taken, by
    ``abs(log(factor))``; a switch counts as a doubled number. If there is none and the loop breaks
    a limit as it is, a change is taken that makes no such margin worse.

    Raises
    ------
    ConfigError
        If the run itself diverges, so that there is no peak.
    """
    base, variant = planned.base, planned.variant
    errors = _errors(base)
    axis, tick = _peak(planned, errors)
    look = _Look(AXES.index(axis), _about(tick, base), slice(*base.window))
    here, whole = look.at(errors)
    now = [scenario for first, scenario in base.epochs if first <= tick][-1]
    goal = planned.request.goal or GOAL * here
    removals = {kind.id: changes_of(kind, now, variant, axis) for kind in CAUSES}
    there = [kind for kind in CAUSES if removals[kind.id]]
    peaks = _peaks(base, [removals[kind.id] for kind in there], look)
    causes = [
        Cause(
            id=kind.id,
            label=kind.label,
            meaning=kind.meaning,
            error=without if math.isfinite(without) else None,
            share=1.0 - without / here if math.isfinite(without) and here > 0.0 else None,
            set=removals[kind.id],
        )
        for kind, (without, _) in zip(there, peaks, strict=True)
    ]
    causes.sort(key=lambda cause: -math.inf if cause.share is None else cause.share, reverse=True)
    search = _Search(planned, now, axis, look, goal, present=(here, whole))
    mend = search.smallest()
    return WhyDocument(
        scenario=base.scenario.name,
        variant=variant,
        axis=axis,
        time=round(tick * CONTROL_PERIOD, 7),
        period=base.reference.period * CONTROL_PERIOD if base.reference.period else None,
        window=(look.near.start * CONTROL_PERIOD, look.near.stop * CONTROL_PERIOD),
        peak=here,
        window_peak=whole if math.isfinite(whole) else None,
        goal=goal,
        causes=causes,
        absent=[Absent(id=kind.id, label=kind.label) for kind in CAUSES if kind not in there],
        mend=mend,
        why_not="" if mend else search.why_not(here),
        tried=search.tried,
        reached=search.reached,
        notes=search.notes,
    )


@dataclass(frozen=True)
class _Look:
    """Axis, ticks about the peak, and ticks of the metrics window."""

    axis: int
    near: slice
    window: slice

    def at(self, errors: NDArray[np.float32]) -> tuple[float, float]:
        """Return the largest error about the peak and in the window, m; NaN where it diverged."""
        own = np.abs(errors[self.axis])
        return float(own[self.near].max()), float(own[self.window].max())


class _Search:
    """The search for the smallest change that mends a peak."""

    def __init__(  # noqa: PLR0913 - what a search is about
        self,
        planned: WhyPlan,
        now: Scenario,
        axis: str,
        look: _Look,
        goal: float,
        *,
        present: Errors,
    ) -> None:
        self._base, self._now, self._look, self._goal = planned.base, now, look, goal
        self._variant, self._axis, self._limits = planned.variant, axis, planned.request.limits
        self._loops: dict[str, LoopFamily] = {}
        self.tried = self.reached = 0
        self.eased = False
        self.notes: list[str] = []
        self._linear = True
        self._present = max(present) if all(map(math.isfinite, present)) else math.inf
        self._lines: dict[tuple[str, float], list[tuple[float, float]]] = {}

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
        if best is None:
            eased = self._eased()
            best = self._smallest(coarse + fine, eased) if eased else None
            self.eased = best is not None
        return None if best is None else self._document(*best)

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
        peaks = _peaks(self._base, [each.set for each in some], self._look)
        self.tried += len(some)
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
        if not _effective(self._now, each.set):
            return False
        try:
            _changed(self._now, each.set)
        except ConfigError:
            return False  # such as stiction below Coulomb friction
        return True

    def _holds(
        self, changes: Mapping[str, Any], limits: MarginLimits
    ) -> tuple[bool, Figures | None]:
        """Return whether the loop with changes keeps every limit, and its worst margins."""
        scenario = _changed(self._now, changes)
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
            label=each.knob.label,
            set=each.set,
            factor=each.factor,
            error=peak[0],
            window_error=peak[1],
            eased=self.eased,
            **{
                name: values[name] if math.isfinite(values.get(name, math.inf)) else None
                for name in ("gain_margin", "phase_margin", "Ms")
            },
        )


def _alone(whole: Prepared, variant: str) -> Prepared:
    """Return a scenario with one of its variants."""

    def only(scenario: Scenario) -> Scenario:
        variants = {variant: scenario.variants[variant]}
        return scenario.model_copy(update={"variants": variants, "schedule": ()})

    epochs = tuple((tick, only(scenario)) for tick, scenario in whole.epochs)
    return dataclasses.replace(whole, scenario=only(whole.scenario), epochs=epochs)


def _changed(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    return validate(apply_changes(scenario.model_dump(mode="json"), dict(changes)))


def _case(base: Prepared, changes: Mapping[str, Any]) -> Prepared:
    """Return a prepared scenario with changes that hold throughout, whatever is scheduled."""
    if not changes:
        return base
    epochs = tuple((tick, _changed(scenario, changes)) for tick, scenario in base.epochs)
    case = dataclasses.replace(base, scenario=epochs[0][1], epochs=epochs)
    if not any(path.startswith("load.") for path in changes):
        return case
    load = base.load.copy()
    for tick, scenario in epochs:
        load[tick:] = load_force(scenario.load, len(load))[tick:]
    return dataclasses.replace(case, load=load)


def _effective(scenario: Scenario, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the changes that change something."""
    tables = scenario.model_dump(mode="json")
    return {path: value for path, value in changes.items() if look_up(tables, path) != value}


def _errors(base: Prepared) -> NDArray[np.float32]:
    """Return the following errors of a run, m, (axes, ticks)."""
    kept: list[NDArray[np.float32]] = []
    run_prepared([base], watch=lambda _, errors: kept.append(errors[0].copy()))
    return kept[0]


def _peaks(
    base: Prepared, cases: Sequence[Mapping[str, Any]], look: _Look
) -> list[tuple[float, float]]:
    """Return the largest errors of a run with each of some changes, as `_Look.at` does."""
    peaks = [(math.nan, math.nan)] * len(cases)

    def watch(movers: NDArray[np.int64], errors: NDArray[np.float32]) -> None:
        for mover, own in zip(movers.tolist(), errors, strict=True):
            peaks[mover] = look.at(own)

    if cases:
        run_prepared([_case(base, changes) for changes in cases], watch=watch)
    return peaks


def _peak(planned: WhyPlan, errors: NDArray[np.float32]) -> tuple[str, int]:
    """Return the axis and the tick of the peak to explain."""
    time = planned.request.time
    part = slice(*planned.base.window) if time is None else _about(to_ticks(time), planned.base)
    places = []
    for axis in planned.axes:
        own = np.abs(errors[AXES.index(axis), part])
        if np.isnan(own).any():
            message = "diverges before that: there is no peak to explain"
            raise ConfigError(FieldError(f"variants.{planned.variant}", message))
        places.append((float(own.max()), axis, part.start + int(own.argmax())))
    _, axis, tick = max(places)
    return axis, tick


def _about(tick: int, base: Prepared) -> slice:
    reach = to_ticks(REACH)
    return slice(max(0, tick - reach), min(base.reference.ticks, tick + reach + 1))
