"""Learning from lap to lap: planned with its prediction, run, and text."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass

import numpy as np
import tomli_w
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.changes import apply_changes
from motionlab.config.load import load_scenario, validate
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.files import complete_file
from motionlab.lanes import model_hash
from motionlab.simulation.learnt import Lap, checked_lap, over_lap
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.learn.documents import (
    EncoderError,
    LearnAxis,
    LearnDocument,
    LearnLap,
    LearnRequest,
    PartialLearning,
    Prediction,
)
from motionlab.studies.learn.encoder_error import EncoderErrorFit
from motionlab.studies.learn.laps import AxisLearning, Learning
from motionlab.studies.learn.learning_filter import (
    SPEEDS,
    LearningFilter,
    bandwidth_of,
    modelled,
    thinned,
    to_error,
)
from motionlab.studies.montecarlo.documents import DEFAULT
from motionlab.studies.montecarlo.draw import draw, missing
from motionlab.studies.study import Progress, Source
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

_FREQUENCIES = 160
_POINTS = 1000
_PREDICTING = 0.3
"""Share of the progress that is predicting's."""


@dataclass(frozen=True)
class LearnPlan:
    """Learning that has passed every check.

    Attributes
    ----------
    request : LearnRequest
        As validated.
    prepared : Prepared
        The scenario.
    variant : str
        Which controller learns.
    lap : Lap
        Of the motion.
    filters : dict of str to LearningFilter
        Of the axes that move.
    bandwidths : dict of str to float
        Hz.
    """

    request: LearnRequest
    prepared: Prepared
    variant: str
    lap: Lap
    filters: dict[str, LearningFilter]
    bandwidths: dict[str, float]

    @property
    def seconds(self) -> float:
        """Simulated time, s."""
        return (self.lap.first + self.request.laps * self.lap.ticks) * CONTROL_PERIOD

    @property
    def scenario(self) -> Scenario:
        """The scenario."""
        return self.prepared.scenario


def plan(request: LearnRequest, source: Source | None = None) -> LearnPlan:
    """Return the checked plan of a request.

    Raises
    ------
    ConfigError
        Naming every field that is wrong; where the controller has no linearisation; and where
        learning would diverge, unless it is to go on anyway.
    """
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    prepared = prepare(scenario)
    scenario = prepared.scenario
    lap = checked_lap(prepared.reference)
    variant = request.variant or list(scenario.variants)[-1]
    if variant not in scenario.variants:
        choices = ", ".join(scenario.variants)
        raise ConfigError(FieldError("variant", "is not in the scenario", variant, choices))
    controller = scenario.variants[variant].controller
    bandwidths = {
        axis: getattr(request.bandwidth, axis) or bandwidth_of(getattr(controller, axis).notch)
        for axis in prepared.reference.moving
    }
    filters = {
        axis: LearningFilter.of(scenario, variant, axis, lap.ticks, bandwidth)
        for axis, bandwidth in bandwidths.items()
    }
    planned = LearnPlan(request, prepared, variant, lap, filters, bandwidths)
    if not request.anyway:
        _refuse_divergence(planned)
    return planned


def _refuse_divergence(planned: LearnPlan) -> None:
    errors = []
    for axis, each in planned.filters.items():
        rho = factors(planned, axis, planned.scenario, band(each))
        worst = int(rho.argmax())
        if rho[worst] >= 1.0:
            at = each.frequency[band(each)][worst]
            errors.append(
                FieldError(
                    f"bandwidth.{axis}",
                    f"learning would diverge: an error at {at:.4g} Hz would grow by "
                    f"{rho[worst]:.3g} from lap to lap; a lower bandwidth or gain converges",
                    planned.bandwidths[axis],
                    unit="Hz",
                )
            )
    if errors:
        raise ConfigError(*errors)


def band(each: LearningFilter) -> NDArray[np.intp]:
    """Return indices of frequencies at which something is learnt, at most some."""
    last = int(np.flatnonzero(each.band)[-1])
    return thinned(each.frequency[: last + 1], _FREQUENCIES)


def factors(planned: LearnPlan, axis: str, scenario: Scenario, at: NDArray[np.intp]) -> Array:
    """Return the largest rho over velocities of the motor of a scenario, (n,).

    Parameters
    ----------
    planned : LearnPlan
        Whose filter learns.
    axis : str
        ``x`` or ``y``.
    scenario : Scenario
        Motor, under the same controller.
    at : ndarray of int, shape (n,)
        Indices of frequencies.
    """
    each, gain = planned.filters[axis], planned.request.gain
    part = LearningFilter(each.frequency[at], each.response[at], each.q[at])
    return np.max(
        [
            part.factor(to_error(scenario, planned.variant, axis, speed, part.frequency), gain)
            for speed in SPEEDS
        ],
        axis=0,
    )


def drawn_motors(planned: LearnPlan) -> list[Scenario]:
    """Return the scenario with motors drawn as Monte Carlo draws them."""
    request, scenario = planned.request, planned.scenario
    document = scenario.model_dump(mode="json")
    absent = missing(document["plant"], DEFAULT)
    vary = [each for each in DEFAULT if each.path not in absent]
    seed = scenario.seed if request.seed is None else request.seed
    draws = draw(document["plant"], vary, cases=request.motors, seed=seed)
    return [validate(apply_changes(document, changes)) for changes in draws]


@dataclass(frozen=True)
class Learnt:
    """What was learnt of a scenario."""

    scenario: Scenario
    document: LearnDocument


def learn(planned: LearnPlan, progress: Progress) -> Learnt:
    """Predict convergence, run the laps, and return what was learnt."""
    predictions = _predictions(planned, progress)
    learning = learning_of(planned)
    laps = planned.request.laps
    for done in learning.run(laps):
        share = _PREDICTING + (1.0 - _PREDICTING) * done / laps
        progress(share, PartialLearning(laps=_laps(learning)))
    return Learnt(planned.scenario, _document(planned, learning, predictions))


def save(learnt: Learnt, path: str) -> None:
    """Write the scenario with what was learnt to a file that ``motionlab run`` takes."""
    tables = apply_changes(learnt.scenario.model_dump(mode="json"), learnt.document.changes)
    scenario = validate(tables).model_dump(mode="json", exclude_none=True)
    with complete_file(path) as part:
        part.write_text(tomli_w.dumps(scenario), encoding="utf-8")


def learning_of(planned: LearnPlan) -> Learning:
    """Return the learning of a plan, before its first lap; what the scenario knows is kept."""
    scenario, variant = planned.scenario, planned.variant
    model = scenario.variants[variant].controller.model
    axes = {}
    for axis, each in planned.filters.items():
        known = getattr(model, axis).subdivision
        fit = (
            EncoderErrorFit.of(scenario, variant, axis, planned.lap.ticks)
            if planned.request.encoder
            else None
        )
        axes[axis] = AxisLearning(
            filter=each,
            encoder=fit,
            gain=planned.request.gain,
            force=_begun(planned, axis),
            known=(known.sine, known.cosine),
        )
    return Learning(planned.prepared, variant, axes)


def _begun(planned: LearnPlan, axis: str) -> Array:
    """Return the force that the scenario has learnt before, N, (ticks,)."""
    known, uses = planned.scenario.learnt, planned.scenario.variants[planned.variant].controller
    if known is None or not uses.learnt:
        return np.zeros(planned.lap.ticks)
    return over_lap(known, planned.lap)[:, AXES.index(axis)].copy()


def _predictions(planned: LearnPlan, progress: Progress) -> dict[str, Prediction]:
    drawn: dict[str, list[Array]] = {axis: [] for axis in planned.filters}
    bands = {axis: band(each) for axis, each in planned.filters.items()}
    motors = drawn_motors(planned)
    for number, motor in enumerate(motors):
        for axis, at in bands.items():
            drawn[axis].append(factors(planned, axis, motor, at))
        progress(_PREDICTING * (number + 1) / len(motors), None)
    return {axis: _prediction(planned, axis, bands[axis], drawn[axis]) for axis in bands}


def _prediction(
    planned: LearnPlan, axis: str, at: NDArray[np.intp], drawn: Sequence[Array]
) -> Prediction:
    frequency = planned.filters[axis].frequency[at]
    motor = factors(planned, axis, planned.scenario, at)
    model = factors(planned, axis, modelled(planned.scenario, planned.variant), at)
    worst = int(motor.argmax())
    low, high = np.quantile(drawn, (0.05, 0.95), axis=0) if drawn else (None, None)
    return Prediction(
        frequency=_rounded(frequency),
        motor=_rounded(motor),
        model=_rounded(model),
        low=None if low is None else _rounded(low),
        high=None if high is None else _rounded(high),
        worst=float(motor[worst]),
        worst_frequency=float(frequency[worst]),
        converging=float(np.mean([each.max() < 1.0 for each in drawn])) if drawn else None,
    )


def _rounded(values: Array) -> list[float]:
    return [float(f"{value:.6g}") for value in values.tolist()]


def _laps(learning: Learning) -> dict[str, list[LearnLap]]:
    return {
        axis: [LearnLap(**asdict(lap)) for lap in each.laps] for axis, each in learning.axes.items()
    }


def _document(
    planned: LearnPlan, learning: Learning, predictions: dict[str, Prediction]
) -> LearnDocument:
    scenario = planned.scenario
    laps = _laps(learning)
    every = max(1, -(-planned.lap.ticks // _POINTS))
    axes = {
        axis: LearnAxis(
            bandwidth=planned.bandwidths[axis],
            prediction=predictions[axis],
            laps=laps[axis],
            encoder=_encoder(each),
            force=_rounded(each.force[::every]),
            remains=_rounded(each.error[::every]),
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
        diverged=learning.laps < planned.request.laps,
        summary=[_sentence(axis, each, planned.request.motors) for axis, each in axes.items()],
        time=_rounded(CONTROL_PERIOD * np.arange(0.0, planned.lap.ticks, every)),
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


def _sentence(axis: str, learnt: LearnAxis, motors: int) -> str:
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
    if not laps:
        return f"{text}."
    best = min(range(len(laps)), key=lambda lap: laps[lap].peak)
    text += (
        f". Its largest error falls from {1e6 * laps[0].peak:.3g} to "
        f"{1e6 * laps[best].peak:.3g} \u00b5m in lap {best + 1}"
    )
    back = sum(lap.went_back for lap in laps)
    if back:
        text += f"; {back} laps were so much worse that learning went back"
    return f"{text}."
