"""Studies and views: those that ship, those of one's own, and why files are not taken."""

from __future__ import annotations

import logging
import typing
from collections.abc import Iterator

from fastapi import APIRouter
from pydantic import BaseModel, Field

from motionlab.analysis.views.table import VIEWS
from motionlab.own_files import OwnFile
from motionlab.own_studies import PROBLEMS
from motionlab.reports.document_text import si_unit
from motionlab.server.http.strict_json import JsonRoute
from motionlab.server.routes.studies import summary_of
from motionlab.studies.own import FILES
from motionlab.studies.own_check import REFUSED
from motionlab.studies.table import STUDIES

router = APIRouter(prefix="/studies", tags=["studies"], route_class=JsonRoute)
_LOG = logging.getLogger(__name__)


class Figure(BaseModel):
    """A field of a view's document."""

    unit: str = Field(description="SI; empty for none")
    description: str


class StudyEntry(BaseModel):
    """A study or a view."""

    name: str
    path: str = Field(description="Of its route, below /api/v1")
    summary: str
    file: str = Field(description="Name of the file of one of one's own; else empty")


class ViewEntry(StudyEntry):
    """A view."""

    figures: dict[str, Figure] = Field(
        description="Fields of the document of one of one's own, those of its parts too, by name"
    )


class StudyList(BaseModel):
    """Every study and view, and files that hold none."""

    studies: list[StudyEntry]
    views: list[ViewEntry]
    refused: list[str] = Field(description="Why files of one's own could not be taken at the start")


@router.get("", operation_id="getStudies", response_model=StudyList)
def get_studies() -> StudyList:
    """Return all studies and views, and why files of one's own are not taken."""
    return StudyList(
        studies=[
            StudyEntry(
                name=study.kind,
                path=study.path,
                summary=summary_of(study),
                file=_name(FILES.get(study.kind)),
            )
            for study in STUDIES
        ],
        views=[
            ViewEntry(
                name=view.name,
                path=f"/views/{view.name}",
                summary=view.summary,
                file=_name(view.file),
                figures={} if view.file is None else _figures(view.document, {}),
            )
            for view in VIEWS
        ],
        refused=[str(each) for each in (*REFUSED, *PROBLEMS)],
    )


def _figures(model: type[BaseModel], figures: dict[str, Figure]) -> dict[str, Figure]:
    for name, info in model.model_fields.items():
        if name not in figures:
            figures[name] = Figure(unit=si_unit(info), description=info.description or "")
            for part in _models(info.annotation):
                _figures(part, figures)
    return figures


def _models(annotation: typing.Any) -> Iterator[type[BaseModel]]:
    """Yield the models of an annotation, such as ``dict[str, dict[str, Shares]]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for part in typing.get_args(annotation):
        yield from _models(part)


def _name(file: OwnFile | None) -> str:
    return "" if file is None else file.path.name


for _problem in PROBLEMS:  # of what the check of each file alone does not see: two of one name
    _LOG.warning("study or view not taken: %s", _problem)
