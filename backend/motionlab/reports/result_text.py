"""The result document as text for people, in the units people use."""

from __future__ import annotations

from typing import Any

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.reports.tables import table

_SHOWN = {"m": (1e6, "um"), "s": (1e3, "ms"), "1": (100.0, "%")}
"""Factor and name of the unit that people use, by SI unit."""


def report(result: dict[str, Any]) -> str:
    """Return a table of the main metrics of every variant.

    Each interval between scheduled switches has a table of its own.
    """
    lines = [f"{result['scenario']}: {result['plant']} motor, seed {result['seed']}"]
    if result["plant_description"]:
        lines.append(f"  {result['plant_description']}")
    segments = result["segments"] if len(result["segments"]) > 1 else [result]
    for segment in segments:
        lines += ["", *_segment(segment)]
    notes = [
        f"note on {name}: {note}"
        for name, variant in result["variants"].items()
        for note in variant["notes"]
    ]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def _segment(segment: dict[str, Any]) -> list[str]:
    """Return the window, what each variant is, and their metrics side by side."""
    variants, window = segment["variants"], segment["window"]
    lines = [f"from {window['start']:g} s to {window['end']:g} s"]
    for name, variant in variants.items():
        law = variant["law"] + ("" if variant["enabled"] else ", not added")
        lines.append(f"  {name}: {variant['label']} (law: {law})")
    axes = next((v["axes"] for v in variants.values() if v["axes"]), {})
    metrics = [
        (
            (axis, definition.printed, unit),
            [_scaled(v["axes"].get(axis, {}).get(metric), factor) for v in variants.values()],
            segment["comparison"].get(axis, {}).get(f"{metric}_ratio"),
        )
        for axis in axes
        for metric, definition in DEFINITIONS.items()
        if definition.printed
        for factor, unit in [_SHOWN.get(definition.unit, (1.0, definition.unit))]
    ]
    if len(axes) > 1:
        largest = [_scaled(v["contour"]["max"], _SHOWN["m"][0]) for v in variants.values()]
        a, b = (*largest, None)[:2]
        ratio = b / a if a and b is not None else None
        metrics.append((("xy", "max contouring error", "um"), largest, ratio))
    rows = [
        [*names, *(_cell(value, "-") for value in values), _cell(ratio, "")]
        for names, values, ratio in metrics
        if any(value is not None for value in values)
    ]
    first, second = (*variants, "")[:2]
    heads = ["", "", "", *variants, f"{second}/{first}" if second else ""]
    return [*lines, table(heads, rows, right=range(3, len(heads)))] if rows else lines


def _scaled(value: float | None, factor: float) -> float | None:
    return None if value is None else value * factor


def _cell(value: float | None, missing: str) -> str:
    return missing if value is None else f"{value:.3g}"
