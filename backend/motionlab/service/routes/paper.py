"""The paper's numbers: as they are printed, and computed as a job."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response
from pydantic import BaseModel, ConfigDict, Field

from motionlab.paper.document import PaperDocument
from motionlab.service.bodies import JsonRoute
from motionlab.service.kinds import ReproduceJob
from motionlab.service.problems import responses
from motionlab.service.routes.jobs import ACCEPTED, as_job

router = APIRouter(tags=["paper"], route_class=JsonRoute)

_ONLY_MAX = 500


class _Names:
    """Has the schema list what there is, looked up when the schema is asked for.

    Names that are none are refused by `quantities`, which says what was meant.
    """

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        from motionlab.paper.registry import GROUPS, quantities

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


@router.get("/paper", operation_id="getPaper")
def get_paper() -> PaperDocument:
    """Return every number that the paper prints, how it is judged and why so; nothing computed."""
    from motionlab.paper.registry import paper

    return paper()


@router.post(
    "/reproduce",
    operation_id="reproduce",
    status_code=202,
    response_model=ReproduceJob,
    responses={**ACCEPTED, **responses(400, 413, 415, 422, 429)},
)
def reproduce_paper(request: Request, body: Annotated[ReproduceRequest, Body()]) -> Response:
    """Compute the paper's numbers and compare them.

    The job's report carries the rows as they are judged.
    """
    from motionlab.paper.registry import quantities
    from motionlab.paper.reproduce import reproduce

    quantities(body.only)  # what is unknown is refused now
    work = request.app.state.kernels.before(lambda progress: reproduce(body.only, progress))
    return as_job(request, "reproduce", body.model_dump(), work)
