"""A prediction as text, and as a table in a file."""

from __future__ import annotations

import csv
from collections.abc import Mapping, Sequence

import numpy as np

from motionlab.files import complete_file
from motionlab.reports.tables import table
from motionlab.studies.minute.documents import MinuteDocument, PredictedError
from motionlab.studies.minute.predict import Array, Prediction


def report(result: Prediction | MinuteDocument) -> str:
    """Return the errors of both controllers, and the motor that was fitted."""
    document = result.document if isinstance(result, Prediction) else result
    lines = [
        f"{document.run} {document.name}, {document.start:.4g} to {document.end:.4g} s: recorded "
        f"under {document.variant}, {document.label}; predicted for {document.other}, "
        f"{document.other_label}",
        "",
    ]
    rows = []
    for axis, each in document.axes.items():
        for name, recorded, predicted in (
            ("max", each.max_recorded, each.max_predicted),
            ("rms", each.rms_recorded, each.rms_predicted),
        ):
            rows.append(
                [
                    f"{axis} {name}",
                    _um(recorded),
                    _um(predicted.value),
                    _interval(predicted),
                    f"{predicted.value / recorded:.3f}" if recorded else "-",
                ]
            )
    heads = ("following error, um", "recorded", "predicted", "95 %", "ratio")
    lines += [table(heads, rows, right=(1, 2, 3, 4)), ""]
    rows = [
        [
            f"{axis} {name}, {fitted.unit}",
            f"{fitted.believed:.4g}",
            f"{fitted.value:.4g}",
            f"{fitted.low:.3g} to {fitted.high:.3g}",
        ]
        for axis, each in document.axes.items()
        for name, fitted in each.motor.items()
    ]
    heads = ("motor, in the controller's newtons", "believed", "fitted", "95 %")
    lines += [table(heads, rows, right=(1, 2, 3)), ""]
    lines += [
        f"{axis}: {each.reversals} reversals, disturbance {each.disturbance:.3g} N rms; the "
        f"recorded controller, simulated, misses its record by {_um(each.miss)} um rms"
        for axis, each in document.axes.items()
    ]
    lines += [f"warning: {warning}" for warning in document.warnings]
    return "\n".join(lines)


def write(result: Prediction | MinuteDocument, path: str) -> None:
    """Write one row a control period as CSV, SI; of a document, one an instant that it has.

    Raises
    ------
    StoreError
        If the file cannot be written.
    """
    with (
        complete_file(path) as partial,
        partial.open("w", newline="", encoding="utf-8") as file,
    ):
        rows = csv.writer(file, lineterminator="\n")
        time, curves = _columns(result)
        rows.writerow(["time [s]", *(f"{name} [m]" for name in curves)])
        columns = [time, *curves.values()]
        rows.writerows([f"{value:.9g}" for value in row] for row in zip(*columns, strict=True))


def _columns(
    result: Prediction | MinuteDocument,
) -> tuple[Sequence[float] | Array, Mapping[str, Sequence[float] | Array]]:
    if isinstance(result, Prediction):
        return result.time, result.curves
    errors = {axis: each.errors.model_dump() for axis, each in result.axes.items()}
    time = sorted({at for each in errors.values() for at in each["time"]})
    curves = {
        f"{axis}.{name}": np.interp(time, each["time"], values)
        for axis, each in errors.items()
        for name, values in each.items()
        if name != "time"
    }
    return time, curves


def _um(value: float) -> str:
    return f"{1e6 * value:.3g}"


def _interval(predicted: PredictedError) -> str:
    return f"{_um(predicted.low)} to {_um(predicted.high)}"
