"""Building blocks of every config model: strict, frozen, with unit, range and source."""

from __future__ import annotations

import math
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from motionlab.config.bounds import text
from motionlab.declarations import Parameter


def whole(value: Any) -> Any:
    """Return a number without fraction, such as 5.0, as the integer that it is to JSON."""
    return int(value) if isinstance(value, float) and value.is_integer() else value


FACTORS = {
    "mm": 1e3,
    "µm": 1e6,
    "nm": 1e9,
    "µs": 1e6,
    "ms": 1e3,
    "mm/s": 1e3,
    "N/mm": 1e-3,
    "N s/mm": 1e-3,
    "°": 180.0 / math.pi,
    "deg": 180.0 / math.pi,
    "%": 100.0,
    "ppm": 1e6,
    "% of pitch": 100.0,
    "kA/m": 1e-3,
    "GPa": 1e-9,
}
"""Units on the screen: displayed number over SI number."""

Whole = Annotated[int, BeforeValidator(whole)]
"""A whole number, be it written 145 or 145.0: JSON has one type of number."""

Text = Annotated[str, AfterValidator(text)]
"""Text without a bound of its own: whatever can be encoded."""


class Config(BaseModel):
    """Base of all config models: frozen, unknown keys refused, no silent conversion."""

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, allow_inf_nan=False)


class Choice(BaseModel):
    """A value that a field can take, and its label."""

    value: str
    label: str = Field(description="Name on the screen")
    description: str = ""
    unit: str = ""


def choices(*named: tuple[str, ...]) -> dict[str, Any]:
    """Return the JSON schema of a field's values: the fields of `Choice`."""
    return {"choices": [dict(zip(Choice.model_fields, each, strict=False)) for each in named]}


def quantity(  # noqa: PLR0913 - one keyword for each fact about a field
    description: str,
    *,
    unit: str,
    source: str,
    label: str | None = None,
    symbol: str = "",
    shown: str = "",
    default: Any = ...,
    ge: float | None = None,
    gt: float | None = None,
    le: float | None = None,
    lt: float | None = None,
    example: Any = None,
    usual: tuple[float, float] | None = None,
    used_with: list[str] | None = None,
) -> Any:
    """Declare a number with its unit, range, source and name on the screen.

    Parameters
    ----------
    description : str
        What the number is.
    unit : str
        SI unit; ``1`` for a pure number.
    source : str
        Where the number or its range comes from.
    label : str, optional
        Name on the screen, which JSON schema calls ``title``.
    symbol : str
        Letter of it in the equations, such as ``l_m``.
    shown : str
        Unit on the screen, one of `FACTORS`; empty for `unit` itself.
    default : Any
        Value when the field is left out; required when not given.
    ge, gt, le, lt : float, optional
        Bounds of the allowed range, in `unit`.
    example : Any
        A usual value where the default is none, or switches something off.
    usual : tuple of float, optional
        Range of a slider, in `unit`.
    used_with : list of str, optional
        Choices of the neighbouring field for which the number is used.

    Returns
    -------
    Any
        A pydantic field whose JSON schema holds ``unit`` and ``source``, and ``display_unit`` and
        ``display_factor`` where it is displayed in another unit, and ``symbol``, ``usual`` and
        ``used_with`` where they are given.
    """
    extra: dict[str, Any] = {"unit": unit, "source": source}
    if shown:
        extra |= {"display_unit": shown, "display_factor": FACTORS[shown]}
    others = {"symbol": symbol, "usual": usual and list(usual), "used_with": used_with}
    extra |= {name: value for name, value in others.items() if value}
    return Field(
        default,
        examples=None if example is None else [example],
        title=label,
        description=description,
        ge=ge,
        gt=gt,
        le=le,
        lt=lt,
        json_schema_extra=extra,
    )


def declared_field(parameter: Parameter, used_with: Any) -> Any:
    """Return the type and the field of a parameter that a law or a sharing function declares."""
    each = parameter
    if each.choices:
        choice = Field(
            default=each.default,
            title=each.label,
            description=each.description,
            json_schema_extra={"used_with": used_with},
        )
        return Literal[each.choices], choice
    number = quantity(
        each.description,
        label=each.label,
        unit=each.unit or "1",
        shown=each.shown,
        source=each.source,
        default=each.default,
        ge=each.ge,
        gt=each.gt,
        le=each.le,
        lt=each.lt,
        usual=each.usual,
        used_with=used_with,
    )
    return (float if each.default is not None else float | None), number


def si(description: str, unit: str, shown: str = "") -> Any:
    """Declare a number of a document with its unit, and the unit in reports where that differs."""
    display = {"display_unit": shown, "display_factor": FACTORS[shown]} if shown else {}
    return Field(description=description, json_schema_extra={"unit": unit, **display})
