"""An identification by experiment, or from a run: whichever the request asks for."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from motionlab.studies.identify.document import IdentificationDocument, PlanDocument
from motionlab.studies.identify.plan import Experiment, plan, plan_document
from motionlab.studies.identify.record_plan import (
    RecordExperiment,
    plan_record,
    record_plan_document,
)
from motionlab.studies.identify.request import IdentifyRequest

AnyExperiment = Experiment | RecordExperiment


def planned(
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


def identified(experiment: AnyExperiment, progress: Any = None) -> IdentificationDocument:
    """Carry an identification out; raise ExperimentFailed if nothing can be told."""
    match experiment:
        case Experiment():
            from motionlab.studies.identify.experiment import identify

            return identify(experiment, progress)
        case RecordExperiment():
            from motionlab.studies.identify.record_identify import identify_record

            return identify_record(experiment, progress)
