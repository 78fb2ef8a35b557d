"""The challenge carried out: laws run, judged and ranked."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from motionlab import __version__
from motionlab.lanes import model_hash
from motionlab.laws import LAWS
from motionlab.studies.challenge.definition import Definition, definition
from motionlab.studies.challenge.documents import (
    AxisDocument,
    ChallengeDocument,
    LawDocument,
    MarginDocument,
    MotorsDocument,
    ScenarioDocument,
    gain_shown,
    phase_shown,
)
from motionlab.studies.challenge.entrants import REFERENCE, Entrant
from motionlab.studies.challenge.runs import (
    ErrorCurves,
    LeastMargin,
    LeastMargins,
    MotorRuns,
    ScenarioRun,
    least_margins,
    run_motors,
    run_scenario,
)
from motionlab.studies.challenge.score import (
    GAIN_MARGIN,
    LIMITS,
    PHASE_MARGIN,
    effort_of,
    error_of,
    geometric_mean,
    place,
    score_of,
    verdict_of,
)

Progress = Callable[[float], None]


@dataclass(frozen=True)
class Challenge:
    """Its document, and the curves of its figures.

    Attributes
    ----------
    document : ChallengeDocument
        The best law first.
    curves : dict of str to dict of str to ErrorCurves
        By scenario and axis; laws in the order of the document.
    """

    document: ChallengeDocument
    curves: dict[str, dict[str, ErrorCurves]]


def challenge(
    entrants: Sequence[Entrant],
    *,
    seed: int | None = None,
    of: Definition | None = None,
    progress: Progress | None = None,
) -> Challenge:
    """Run, judge and rank laws.

    Parameters
    ----------
    entrants : sequence of Entrant
        `motionlab.studies.challenge.entrants.entrants` makes them; the law `off` comes first.
    seed : int, optional
        Of the drawn motors; the challenge's when left out.
    of : Definition, optional
        The shipped one when left out.
    progress : callable, optional
        Takes the share done; what it raises ends the work.

    Raises
    ------
    ConfigError
        If a parameter of a law is not valid.
    """
    of = definition() if of is None else of
    assert entrants[0].law == REFERENCE
    laws = [each.compensation for each in entrants]
    steps = len(of.scenarios) + len(of.on_motors)

    def tell(done: float) -> None:
        if progress is not None:
            progress(done / steps)

    chosen = of.seed if seed is None else seed
    margins, runs, motors = least_margins(of, laws), {}, {}
    for number, name in enumerate(of.scenarios):
        runs[name] = run_scenario(of, name, laws)
        tell(number + 1)
    for number, name in enumerate(of.on_motors, start=len(of.scenarios)):
        motors[name] = run_motors(
            of, name, laws, chosen, lambda share, before=number: tell(before + share)
        )
    judged = [
        _judged(entrant, law, margins[law], runs, motors) for law, entrant in enumerate(entrants)
    ]
    order = sorted(
        range(len(judged)),
        key=lambda law: place(judged[law].verdict, judged[law].score, judged[law].label),
    )
    document = ChallengeDocument(
        challenge=of.version,
        digest=of.digest(),
        seed=chosen,
        own_seed=chosen != of.seed,
        motors=of.motors,
        version=__version__,
        model=model_hash(),
        titles={name: tables["title"] for name, tables in of.scenarios.items()},
        laws=[
            judged[law].model_copy(update={"rank": rank}) for rank, law in enumerate(order, start=1)
        ],
    )
    return Challenge(document, _ordered(runs, order))


def _judged(
    entrant: Entrant,
    law: int,
    margins: LeastMargins,
    runs: dict[str, ScenarioRun],
    motors: dict[str, MotorRuns],
) -> LawDocument:
    scenarios = {name: _scenario(run, law, motors.get(name)) for name, run in runs.items()}
    parts = {
        "error": _mean(each.error for each in scenarios.values()),
        "motors": _mean(_mean_motors(run.ratios[law]) for run in motors.values()),
        "effort": _mean(each.effort for each in scenarios.values()),
    }
    known = {name: part for name, part in parts.items() if part is not None}
    diverged = [f"diverges in {name}" for name, each in scenarios.items() if each.axes is None]
    diverged += [
        f"diverges on {count} of {run.ratios.shape[1]} motors of {name}"
        for name, run in motors.items()
        if (count := int(run.diverged[law]))
    ]
    gain, phase = _margin(margins.gain_margin), _margin(margins.phase_margin)
    return LawDocument(
        rank=0,
        law=entrant.law,
        label=entrant.label,
        description=LAWS[entrant.law].description,
        parameters=dict(entrant.parameters),
        shipped=entrant.shipped,
        entered=entrant.entered,
        source=entrant.source,
        verdict=verdict_of(
            diverged=len(diverged),
            stable=not margins.unstable,
            gain_margin=margins.gain_margin.value,
            phase_margin=margins.phase_margin.value,
        ),
        reasons=[*diverged, *_shortcomings(margins)],
        score=score_of(known) if len(known) == len(parts) else None,
        **parts,
        gain_margin=gain,
        phase_margin=phase,
        scenarios=scenarios,
    )


def _scenario(run: ScenarioRun, law: int, motors: MotorRuns | None) -> ScenarioDocument:
    figures, off = run.figures[law], run.figures[0]
    error = effort = axes = None
    if figures is not None:
        axes = {axis: AxisDocument(**each._asdict()) for axis, each in figures.items()}
        if off is not None:
            error, effort = error_of(figures, off), effort_of(figures, off)
    return ScenarioDocument(
        axes=axes,
        error=error,
        effort=effort,
        motors=None if motors is None else _motors(motors, law),
    )


def _motors(motors: MotorRuns, law: int) -> MotorsDocument:
    ratios = motors.ratios[law]
    finite = ratios[np.isfinite(ratios)]
    median, q95 = np.quantile(finite, (0.5, 0.95)).tolist() if len(finite) else (None, None)
    return MotorsDocument(
        ratios=[each if math.isfinite(each) else None for each in ratios.tolist()],
        median=median,
        q95=q95,
        diverged=int(motors.diverged[law]),
        left_out=motors.left_out,
    )


def _mean_motors(ratios: np.ndarray) -> float | None:
    finite = ratios[np.isfinite(ratios)].tolist()
    return geometric_mean(finite) if finite else None


def _mean(values: Iterable[float | None]) -> float | None:
    """Return the geometric mean; None where one is missing."""
    listed = list(values)
    known = [each for each in listed if each is not None]
    return geometric_mean(known) if known and len(known) == len(listed) else None


def _margin(margin: LeastMargin) -> MarginDocument | None:
    if not margin.motor:
        return None
    return MarginDocument(
        value=margin.value if math.isfinite(margin.value) else None,
        motor=margin.motor,
        axis=margin.axis,
        velocity=margin.velocity,
    )


def _shortcomings(margins: LeastMargins) -> list[str]:
    if margins.unstable:
        return [margins.unstable]
    gain, phase = margins.gain_margin, margins.phase_margin
    short = []
    if gain.value < GAIN_MARGIN:
        limit = f"{LIMITS['gain_margin_dB']:g} dB"
        short.append(f"{gain_shown(_margin(gain))} of {limit} on {gain.axis} of {gain.motor}")
    if phase.value < PHASE_MARGIN:
        limit = f"{LIMITS['phase_margin_deg']:g} degrees"
        short.append(f"{phase_shown(_margin(phase))} of {limit} on {phase.axis} of {phase.motor}")
    return short


def _ordered(
    runs: dict[str, ScenarioRun], order: Sequence[int]
) -> dict[str, dict[str, ErrorCurves]]:
    return {
        name: {
            axis: dataclasses.replace(each, low=each.low[order], high=each.high[order])
            for axis, each in run.curves.items()
        }
        for name, run in runs.items()
    }
