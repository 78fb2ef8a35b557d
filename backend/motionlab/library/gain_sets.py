"""The gain sets that are kept, by name, in the index."""

from __future__ import annotations

import sqlalchemy as sa

from motionlab.errors import StoreFull, Unknown
from motionlab.library.gain_set import GainSet
from motionlab.library.index import Index
from motionlab.library.tables import GAIN_SETS

SETS_MAX = 1000
"""Sets that may be kept."""


def all_sets(index: Index) -> list[GainSet]:
    """Return all sets, the newest first."""
    query = sa.select(GAIN_SETS.c.document).order_by(GAIN_SETS.c.created.desc(), GAIN_SETS.c.name)
    with index.begin() as connection:
        return [GainSet(**row) for row in connection.execute(query).scalars()]


def find_set(index: Index, name: str) -> GainSet:
    """Return a set by its name.

    Raises
    ------
    Unknown
        If there is none.
    """
    query = sa.select(GAIN_SETS.c.document).where(GAIN_SETS.c.name == name)
    with index.begin() as connection:
        row = connection.execute(query).scalar_one_or_none()
    if row is None:
        raise Unknown(f"no gain set {name!r}")
    return GainSet(**row)


def save_set(index: Index, gain_set: GainSet) -> None:
    """Save a set, in the place of the one of its name.

    Raises
    ------
    StoreFull
        If `SETS_MAX` are saved already.
    """
    with index.begin() as connection:
        connection.execute(sa.delete(GAIN_SETS).where(GAIN_SETS.c.name == gain_set.name))
        count = connection.execute(sa.select(sa.func.count()).select_from(GAIN_SETS)).scalar_one()
        if count >= SETS_MAX:
            raise StoreFull(f"{SETS_MAX} gain sets are saved already; delete one")
        row = {"name": gain_set.name, "created": gain_set.created}
        connection.execute(
            sa.insert(GAIN_SETS).values(**row, document=gain_set.model_dump(mode="json"))
        )


def delete_set(index: Index, name: str) -> None:
    """Delete a set.

    Raises
    ------
    Unknown
        If there is none.
    """
    with index.begin() as connection:
        done = connection.execute(sa.delete(GAIN_SETS).where(GAIN_SETS.c.name == name))
        if done.rowcount == 0:
            raise Unknown(f"no gain set {name!r}")
