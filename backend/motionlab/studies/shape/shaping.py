"""Gains and filters on a measured plant, from the measurement to the check by a second one."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.errors import ConfigError, FieldError
from motionlab.studies.loop.frequency_sweep import LoopCurve, loop_curve
from motionlab.studies.record.part import kept_run
from motionlab.studies.response.controller_check import OTHER
from motionlab.studies.response.documents import MarginInterval, MeasuredResponse, ResponseRequest
from motionlab.studies.response.margins import NAMES, intervals, measured_margins, refined
from motionlab.studies.response.measure import ResponsePlan, measure
from motionlab.studies.response.measure import plan as plan_response
from motionlab.studies.response.recorded import RecordedPlan
from motionlab.studies.shape.controllers import (
    Controllers,
    Shape,
    changes_of,
    free_places,
    present,
)
from motionlab.studies.shape.documents import (
    ProposedFilter,
    Resonance,
    ShapeCheck,
    ShapeDocument,
    ShapeRequest,
)
from motionlab.studies.shape.resonances import significant
from motionlab.studies.shape.search import GAIN_MARGIN, Limits, Search
from motionlab.studies.study import Source

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Progress = Callable[[float, ShapeDocument | None], None]

_MEASURED, _SEARCHED = 0.4, 0.7  # shares of the work that are done
_SHORT = 4
_WITHOUT = 100.0  # dB, where without a filter nothing keeps the limits
_SURE, _LINES_MIN = 0.5, 12
_SAME = 0.01
_OF_SHAPE = ("phase_margin", "gain_margin", "step", "filters", "second_run")
_CERTAIN = 1.96
_PEAK = 3.5  # standard errors of a resonance: there are hundreds of frequencies
_NAMED = 6  # differences that are listed
_NEEDED = {
    "crossover": "crossover",
    "phase_margin": "phase margin",
    "gain_margin": "gain margin up",
}


@dataclass(frozen=True)
class ShapePlan:
    """A request that has passed every check.

    Attributes
    ----------
    request : ShapeRequest
        As validated.
    source : object
        The scenario as given.
    response : ResponsePlan or RecordedPlan
        Of the measurement.
    second : RecordedPlan, optional
        Of the run that checks.
    """

    request: ShapeRequest
    source: Source | None
    response: ResponsePlan | RecordedPlan
    second: RecordedPlan | None

    @property
    def seconds(self) -> float:
        """Simulated time of both experiments, s."""
        return 2.0 * self.response.seconds


def plan(request: ShapeRequest, source: Source | None = None) -> ShapePlan:
    """Return the checked measurement on which the loop is shaped.

    Raises
    ------
    ConfigError
        As the response's plan; if the axis has no gains, or `second_run` stands alone.
    """
    if request.second_run is not None and request.run is None:
        message = "checks what was measured in a run; name that as run"
        raise ConfigError(FieldError("second_run", message, request.second_run))
    first = plan_response(_of_response(request), source)
    gains = getattr(first.scenario.variants[first.variant].controller, request.axis)
    for name in ("k_p", "k_d"):
        if getattr(gains, name) == 0.0:
            place = f"variants.{first.variant}.controller.{request.axis}.{name}"
            message = "must be above 0: its factor is searched"
            raise ConfigError(FieldError(place, message, 0.0))
    second = None
    if request.second_run is not None:
        second = _plan_second(request, source)
    return ShapePlan(request, source, first, second)


def _plan_second(
    request: ShapeRequest, source: Source | None, changes: dict[str, Any] | None = None
) -> RecordedPlan:
    """Return the plan of the run that checks; of a measurement under the changes."""
    update = {"run": request.second_run, "set": request.set | (changes or {})}
    if kept_run(str(request.second_run), "second_run").scenario_document is not None:
        update |= {"start": 0.0, "end": None}  # its slides; a measurement repeats the motion
    other = _of_response(request).model_copy(update=update)
    planned = plan_response(other, source)
    assert isinstance(planned, RecordedPlan)
    return planned


def shape(planned: ShapePlan, progress: Progress | None = None) -> ShapeDocument:
    """Measure, search, and check by a second measurement.

    Parameters
    ----------
    planned : ShapePlan
        From `plan`.
    progress : callable, optional
        Takes the share done and nothing; what it raises ends the work.

    Raises
    ------
    ConfigError
        As a measurement does.
    """

    def report(share: float) -> None:
        if progress is not None:
            progress(share, None)

    request, first = planned.request, planned.response
    measured = measure(first, lambda share, _: report(_MEASURED * share))
    other = [each for each in measured.warnings if each.startswith(OTHER)]
    if other:
        message = f"was not under the controller of variant {first.variant}: {other[-1]}"
        raise ConfigError(FieldError("run", message))
    of_lines = sure_lines(measured, "run" if request.run else "force")
    f, plant, deviation = refined(*of_lines, measured.fitted)
    controllers = Controllers(first.scenario, first.variant, request.axis, measured.velocity, f)
    before = present(controllers.config, request.axis)
    search = Search(
        controllers,
        plant,
        deviation,
        before,
        Limits(
            request.phase_margin,
            request.gain_margin,
            request.step,
            request.filters,
        ),
        progress=lambda share: report(_MEASURED + (_SEARCHED - _MEASURED) * share),
    )
    size = np.abs(of_lines[1])
    peaks = significant(of_lines[0], size, _PEAK * of_lines[2] / size)
    proposed, compliance, worth = search.best(peaks, free_places(controllers.config, request.axis))
    better = compliance < 0.0 or (math.isfinite(compliance) and not search.keeps(before))
    after = rounded(proposed) if better else before
    L = search.open(after)
    size = np.abs(controllers.response(after))
    lines = np.isin(f, of_lines[0])
    spread = intervals(f, L, deviation * size, request.seed, lines=lines)
    here, there = measured_margins(f, L), measured_margins(f, search.open(before))
    changes = changes_of(first.variant, request.axis, before, after) if better else {}
    document = ShapeDocument(
        response=measured,
        resonances=peaks,
        filters=[
            ProposedFilter(
                kind=each.kind,
                place=each.place,
                values=each.values,
                reason=each.reason,
                gain=_short(min(worth[k], _WITHOUT)),
            )
            for k, each in enumerate(after.filters)
        ],
        changes=changes,
        before=_numbers(before),
        after=_numbers(after),
        margins={
            name: MarginInterval(value=here[name], interval=spread[name], model=there[name])
            for name in NAMES
        },
        frequency=f.tolist(),
        open=loop_curve(L),
        compliance=_short(search.stiffer(after)),
        notes=_notes(planned, search, peaks, after, better=better),
        check=None,
    )
    report(_SEARCHED)
    if not changes:
        return document
    return document.model_copy(update={"check": _check(planned, document, report)})


def arrays_of(measured: MeasuredResponse) -> tuple[Array, Complex, Array]:
    """Return frequencies, the plant, and its deviation as a complex number, of a document."""
    magnitude = np.array(measured.plant.magnitude)
    plant = magnitude * np.exp(1j * np.array(measured.plant.phase))
    deviation = np.array(measured.plant.interval) * magnitude * np.sqrt(2.0) / _CERTAIN
    return np.array(measured.frequency), plant, deviation


def sure_lines(measured: MeasuredResponse, loc: str) -> tuple[Array, Complex, Array]:
    """Return `arrays_of` at the frequencies whose interval is within 50 %.

    Raises
    ------
    ConfigError
        If too few are left, naming `loc`.
    """
    frequency, plant, deviation = arrays_of(measured)
    sure = _CERTAIN * deviation <= _SURE * np.abs(plant)
    if sure.sum() < _LINES_MIN:
        message = f"leaves too few frequencies whose interval is within {100 * _SURE:g} %"
        raise ConfigError(FieldError(loc, message, int(sure.sum()), f">= {_LINES_MIN}"))
    return frequency[sure], plant[sure], deviation[sure]


def rounded(shape: Shape) -> Shape:
    """Return a shape to four digits, as it is written into changes."""
    return shape.with_numbers(np.log([_short(each) for each in np.exp(shape.numbers)]))


def _of_response(request: ShapeRequest) -> ResponseRequest:
    return ResponseRequest.model_validate(request.model_dump(exclude=set(_OF_SHAPE)))


def _numbers(shape: Shape) -> dict[str, float]:
    numbers = {"k_p": _short(shape.k_p), "k_d": _short(shape.k_d)}
    return numbers | ({"bandwidth": _short(shape.bandwidth)} if shape.bandwidth > 0.0 else {})


def _notes(
    planned: ShapePlan, search: Search, peaks: list[Resonance], after: Shape, *, better: bool
) -> list[str]:
    before = search.before
    notes = [
        f"the top of the resonance at {each.frequency:.4g} Hz may lie between two frequencies: "
        "measure with more lines"
        for each in peaks
        if not each.resolved
    ]
    if not better:
        notes.append("nothing within the limits is stiffer than what was measured")
    if not search.keeps(before):
        worst, highest = search.worst(before), search.without_gain_margin_up_to(before)
        if worst == GAIN_MARGIN and highest is not None:
            notes.append(
                f"the gain margin up is not known: up to {highest:.4g} Hz, the highest frequency "
                "that is sure, the phase does not reach -180 degrees; shake more above"
            )
        else:
            notes.append(
                f"the loop that was measured does not keep {worst} itself, at the worse end of its "
                "interval"
            )
    if not better and planned.request.second_run is not None:
        notes.append("nothing is proposed, so that the second run was not read")
    step = planned.request.step
    near = [
        name
        for name, value in _numbers(after).items()
        if abs(abs(math.log(value / _numbers(before)[name])) - math.log(step)) < _SAME
    ]
    if near:
        notes.append(
            f"{' and '.join(near)} went as far as the step of {step:g} allows: measure again with "
            "these values, and shape on that"
        )
    return notes


def _check(
    planned: ShapePlan, document: ShapeDocument, report: Callable[[float], None]
) -> ShapeCheck | None:
    """Return what a second measurement shows of the proposal; None until there is one."""
    request, first, second = planned.request, planned.response, planned.second
    if isinstance(first, RecordedPlan) and second is None:
        return None
    if second is None:
        again = _of_response(request)
        again = again.model_copy(
            update={"set": again.set | document.changes, "seed": request.seed + 1}
        )
        try:
            measured = measure(
                plan_response(again, planned.source),
                lambda share, _: report(_SEARCHED + (1.0 - _SEARCHED) * share),
            )
        except ConfigError as error:
            text = f"the loop as proposed could not be measured: {error}"
            return ShapeCheck(
                margins={},
                open=LoopCurve(magnitude=[], phase=[]),
                frequency=[],
                holds=False,
                text=text,
            )
        different: list[str] = []
    else:
        if not second.own:  # a measurement has no controller: it is taken to have the proposed one
            second = _plan_second(request, planned.source, document.changes)
        measured = measure(second)
        if second.own:
            different = _differences(planned, second, document.changes)
        else:
            different = [each for each in measured.warnings if each.startswith(OTHER)]
    margins = {
        name: each.model_copy(update={"model": document.margins[name].value})
        for name, each in measured.margins.items()
    }
    missed = _missed(request, margins, measured.frequency[-1])
    if different:
        text = "the second run is not of this motor under the proposed controller: " + "; ".join(
            different
        )
    elif missed:
        text = "does not keep the margins: " + "; ".join(missed)
    else:
        text = "a second measurement keeps the margins"
    return ShapeCheck(
        margins=margins,
        open=measured.open,
        frequency=measured.frequency,
        holds=not missed and not different,
        text=text,
    )


def _missed(request: ShapeRequest, margins: dict[str, MarginInterval], highest: float) -> list[str]:
    """Return which margins are missed; one that was not measured is not kept."""
    missed = [
        f"no {title} was measured up to {highest:.4g} Hz"
        for name, title in _NEEDED.items()
        if margins[name].value is None
    ]
    phase = margins["phase_margin"].value
    if phase is not None and phase < request.phase_margin:
        bound = math.degrees(request.phase_margin)
        missed.append(f"phase margin {math.degrees(phase):.3g} of {bound:.3g} deg")
    least = _decibels(request.gain_margin)
    for name, title in (("gain_margin", "up"), ("gain_reduction", "down")):
        gain = margins[name].value
        if gain is not None and (here := abs(_decibels(gain))) < least:
            missed.append(f"gain margin {title} {here:.3g} of {least:.3g} dB")
    return missed


def _differences(planned: ShapePlan, second: RecordedPlan, changes: dict[str, Any]) -> list[str]:
    """Return in what the second run's motor or controller is not the first's as proposed."""
    first = planned.response
    other = "y" if planned.request.axis == "x" else "x"
    then = apply_changes(first.scenario.model_dump(mode="json"), changes)
    different = []
    for part in ("plant", f"variants.{first.variant}.controller"):
        for path, value, here in _leaves(then, second.scenario.model_dump(mode="json"), part):
            if f".{other}." in path or path.endswith((".name", ".label", ".description")):
                continue
            if path in changes and _is_number(here) and abs(here - value) <= _SAME * abs(value):
                continue
            if here != value:
                different.append(f"{path} is {here}, not {value}")
    return different[:_NAMED]


def _leaves(a: Any, b: Any, path: str) -> list[tuple[str, Any, Any]]:
    """Return paths and values of both documents below a path."""
    for key in path.split("."):
        a, b = (each.get(key) if isinstance(each, dict) else None for each in (a, b))
    return _pairs(a, b, path)


def _pairs(a: Any, b: Any, path: str) -> list[tuple[str, Any, Any]]:
    if not isinstance(a, dict) or not isinstance(b, dict):
        return [(path, a, b)]
    return [
        leaf
        for key in [*a, *(key for key in b if key not in a)]
        for leaf in _pairs(a.get(key), b.get(key), f"{path}.{key}")
    ]


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _decibels(factor: float) -> float:
    return 20.0 * math.log10(factor)


def _short(value: float) -> float:
    return float(f"{value:.{_SHORT}g}")
