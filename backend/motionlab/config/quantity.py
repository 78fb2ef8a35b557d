"""Building blocks of every config model: strict, frozen, with unit, range and source."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field

PAPER = "Huang et al., IEEE Access 2019"
OURS = "this project's choice"


def whole(value: Any) -> Any:
    """Return a number without fraction, such as 5.0, as the integer that it is to JSON."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


Whole = Annotated[int, BeforeValidator(whole)]
"""A whole number, be it written 145 or 145.0: JSON has one type of number."""


class Config(BaseModel):
    """Base of all config models: frozen, unknown keys refused, no silent conversion."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


def quantity(  # noqa: PLR0913 - one keyword for each fact about a field
    description: str,
    *,
    unit: str,
    source: str,
    default: Any = ...,
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
) -> Any:
    """Declare a number with its unit, range and source.

    Parameters
    ----------
    description : str
        What the number is.
    unit : str
        SI unit; ``1`` for a pure number.
    source : str
        Where the number or its range comes from.
    default : Any
        Value when the field is left out; required when not given.
    ge, gt, le, lt : float, optional
        Bounds of the allowed range, in `unit`.

    Returns
    -------
    Any
        A pydantic field whose JSON schema holds ``unit`` and ``source``.
    """
    return Field(
        default,
        description=description,
        ge=ge,
        gt=gt,
        le=le,
        lt=lt,
        json_schema_extra={"unit": unit, "source": source},
    )
