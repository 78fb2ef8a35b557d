"""Learning from lap to lap: run, and told."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
import tomli_w
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import MotionLabError
from motionlab.files import complete_file
from motionlab.lanes import model_hash
from motionlab.simulation.learnt import over_lap
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.result import plant_name
from motionlab.studies.learn.documents import (
    CarriedOver,
    EncoderError,
    LearnAxis,
    LearnDocument,
    LearnLap,
    PartialLearning,
    Prediction,
)
from motionlab.studies.learn.encoder_error import EncoderErrorFit
from motionlab.studies.learn.laps import AxisLearning, Learning
from motionlab.studies.learn.lessons import carry_over, lesson_fits
from motionlab.studies.learn.plan import LearnPlan
from motionlab.studies.learn.predictions import SHARE, predictions, rounded
from motionlab.studies.study import Progress
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

_POINTS = 1000


@dataclass(frozen=True)
class Learnt:
    """What was learnt of a scenario."""

    scenario: Scenario
    document: LearnDocument


def learn(planned: LearnPlan, progress: Progress) -> Learnt:
    """Predict convergence, run the laps, and return what was learnt."""
    predicted = predictions(planned, progress)
    learning = learning_of(planned)
    carried = carried_over(planned, learning) if planned.after else {}
    laps = planned.request.laps
    for done in learning.run(laps):
        share = SHARE + (1.0 - SHARE) * done / laps
        progress(share, PartialLearning(laps=_laps(learning)))
    return Learnt(planned.scenario, _document(planned, learning, predicted, carried))


def carried_over(planned: LearnPlan, learning: Learning) -> dict[str, CarriedOver]:
    """Learn other motions first, carry over what they teach, and return it.

    Raises
    ------
    MotionLabError
        If the motor diverges in one of them, or in the first lap without what they teach.
    """
    without = learning_of(planned)
    without.approach(lap=True)
    _run_whole(without, 1, "the motion itself")
    learnings = []
    for motion, each in zip(planned.request.after, planned.after, strict=True):
        first = learning_of(each)
        _run_whole(first, each.request.laps, name_of(motion))
        learnings.append(first)
    for axis, own in learning.axes.items():
        known = [each.axes[axis].known for each in learnings if axis in each.axes]
        own.known = known[0] if known else own.known
    fits = lesson_fits(learnings)

    def begin(prepared: Prepared) -> Learning:
        return learning_of(replace(planned, prepared=prepared), encoder=False)

    carry_over(learning, fits, begin)
    return {
        axis: CarriedOver(
            motions=[
                name_of(motion)
                for motion, each in zip(planned.request.after, learnings, strict=True)
                if axis in each.axes
            ],
            explained=fits[axis].explained,
            peak=without.axes[axis].laps[0].peak,
        )
        for axis in learning.axes
        if axis in fits
    }


def _run_whole(learning: Learning, laps: int, motion: str) -> None:
    """Run laps that something is learnt from for another motion."""
    for _ in learning.run(laps):
        pass
    if learning.laps < laps:
        lap = learning.laps + 1
        raise MotionLabError(f"the motor diverged in lap {lap} of {motion}: nothing to carry over")


def name_of(motion: str | dict[str, Any]) -> str:
    """Return the name of a motion that is learnt first, or its kind."""
    return motion if isinstance(motion, str) else str(motion.get("kind", "motion"))


def save(learnt: Learnt, path: str) -> None:
    """Write the scenario with what was learnt to a file that ``motionlab run`` takes.

    Raises
    ------
    MotionLabError
        If the motor diverged.
    """
    if learnt.document.diverged:
        lap = learnt.document.laps + 1
        raise MotionLabError(f"{path} is not written: the motor diverged in lap {lap}")
    tables = apply_changes(learnt.scenario.model_dump(mode="json"), learnt.document.changes)
    scenario = validate(tables).model_dump(mode="json", exclude_none=True)
    with complete_file(path) as part:
        part.write_text(tomli_w.dumps(scenario), encoding="utf-8")


def learning_of(planned: LearnPlan, *, encoder: bool = True) -> Learning:
    """Return the learning of a plan, before its first lap; what the scenario knows is kept.

    Without `encoder`, neither is known of its error nor learnt.
    """
    scenario, variant = planned.scenario, planned.variant
    model = scenario.variants[variant].controller.model
    axes = {}
    for axis, each in planned.filters.items():
        known = getattr(model, axis).subdivision
        fit = (
            EncoderErrorFit.of(scenario, variant, axis, planned.lap.ticks)
            if planned.request.encoder and encoder
            else None
        )
        axes[axis] = AxisLearning(
            filter=each,
            encoder=fit,
            gain=planned.request.gain,
            force=_begun(planned, axis),
            known=(known.sine, known.cosine) if encoder else (0.0, 0.0),
        )
    return Learning(planned.prepared, variant, axes)


def _begun(planned: LearnPlan, axis: str) -> Array:
    """Return the force that the scenario has learnt before, N, (ticks,)."""
    known, uses = planned.scenario.learnt, planned.scenario.variants[planned.variant].controller
    if known is None or not uses.learnt:
        return np.zeros(planned.lap.ticks)
    return over_lap(known, planned.lap)[:, AXES.index(axis)].copy()


def _laps(learning: Learning) -> dict[str, list[LearnLap]]:
    return {
        axis: [LearnLap(**asdict(lap)) for lap in each.laps] for axis, each in learning.axes.items()
    }


def _document(
    planned: LearnPlan,
    learning: Learning,
    predicted: dict[str, Prediction],
    carried: dict[str, CarriedOver],
) -> LearnDocument:
    scenario, diverged = planned.scenario, learning.laps < planned.request.laps
    laps = _laps(learning)
    every = max(1, -(-planned.lap.ticks // _POINTS))
    axes = {
        axis: LearnAxis(
            bandwidth=planned.bandwidths[axis],
            prediction=predicted[axis],
            laps=laps[axis],
            carried_over=carried.get(axis),
            encoder=_encoder(each),
            force=rounded(each.force[::every]),
            remains=rounded(each.error[::every]),
        )
        for axis, each in learning.axes.items()
    }
    return LearnDocument(
        scenario=scenario.name,
        plant=plant_name(scenario.plant),
        version=__version__,
        model=model_hash(),
        variant=planned.variant,
        law=scenario.variants[planned.variant].controller.compensation.law,
        lap=planned.lap.ticks * CONTROL_PERIOD,
        laps=learning.laps,
        diverged=diverged,
        summary=[
            _sentence(axis, each, planned.request.motors, diverged=diverged)
            for axis, each in axes.items()
        ],
        time=rounded(CONTROL_PERIOD * np.arange(0.0, planned.lap.ticks, every)),
        axes=axes,
        changes=learning.changes(),
    )


def _encoder(learning: AxisLearning) -> EncoderError | None:
    if learning.encoder is None:
        return None
    sine, cosine = learning.known
    return EncoderError(
        amplitude=float(np.hypot(sine, cosine)),
        sine=sine,
        cosine=cosine,
        period=learning.encoder.period,
    )


def _sentence(axis: str, learnt: LearnAxis, motors: int, *, diverged: bool) -> str:
    """Return what became of an axis, and what was predicted."""
    rho, laps = learnt.prediction, learnt.laps
    fate = "converges" if rho.worst < 1.0 else "diverges"
    text = (
        f"{axis} {fate}: at {rho.worst_frequency:.4g} Hz an error becomes "
        f"{rho.worst:.3f} of itself from lap to lap, at other frequencies less"
    )
    if rho.converging is not None:
        text += (
            f"; so do {100 * rho.converging:.3g} % of {motors} drawn motors"
            if (rho.worst < 1.0)
            else f"; {100 * rho.converging:.3g} % of {motors} drawn motors converge"
        )
    if diverged:
        return f"{text}. The motor diverged in lap {len(laps) + 1}."
    best = min(range(len(laps)), key=lambda lap: laps[lap].peak)
    if learnt.carried_over is not None:
        before = learnt.carried_over
        text += (
            f". What {' and '.join(before.motions)} taught takes its first lap from "
            f"{1e6 * before.peak:.3g} to {1e6 * laps[0].peak:.3g} \u00b5m"
        )
    text += (
        f". Its largest error falls from {1e6 * laps[0].peak:.3g} to "
        f"{1e6 * laps[best].peak:.3g} \u00b5m in lap {best + 1}"
    )
    back = sum(lap.went_back for lap in laps)
    if back:
        laps_were = "lap was" if back == 1 else "laps were"
        text += f"; {back} {laps_were} so much worse that learning went back"
    return f"{text}."
