"""Drawing plants: each number of each axis from a generator of its own."""

from __future__ import annotations

import math
import zlib
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, FieldError
from motionlab.studies.montecarlo.documents import Variation

Array = NDArray[np.float64]


def draw(
    plant: dict[str, Any], vary: Sequence[Variation], *, cases: int, seed: int
) -> list[dict[str, Any]]:
    """Return the changes that make each case's plant of the scenario's.

    Case k is the same whatever else is varied and however many cases there are: the generator of a
    number is keyed by seed, path and axis. A stiction drawn below the Coulomb friction is raised to
    it.

    Raises
    ------
    ConfigError
        If the plant has no such number, or none that can be multiplied or added to.
    """
    cases_drawn: list[dict[str, Any]] = [{} for _ in range(cases)]
    for index, variation in enumerate(vary):
        for number, axis in enumerate(AXES):
            path = f"plant.{axis}.{variation.path}"
            base = _look_up(plant[axis], variation, f"vary.{index}.path")
            key = (zlib.crc32(variation.path.encode()), number)
            random = np.random.Generator(
                np.random.Philox(np.random.SeedSequence(seed, spawn_key=key))
            )
            values = _values(variation, base, cases, random)
            for case, value in zip(cases_drawn, values.tolist(), strict=True):
                case[path] = value
    for case in cases_drawn:
        for axis in AXES:
            _raise_stiction(case, plant[axis], f"plant.{axis}.friction")
    return cases_drawn


def missing(plant: dict[str, Any], vary: Sequence[Variation]) -> list[str]:
    """Return the varied paths that an axis of the plant does not have, such as of a table."""
    return [
        variation.path
        for variation in vary
        if not all(_has(plant[axis], variation.path) for axis in AXES)
    ]


def _has(tables: dict[str, Any], path: str) -> bool:
    for key in path.split("."):
        if not isinstance(tables, dict) or key not in tables:
            return False
        tables = tables[key]
    return True


def _look_up(axis: dict[str, Any], variation: Variation, loc: str) -> Array:
    """Return the nominal value of a variation, as an array with one item or one per phase."""
    value: Any = axis
    if not _has(axis, variation.path):
        raise ConfigError(FieldError(loc, "is no number of this plant", variation.path))
    for key in variation.path.split("."):
        value = value[key]
    relative = variation.kind in {"log-normal", "normal"}
    items = value if isinstance(value, list) else [value]
    if any(isinstance(item, bool | str | dict) for item in items) or (relative and None in items):
        raise ConfigError(FieldError(loc, f"is no number to be {variation.kind} about", value))
    return own_value(axis, variation.path)


def own_value(axis: Mapping[str, Any], path: str) -> Array:
    """Return a number of an axis, or its numbers per phase, as an array; NaN where it has none."""
    value: Any = axis
    for key in path.split("."):
        value = value[key]
    return np.array(value, dtype=float)


def _values(variation: Variation, base: Array, cases: int, random: np.random.Generator) -> Array:
    """Return a value for each case, (cases, *base.shape)."""
    shape = (cases, *base.shape)
    match variation.kind:
        case "log-normal":
            return base * np.exp(_required(variation.sigma) * random.standard_normal(shape))
        case "normal":
            return base + _required(variation.sigma) * random.standard_normal(shape)
        case "uniform":
            return random.uniform(_required(variation.low), _required(variation.high), shape)
        case "log-uniform":
            low, high = math.log(_required(variation.low)), math.log(_required(variation.high))
            return np.exp(random.uniform(low, high, shape))
        case "value":
            return np.full(shape, _required(variation.value))


def _required(number: float | None) -> float:
    assert number is not None  # the request has checked it
    return number


def _raise_stiction(case: dict[str, Any], axis: dict[str, Any], path: str) -> None:
    F_s = case.get(f"{path}.F_s", axis["friction"]["F_s"])
    F_c = case.get(f"{path}.F_c", axis["friction"]["F_c"])
    if F_s < F_c:
        case[f"{path}.F_s"] = F_c
