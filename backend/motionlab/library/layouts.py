"""The layouts that are kept, by name, in the index."""

from __future__ import annotations

import sqlalchemy as sa

from motionlab.errors import StoreFull, Unknown
from motionlab.library.index import Index
from motionlab.library.layout import ScopeLayout
from motionlab.library.tables import LAYOUTS

LAYOUTS_MAX = 1000
"""Layouts that may be kept."""


def all_layouts(index: Index) -> list[ScopeLayout]:
    """Return all layouts by name."""
    query = sa.select(LAYOUTS.c.name, LAYOUTS.c.scopes).order_by(LAYOUTS.c.name)
    with index.begin() as connection:
        rows = connection.execute(query)
        return [ScopeLayout(name=name, scopes=scopes) for name, scopes in rows]


def save_layout(index: Index, layout: ScopeLayout) -> None:
    """Save a layout, in the place of the one of its name.

    Raises
    ------
    StoreFull
        If `LAYOUTS_MAX` are saved already.
    """
    with index.begin() as connection:
        connection.execute(sa.delete(LAYOUTS).where(LAYOUTS.c.name == layout.name))
        count = connection.execute(sa.select(sa.func.count()).select_from(LAYOUTS)).scalar_one()
        if count >= LAYOUTS_MAX:
            raise StoreFull(f"{LAYOUTS_MAX} layouts are saved already; delete one")
        connection.execute(sa.insert(LAYOUTS).values(**layout.model_dump()))


def delete_layout(index: Index, name: str) -> None:
    """Delete a layout.

    Raises
    ------
    Unknown
        If there is none.
    """
    with index.begin() as connection:
        done = connection.execute(sa.delete(LAYOUTS).where(LAYOUTS.c.name == name))
        if done.rowcount == 0:
            raise Unknown(f"no layout {name!r}")
