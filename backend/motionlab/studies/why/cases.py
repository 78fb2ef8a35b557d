"""A run with changes, and the errors that it has about a peak."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import apply_changes
from motionlab.config.load import validate
from motionlab.config.scenario import Scenario
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.inputs import load_force
from motionlab.simulation.prepare import Prepared
from motionlab.studies.why.causes import look_up

Errors = tuple[float, float]
"""Largest about the peak and over the metrics window, m; NaN where the run diverged."""


@dataclass(frozen=True)
class Look:
    """Axis, ticks about the peak, and ticks of the metrics window."""

    axis: int
    near: slice
    window: slice

    def at(self, errors: NDArray[np.float32]) -> tuple[float, float]:
        """Return the largest error about the peak and in the window, m; NaN where it diverged."""
        own = np.abs(errors[self.axis])
        return float(own[self.near].max()), float(own[self.window].max())


def alone(whole: Prepared, variant: str) -> Prepared:
    """Return a scenario with one of its variants."""

    def only(scenario: Scenario) -> Scenario:
        variants = {variant: scenario.variants[variant]}
        return scenario.model_copy(update={"variants": variants, "schedule": ()})

    epochs = tuple((tick, only(scenario)) for tick, scenario in whole.epochs)
    return dataclasses.replace(whole, scenario=only(whole.scenario), epochs=epochs)


def changed(scenario: Scenario, changes: Mapping[str, Any]) -> Scenario:
    """Return a scenario with changes, validated."""
    return validate(apply_changes(scenario.model_dump(mode="json"), dict(changes)))


def with_changes(base: Prepared, changes: Mapping[str, Any]) -> Prepared:
    """Return a prepared scenario with changes that hold throughout, whatever is scheduled."""
    if not changes:
        return base
    epochs = tuple((tick, changed(scenario, changes)) for tick, scenario in base.epochs)
    case = dataclasses.replace(base, scenario=epochs[0][1], epochs=epochs)
    if not any(path.startswith("load.") for path in changes):
        return case
    load = base.load.copy()
    for tick, scenario in epochs:
        load[tick:] = load_force(scenario.load, len(load))[tick:]
    return dataclasses.replace(case, load=load)


def effective(scenario: Scenario, changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return the changes that change something."""
    tables = scenario.model_dump(mode="json")
    return {path: value for path, value in changes.items() if look_up(tables, path) != value}


def errors_of(base: Prepared) -> NDArray[np.float32]:
    """Return the following errors of a run, m, (axes, ticks)."""
    kept: list[NDArray[np.float32]] = []
    run_prepared([base], watch=lambda _, errors: kept.append(errors[0].copy()))
    return kept[0]


def peaks_of(
    base: Prepared, cases: Sequence[Mapping[str, Any]], look: Look
) -> list[tuple[float, float]]:
    """Return the largest errors of a run with each of some changes, as `Look.at` does."""
    peaks = [(math.nan, math.nan)] * len(cases)

    def watch(movers: NDArray[np.int64], errors: NDArray[np.float32]) -> None:
        for mover, own in zip(movers.tolist(), errors, strict=True):
            peaks[mover] = look.at(own)

    if cases:
        run_prepared([with_changes(base, changes) for changes in cases], watch=watch)
    return peaks
