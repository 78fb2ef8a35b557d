"""Display data of the models: names, units, bounds, choices, metrics."""

from __future__ import annotations

import functools
import hashlib
from typing import Annotated, Literal

from fastapi import APIRouter, HTTPException, Path, Request, Response
from pydantic import BaseModel, Field, RootModel

from motionlab.analysis.metrics import CONTOUR_DEFINITIONS, DEFINITIONS, Definition
from motionlab.config.changes import SCHEDULABLE
from motionlab.config.fields import FieldEntry, fields_of
from motionlab.config.scenario import Scenario
from motionlab.laws import REDECLARED
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.studies.table import BY_KIND

router = APIRouter(prefix="/fields", tags=["scenarios"], route_class=JsonRoute)

_NOT_MODIFIED = {304: {"description": "Not Modified: `If-None-Match` names the present ETag"}}


class MetricEntry(BaseModel):
    """One metric."""

    label: str = Field(description="Name on the screen; `$` stands for the axis")
    unit: str = Field(description="SI unit")
    meaning: str
    formula: str
    lower_is_better: bool
    rank: Literal["main", "other", "hidden"] = Field(
        description="Whether a table shows it at once, on demand, or not"
    )
    scale: str = Field(description="Metrics of one scale are shown in one unit; empty: of its own")


class ScenarioFields(BaseModel):
    """Fields of a scenario, and metrics of a run."""

    fields: dict[str, FieldEntry] = Field(
        description="By dotted path; `*` stands for a variant's letter and for an item of a list"
    )
    schedulable: list[str] = Field(description="Tables that can change during a run")
    metrics: dict[str, MetricEntry] = Field(description="Metrics of one axis")
    contour: dict[str, MetricEntry] = Field(description="Metrics of a variant's contour")


class RequestFields(RootModel[dict[str, FieldEntry]]):
    """Fields of the request of a study, by dotted path."""


@router.get(
    "", operation_id="getFields", response_model=ScenarioFields, responses={**_NOT_MODIFIED}
)
def get_fields(request: Request) -> Response:
    """Return name, unit, factor, bounds and choices of every field of a scenario."""
    return _answer(_scenario(), request)


@router.get(
    "/{kind}",
    operation_id="getRequestFields",
    response_model=RequestFields,
    responses={**_NOT_MODIFIED, **responses(404, 422)},
)
def get_request_fields(
    request: Request,
    kind: Annotated[
        str, Path(pattern="^[a-z0-9-]{1,64}$", description="Kind of a study", examples=["tune"])
    ],
) -> Response:
    """Return the same of the request of a study, with its defaults."""
    if kind not in BY_KIND:
        raise HTTPException(404, f"no study {kind!r}: there are {', '.join(BY_KIND)}")
    return _answer(_request(kind), request)


@functools.cache
def _scenario() -> bytes:
    document = ScenarioFields(
        fields=fields_of(Scenario),
        schedulable=list(SCHEDULABLE),
        metrics=_metrics(DEFINITIONS),
        contour=_metrics(CONTOUR_DEFINITIONS),
    )
    return document.model_dump_json(exclude_none=True).encode()


@functools.cache
def _request(kind: str) -> bytes:
    fields = RequestFields(fields_of(BY_KIND[kind].request_model))
    return fields.model_dump_json(exclude_none=True).encode()


REDECLARED.extend((_scenario.cache_clear, _request.cache_clear))


def _metrics(definitions: dict[str, Definition]) -> dict[str, MetricEntry]:
    return {
        name: MetricEntry.model_validate(each, from_attributes=True)
        for name, each in definitions.items()
    }


def _answer(document: bytes, request: Request) -> Response:
    """Return a document, or 304 to a client that has it."""
    tag = f'"{hashlib.sha256(document).hexdigest()[:16]}"'
    headers = {"ETag": tag, "Cache-Control": "no-cache"}
    if tag in request.headers.get("if-none-match", ""):
        return Response(status_code=304, headers=headers)
    return Response(document, media_type="application/json", headers=headers)
