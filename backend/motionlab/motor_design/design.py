"""A design document from a request, in both directions, with validation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from pydantic import ValidationError

from motionlab.config.validation_errors import field_errors
from motionlab.errors import ConfigError, FieldError
from motionlab.motor_design.document import DesignDocument
from motionlab.motor_design.inputs import DesignRequest, Dimensions
from motionlab.motor_design.presets import PRESETS, DesignPreset
from motionlab.motor_design.rating import rate
from motionlab.motor_design.sizing import size


def design(request: Mapping[str, Any]) -> DesignDocument:
    """Return the sizing and the rating that a request asks for.

    Parameters
    ----------
    request : mapping
        ``preset``, ``requirements`` and ``dimensions``, each optional; what is left out of the
        tables has the preset's value.

    Returns
    -------
    DesignDocument
        Both directions.

    Raises
    ------
    ConfigError
        Naming every field that is wrong, its value, range and unit.
    """
    try:
        checked = DesignRequest.model_validate(_upon_preset(request))
    except ValidationError as error:
        # A key that is no text, half of a surrogate pair, fails the table as a whole.
        problems = (replace(e, loc=e.loc or "design") for e in field_errors(error, DesignRequest))
        raise ConfigError(*problems) from None
    except RecursionError:
        raise ConfigError(FieldError(loc="design", message="is nested too deeply")) from None
    preset = PRESETS[checked.preset]
    dimensions = checked.dimensions
    if dimensions is not None:
        _refuse_unknown(preset, dimensions)
    elif not preset.unknown:
        dimensions = Dimensions.model_validate(preset.choices)
    return DesignDocument(
        preset=checked.preset,
        title=preset.title,
        notes=list(preset.notes),
        requirements=checked.requirements.resolved(),
        sizing=size(checked.requirements),
        dimensions=None if dimensions is None else dimensions.resolved(),
        rating=None if dimensions is None else rate(dimensions),
    )


def _upon_preset(request: Mapping[str, Any]) -> dict[str, Any]:
    """Return a request whose tables have the preset's values where they give none."""
    name = request.get("preset", "paper")
    choices = PRESETS[name].choices if isinstance(name, str) and name in PRESETS else {}
    tables = {"requirements": {}, **request}
    for key in ("requirements", "dimensions"):
        if isinstance(tables.get(key), Mapping):
            tables[key] = {**choices, **tables[key]}
    return tables


def _refuse_unknown(preset: DesignPreset, dimensions: Dimensions) -> None:
    """Refuse dimensions missing from the request and from the paper."""
    missing = [path for path in preset.unknown if not _is_given(dimensions, path)]
    if missing:
        raise ConfigError(
            *(
                FieldError(
                    loc=f"dimensions.{path}",
                    message="is missing: the paper does not give it for this design",
                )
                for path in missing
            )
        )


def _is_given(dimensions: Dimensions, path: str) -> bool:
    here: Any = dimensions
    for key in path.split("."):
        if key not in here.model_fields_set:
            return False
        here = getattr(here, key)
    return True
