"""Estimates of an identification, as document and as text."""

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
from motionlab.config.timing import CONTROL_PERIOD
from motionlab.files import complete_file
from motionlab.library.motors import MotorOrigin
from motionlab.reports.result_text import report as run_report
from motionlab.studies.identify.documents import (
    AxisIdentification,
    Fit,
    ForceRamp,
    IdentificationDocument,
    Known,
    Parameter,
    Point,
    RecordEvidence,
    StribeckCurve,
)
from motionlab.studies.identify.fit import Fitted, curve_half_width, stribeck_curve
from motionlab.studies.identify.rig import Rig

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
_WIDTH = 12


def report(document: IdentificationDocument) -> str:
    """Return a table of parameters for each axis, warnings below it.

    Parameters
    ----------
    found : IdentificationDocument
        From `motionlab.studies.identify.experiment.identify`.
    """
    lines = [
        f"{document.plant} motor, gains and force map of {document.variant}, seed {document.seed}: "
        f"{document.simulated_time:.0f} s of motion"
        if document.run is None
        else f"run {document.run}, {document.simulated_time:.4g} s; "
        f"force map of {document.variant}",
        "Forces are in newtons of the controller's map; +- is half of the 95 % interval.",
    ]
    for axis, identified in document.axes.items():
        fits = [fit for fit in (identified.sliding, identified.presliding) if fit is not None]
        head = "".join(t.rjust(_WIDTH) for t in ("identified", "+-", "true", "ratio", "believed"))
        lines += ["", f"{axis}, {len(identified.points)} points{'':20}"[:28] + head]
        for fit in fits:
            lines += [_row(name, parameter) for name, parameter in fit.parameters.items()]
        lines += [f"  residual: {_residual(fit)}" for fit in fits]
        if identified.record is not None:
            lines += _evidence(identified.record)
        warnings = [*identified.warnings, *(w for fit in fits for w in fit.warnings)]
        lines += [f"  warning: {warning}" for warning in warnings]
    if document.set:
        lines += ["", f"into the model of {document.apply_to}:"]
        lines += [f"  --set {path}={value:.6g}" for path, value in document.set.items()]
    if document.motor is not None and document.motor.origin is not None:
        lines += _motor(document.motor.origin)
    if document.comparison is not None:
        lines += ["", run_report(document.comparison.model_dump())]
    return "\n".join(lines)


def _motor(origin: MotorOrigin) -> list[str]:
    """Return the lines on the fitted motor: the residual of its simulation against the run."""
    lines = ["", "the simulated motor with these values and masses (--motor NAME saves it):"]
    for axis, residual in (origin.residual or {}).items():
        before, after = 1e6 * residual.before, 1e6 * residual.after
        lines.append(
            f"  {axis}: following error of the run less the simulation's, rms: "
            f"{before:.3g} um before, {after:.3g} um fitted"
        )
    return lines + [f"  note: {note}" for note in origin.notes]


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


def _evidence(record: RecordEvidence) -> list[str]:
    """Return the lines on the information of a run."""
    shares = ", ".join(f"{100 * share:.0f} % {name}" for name, share in record.shares.items())
    half = record.lag_half_width
    lag = (
        ": not determined" if half is None else f" by {record.lag * 1e6:.0f} +- {half * 1e6:.2g} us"
    )
    return [
        f"  read: {record.position} and {record.force}, {record.rate:.6g} Hz, filter "
        f"{record.bandwidth:.3g} Hz, noise {record.noise * 1e9:.3g} nm",
        f"  sliding at {record.slowest * 1e3:.3g} to {record.fastest * 1e3:.3g} mm/s, "
        f"{record.reversals} reversals; {shares}",
        f"  motion behind force{lag}; condition number {record.condition:.3g}",
    ]


def _row(name: str, parameter: Parameter) -> str:
    half = None if parameter.high is None else parameter.high - parameter.value
    cells = (parameter.value, half, parameter.true, parameter.ratio, parameter.believed)
    return f"  {name:10}{parameter.unit:16}" + "".join(_cell(cell) for cell in cells)


def _cell(value: float | None) -> str:
    return ("-" if value is None else f"{value:.4g}").rjust(_WIDTH)


def _residual(fit: Fit) -> str:
    if fit.residual_unit == "m":
        return f"{fit.residual_rms * 1e6:.3g} um rms"
    return f"{fit.residual_rms * 1e3:.3g} mN rms"
