"""Why a following error peaks: the run again without each cause, and with each possible change."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.simulation.batch import check_length
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.studies.why.cases import Look, alone, errors_of, peaks_of
from motionlab.studies.why.causes import CAUSES, changes_of
from motionlab.studies.why.documents import Absent, Cause, WhyDocument, WhyRequest
from motionlab.studies.why.mend import Search
from motionlab.timing import CONTROL_PERIOD, to_ticks

Source = str | Path | Mapping[str, Any]

REACH = 0.1
"""Errors about a peak are taken so far before and after it, s."""
GOAL = 0.5
"""Goal as a share of the peak, where none is stated."""
DURATION_MAX = 300.0
"""Longest run that is explained, s."""


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
    return WhyPlan(request, alone(whole, variant), variant, axes)


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
    a limit as it is, a change is taken that makes no such margin worse. If there is none either,
    the changes that help most are tried two by two, and if no pair reaches the goal, what comes
    nearest to it is taken.

    Raises
    ------
    ConfigError
        If the run itself diverges, so that there is no peak.
    """
    base, variant = planned.base, planned.variant
    errors = errors_of(base)
    axis, tick = _peak(planned, errors)
    look = Look(AXES.index(axis), _about(tick, base), slice(*base.window))
    here, whole = look.at(errors)
    now = [scenario for first, scenario in base.epochs if first <= tick][-1]
    goal = planned.request.goal or GOAL * here
    removals = {kind.id: changes_of(kind, now, variant, axis) for kind in CAUSES}
    there = [kind for kind in CAUSES if removals[kind.id]]
    peaks = peaks_of(base, [removals[kind.id] for kind in there], look)
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
    limits, present = planned.request.limits, (here, whole)
    search = Search(base, now, variant, axis, look, limits=limits, goal=goal, present=present)
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
        why_not="" if mend and mend.reaches else search.why_not(here),
        tried=search.tried,
        reached=search.reached,
        notes=search.notes,
    )


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
