"""Layouts of scopes: which channels each scope shows, and how."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

from pydantic import BaseModel, Field

if TYPE_CHECKING:
    from motionlab.library.table_documents import TableDocuments

SCOPE = (
    r"^[A-Za-z0-9_.%-]{1,800}!?~?(,[A-Za-z0-9_.%-]{1,800}!?~?){0,15}"
    r"(@[0-9.]{1,8})?(=[0-9.e+-]{1,24}:[0-9.e+-]{1,24})?$"
)
"""Form of a scope: docs/lab.md, Layouts."""

Scope = Annotated[str, Field(pattern=SCOPE, max_length=4000)]


class Scopes(BaseModel, extra="forbid"):
    """The scopes of a layout."""

    scopes: list[Scope] = Field(
        min_length=1,
        max_length=12,
        description="Each as its channels by comma, such as `A.x.thrust,A.x.friction`; docs/lab.md",
    )


class ScopeLayout(Scopes):
    """A layout by its name."""

    name: str


def layouts() -> TableDocuments[ScopeLayout]:
    """Return the store of layouts."""
    from motionlab.library.library import library
    from motionlab.library.table_documents import TableDocuments
    from motionlab.library.tables import LAYOUTS

    return TableDocuments(library().index, LAYOUTS, ScopeLayout, "layout")
