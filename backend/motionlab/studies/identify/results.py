"""Estimates of an identification, as a document."""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from motionlab.config.plant import FrictionConfig
from motionlab.config.scenario import Scenario
from motionlab.files import complete_file
from motionlab.studies.identify.documents import (
    AxisIdentification,
    Fit,
    ForceRamp,
    IdentificationDocument,
    Known,
    Parameter,
    Point,
    StribeckCurve,
)
from motionlab.studies.identify.fit import Fitted, curve_half_width, stribeck_curve
from motionlab.studies.identify.rig import Rig
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]

UNITS = {
    "F_c": "N",
    "F_s": "N",
    "v_s": "m/s",
    "sigma_2": "N s/m",
    "f_0": "N",
    "sigma_0": "N/m",
    "sigma_1": "N s/m",
    "M": "kg",
    "lag": "s",
}
_DRAWN = 240
"""Samples of a ramp in the document, at most."""


_CURVE_SAMPLES = 80
"""Of the fitted curve in the document, each way."""

_NEAR_ZERO = 0.5
"""Share of the slowest speed at which the curve begins."""


@dataclass(frozen=True)
class AxisEstimate:
    """Results of the experiment on one axis."""

    points: list[Point]
    sliding: Fitted
    presliding: Fitted | None
    ramps: list[ForceRamp]
    warnings: list[str]


def axis_document(rig: Rig, axis: str, estimate: AxisEstimate) -> AxisIdentification:
    """Return the results of one axis, the old model and the true values."""
    velocity = np.array([point.velocity for point in estimate.points])
    force = np.array([point.force for point in estimate.points])
    presliding, truth = estimate.presliding, rig.scenario
    return AxisIdentification(
        points=estimate.points,
        residuals=(force - stribeck_curve(velocity, estimate.sliding.values)).tolist(),
        curve=curve_document(estimate.sliding, np.abs(velocity)),
        sliding=fit_document(rig, axis, estimate.sliding, "N", truth),
        presliding=None if presliding is None else fit_document(rig, axis, presliding, "m", truth),
        ramps=estimate.ramps,
        warnings=estimate.warnings,
    )


def known_document(rig: Rig, axis: str, truth: Scenario | None) -> Known:
    """Return the model's and the true friction of an axis; `truth` is what was simulated."""
    true = None if truth is None else getattr(truth.plant, axis).friction
    return Known(
        believed=_parameters(rig.identified_model(axis).friction),
        true=_parameters(true) if true is not None and true.enabled else None,
    )


def curve_document(sliding: Fitted, speed: Array) -> StribeckCurve:
    """Return the fitted curve and its band over the range of some speeds, both ways."""
    one_way = np.geomspace(_NEAR_ZERO * speed.min(), speed.max(), _CURVE_SAMPLES)
    v = np.concatenate([-one_way[::-1], one_way])
    force = stribeck_curve(v, sliding.values)
    half = curve_half_width(v, sliding)
    return StribeckCurve(
        velocity=v.tolist(),
        force=force.tolist(),
        low=None if half is None else (force - half).tolist(),
        high=None if half is None else (force + half).tolist(),
    )


def ramp_document(rate: float, force: Array, measured: Array, fitted: Array) -> ForceRamp:
    """Return the response to force ramps of one rate, thinned out."""
    step = -(-len(force) // _DRAWN)
    return ForceRamp(
        rate=rate,
        force_max=float(force.max()),
        time=[float(t) for t in np.arange(0, len(force), step) * CONTROL_PERIOD],
        force=force[::step].tolist(),
        displacement=measured[::step].tolist(),
        fitted=fitted[::step].tolist(),
    )


def is_a_model(friction: dict[str, float], believed: FrictionConfig) -> bool:
    """Return whether the identified values are valid in a controller's model."""
    try:
        FrictionConfig.model_validate(believed.model_dump() | friction)
    except ValidationError:
        return False
    return True


def _parameters(friction: FrictionConfig) -> dict[str, float]:
    return {name: getattr(friction, name) for name in UNITS if hasattr(friction, name)}


def fit_document(rig: Rig, axis: str, fitted: Fitted, unit: str, truth: Scenario | None) -> Fit:
    """Return a fit beside the old model and, where something was simulated, its true values."""
    plant = None if truth is None else getattr(truth.plant, axis)
    model = rig.identified_model(axis)
    parameters = {}
    for i, name in enumerate(fitted.names):
        value, half = float(fitted.values[i]), float(fitted.half_width[i])
        known = np.isfinite(half)
        true = None
        if plant is not None and (plant.friction.enabled or name == "M"):
            true = _of(plant, name)
        parameters[name] = Parameter(
            value=value,
            unit=UNITS[name],
            standard_error=float(fitted.errors[i]) if known else None,
            low=value - half if known else None,
            high=value + half if known else None,
            believed=_of(model, name),
            true=true,
            ratio=value / true if true else None,
        )
    return Fit(
        parameters=parameters,
        residual_rms=fitted.residual_rms,
        residual_unit=unit,
        warnings=fitted.warnings,
    )


def _of(known: Any, name: str) -> float | None:
    """Return a parameter of a motor or of a model of it; neither has an offset of force."""
    if name in {"f_0", "lag"}:
        return None
    return known.mass if name == "M" else getattr(known.friction, name)


_COLUMNS = ("axis", "velocity [m/s]", "force [N]", "deviation [N]", "pitches [1]")


def write(document: IdentificationDocument, path: str) -> None:
    """Write the points as CSV, or the document as JSON; the suffix of `path` decides.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        if Path(path).suffix == ".json":
            json.dump(document.model_dump(), file, allow_nan=False)
            return
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(_COLUMNS)
        for axis, identified in document.axes.items():
            rows.writerows([axis, *point.model_dump().values()] for point in identified.points)
