"""Named documents as rows of a table of the index, which all servers of one database share."""

from __future__ import annotations

from typing import Any, TypeVar

import sqlalchemy as sa
from pydantic import BaseModel

from motionlab.library.index import Index
from motionlab.library.named_documents import COUNT_MAX, NamedDocuments

Model = TypeVar("Model", bound=BaseModel)


class TableDocuments(NamedDocuments[Model, Model]):
    """Documents of one model; a column holds the field of its name, or, as `document`, all."""

    def __init__(
        self,
        index: Index,
        table: sa.Table,
        model: type[Model],
        noun: str,
        *,
        count_max: int = COUNT_MAX,
    ) -> None:
        super().__init__(noun, f"{noun}s", count_max)
        self._index, self._table, self._model = index, table, model

    def all(self) -> list[Model]:
        """Return all documents, the newest first where that is known, then by name."""
        columns = self._table.c
        newest = [columns.created.desc()] if "created" in columns else []
        return self._read(sa.select(self._table).order_by(*newest, columns.name))

    def get(self, name: str) -> Model:
        """Return a document."""
        documents = self._read(sa.select(self._table).where(self._table.c.name == name))
        if not documents:
            raise self.unknown(name)
        return documents[0]

    def put(self, document: Model) -> Model:
        """Save a document in the place of the one of its name, and return it."""
        fields = document.model_dump(mode="json")
        row = {column.name: fields.get(column.name, fields) for column in self._table.columns}
        count = sa.select(sa.func.count()).select_from(self._table)
        with self._index.begin() as connection:
            connection.execute(sa.delete(self._table).where(self._table.c.name == row["name"]))
            self._check_room(connection.execute(count).scalar_one())
            connection.execute(sa.insert(self._table).values(**row))
        return document

    def _read(self, query: sa.Select[Any]) -> list[Model]:
        with self._index.begin() as connection:
            rows = [dict(row) for row in connection.execute(query).mappings()]
        return [self._model.model_validate(row.get("document", row)) for row in rows]

    def _removed(self, name: str) -> bool:
        with self._index.begin() as connection:
            done = connection.execute(sa.delete(self._table).where(self._table.c.name == name))
        return done.rowcount > 0
