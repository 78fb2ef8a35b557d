"""The result document of a run: metrics of every variant, B against A, window by window."""

from __future__ import annotations

import functools
import json
from typing import Any

from motionlab import __version__
from motionlab.analysis.metrics import variant_metrics
from motionlab.analysis.variant_comparison import compare
from motionlab.config.includes import resolve
from motionlab.config.named_configs import names, own_motors
from motionlab.config.planar import AXES
from motionlab.config.plant import PlantConfig
from motionlab.config.scenario import Scenario, VariantConfig
from motionlab.kernel.force_maps import maps_of
from motionlab.lanes import model_hash
from motionlab.simulation.prepare import Prepared
from motionlab.simulation.warnings import warnings_of
from motionlab.telemetry.recording import Divergence, Recording
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.feasibility import count_rate_warning
from motionlab.trajectories.reference import Reference

Window = tuple[int, int]

_PUBLISHED_K = (
    "K as published, eq. (25), does not work in discrete time: it needs an acceleration that K "
    "itself causes, its denominator crosses zero, and V of eq. (37) is only semidefinite"
)


def document(prepared: Prepared, recording: Recording) -> dict[str, Any]:
    """Return the result document, in types of JSON only.

    Parameters
    ----------
    prepared : Prepared
        What was run.
    recording : Recording
        Its recording; it must hold the window, segments outside of it are left out.

    Returns
    -------
    dict
        Metrics in SI units; see docs/metrics.md.
    """
    window = prepared.window
    measured = _measure(prepared, recording, window)
    return {
        **identity(prepared),
        **measured,
        "segments": [
            measured if segment == window else _measure(prepared, recording, segment)
            for segment in segments(prepared)
            if recording.holds(segment)
        ],
    }


def identity(prepared: Prepared) -> dict[str, Any]:
    """Return the part of the result document that says what was run, and by what."""
    scenario = prepared.scenario
    in_effect = effective(prepared, prepared.window)
    plant = in_effect.plant
    return {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "plant": plant_name(plant),
        "plant_description": plant.description,
        "version": __version__,
        "model": model_hash(),
        "maps": maps_of(in_effect),
    }


def metadata(scenario: Scenario) -> dict[str, str]:
    """Return the metadata that reproduce a recording: scenario, seed, versions."""
    return {
        "scenario": json.dumps(scenario.model_dump(mode="json"), allow_nan=False),
        "seed": str(scenario.seed),
        "version": __version__,
        "model": model_hash(),
        "maps": json.dumps(maps_of(scenario)),
    }


def _measure(prepared: Prepared, recording: Recording, window: Window) -> dict[str, Any]:
    """Return the metrics of all variants over one window."""
    scenario, reference = effective(prepared, window), prepared.reference
    variants: dict[str, Any] = {}
    for name, variant in scenario.variants.items():
        diverged = recording.variants[name].diverged
        metrics = variant_metrics(
            recording, name, reference, window, settling_band=scenario.settling_band
        )
        result = {"diverged": None if diverged is None else _divergence(diverged), **metrics}
        own = variant_identity(scenario, reference, variant)
        notes = [*warnings_of(scenario, name, result), *own["notes"]]
        variants[name] = {**own, "notes": notes, **result}
    first, *others = variants
    comparison = compare(variants[first], variants[others[0]]) if others else {}
    _note_published_k(variants, first)
    return {
        "window": {"start": window[0] * CONTROL_PERIOD, "end": window[1] * CONTROL_PERIOD},
        "variants": variants,
        "comparison": comparison,
    }


def variant_identity(
    scenario: Scenario, reference: Reference, variant: VariantConfig
) -> dict[str, Any]:
    """Return the part of a variant's result that does not depend on its run."""
    compensation = variant.controller.compensation
    return {
        "label": variant.label,
        "law": compensation.law,
        "enabled": compensation.enabled,
        "notes": _notes(scenario, reference, variant),
    }


def effective(prepared: Prepared, window: Window) -> Scenario:
    """Return the parameters in effect at the end of a window."""
    return [scenario for tick, scenario in prepared.epochs if tick < window[1]][-1]


def segments(prepared: Prepared) -> list[Window]:
    """Return a window for each interval between scheduled switches.

    Without a schedule that is the main window. Of a motion that repeats, each is the last two
    periods of its interval, after at least one where there is room; otherwise the whole interval.
    """
    starts = [tick for tick, _ in prepared.epochs]
    if len(starts) == 1:
        return [prepared.window]
    ends = [*starts[1:], prepared.reference.ticks]
    period = prepared.reference.period
    windows = []
    for start, end in zip(starts, ends, strict=True):
        settled = min(start + period, end - 1)
        windows.append((max(settled, end - 2 * period) if period else start, end))
    return windows


def _divergence(diverged: Divergence) -> dict[str, Any]:
    return {
        "time": diverged.time,
        "channel": diverged.channel,
        "last_states": [
            {name: _finite(value) for name, value in state.items()}
            for state in diverged.last_states
        ],
    }


def _finite(value: float) -> float | str:
    """Return a number as it is, or the name of one that is not finite."""
    return value if abs(value) < float("inf") else str(value)


def _notes(scenario: Scenario, reference: Reference, variant: VariantConfig) -> list[str]:
    notes = list(reference.notes)
    if variant.controller.compensation.law == "published-k":
        notes.append(_PUBLISHED_K)
    for axis in AXES:
        encoder = getattr(scenario.plant, axis).encoder
        if encoder.resolution > 0.0:
            warning = count_rate_warning(
                reference,
                axis,
                resolution=encoder.resolution,
                rate=encoder.interface_rate,
            )
            notes += [] if warning is None else [warning]
    return notes


def _note_published_k(variants: dict[str, Any], first: str) -> None:
    """Add to a published-K variant how much worse than the first one it is."""
    for name, variant in variants.items():
        if variant["law"] != "published-k" or name == first:
            continue
        ratios = compare(variants[first], variant)
        worse = [
            f"{ratio:.3g} times on {axis}"
            for axis, metrics in ratios.items()
            if (ratio := metrics.get("max_abs_following_error_ratio")) is not None
        ]
        if worse:
            variant["notes"].append(f"largest following error against {first}: " + ", ".join(worse))


def plant_name(plant: PlantConfig) -> str:
    """Return the plant's name, marked when it is no longer the motor of that name."""
    if plant.name in names("motors"):
        known = _shipped(plant.name)
    elif plant.name in own_motors():
        known = _named(plant.name)
    else:
        return plant.name
    return plant.name if known == plant else f"{plant.name} (changed)"


@functools.cache
def _shipped(name: str) -> PlantConfig:
    return _named(name)


def _named(name: str) -> PlantConfig:
    return PlantConfig.model_validate(resolve({"plant": name})["plant"])
