"""Which of the paper's numbers are computed."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

_ONLY_MAX = 500


class _Names:
    """Lists the available names in the schema, on demand.

    Unknown names are refused by `quantities`, with a suggestion.
    """

    def __get_pydantic_json_schema__(self, core: Any, handler: Any) -> dict[str, Any]:
        from motionlab.paper.registry import GROUPS, quantities

        names = [*(group.id for group in GROUPS), *(row.id for row in quantities())]
        items = {"type": "string", "enum": names}
        return {"type": "array", "items": items, "maxItems": _ONLY_MAX}


class ReproduceRequest(BaseModel):
    """Which of the paper's numbers are computed."""

    model_config = ConfigDict(extra="forbid", strict=True)

    only: Annotated[list[str], _Names()] = Field(
        default_factory=list,
        max_length=_ONLY_MAX,
        description="Identifiers of rows or of groups; everything, with the errata, when empty",
    )
