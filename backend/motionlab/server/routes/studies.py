"""The routes of all studies: a job of each, or an answer at once where that takes no time."""

import functools
import inspect
from collections.abc import Callable
from typing import Annotated, Any

from fastapi import APIRouter, Body, Request, Response

from motionlab.errors import ConfigError
from motionlab.executors.executor import executing
from motionlab.server.http.openapi_input import Described, DescribedTable
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.job_reports import REPORTS
from motionlab.server.routes.jobs import CheckedRequest, accepted, as_job
from motionlab.server.settings import Settings
from motionlab.server.worker_answers import computed, json_of
from motionlab.server.workers.worker import Call
from motionlab.studies.study import Study
from motionlab.studies.table import BY_KIND, STUDIES

router = APIRouter(route_class=JsonRoute)


def _endpoint(study: Study) -> Callable[..., Any]:
    """Return the function that answers requests of a study."""
    request_model = study.request_model
    has_scenario = "scenario" in request_model.model_fields
    described = (Described if has_scenario else DescribedTable)(request_model)
    kind = study.kind
    of_kind = functools.partial(run, kind=kind)

    async def at_once(request: Request, body: dict[str, Any]) -> Response:
        return await computed(request, answer, kind, body, light=study.light)

    async def as_a_job(request: Request, body: dict[str, Any]) -> Response:
        return await as_job(request, kind, of_kind, check, kind, body, batches=study.batches)

    endpoint = at_once if study.direct else as_a_job
    as_body = Annotated[dict[str, Any], described, Body(examples=list(study.bodies))]
    endpoint.__annotations__["body"] = as_body
    return endpoint


def planned(kind: str, body: dict[str, Any], bounds: Settings) -> Any:
    """Return the plan of a study, which is not too large for one request.

    Raises
    ------
    ConfigError
        Naming every field that is wrong.
    """
    study = BY_KIND[kind]
    plan = study.plan(body)
    too_much = study.excess(plan, bounds)
    if too_much:
        raise ConfigError(*too_much)
    return plan


def answer(kind: str, body: dict[str, Any]) -> Any:
    """Return the document of a study that is answered at once; runs in a worker."""
    study = BY_KIND[kind]
    return study.document(study.run(study.plan(body), lambda *_: None))


def check(call: Call, bounds: Settings, kind: str, body: dict[str, Any]) -> bytes | CheckedRequest:
    """Return the request of a job, or the document that is kept already; runs in a worker."""
    study = BY_KIND[kind]
    kept = study.kept(planned(kind, body, bounds))
    return CheckedRequest.of(body) if kept is None else json_of(call, study.document, (kept,))


def run(call: Call, body: dict[str, Any], bounds: Settings, *, kind: str) -> Any:
    """Return the document of a study; runs in the process of its job."""
    study = BY_KIND[kind]
    with executing(bounds.scheduler):
        return study.document(study.run(planned(kind, body, bounds), call.progress))


def summary_of(study: Study) -> str:
    """Return what a study does, in a sentence without an end."""
    text = study.kind.replace("-", " ") if study.command is None else study.command.help
    return text[0].upper() + text[1:]


for _study in STUDIES:
    _refused = responses(400, 413, 415, 422, 429, 503, *((507,) if _study.keeps else ()))
    _document = _study.document_model
    router.add_api_route(
        _study.path,
        _endpoint(_study),
        methods=["POST"],
        operation_id=_study.operation,
        summary=summary_of(_study),
        description=inspect.getdoc(type(_study)),
        tags=[_study.tag],
        status_code=200 if _study.direct or _study.keeps else 202,
        response_model=_document if _study.direct or _study.keeps else REPORTS[_study.kind],
        responses=_refused if _study.direct else {**accepted(REPORTS[_study.kind]), **_refused},
    )
