"""An identification as text for people, and as a file."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from motionlab.files import complete_file
from motionlab.library.motors import MotorOrigin
from motionlab.reports.result_text import report as run_report
from motionlab.studies.identify.document import (
    Fit,
    IdentificationDocument,
    Parameter,
    RecordEvidence,
)

_COLUMNS = ("axis", "velocity [m/s]", "force [N]", "deviation [N]", "pitches [1]")
_WIDTH = 12


def report(found: IdentificationDocument) -> str:
    """Return a table of parameters for each axis, warnings below it.

    Parameters
    ----------
    found : IdentificationDocument
        From `motionlab.studies.identify.experiment.identify`.

    Returns
    -------
    str
        Several lines.
    """
    lines = [
        f"{found.plant} motor, gains and force map of {found.variant}, seed {found.seed}: "
        f"{found.simulated_time:.0f} s of motion"
        if found.run is None
        else f"run {found.run}, {found.simulated_time:.4g} s; force map of {found.variant}",
        "Forces are in newtons of the controller's map; +- is half of the 95 % interval.",
    ]
    for axis, identified in found.axes.items():
        fits = [fit for fit in (identified.sliding, identified.presliding) if fit is not None]
        head = "".join(t.rjust(_WIDTH) for t in ("identified", "+-", "true", "ratio", "believed"))
        lines += ["", f"{axis}, {len(identified.points)} points{'':20}"[:28] + head]
        for fit in fits:
            lines += [_row(name, parameter) for name, parameter in fit.parameters.items()]
        lines += [f"  residual: {_residual(fit)}" for fit in fits]
        if identified.record is not None:
            lines += _told(identified.record)
        warnings = [*identified.warnings, *(w for fit in fits for w in fit.warnings)]
        lines += [f"  warning: {warning}" for warning in warnings]
    if found.set:
        lines += ["", f"into the model of {found.apply_to}:"]
        lines += [f"  --set {path}={value:.6g}" for path, value in found.set.items()]
    if found.motor is not None and found.motor.origin is not None:
        lines += _motor(found.motor.origin)
    if found.comparison is not None:
        lines += ["", run_report(found.comparison.model_dump())]
    return "\n".join(lines)


def _motor(origin: MotorOrigin) -> list[str]:
    """Return what the fitted motor is worth: how far its simulation is from the run."""
    lines = ["", "the simulated motor with these values and masses (--motor NAME saves it):"]
    for axis, residual in (origin.residual or {}).items():
        before, after = 1e6 * residual.before, 1e6 * residual.after
        lines.append(
            f"  {axis}: following error of the run less the simulation's, rms: "
            f"{before:.3g} um before, {after:.3g} um fitted"
        )
    return lines + [f"  note: {note}" for note in origin.notes]


def write(found: IdentificationDocument, path: str) -> None:
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
            json.dump(found.model_dump(), file, allow_nan=False)
            return
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(_COLUMNS)
        for axis, identified in found.axes.items():
            rows.writerows([axis, *point.model_dump().values()] for point in identified.points)


def _told(record: RecordEvidence) -> list[str]:
    """Return what a run could tell."""
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
