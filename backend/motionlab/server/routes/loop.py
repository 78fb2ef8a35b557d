"""The linearised loop: margins, and how far each gain is from instability."""

from __future__ import annotations

from typing import Annotated

from fastapi import APIRouter, Body, Request, Response

from motionlab.config.load import load_scenario
from motionlab.loop.document import LoopDocument, loop_document
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import ChangedScenario
from motionlab.server.worker_answers import computed

router = APIRouter(tags=["simulate"], route_class=JsonRoute)


@router.post(
    "/loop",
    operation_id="getLoop",
    response_model=LoopDocument,
    responses=responses(400, 413, 415, 422, 429, 503),
)
async def get_loop(request: Request, body: Annotated[ChangedScenario, Body()]) -> Response:
    """Return margins and limits of stability of every loop; docs/loop.md."""
    return await computed(request, _loops, body)


def _loops(body: ChangedScenario) -> LoopDocument:
    return loop_document(load_scenario(body.scenario, body.set))
