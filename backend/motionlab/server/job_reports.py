"""Reports of jobs: one form for all, whose partial result and result are those of the study."""

from __future__ import annotations

import functools
import operator
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, TypeAdapter, create_model

from motionlab.analysis.result_document import ResultDocument
from motionlab.library.replay import Replay
from motionlab.library.replays import Replays
from motionlab.studies.table import STUDIES

State = Literal["queued", "running", "done", "failed", "cancelled", "interrupted"]
WaitsFor = Literal["server", "jobs", "kernels", "memory"]

_MODELS: dict[str, tuple[str, type[BaseModel], type[BaseModel] | None]] = {
    "simulate": ("SimulationJob", ResultDocument, None),
    "replay": ("ReplayJob", Replay, None),
    "replays": ("ReplaysJob", Replays, None),
} | {
    study.kind: (study.report_name, study.document_model, study.partial_model)
    for study in STUDIES
    if not study.direct
}

if TYPE_CHECKING:
    Kind = str
else:
    Kind = Literal[tuple(_MODELS)]


class _State(BaseModel):
    """State of a job of any kind, without its request."""

    model_config = ConfigDict(allow_inf_nan=False)  # a damaged record is none

    id: str = Field(description="Identifier, part of its URL")
    state: State = Field(
        description="queued, running, done, failed, cancelled, or interrupted by the server's end"
    )
    progress: float = Field(description="Share of the work that is done, 0 to 1")
    created: AwareDatetime = Field(description="When it was asked for")
    elapsed: float = Field(description="Time that it has run, s")
    remaining: float | None = Field(description="Estimate of the time that it still needs, s")
    waits_for: WaitsFor | None = Field(
        default=None,
        description="Why it is queued: the server starts, other jobs run, kernels are compiled, "
        "runs and sessions hold the memory; null when it is not",
    )
    subject: str = Field(
        default="", description="What it is of, in short: a scenario, a run, a preset"
    )
    version: str = Field(default="", description="Version of the program that computes it")
    model: str = Field(default="", description="Hash of the model's sources")
    shipped: bool = Field(default=False, description="Whether it came with the program")
    error: str | None = Field(description="Why a job failed or was interrupted")
    unrecorded: str | None = Field(
        default=None, description="Why there is no record of it beyond the server's end"
    )


class JobState(_State):
    """State of a job, without its request and results."""

    kind: Kind = Field(description="Its study, or simulate")


class _JobFields(_State):
    """State of a job of any kind, and what was asked for."""

    request: dict[str, Any] = Field(description="Body of the request that asked for it")


class JobSummary(_JobFields):
    """State of a job, without its results."""

    kind: Kind = Field(description="Its study, or simulate")
    other_model: bool = Field(
        default=False, description="Whether another version of the model has computed it"
    )


def subject_of(request: dict[str, Any]) -> str:
    """Return what a request is of, in short."""
    if request.get("run"):
        return f"run {request['run']}"
    if "q" in request:
        return request["q"] or "all runs"
    if "preset" in request or "geometry" in request:
        return str(request.get("preset", "default"))
    if only := request.get("only"):
        return ", ".join(only[:3]) + (", …" if len(only) > 3 else "")
    scenario = request.get("scenario", "")
    return str(scenario.get("name", "")) if isinstance(scenario, dict) else str(scenario)


def _report(
    kind: str, name: str, document: type[BaseModel], partial: type[BaseModel] | None
) -> type[_JobFields]:
    fields: dict[str, Any] = {
        "kind": (Literal[kind], kind),
        "partial": (
            None if partial is None else partial | None,
            Field(
                default=None,
                description="Results so far, of a job that is running or was interrupted",
            ),
        ),
        "result": (
            document | None,
            Field(default=None, description="Results of a job that is done"),
        ),
    }
    doc = f"A job of the kind {kind}."
    return create_model(name, __base__=_JobFields, __doc__=doc, __module__=__name__, **fields)


REPORTS = {kind: _report(kind, *models) for kind, models in _MODELS.items()}
"""Type of the report of a job, by kind."""

JobReport = Annotated[functools.reduce(operator.or_, REPORTS.values()), Field(discriminator="kind")]  # pyright: ignore[reportInvalidTypeForm]

REPORT: TypeAdapter[Any] = TypeAdapter(JobReport)
