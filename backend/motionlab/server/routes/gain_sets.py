"""Named gain sets: saved with what they achieved, listed, exported, deleted."""

from __future__ import annotations

from typing import Annotated, Any

import tomli_w
from fastapi import APIRouter, Body, Path, Request, Response
from pydantic import Field

from motionlab.config.load import load_scenario
from motionlab.library.gain_set import NAME, VALUES_MAX, GainSet, measured, tables_of
from motionlab.library.library import library
from motionlab.server.http.openapi_input import Paths, examples
from motionlab.server.http.problems import responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.simulate import ChangedScenario
from motionlab.server.worker_answers import ComputedResponse, called, computed
from motionlab.server.workers.pool import indexed
from motionlab.server.workers.worker import Call

router = APIRouter(prefix="/gain-sets", tags=["gain sets"], route_class=JsonRoute)

SetName = Annotated[
    str, Path(pattern=NAME, description="Name of a gain set", examples=["stiffer B"])
]


class GainSetRequest(ChangedScenario):
    """Values of controllers, and the scenario in which they are measured."""

    model_config = examples(
        {"scenario": "circle", "values": {"variants.B.controller.x.k_p": 312000.0}}
    )

    values: Annotated[dict[str, Any], Paths("variants")] = Field(
        min_length=1, max_length=VALUES_MAX, description="Dotted path to value, SI"
    )
    note: str = Field(default="", max_length=2000)


@router.get(
    "", operation_id="listGainSets", response_model=list[GainSet], responses=responses(429, 503)
)
async def list_gain_sets(request: Request) -> Response:
    """Return all gain sets, the newest first."""
    return await computed(request, _listed, light=True)


@router.put(
    "/{name}",
    operation_id="putGainSet",
    response_model=GainSet,
    responses=responses(400, 413, 415, 422, 429, 503, 507),
)
async def put_gain_set(
    request: Request, name: SetName, body: Annotated[GainSetRequest, Body()]
) -> Response:
    """Save values of controllers under a name, with the metrics and margins that they have."""
    return await computed(request, _saved, name, body)


@router.get(
    "/{name}/scenario.toml",
    operation_id="getGainSetFile",
    response_class=Response,
    responses={
        200: {
            "description": "Tables of a scenario; docs/scenarios.md",
            "content": {"text/plain": {"schema": {"type": "string"}}},
        },
        **responses(404, 422, 429, 503),
    },
)
async def get_gain_set_file(request: Request, name: SetName) -> Response:
    """Return a gain set as a TOML file; ``motionlab run`` takes it where its scenario ships."""
    answer = await called(request, _as_toml, name, light=True)
    headers = {"Content-Disposition": f'attachment; filename="{name.replace(" ", "-")}.toml"'}
    return ComputedResponse(answer, headers=headers, media_type="text/plain; charset=utf-8")


@router.delete(
    "/{name}",
    operation_id="deleteGainSet",
    status_code=204,
    responses=responses(404, 422, 429, 503),
)
async def delete_gain_set(request: Request, name: SetName) -> Response:
    """Delete a gain set."""
    (await called(request, _deleted, name, light=True)).close()
    return Response(status_code=204)


@indexed
def _listed() -> list[GainSet]:
    from motionlab.library.gain_sets import all_sets

    return all_sets(library().index)


@indexed
def _saved(name: str, body: GainSetRequest) -> GainSet:
    from motionlab.library.gain_sets import save_set

    scenario = load_scenario(body.scenario, {**body.set, **body.values})
    found = measured(name, body.note, scenario, body.values)
    save_set(library().index, found)
    return found


@indexed
def _as_toml(_: Call, name: str) -> bytes:
    from motionlab.library.gain_sets import find_set

    return tomli_w.dumps(tables_of(find_set(library().index, name))).encode()


@indexed
def _deleted(_: Call, name: str) -> None:
    from motionlab.library.gain_sets import delete_set

    delete_set(library().index, name)
