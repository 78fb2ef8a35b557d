"""The paper's numbers: as they are printed, and computed as a job."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.service.http.problems import responses
from motionlab.service.http.strict_json import JsonRoute
from motionlab.service.job_reports import ReproduceJob
from motionlab.service.routes.jobs import Asked, accepted, as_job
from motionlab.service.settings import Settings
from motionlab.service.worker_answers import computed
from motionlab.service.workers.worker import Call
from motionlab.studies.paper.document import PaperDocument, ReproduceDocument

router = APIRouter(tags=["paper"], route_class=JsonRoute)

_ONLY_MAX = 500


class _Names:
    """Has the schema list what there is, looked up when the schema is asked for.

    Names that are none are refused by `quantities`, which says what was meant.
    """

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        from motionlab.studies.paper.registry import GROUPS, quantities

        names = [*(group.id for group in GROUPS), *(row.id for row in quantities())]
        items = {"type": "string", "enum": names}
        return {"type": "array", "items": items, "maxItems": _ONLY_MAX}


class ReproduceRequest(BaseModel):
    """Which of the paper's numbers are computed."""

    model_config = ConfigDict(
        extra="forbid", json_schema_extra={"examples": [{"only": ["sizing", "rhombus-x"]}]}
    )

    only: Annotated[list[str], _Names()] = Field(
        default_factory=list,
        max_length=_ONLY_MAX,
        description="Identifiers of rows or of groups; everything, with the errata, when empty",
    )


@router.get(
    "/paper",
    operation_id="getPaper",
    response_model=PaperDocument,
    responses=responses(429, 503),
)
async def get_paper(request: Request) -> Response:
    """Return every number that the paper prints, how it is judged and why so; nothing computed."""
    return await computed(request, _paper, light=True)


def _paper() -> PaperDocument:
    from motionlab.studies.paper.registry import paper

    return paper()


@router.post(
    "/reproduce",
    operation_id="reproduce",
    status_code=202,
    response_model=ReproduceJob,
    responses={**accepted(ReproduceJob), **responses(400, 413, 415, 422, 429, 503)},
)
async def reproduce_paper(request: Request, body: Annotated[ReproduceRequest, Body()]) -> Response:
    """Compute the paper's numbers and compare them.

    The job's report carries the rows as they are judged.
    """
    return await as_job(request, "reproduce", _reproduced, _checked, body, batches=True)


def _checked(_: Call, _bounds: Settings, body: ReproduceRequest) -> Asked:
    from motionlab.studies.paper.registry import quantities

    quantities(body.only)  # what is unknown is refused now
    return Asked.of(body.model_dump())


def _reproduced(call: Call, body: dict[str, Any], _: Settings) -> ReproduceDocument:
    from motionlab.studies.paper.reproduce import reproduce

    return reproduce(body["only"], call.progress)
