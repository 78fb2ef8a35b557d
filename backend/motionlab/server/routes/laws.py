"""Laws of friction compensation: what they are, and the text of their files."""

from __future__ import annotations

import inspect
import sys

from fastapi import APIRouter, Request
from pydantic import BaseModel, Field

from motionlab.declarations import DeclarationError
from motionlab.laws import FILES, LAWS, SOURCES, Law
from motionlab.own_laws.accepted import REFUSED
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.own_laws import OwnLaws

router = APIRouter(prefix="/laws", tags=["scenarios"], route_class=JsonRoute)


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


class LawList(BaseModel):
    """Every law, and files that hold none."""

    laws: list[LawEntry]
    refused: list[str] = Field(description="Why files of one's own could not be taken at the start")


@router.get("", operation_id="getLaws", response_model=LawList)
def get_laws(request: Request) -> LawList:
    """Return all laws, and why files of laws of one's own are not taken."""
    own: OwnLaws = request.app.state.own_laws
    return LawList(
        laws=[_entry(law, own) for law in LAWS.values()],
        refused=[str(each) for each in REFUSED],
    )


def _entry(law: Law, own: OwnLaws) -> LawEntry:
    problem = own.problems.get(law.name)
    module = sys.modules[getattr(law.step, "py_func", law.step).__module__]
    file = FILES[law.name].path.name if law.name in FILES else f"{module.__name__}.py"
    return LawEntry(
        name=law.name,
        label=law.label,
        description=law.description,
        source=law.source,
        parameters=[each.name for each in law.parameters],
        own=law.name in FILES and not FILES[law.name].module,
        file=file.rpartition("motionlab.")[2],
        text=_text(law) if problem else SOURCES.get(law.name) or inspect.getsource(module),
        problem="" if problem is None else str(problem),
    )


def _text(law: Law) -> str:
    """Return the file as it is now; where it cannot be read, the version that runs."""
    try:
        return FILES[law.name].text()
    except DeclarationError:
        return SOURCES[law.name]
