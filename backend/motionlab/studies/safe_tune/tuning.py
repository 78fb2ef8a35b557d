"""One step of tuning on a machine from its runs, or a rehearsal on a simulated machine."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, needs
from motionlab.loop.linearise import linearise
from motionlab.simulation.prepare import prepare
from motionlab.studies.response.documents import ResponseRequest
from motionlab.studies.response.measure import ResponsePlan
from motionlab.studies.response.measure import plan as plan_response
from motionlab.studies.response.recorded import RecordedPlan
from motionlab.studies.safe_tune.documents import (
    Examined,
    LeastMargins,
    MotionMade,
    NextMotion,
    Refusal,
    SafeTuneDocument,
    SafeTuneRequest,
)
from motionlab.studies.safe_tune.measured import RunMeasured, read_run, same_but_gains
from motionlab.studies.safe_tune.model import (
    Bench,
    MeasuredLoop,
    MotorModel,
    gains_of,
    plausible_motors,
)
from motionlab.studies.safe_tune.search import Examination, Limits, Measured, examine
from motionlab.studies.study import Source
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Progress = Callable[[float, SafeTuneDocument | None], None]

_ERROR = 2.0  # times the first motion's
_FORCE = 0.9  # of the controller's limit
_LINES = 300  # of a rehearsal's response
_BEYOND = 1.001
_SLOW = 1e-4  # m/s
_LIMITS: tuple[Refusal, ...] = ("margin", "error", "force")


@dataclass(frozen=True)
class SafeTunePlan:
    """A request that has passed every check.

    Attributes
    ----------
    request : SafeTuneRequest
        As validated.
    scenario : Scenario
        Motor that is believed in, motion and present controller.
    variant : str
        Whose gains.
    machine : Scenario or None
        Of a rehearsal.
    plausible : tuple of Scenario
        With each of the plausible motors.
    runs : tuple of RunMeasured
        What the motions made so far measured.
    response : ResponsePlan, RecordedPlan or None
        Of the measured loop.
    seconds : float
        Simulated time of all that may be simulated, s.
    """

    request: SafeTuneRequest
    scenario: Scenario
    variant: str
    machine: Scenario | None
    plausible: tuple[Scenario, ...]
    runs: tuple[RunMeasured, ...]
    response: ResponsePlan | RecordedPlan | None
    seconds: float

    @property
    def path(self) -> str:
        """Dotted path of the axis's gains."""
        return f"variants.{self.variant}.controller.{self.request.axis}"


def plan(request: SafeTuneRequest, source: Source | None = None) -> SafeTunePlan:
    """Return the checked plan of a request.

    Raises
    ------
    ConfigError
        If scikit-learn is missing, runs and machine are both named, a run is not of this motion or
        controller, or the law has no linearisation.
    Infeasible
        If the motor cannot follow the motion.
    """
    if importlib.util.find_spec("sklearn") is None:
        raise ConfigError(FieldError("scenario", needs("sklearn")))
    scenario = load_scenario(request.scenario if source is None else source, request.set)
    variant = request.chosen(scenario)
    for name, gain in zip(("k_p", "k_d"), gains_of(scenario, variant, request.axis), strict=True):
        if gain <= 0.0:
            place = f"variants.{variant}.controller.{request.axis}.{name}"
            raise ConfigError(FieldError(place, "must be above 0: its factor is searched", gain))
    bench = Bench(scenario, variant, request.axis, request.metric)
    if not bench.moving:
        message = "does not move in this scenario"
        raise ConfigError(FieldError("axis", message, request.axis))
    if scenario.schedule:
        message = "changes the controller or motor during a motion: leave it out"
        raise ConfigError(FieldError("schedule", message))
    machine, response = None, None
    if request.machine is not None:
        if request.runs or request.response is not None:
            message = "is of a rehearsal, whose motions are simulated: leave out runs and response"
            raise ConfigError(FieldError("machine", message))
        machine = _machine(scenario, request.machine)
        if request.measure:
            response = _rehearsed(request, machine, variant)
    elif request.response is not None:
        response = plan_response(
            ResponseRequest(run=request.response, axis=request.axis, variant=variant)
        )
        if isinstance(response, RecordedPlan) and not response.own:
            message = "is a measurement, whose controller the lab does not know: `shape` takes it"
            raise ConfigError(FieldError("response", message, request.response))
        same_but_gains(scenario, response.scenario, variant, request.axis, "response")
    runs = tuple(
        read_run(
            run,
            f"runs.{k}",
            scenario=scenario,
            variant=variant,
            request=request,
            window=bench.window,
        )
        for k, run in enumerate(request.runs)
    )
    scenario = _delayed(scenario, variant, runs)
    linearise(scenario, variant, request.axis, v=_SLOW)
    plausible = plausible_motors(scenario, request)
    # A motion is looked at from 121 gains about it, overlapping ones once, over window and whole.
    steps = request.motions if machine is not None else 1
    seconds = bench.window[1] * CONTROL_PERIOD * 2.0 * 121.0 * steps * max(1, len(runs), steps // 2)
    measured = response.seconds if response is not None else 0.0
    seconds += measured
    return SafeTunePlan(request, scenario, variant, machine, plausible, runs, response, seconds)


def tune_safely(planned: SafeTunePlan, progress: Progress | None = None) -> SafeTuneDocument:
    """Return the next motion, or make all of them in a rehearsal.

    Parameters
    ----------
    planned : SafeTunePlan
        From `plan`.
    progress : callable, optional
        Takes the share done and, of a rehearsal, the document so far; what it raises ends the work.

    Raises
    ------
    ConfigError
        As the measured loop does.
    """
    request = planned.request

    def tell(share: float, document: SafeTuneDocument | None = None) -> None:
        if progress is not None:
            progress(share, document)

    tell(0.0)
    loop = None if planned.response is None else MeasuredLoop(planned.response, request)
    model = MotorModel(planned.scenario, planned.variant, request, planned.plausible, loop=loop)
    if planned.machine is None:
        return _step(planned, model, list(planned.runs))
    machine = Bench(planned.machine, planned.variant, request.axis, request.metric)
    runs: list[RunMeasured] = []
    while True:
        document = _step(planned, model, runs)
        tell(len(runs) / request.motions, document)
        if document.proposal is None:
            return document
        k_p, k_d = document.proposal.k_p, document.proposal.k_d
        outputs = machine.measure(np.array([k_p]), np.array([k_d]))[:, 0]
        runs.append(RunMeasured(None, k_p, k_d, *outputs.tolist()))


def _delayed(scenario: Scenario, variant: str, runs: tuple[RunMeasured, ...]) -> Scenario:
    """Return the scenario with the delay of the runs: on drives it is a period."""
    delays = {each.delay for each in runs}
    if not delays:
        return scenario
    if len(delays) > 1:
        message = "are of machines with different delays, such as a simulation and drives"
        raise ConfigError(FieldError("runs", message, sorted(delays), unit="periods"))
    owner = scenario.variants[variant]
    controller = owner.controller.model_copy(update={"delay": delays.pop()})
    changed = owner.model_copy(update={"controller": controller})
    return scenario.model_copy(update={"variants": {**scenario.variants, variant: changed}})


def _machine(scenario: Scenario, changes: dict[str, Any]) -> Scenario:
    for place in changes:
        if place.split(".")[0] not in {"plant", "load"}:
            message = "is not of the machine"
            raise ConfigError(FieldError("machine", message, place, "fields of plant or load"))
    machine = load_scenario(scenario.model_dump(mode="json"), changes)
    prepare(machine)  # it can follow the motion
    return machine


def _rehearsed(request: SafeTuneRequest, machine: Scenario, variant: str) -> ResponsePlan:
    response = ResponseRequest(axis=request.axis, variant=variant, lines=_LINES)
    planned = plan_response(response, machine.model_dump(mode="json"))
    assert isinstance(planned, ResponsePlan)
    return planned


def _step(planned: SafeTunePlan, model: MotorModel, runs: list[RunMeasured]) -> SafeTuneDocument:
    """Return the document of the motions so far."""
    request = planned.request
    start = gains_of(planned.scenario, planned.variant, request.axis)
    limit = planned.scenario.variants[planned.variant].controller.force_limit
    force = _FORCE * limit if request.force is None else request.force
    error = request.error
    if error is None and runs and math.isfinite(runs[0].error):
        error = _ERROR * runs[0].error
    limits = Limits(math.inf if error is None else error, force)
    gains = np.array([(each.k_p, each.k_d) for each in runs]).reshape(-1, 2)
    outputs = np.array([(each.metric, each.error, each.force) for each in runs]).reshape(-1, 3).T
    measured = Measured(gains, outputs)
    kept = limits.keep(measured) if runs else np.zeros(0, dtype=bool)
    best = int(np.argmin(np.where(kept, outputs[0], math.inf))) if kept.any() else None
    made = [
        MotionMade(
            run=each.run,
            k_p=each.k_p,
            k_d=each.k_d,
            metric=_finite(each.metric),
            error=_finite(each.error),
            force=_finite(each.force),
            within=bool(within),
        )
        for each, within in zip(runs, kept, strict=True)
    ]
    document = SafeTuneDocument(
        error=error,
        force=force,
        motions=made,
        proposal=None,
        ended="",
        best=best,
        changes={},
        examined=Examined(k_p=[], k_d=[], refused=[], expected=[]),
        warnings=[],
    )
    if not runs:
        return _first(planned, model, document, start)
    if best is not None and (made[best].k_p, made[best].k_d) != start:
        document.changes = _changes(planned, made[best].k_p, made[best].k_d)
    if not kept[-1] and math.isfinite(runs[-1].metric):
        document.warnings.append(
            f"the last motion went beyond its limits: {_beyond_limits(runs[-1], limits)}"
        )
    if not math.isfinite(runs[-1].metric):
        document.ended = f"motion {len(runs)} diverged: the machine is not what is known of it"
        return document
    if best is None:
        document.ended = "no motion stayed within the limits of error and force"
        return document
    seen = examine(model, request, measured, limits)
    document.examined = _examined(seen)
    if len(runs) >= request.motions:
        document.ended = f"{len(runs)} motions are made, as many as were requested"
        return document
    chosen = int(np.argmax(seen.improvement))
    promise = float(-np.expm1(-seen.improvement[chosen]))
    if not seen.safe.any():
        document.ended = "no gains within a step are sure to keep margins, error and force"
    elif promise < request.improvement:
        document.ended = (
            f"no safe gains within a step promise {100 * request.improvement:.3g} % less error: "
            f"{100 * promise:.2g} % at most"
        )
    else:
        document.proposal = _proposal(planned, seen, chosen, promise, gains)
    return document


def _first(
    planned: SafeTunePlan,
    model: MotorModel,
    document: SafeTuneDocument,
    start: tuple[float, float],
) -> SafeTuneDocument:
    """Propose the present gains."""
    k_p, k_d = start
    margins = model.margins(np.array([k_p]), np.array([k_d]))
    metric, error, force = model.measure(np.array([k_p]), np.array([k_d]))[:, 0].tolist()
    if not margins.hold[0]:
        document.warnings.append(
            "the present gains do not keep the requested margins, on what is known of the machine"
        )
    if math.isnan(margins.gain[0]) or not math.isfinite(metric):
        document.ended = "the present gains are not stable on the scenario's motor"
        return document
    document.proposal = NextMotion(
        k_p=k_p,
        k_d=k_d,
        changes={},
        expected=metric,
        error_high=error,
        force_high=force,
        margins=_least(margins.gain[0], margins.phase[0]),
        plausible=_least(margins.least_gain[0], margins.least_phase[0]),
        improvement=0.0,
        beyond=True,
        text="the present gains, from which all that follows is measured; expected of the "
        "scenario's motor",
    )
    return document


def _proposal(
    planned: SafeTunePlan, seen: Examination, chosen: int, promise: float, gains: Array
) -> NextMotion:
    k_p, k_d = (float(f"{each:.4g}") for each in seen.gains[chosen])
    over = np.array([k_p, k_d]) / gains.max(axis=0)
    names = [
        f"{name} {100 * (share - 1.0):.2g} %"
        for name, share in zip(("k_p", "k_d"), over, strict=True)
        if share > _BEYOND
    ]
    margins = seen.margins
    return NextMotion(
        k_p=k_p,
        k_d=k_d,
        changes=_changes(planned, k_p, k_d),
        expected=float(seen.median[0, chosen]),
        error_high=float(seen.high[1, chosen]),
        force_high=float(seen.high[2, chosen]),
        margins=_least(margins.gain[chosen], margins.phase[chosen]),
        plausible=_least(margins.least_gain[chosen], margins.least_phase[chosen]),
        improvement=promise,
        beyond=bool(names),
        text="beyond every motion made: " + " and ".join(names)
        if names
        else "no gain is larger than in the motions made",
    )


def _changes(planned: SafeTunePlan, k_p: float, k_d: float) -> dict[str, float]:
    return {f"{planned.path}.k_p": k_p, f"{planned.path}.k_d": k_d}


def _least(gain: float, phase: float) -> LeastMargins:
    return LeastMargins(
        gain_margin=float(gain) if math.isfinite(gain) else None,
        phase_margin=float(phase) if math.isfinite(phase) else None,
    )


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _beyond_limits(motion: RunMeasured, limits: Limits) -> str:
    parts: list[str] = []
    if not motion.error <= limits.error:
        parts.append(f"error {1e6 * motion.error:.4g} um of {1e6 * limits.error:.4g} um")
    if not motion.force <= limits.force:
        parts.append(f"force {motion.force:.4g} N of {limits.force:.4g} N")
    return ", ".join(parts)


def _examined(seen: Examination) -> Examined:
    refused: list[Refusal] = []
    for holds in seen.holds.T.tolist():
        missed: list[Refusal] = [name for name, ok in zip(_LIMITS, holds, strict=True) if not ok]
        refused.append(missed[0] if missed else "")
    expected = [float(each) if math.isfinite(each) else None for each in seen.median[0]]
    return Examined(
        k_p=seen.gains[:, 0].tolist(),
        k_d=seen.gains[:, 1].tolist(),
        refused=refused,
        expected=expected,
    )
