"""Measurements as runs: telemetry, metrics and picture of what was imported."""

from __future__ import annotations

import json
import os
import time
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from numpy.typing import NDArray

from motionlab import __version__
from motionlab.config.planar import AXES
from motionlab.exchange.measurements.channels import Measurement, read_measurement
from motionlab.exchange.measurements.column_guess import VARIANT
from motionlab.exchange.measurements.document import Import, ImportOptions
from motionlab.exchange.measurements.table_file import read_file
from motionlab.exchange.measurements.two_files import merged
from motionlab.library.description import picture
from motionlab.library.library import Library
from motionlab.library.run import NAME_MAX, Event, RunDetail, new_id
from motionlab.telemetry.recorder import ROWS, parquet_writer

_EVENTS_MAX = 1000  # gaps that are events of the run


def import_file(
    path: Path,
    options: ImportOptions,
    *,
    library: Library | None,
    name: str,
    second: Path | None = None,
) -> tuple[Import, RunDetail | None]:
    """Read a file of a machine, and keep it as a run.

    Parameters
    ----------
    path : Path
        CSV, Parquet, MAT, NPZ or MCAP; its content decides which.
    options : ImportOptions
        What the user says of it.
    library : Library, optional
        Where it is kept; None for a preview.
    name : str
        What the run is called where `options` give no name: of a file, whose name may be no text.
    second : Path, optional
        Another file of the same motion, which is merged on the time of the first.

    Returns
    -------
    Import
        What was found out and guessed.
    RunDetail or None
        None in a preview, and where the document has problems.

    Raises
    ------
    ConfigError
        If the file or an option cannot be used.
    StoreError
        If it cannot be kept.
    """
    file, about_second = read_file(path, options), None
    if second is not None:
        file, about_second, options = merged(file, read_file(second, options), options)
    measurement = read_measurement(file, options)
    document = measurement.document
    document.merged = about_second
    if library is None or document.problems:
        return document, None
    name = options.name or os.fsencode(name).decode("utf-8", "replace")
    run = _run(measurement, name[:NAME_MAX])
    run.result["import"] = document.model_dump(mode="json", exclude={"run", "channels", "units"})
    about = {
        "version": __version__,
        "import": json.dumps(run.result["import"], allow_nan=False),
    }
    kept = library.keep_file(run, lambda part: _write(measurement, part, about))
    return document.model_copy(update={"run": kept.id}), kept


def _run(measurement: Measurement, name: str) -> RunDetail:
    document, values = measurement.document, measurement.values
    ticks = len(next(iter(values.values())))
    missing = document.missing * measurement.period
    gaps = measurement.gaps
    return RunDetail(
        id=new_id(),
        kind="measurement",
        state="partial" if gaps else "complete",
        reason=f"{missing:.3g} s are missing in the file" if gaps else "",
        name=name,
        scenario="",
        note="",
        tags=[],
        pinned=False,
        kept=True,
        created=time.time() if measurement.begun is None else measurement.begun,
        duration=0.0,
        ticks=ticks,
        period=measurement.period,
        size=0,
        variants=[VARIANT],
        labels={VARIANT: "measurement"},
        differences=[],
        metrics={},
        thumbnail=_picture(values),
        seed=None,
        version=__version__,
        model="",
        processor="",
        maps={},
        scenario_document=None,
        events=[
            Event(tick=tick, kind="gap", ticks=length, reason="missing in the file")
            for tick, length in gaps[:_EVENTS_MAX]
        ],
        result=_result(values, measurement.period),
        columns=[],
    )


def _result(values: dict[str, NDArray[np.float32]], period: float) -> dict[str, Any]:
    """Return the metrics of the following errors over the whole record."""
    axes: dict[str, dict[str, float]] = {}
    ticks = len(next(iter(values.values())))
    for axis in AXES:
        error = values.get(f"{VARIANT}.{axis}.following_error")
        if error is None or not np.isfinite(error).any():
            continue
        finite = error[np.isfinite(error)].astype(np.float64)
        axes[axis] = {
            "max_abs_following_error": float(np.max(np.abs(finite))),
            "rms_following_error": float(np.sqrt(np.mean(finite**2))),
        }
    variant = {"label": "measurement", "diverged": None, "notes": [], "axes": axes}
    return {
        "window": {"start": 0.0, "end": ticks * period},
        "variants": {VARIANT: variant},
        "comparison": {},
    }


def _picture(values: dict[str, NDArray[np.float32]]) -> dict[str, list[int]]:
    ticks = len(next(iter(values.values())))
    path, error = np.zeros((2, 2, ticks), dtype=np.float32)
    referred = False
    known = False
    for row, axis in enumerate(AXES):
        reference = values.get(f"{axis}.position_reference")
        measured = values.get(f"{VARIANT}.{axis}.position_measured")
        drawn = measured if reference is None else reference
        if drawn is None:
            continue
        known, referred = True, referred or reference is not None
        path[row] = drawn
        if reference is not None:
            error[row] = values.get(f"{VARIANT}.{axis}.following_error", 0.0)
    if not known:
        return {}
    curves = picture(path, {VARIANT: error})
    return curves if referred else {VARIANT: curves["reference"]}


def _write(measurement: Measurement, path: str, about: dict[str, str]) -> None:
    """Write the samples as telemetry of a run."""
    fields = [
        pa.field("tick", pa.int64(), metadata={"unit": "1", "meaning": "sample"}),
        pa.field("time", pa.float64(), metadata={"unit": "s", "meaning": "time from the first"}),
    ]
    fields += [
        pa.field(name, pa.float32(), metadata={"unit": unit, "meaning": meaning})
        for name, (unit, meaning) in measurement.columns.items()
    ]
    schema = pa.schema(fields, metadata=about)
    values = measurement.values
    ticks = len(next(iter(values.values())))
    with parquet_writer(Path(path), schema) as writer:
        for start in range(0, ticks, ROWS):
            steps = np.arange(start, min(start + ROWS, ticks))
            arrays = [pa.array(steps), pa.array(steps * measurement.period)]
            arrays += [
                pa.array(values[name][start : start + ROWS], from_pandas=True)
                for name in measurement.columns
            ]
            writer.write_batch(pa.RecordBatch.from_arrays(arrays, schema=schema))
