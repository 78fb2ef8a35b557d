"""The paper's numbers as they are printed."""

from __future__ import annotations

from fastapi import APIRouter, Request, Response

from motionlab.paper.documents import PaperDocument
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.worker_answers import computed

router = APIRouter(tags=["paper"], route_class=JsonRoute)


@router.get(
    "/paper",
    operation_id="getPaper",
    response_model=PaperDocument,
    responses=responses(429, 503),
)
async def get_paper(request: Request) -> Response:
    """Return every number that the paper prints, how it is judged and why; nothing is computed."""
    return await computed(request, _paper, light=True)


def _paper() -> PaperDocument:
    from motionlab.paper.registry import paper

    return paper()
