"""Laws of friction compensation: what they are, and the text of their files."""

from __future__ import annotations

import asyncio
import inspect
import sys
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, HTTPException, Path, Request
from pydantic import BaseModel, ConfigDict, Field

from motionlab.declarations import NAME_MAX, DeclarationError
from motionlab.errors import ConfigError, FieldError
from motionlab.laws import FILES, LAWS, SOURCES, Law, before_of
from motionlab.own_laws.cost import LawCost, cost_of
from motionlab.server.http.openapi_input import examples
from motionlab.server.http.problems import problem, responses
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.own_laws import OwnLaws, digest_of
from motionlab.server.routes.sessions import Actor
from motionlab.server.worker_answers import called
from motionlab.server.workers.worker import Call

router = APIRouter(prefix="/laws", tags=["scenarios"], route_class=JsonRoute)


LawName = Annotated[
    str, Path(max_length=2 * NAME_MAX, description="Name of a law", examples=["lugre-observer"])
]
TEXT_MAX = 256 * 1024
"""Bytes of a law's file that the page may write."""
_COST_SECONDS = 120.0  # a new version may have to be compiled


class LawEntry(BaseModel):
    """A law of friction compensation."""

    name: str
    label: str = Field(description="Name on the screen")
    description: str
    source: str = Field(description="Where it comes from")
    parameters: list[str] = Field(description="Fields of a controller's compensation that it uses")
    own: bool = Field(description="Whether it is of a file that is taken anew when it is saved")
    file: str = Field(description="Name of its file")
    text: str = Field(description="Text of its file; with a problem, that of the later version")
    problem: str = Field(description="Why a later version of the file does not run; empty if none")
    version: int = Field(description="Number of the version that runs, from 1")
    versions: int = Field(description="Versions that are kept, to go back to and forward again")
    newer: bool = Field(description="Whether the file holds another text than that which runs")
    before: str = Field(
        description="Law under whose name the version before runs; empty where there is none"
    )
    digest: str = Field(
        description="SHA-256 of what its file holds, for PUT /laws/NAME; empty where refused"
    )
    cost: LawCost | None = Field(
        description="What it costs in a control period; null until GET /laws/NAME/cost has "
        "measured the version that runs"
    )


class LawList(BaseModel):
    """Every law, and files that hold none."""

    laws: list[LawEntry]
    refused: list[str] = Field(description="Why files of one's own that hold no law are not taken")


@router.get("", operation_id="getLaws", response_model=LawList)
def get_laws(request: Request) -> LawList:
    """Return all laws, and why files of laws of one's own are not taken."""
    own: OwnLaws = request.app.state.own_laws
    editable: bool = request.app.state.settings.edit_laws
    return LawList(
        laws=[_entry(law, own, editable=editable) for law in LAWS.values()],
        refused=[str(each) for each in own.refused.values()],
    )


@router.get(
    "/{name}/cost",
    operation_id="getLawCost",
    response_model=LawCost,
    responses=responses(404, 422, 429, 503),
)
async def cost(request: Request, name: LawName) -> LawCost:
    """Return what a law costs in a control period, measured once for each version."""
    own: OwnLaws = request.app.state.own_laws
    if name not in LAWS:
        raise HTTPException(404, f"no law {name!r}")
    version = name, SOURCES.get(name, "")
    if (known := own.costs.get(version)) is not None:
        return known
    answer = await called(request, _cost, name, light=True, seconds=_COST_SECONDS)
    measured = LawCost.model_validate(answer.value)
    answer.close()
    if version[1] == SOURCES.get(name, ""):  # no other version came meanwhile
        own.costs[version] = measured
    return measured


def _cost(_: Call, name: str) -> dict[str, float]:
    return cost_of(name).model_dump()


class LawText(BaseModel):
    """What the file of a law is to hold."""

    model_config = ConfigDict(extra="forbid") | examples({"text": "LAW = ..."})

    text: str = Field(max_length=TEXT_MAX, description=f"Python, at most {TEXT_MAX} bytes of UTF-8")


@router.put(
    "/{name}",
    operation_id="putLaw",
    response_model=LawEntry,
    responses=responses(400, 403, 404, 409, 413, 415, 422, 507),
)
async def put_law(
    request: Request,
    name: LawName,
    body: Annotated[LawText, Body()],
    if_match: Annotated[
        str,
        Header(
            max_length=80,
            description="`digest` of the law: what its file is known to hold",
            examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
        ),
    ],
) -> Any:
    """Write the file of a law of one's own, which is then tried and taken as if it were saved."""
    if not request.app.state.settings.edit_laws:
        return problem(
            "not-editable", "laws are not edited here: motionlab serve --edit-laws permits it"
        )
    own: OwnLaws = request.app.state.own_laws
    if name not in own.versions:
        raise HTTPException(404, f"no law of one's own {name!r}, whose file is taken when saved")
    try:
        text = body.text.encode()
    except UnicodeEncodeError as error:
        message = f"has half of a character at {error.start}"
        raise ConfigError(FieldError("text", message)) from None
    if len(text) > TEXT_MAX:
        raise ConfigError(
            FieldError("text", "is too large", len(text), f"at most {TEXT_MAX}", "bytes")
        )
    await own.write(name, text, if_match.strip().strip('"'))
    return await asyncio.to_thread(_entry, LAWS[name], own, editable=True)


@router.post(
    "/{name}/back",
    operation_id="takeLawBack",
    response_model=LawEntry,
    responses=responses(404, 409, 422),
)
async def back(request: Request, name: LawName, by: Actor) -> LawEntry:
    """Have the version before of a law's file run again, in all sessions."""
    return await _moved(request, name, -1, by)


@router.post(
    "/{name}/forward",
    operation_id="takeLawForward",
    response_model=LawEntry,
    responses=responses(404, 409, 422),
)
async def forward(request: Request, name: LawName, by: Actor) -> LawEntry:
    """Have the version of a law's file run that came after the one that runs, in all sessions."""
    return await _moved(request, name, 1, by)


async def _moved(request: Request, name: str, by: int, person: str) -> LawEntry:
    own: OwnLaws = request.app.state.own_laws
    if name not in own.versions:
        raise HTTPException(404, f"no law of one's own {name!r}, whose file is taken when saved")
    await own.move(name, by, person)
    editable = request.app.state.settings.edit_laws
    return await asyncio.to_thread(_entry, LAWS[name], own, editable=editable)


def _entry(law: Law, own: OwnLaws, *, editable: bool) -> LawEntry:
    problem = own.problems.get(law.name)
    versions = own.versions.get(law.name)
    now = "" if versions is None else _text(law)
    former = before_of(law.name)
    module = sys.modules[getattr(law.step, "py_func", law.step).__module__]
    file = FILES[law.name].path.name if law.name in FILES else f"{module.__name__}.py"
    return LawEntry(
        name=law.name,
        label=law.label,
        description=law.description,
        source=law.source,
        parameters=[each.name for each in law.parameters],
        own=versions is not None,
        file=file.rpartition("motionlab.")[2],
        text=now if problem else SOURCES.get(law.name) or inspect.getsource(module),
        problem="" if problem is None else str(problem),
        version=1 if versions is None else versions.number,
        versions=1 if versions is None else len(versions.texts),
        newer=versions is not None and now != SOURCES[law.name],
        before=former if versions is not None and versions.number > 1 else "",
        digest=digest_of(now.encode()) if editable and versions is not None else "",
        cost=own.costs.get((law.name, SOURCES.get(law.name, ""))),
    )


def _text(law: Law) -> str:
    """Return the file as it is now; where it cannot be read, the version that runs."""
    try:
        return FILES[law.name].text()
    except DeclarationError:
        return SOURCES[law.name]
