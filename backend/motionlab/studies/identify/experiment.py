"""The experiment on the simulated motor: plan, uniform motions, force ramps, fits, document."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from motionlab import __version__
from motionlab.analysis.result_document import ResultDocument
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError, ExperimentFailed, FieldError
from motionlab.lanes import model_hash
from motionlab.plant.friction import LuGre
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import plant_name
from motionlab.studies.identify.documents import (
    FEWEST_SPEEDS,
    AxisIdentification,
    ExperimentProgress,
    ForceRamp,
    IdentificationDocument,
    IdentifyRequest,
    PartialIdentification,
    PlanDocument,
    PlannedMotion,
    Point,
    Step,
)
from motionlab.studies.identify.fit import Fitted, fit_presliding, fit_sliding
from motionlab.studies.identify.presliding import (
    SLOWEST,
    displacement,
    model_response,
    plan_ramps,
    ramp_thrust,
    ramp_ticks,
)
from motionlab.studies.identify.record.identify import identify_record
from motionlab.studies.identify.record.plan import (
    RecordExperiment,
    plan_record,
    record_plan_document,
)
from motionlab.studies.identify.results import (
    AxisEstimate,
    axis_document,
    is_a_model,
    known_document,
    ramp_document,
)
from motionlab.studies.identify.rig import Rig, compare_models, record
from motionlab.studies.identify.sliding import (
    Doubt,
    UniformMotion,
    in_words,
    measure,
    oscillates,
    plan_motions,
)
from motionlab.studies.identify.thrust_from_currents import CurrentLoops
from motionlab.timing import CONTROL_PERIOD

Source = str | Path | dict[str, Any]


@dataclass(frozen=True)
class Experiment:
    """An identification that has passed every check."""

    request: IdentifyRequest
    source: Source
    rig: Rig
    motions: dict[str, list[UniformMotion]]

    @property
    def ticks(self) -> int:
        """About how many ticks the uniform motions take."""
        return sum(motion.ticks for motions in self.motions.values() for motion in motions)

    @property
    def seconds(self) -> float:
        """About how long they take on a motor, s."""
        return self.ticks * CONTROL_PERIOD


def plan(request: IdentifyRequest, source: Source | None = None) -> Experiment:
    """Return the checked experiment of a request.

    Raises
    ------
    ConfigError
        Naming every number that is wrong: of the scenario, of a variant, of speeds for which the
        stroke is too short.
    """
    source = request.scenario if source is None else source
    scenario = load_scenario(source, request.set)
    rig = Rig.of(request, scenario)
    if request.compare:
        _refuse_nothing_to_compare(rig)
    motions = {
        axis: plan_motions(
            rig,
            axis,
            request.speeds,
            time_max=request.time_max,
            pitches_max=request.pitches_max,
        )
        for axis in request.axes
    }
    return Experiment(request, source, rig, motions)


def plan_document(experiment: Experiment, simulated_time_max: float) -> PlanDocument:
    """Return the motions of an experiment and their duration.

    The force ramps depend on the stiction that is yet to be found; until then the old model's value
    is used.

    Parameters
    ----------
    experiment : Experiment
        From `plan`.
    simulated_time_max : float
        Longest of one request, s.
    """
    rig, options = experiment.rig, experiment.request.presliding
    ticks, ramps = experiment.ticks, 0
    if options.enabled:
        each = 2 * options.places
        ramps = each * len(options.rates) * len(experiment.motions)
        for axis in experiment.motions:
            force_max = options.share * rig.identified_model(axis).friction.F_s
            ticks += each * sum(ramp_ticks(force_max, rate) for rate in options.rates)
    return PlanDocument(
        simulated_time=ticks * CONTROL_PERIOD,
        simulated_time_max=simulated_time_max,
        known={axis: known_document(rig, axis, rig.scenario) for axis in experiment.motions},
        axes={
            axis: [
                PlannedMotion(
                    speed=motion.speed, pitches=motion.pitches, time=motion.ticks * CONTROL_PERIOD
                )
                for motion in motions
            ]
            for axis, motions in experiment.motions.items()
        },
        ramps=ramps,
    )


def _refuse_nothing_to_compare(rig: Rig) -> None:
    compensation = rig.scenario.variants[rig.apply_to].controller.compensation
    if compensation.law == "off" or not compensation.enabled:
        raise ConfigError(
            FieldError(
                loc="apply_to",
                message="adds no friction compensation, so that its model makes no difference to "
                "compare",
                value=rig.apply_to,
            )
        )


Progress = Callable[[float, PartialIdentification | None], None]
"""Takes the share done, 0 to 1, and the results so far when they have changed."""

_SLIDING_SHARE = 0.95
"""Share of the work that is done when the uniform motions are."""

_MASS_OFF = 0.05
"""Share by which M misses the known mass, interval apart, from which a warning is given."""

_FEWEST_COUNTS = 20
"""Of the encoder, that a ramp should move the axis by."""

_LEAST_STICTION = 0.05
"""Stiction below which ramps would not move the axis by a readable amount, N."""


def identify(experiment: Experiment, progress: Progress | None = None) -> IdentificationDocument:
    """Carry out an experiment and evaluate it.

    Only commands, the currents that the drives report, the encoder's reading and the controller's
    map enter an estimate; the motor's true values are added afterwards for comparison.

    Parameters
    ----------
    experiment : Experiment
        From `motionlab.studies.identify.experiment.plan`.
    progress : callable, optional
        Called with the share done, and with the points whenever there are new ones.

    Raises
    ------
    ExperimentFailed
        If the motor diverged.
    """
    return _Execution(experiment, progress).document()


class _Execution:
    """One execution of an experiment."""

    def __init__(self, experiment: Experiment, progress: Progress | None) -> None:
        self.request, self.rig = experiment.request, experiment.rig
        self.source, self.planned = experiment.source, experiment.motions
        self.total = experiment.ticks / _SLIDING_SHARE
        self.done = 0
        self.spent = 0
        self.points: dict[str, list[Point]] = {}
        self.motions: dict[str, list[int]] = {}
        self.results: dict[str, AxisIdentification] = {}
        self.known = {
            axis: known_document(self.rig, axis, self.rig.scenario) for axis in self.planned
        }
        self.loops = {axis: CurrentLoops(self.rig.controller.delay) for axis in self.planned}
        self.progress = progress

    def document(self) -> IdentificationDocument:
        scenario = self.rig.scenario
        changes: dict[str, float] = {}
        for axis in self.planned:
            self.results[axis], identified_changes = self._axis(axis)
            changes |= identified_changes
        comparison = self._compare(changes) if self.request.compare and changes else None
        return IdentificationDocument(
            scenario=scenario.name,
            seed=scenario.seed,
            plant=plant_name(scenario.plant),
            version=__version__,
            model=model_hash(),
            variant=self.rig.variant,
            apply_to=self.rig.apply_to,
            simulated_time=self.spent * CONTROL_PERIOD,
            axes=self.results,
            set=changes,
            comparison=comparison,
        )

    def _axis(self, axis: str) -> tuple[AxisIdentification, dict[str, float]]:
        warnings = self._slide(axis)
        points = self.points[axis]
        if len(points) < 2 * FEWEST_SPEEDS:
            raise ExperimentFailed(
                f"identification: on {axis} the motor followed {len(points)} of "
                f"{2 * len(self.planned[axis])} motions, {2 * FEWEST_SPEEDS} are needed: "
                + "; ".join(warnings[:2])
            )
        sliding = fit_sliding(
            np.array([point.velocity for point in points]),
            np.array([point.force for point in points]),
            motion=np.array(self.motions[axis]),
            time=np.array([point.pitches / abs(point.velocity) for point in points]),
        )
        friction = {name: sliding[name] for name in ("F_c", "F_s", "v_s", "sigma_2")}
        presliding: Fitted | None = None
        ramps: list[ForceRamp] = []
        if self.request.presliding.enabled:
            if _stiction_left(sliding) < _LEAST_STICTION:
                warnings.append(
                    f"no force ramps: F_s = {sliding['F_s']:.3g} N under a load of "
                    f"{sliding['f_0']:.3g} N is too small to read a displacement below it"
                )
            elif sliding["F_s"] > (limit := self.rig.controller.force_limit):
                warnings.append(
                    f"no force ramps: F_s = {sliding['F_s']:.3g} N is beyond the {limit:g} N that "
                    "the loop may command: these speeds do not tell it"
                )
            else:
                presliding, ramps, doubts = self._ramp(axis, sliding)
                warnings += doubts
                warnings += self._mass_doubted(axis, presliding)
                friction |= {name: presliding[name] for name in ("sigma_0", "sigma_1")}
        path = f"variants.{self.rig.apply_to}.controller.model.{axis}.friction."
        if is_a_model(friction, self.rig.identified_model(axis).friction):
            changes = {path + name: value for name, value in friction.items()}
        else:
            changes = {}
            warnings.append("the controller's model cannot take these numbers: none is in `set`")
        everything = AxisEstimate(points, sliding, presliding, ramps, warnings)
        return axis_document(self.rig, axis, everything), changes

    def _slide(self, axis: str) -> list[str]:
        """Carry out the uniform motions of an axis; return warnings."""
        doubts: list[Doubt] = []
        self.points[axis], self.motions[axis] = [], []
        planned = self.planned[axis]
        for index, motion in enumerate(planned):
            self._stand(axis, "sliding", index, len(planned))
            prepared = prepare(motion.scenario)
            self.spent += prepared.reference.ticks
            samples = record(prepared, self._advance)
            points, wrong = measure(
                self.rig, motion, prepared.reference, samples, axis, self.loops[axis]
            )
            self.points[axis] += points
            self.motions[axis] += [index] * len(points)
            doubts += wrong
            if index + 1 == FEWEST_SPEEDS:
                self._refuse_oscillation(axis, doubts)
        return in_words(doubts)

    def _refuse_oscillation(self, axis: str, doubts: list[Doubt]) -> None:
        """End an experiment whose loop is unstable: it would not measure friction."""
        controller = self.rig.controller
        if not oscillates(self.points[axis], doubts, controller.force_limit):
            return
        gains = getattr(controller, axis)
        raise ExperimentFailed(
            f"identification: the loop of {self.rig.variant} oscillates on {axis} between its "
            f"limits of {controller.force_limit:g} N in every motion so far. Gains that a motor "
            f"with its amplifiers, delay and resonance does not bear: k_p = {gains.k_p:g} N/m, "
            f"k_d = {gains.k_d:g} N s/m"
        )

    def _ramp(self, axis: str, sliding: Fitted) -> tuple[Fitted, list[ForceRamp], list[str]]:
        """Carry out the force ramps of an axis and fit them."""
        options = self.request.presliding
        mass = self.rig.model(axis).mass
        force_max = options.share * _stiction_left(sliding)
        warnings = [
            f"a ramp of {rate:g} N/s is slower than {SLOWEST:g} N/s: ripple, noise and creep "
            "add to what it moves"
            for rate in options.rates
            if rate < SLOWEST
        ]
        doubts: list[Doubt] = []
        ways: dict[int, list[Any]] = {place: [] for place in range(options.places)}
        thrusts: dict[int, list[Any]] = {place: [] for place in range(options.places)}
        ramps = plan_ramps(
            self.rig, axis, force_max=force_max, rates=options.rates, places=options.places
        )
        for index, ramp in enumerate(ramps):
            self._stand(axis, "presliding", index, len(ramps))
            self.spent += ramp.prepared.reference.ticks
            samples = record(ramp.prepared)
            way, wrong = displacement(ramp, samples, axis)
            ways[ramp.place].append(way)
            thrusts[ramp.place].append(ramp_thrust(self.rig, ramp, samples, axis, self.loops[axis]))
            doubts += [] if wrong is None else [Doubt("left away", wrong)]
        warnings += in_words(doubts)
        responses, forces = [*ways.values()], [*thrusts.values()]
        way = min(float(response.max()) for place in responses for response in place)
        warnings += self._hardly_seen(axis, force_max, way)
        signs = [ramp.sign for ramp in ramps if ramp.place == 0]
        fitted = fit_presliding(responses, forces, signs, sliding, mass)
        friction = LuGre(
            fitted["sigma_0"],
            fitted["sigma_1"],
            sliding["sigma_2"],
            sliding["F_c"],
            sliding["F_s"],
            sliding["v_s"],
        )
        force = _over_places(forces)
        model = _both_ways(friction, fitted["M"], force, sliding["f_0"])
        drawn = [
            ramp_document(rate, newtons.mean(axis=1), measured, moved)
            for rate, newtons, measured, moved in zip(
                options.rates, force, _over_places(responses), model, strict=True
            )
        ]
        return fitted, drawn, warnings

    def _mass_doubted(self, axis: str, presliding: Fitted) -> list[str]:
        """Warn if the mass, in newtons of the map, differs from the known one."""
        known, mass = self.rig.model(axis).mass, presliding["M"]
        half = float(presliding.half_width[presliding.names.index("M")])
        if abs(mass - known) - half < _MASS_OFF * known:
            return []
        way = "less" if mass < known else "more"
        return [
            f"M = {mass:.4g} kg comes out where {known:.4g} kg are known, {way} by "
            f"{100.0 * abs(1.0 - mass / known):.0f} %: the force map in control is off by about "
            "as much, and so are all forces, which are in its newtons"
        ]

    def _hardly_seen(self, axis: str, force_max: float, way: float) -> list[str]:
        """Warn if the encoder's resolution is too coarse for a displacement."""
        resolution = getattr(self.rig.scenario.plant, axis).encoder.resolution
        if way >= _FEWEST_COUNTS * resolution:
            return []
        return [
            f"ramps up to {force_max:.3g} N move the axis {way * 1e6:.3g} um only, fewer than "
            f"{_FEWEST_COUNTS} counts of the encoder, of {resolution * 1e6:.3g} um: sigma_0 and "
            "sigma_1 are read from steps"
        ]

    def _compare(self, changes: dict[str, float]) -> ResultDocument:
        """Return the result document of the circle with the old model and the new one."""
        self._stand(None, "comparison", 0, 1)
        return compare_models(self.rig, self.source, self.request.set, changes)

    def _advance(self, ticks: int) -> None:
        self.done += ticks
        self._report(None)

    def _stand(self, axis: str | None, step: Step, done: int, count: int) -> None:
        """Report the next step and the results so far."""
        self._report(
            PartialIdentification(
                standing=ExperimentProgress(axis=axis, step=step, done=done, count=count),
                known=self.known,
                axes={name: [*points] for name, points in self.points.items()},
                found=dict(self.results),
            )
        )

    def _report(self, partial: PartialIdentification | None) -> None:
        if self.progress is not None:
            self.progress(min(1.0, self.done / self.total), partial)


def _stiction_left(sliding: Fitted) -> float:
    """Return the stiction that a constant load leaves, N."""
    return sliding["F_s"] - abs(sliding["f_0"])


def _both_ways(friction: LuGre, mass: float, forces: list[Any], load: float) -> list[Any]:
    """Return the model's mean response to each force ramp with and against a constant load."""
    ways = [model_response(friction, mass, forces, [way * load] * len(forces)) for way in (1, -1)]
    return [np.mean(both, axis=0) for both in zip(*ways, strict=True)]


def _over_places(series: list[list[Any]]) -> list[Any]:
    """Return the mean of each rate's series over all places and both signs."""
    ramps = [*zip(*series, strict=True)]
    return [np.mean([*ramps[k], *ramps[k + 1]], axis=0) for k in range(0, len(ramps), 2)]


AnyExperiment = Experiment | RecordExperiment


def plan_identification(
    request: IdentifyRequest, source: str | Path | dict[str, Any] | None = None
) -> AnyExperiment:
    """Return the checked plan of a request; raise ConfigError naming every field that is wrong."""
    return plan(request, source) if request.run is None else plan_record(request, source)


def plan_of(experiment: AnyExperiment, simulated_time_max: float) -> PlanDocument:
    """Return the motions of an experiment, or what is read of a run."""
    match experiment:
        case Experiment():
            return plan_document(experiment, simulated_time_max)
        case RecordExperiment():
            return record_plan_document(experiment, simulated_time_max)


def run_identification(experiment: AnyExperiment, progress: Any = None) -> IdentificationDocument:
    """Carry an identification out; raise ExperimentFailed if nothing can be told."""
    match experiment:
        case Experiment():
            return identify(experiment, progress)
        case RecordExperiment():
            return identify_record(experiment, progress)
