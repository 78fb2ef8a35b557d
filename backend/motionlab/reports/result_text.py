"""The result document as text for people, in the units people use."""

from __future__ import annotations

from typing import Any

_MICRO = 1e6
_ROWS = (
    ("max abs following error", "max_abs_following_error", _MICRO, "um"),
    ("RMS following error", "rms_following_error", _MICRO, "um"),
    ("largest error at rest", "steady_state_error", _MICRO, "um"),
    ("settling time", "settling_time", 1e3, "ms"),
    ("RMS force", "rms_force", 1.0, "N"),
    ("RMS current", "rms_current", 1.0, "A"),
    ("saturated", "saturated_fraction", 100.0, "%"),
)
_WIDTH = 12


def report(result: dict[str, Any]) -> str:
    """Return a table of the main metrics of every variant.

    Parameters
    ----------
    result : dict
        From `motionlab.simulation.result.document`.

    Returns
    -------
    str
        Several lines; a segment of its own for each interval between scheduled switches.
    """
    lines = [f"{result['scenario']}: {result['plant']} motor, seed {result['seed']}"]
    if result["plant_description"]:
        lines.append(f"  {result['plant_description']}")
    segments = result["segments"] if len(result["segments"]) > 1 else [result]
    for segment in segments:
        lines += ["", *_table(segment)]
    notes = [
        f"note on {name}: {note}"
        for name, variant in result["variants"].items()
        for note in variant["notes"]
    ]
    return "\n".join([*lines, *([""] if notes else []), *notes])


def _table(segment: dict[str, Any]) -> list[str]:
    variants = segment["variants"]
    window = segment["window"]
    lines = [f"from {window['start']:g} s to {window['end']:g} s"]
    for name, variant in variants.items():
        law = variant["law"] + ("" if variant["enabled"] else ", not added")
        lines.append(f"  {name}: {variant['label']} (law: {law})")
    compared = len(variants) > 1
    first, second = (*variants, None)[:2] if compared else (*variants, None)
    head = "".join(name.rjust(_WIDTH) for name in variants)
    lines.append(" " * 34 + head + (f"{second}/{first}".rjust(_WIDTH) if compared else ""))
    axes = next((v["axes"] for v in variants.values() if v["axes"]), {})
    for axis in axes:
        for title, metric, factor, unit in _ROWS:
            values = [_value(v, axis, metric) for v in variants.values()]
            if all(value is None for value in values):
                continue
            cells = "".join(_cell(value, factor) for value in values)
            ratio = segment["comparison"].get(axis, {}).get(f"{metric}_ratio") if compared else None
            lines.append(f"  {axis}  {title:25} {unit:3} {cells}{_cell(ratio, 1.0, blank=True)}")
    if len(axes) > 1 and any(v["contour"]["max"] is not None for v in variants.values()):
        values = [v["contour"]["max"] for v in variants.values()]
        cells = "".join(_cell(value, _MICRO) for value in values)
        ratio = _ratio(values[1], values[0]) if compared else None
        cells += _cell(ratio, 1.0, blank=True)
        lines.append(f"  xy {'max contouring error':25} um  {cells}")
    return lines


def _ratio(second: float | None, first: float | None) -> float | None:
    return second / first if second is not None and first else None


def _value(variant: dict[str, Any], axis: str, metric: str) -> float | None:
    return variant["axes"].get(axis, {}).get(metric)


def _cell(value: float | None, factor: float, *, blank: bool = False) -> str:
    if value is None:
        return ("" if blank else "-").rjust(_WIDTH)
    return f"{value * factor:.3g}".rjust(_WIDTH)
