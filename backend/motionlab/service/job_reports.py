"""What is told of a job: the same for all, and for each kind its partial and final result."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from pydantic import AwareDatetime, BaseModel, ConfigDict, Field, TypeAdapter

from motionlab.design.fem.document import MapEntry
from motionlab.results.document import ResultDocument
from motionlab.studies.identify.document import IdentificationDocument, PartialIdentification
from motionlab.studies.loop.response import SweepDocument
from motionlab.studies.montecarlo.document import MonteCarloDocument
from motionlab.studies.paper.document import PartialReproduce, ReproduceDocument
from motionlab.studies.tune.document import (
    LandscapeDocument,
    PartialLandscape,
    PartialTuning,
    TuneDocument,
)

State = Literal["queued", "running", "done", "failed", "cancelled", "interrupted"]
Kind = Literal[
    "simulate", "identify", "map", "reproduce", "tune", "landscape", "sweep", "monte-carlo"
]

_PARTIAL = "What is there so far, of a job that is looked at while it goes on"
_RESULT = "What came of a job that is done"


class _Job(BaseModel):
    """What is told of a job of any kind."""

    model_config = ConfigDict(allow_inf_nan=False)  # a damaged record is none

    id: str = Field(description="Identifier, part of its URL")
    state: State = Field(
        description="queued, running, done, failed, cancelled, or interrupted by the server's end"
    )
    progress: float = Field(description="Share of the work that is done, 0 to 1")
    created: AwareDatetime = Field(description="When it was asked for")
    elapsed: float = Field(description="Time that it has run, s")
    remaining: float | None = Field(description="Estimate of the time that it still needs, s")
    request: dict[str, Any] = Field(description="Body of the request that asked for it")
    error: str | None = Field(description="Why a job failed or was interrupted")
    unrecorded: str | None = Field(
        default=None, description="Why there is no record of it beyond the server's end"
    )


class JobSummary(_Job):
    """What is known of a job, without what comes of it."""

    kind: Kind = Field(description="What it does")


class SimulationJob(_Job):
    """A run of a scenario."""

    kind: Literal["simulate"] = "simulate"
    partial: None = Field(default=None, description="Nothing")
    result: ResultDocument | None = Field(default=None, description=_RESULT)


class IdentificationJob(_Job):
    """An identification of friction."""

    kind: Literal["identify"] = "identify"
    partial: PartialIdentification | None = Field(default=None, description=_PARTIAL)
    result: IdentificationDocument | None = Field(default=None, description=_RESULT)


class MapJob(_Job):
    """A force map by finite elements."""

    kind: Literal["map"] = "map"
    partial: None = Field(default=None, description="Nothing")
    result: MapEntry | None = Field(default=None, description=_RESULT)


class ReproduceJob(_Job):
    """The paper's numbers, computed."""

    kind: Literal["reproduce"] = "reproduce"
    partial: PartialReproduce | None = Field(default=None, description=_PARTIAL)
    result: ReproduceDocument | None = Field(default=None, description=_RESULT)


class TuningJob(_Job):
    """A search for gains."""

    kind: Literal["tune"] = "tune"
    partial: PartialTuning | None = Field(default=None, description=_PARTIAL)
    result: TuneDocument | None = Field(default=None, description=_RESULT)


class LandscapeJob(_Job):
    """A map of the cost over gains."""

    kind: Literal["landscape"] = "landscape"
    partial: PartialLandscape | None = Field(default=None, description=_PARTIAL)
    result: LandscapeDocument | None = Field(default=None, description=_RESULT)


class SweepJob(_Job):
    """A frequency sweep of the simulated loop."""

    kind: Literal["sweep"] = "sweep"
    partial: SweepDocument | None = Field(default=None, description=_PARTIAL)
    result: SweepDocument | None = Field(default=None, description=_RESULT)


class MonteCarloJob(_Job):
    """A scenario on many plausible plants."""

    kind: Literal["monte-carlo"] = "monte-carlo"
    partial: None = Field(default=None, description="Nothing")
    result: MonteCarloDocument | None = Field(default=None, description=_RESULT)


JobReport = Annotated[
    SimulationJob
    | IdentificationJob
    | MapJob
    | ReproduceJob
    | TuningJob
    | LandscapeJob
    | SweepJob
    | MonteCarloJob,
    Field(discriminator="kind"),
]
"""What is known of a job, by its kind."""

REPORT: TypeAdapter[JobReport] = TypeAdapter(JobReport)
