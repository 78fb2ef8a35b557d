"""Measured frequency responses against the linearisation, and how often intervals hold."""

from __future__ import annotations

import time
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.studies.response.documents import MeasuredResponse, ResponseRequest
from motionlab.studies.response.measure import measure, plan
from tests.bench.table import Row

_AXES = [("circle-resonant", "x"), ("circle-resonant", "y")]
_MOTORS = [(f"circle{kind}", axis) for kind in ("", "-matched", "-resonant") for axis in "xy"]
_SEEDS, _LONG = 8, 1500.0  # measurements of a minute; s of the one that they are held against
_SIGNALS = ({"signal": "noise"}, {"signal": "chirp"}, {"signal": "stepped-sine", "lines": 10})
_COHERENT = 0.9
_DECIBELS, _DEGREES = 0.5, 3.0
_HELD, _CERTAIN = (0.93, 0.97), 0.95

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]


def response() -> Iterator[Row]:
    """Measure all."""
    for scenario, axis in _AXES:
        begun = time.perf_counter()
        minutes = [_measured(scenario, axis, seed=seed) for seed in range(_SEEDS)]
        took = (time.perf_counter() - begun) / _SEEDS
        yield from _errors(f"{scenario}, {axis}", minutes, took)
        yield _coverage(scenario, axis, minutes)
    for fields in _SIGNALS:
        for scenario, axis in _AXES:
            yield _other(scenario, axis, fields)
    yield _margins()


def _other(scenario: str, axis: str, fields: dict[str, Any]) -> Row:
    """Return how far a minute with another signal, or 2.5 of stepped sines, is off."""
    seconds = 150.0 if "lines" in fields else 60.0
    result = _measured(scenario, axis, seconds=seconds, **fields)
    ratio = (_complex(result.plant) / _complex(result.linearised_plant))[_coherent(result)]
    decibels = np.quantile(20.0 * np.abs(np.log10(np.abs(ratio))), 0.95)
    degrees = np.quantile(np.degrees(np.abs(np.angle(ratio))), 0.95)
    return Row(
        f"{scenario}, {axis}, {fields['signal']}: 95 % of the lines",
        "",
        f"{decibels:.2f} dB, {degrees:.1f} deg",
        f"{len(ratio)} of {len(result.frequency)} lines",
    )


def _measured(scenario: str, axis: str, **fields: Any) -> MeasuredResponse:
    request = {"scenario": scenario, "axis": axis} | fields
    return measure(plan(ResponseRequest.model_validate(request)))


def _complex(curve: Any) -> Complex:
    return np.array(curve.magnitude) * np.exp(1j * np.array(curve.phase))


def _coherent(result: MeasuredResponse) -> NDArray[np.bool_]:
    return np.array(result.plant.coherence) > _COHERENT


def _errors(what: str, minutes: list[MeasuredResponse], took: float) -> Iterator[Row]:
    ratios = np.concatenate(
        [
            (_complex(each.plant) / _complex(each.linearised_plant))[_coherent(each)]
            for each in minutes
        ]
    )
    share = np.mean([_coherent(each).mean() for each in minutes])
    for unit, limit, errors in (
        ("dB", _DECIBELS, np.abs(20.0 * np.log10(np.abs(ratios)))),
        ("deg", _DEGREES, np.degrees(np.abs(np.angle(ratios)))),
    ):
        yield Row(
            f"{what}: to the linearisation",
            f"<= {limit:g} {unit}",
            f"max {errors.max():.2f} {unit}",
            f"95 %: {np.quantile(errors, 0.95):.2f} {unit}",
            "",
            bool(errors.max() <= limit),
        )
    yield Row(
        f"  lines with coherence above {_COHERENT:g}", "", f"{share:.1%}", f"{took:.1f} s each"
    )


def _coverage(scenario: str, axis: str, minutes: list[MeasuredResponse]) -> Row:
    """Return how often intervals hold what a long measurement with other phases finds."""
    there = _complex(_measured(scenario, axis, seconds=_LONG, seed=999).plant)
    held = []
    for each in minutes:
        ratio, half = there / _complex(each.plant), np.array(each.plant.interval)
        of_both = (np.abs(np.abs(ratio) - 1.0) < half, np.abs(np.angle(ratio)) < half)
        held += [part[_coherent(each)] for part in of_both]
    share = float(np.concatenate(held).mean())
    low, high = _HELD
    return Row(
        f"  95 % intervals hold that of {_LONG / 60:.0f} min",
        f"{low:.0%} to {high:.0%}",
        f"{share:.1%}",
        f"{sum(map(len, held))} intervals",
        "",
        low <= share <= high,
    )


def _margins() -> Row:
    """Return how many linearised margins lie within the intervals of measured minutes.

    A margin that neither loop has counts for nothing.
    """
    held = []
    for scenario, axis in _MOTORS:
        for seed in range(_SEEDS):
            for each in _measured(scenario, axis, seed=seed).margins.values():
                ends, model = each.interval, each.model
                if each.value is not None or model is not None:
                    held.append(bool(ends and model and ends[0] <= model <= ends[1]))
    return Row(
        "linearised margins within intervals",
        f">= {_CERTAIN:.0%}",
        f"{sum(held)} of {len(held)}",
        f"{len(_MOTORS)} motors, {_SEEDS} minutes each",
        "",
        bool(np.mean(held) >= _CERTAIN),
    )
