"""The plan of an identification: every number validated before the first motion."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from motionlab.config.load import load_scenario
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.errors import ConfigError, FieldError
from motionlab.studies.identify.document import PlanDocument, PlannedMotion
from motionlab.studies.identify.evaluate import known_document
from motionlab.studies.identify.presliding import ramp_ticks
from motionlab.studies.identify.request import IdentifyRequest
from motionlab.studies.identify.sliding import UniformMotion, plan_motions
from motionlab.studies.identify.test_bench import Rig

Source = str | Path | dict[str, Any]


@dataclass(frozen=True)
class Experiment:
    """An identification that has passed every check.

    Attributes
    ----------
    request : IdentifyRequest
        As validated.
    source : str, Path or dict
        The scenario as given.
    rig : Rig
        Motor and loop.
    motions : dict of str to list of UniformMotion
        Uniform motions of each axis.
    """

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

    Parameters
    ----------
    request : IdentifyRequest
        Validated request.
    source : str, Path or dict, optional
        The scenario in place of the request's, which is never a path.

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

    Returns
    -------
    PlanDocument
        Motions of each axis, and the time of all.
    """
    rig, asked = experiment.rig, experiment.request.presliding
    ticks, ramps = experiment.ticks, 0
    if asked.enabled:
        each = 2 * asked.places
        ramps = each * len(asked.rates) * len(experiment.motions)
        for axis in experiment.motions:
            force_max = asked.share * rig.identified_model(axis).friction.F_s
            ticks += each * sum(ramp_ticks(force_max, rate) for rate in asked.rates)
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
