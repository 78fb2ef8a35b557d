"""Reports of runs and of comparisons."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.run_comparison import CompareRequest
from motionlab.server.routes.runs import RunId
from motionlab.server.worker_answers import ComputedResponse, called
from motionlab.server.workers.fork_client import CallResult
from motionlab.server.workers.worker import Call

router = APIRouter(prefix="/runs", tags=["runs"], route_class=JsonRoute)

_MEDIA_TYPE = "text/html; charset=utf-8"
_FILE: dict[str, Any] = {
    "description": "One HTML file that needs nothing else; docs/report.md",
    "content": {"text/html": {"schema": {"type": "string"}}},
}


@router.get(
    "/{run_id}/report",
    operation_id="getRunReport",
    response_class=Response,
    responses={200: _FILE, **responses(404, 409, 422, 429, 503)},
)
async def get_run_report(request: Request, run_id: RunId) -> Response:
    """Return the report of a run as one HTML file."""
    return _file(await called(request, _run_report, run_id), run_id)


@router.post(
    "/compare/report",
    operation_id="getComparisonReport",
    response_class=Response,
    responses={200: _FILE, **responses(400, 404, 409, 413, 415, 422, 429, 503)},
)
async def get_comparison_report(
    request: Request, body: Annotated[CompareRequest, Body()]
) -> Response:
    """Return the report of a comparison as one HTML file."""
    return _file(await called(request, _comparison_report, body), f"{body.a}-{body.b}")


def _file(answer: CallResult, name: str) -> Response:
    headers = {"Content-Disposition": f'attachment; filename="{name}.html"'}
    return ComputedResponse(answer, headers=headers, media_type=_MEDIA_TYPE)


def _run_report(call: Call, run_id: str) -> bytes:
    from motionlab.reports.run_reports import run_report

    return run_report(run_id, call.hold)


def _comparison_report(call: Call, body: CompareRequest) -> bytes:
    from motionlab.reports.run_reports import comparison_report

    return comparison_report(body.a, body.b, body, call.hold)
