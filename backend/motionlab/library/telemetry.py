"""Telemetry of runs read back as a recording."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from motionlab.analysis.contouring import AROUND
from motionlab.analysis.latest_metrics import ReferencePath
from motionlab.config.planar import AXES
from motionlab.telemetry.channels import stream_columns
from motionlab.telemetry.expressions.columns import MathChannel, compile_columns
from motionlab.telemetry.expressions.compile import Program
from motionlab.telemetry.expressions.evaluate import BLOCK, Evaluation, reach
from motionlab.telemetry.law_channels import kept_states
from motionlab.telemetry.parquet import column_descriptions, read_ticks
from motionlab.telemetry.recording import Recording, as_recording

if TYPE_CHECKING:
    from pyarrow import parquet


def check_columns(
    file: parquet.ParquetFile, columns: Sequence[str], period: float
) -> dict[str, MathChannel]:
    """Refuse columns that are not there or come twice, and expressions that cannot be computed.

    Parameters
    ----------
    file : ParquetFile
        Telemetry of a run.
    columns : sequence of str
        Names of channels, and math channels as ``name=expression``.
    period : float
        Time between samples, s.

    Raises
    ------
    ConfigError
        Naming each.
    """
    units = {each["name"]: each["unit"] for each in column_descriptions(file.schema_arrow)}
    return compile_columns(columns, units, period)


def read_columns(
    file: parquet.ParquetFile,
    columns: Sequence[str],
    math: Mapping[str, MathChannel],
    start: int,
    stop: int,
) -> NDArray[np.float32]:
    """Return samples [start, stop) of columns, those of `math` computed from the first sample on.

    Parameters
    ----------
    file : ParquetFile
        Telemetry of a run.
    columns : sequence of str
        Checked by `check_columns`, which returned `math`.
    math : mapping of str to MathChannel
        The math channels by their texts.
    start, stop : int
        Samples; cut to what there is.

    Returns
    -------
    ndarray of float32, shape (columns, stop - start)
        Missing samples are NaN.
    """
    if not math:
        return read_ticks(file, columns, start, stop)
    recorded = [name for name in columns if name not in math]
    samples = dict(zip(recorded, read_ticks(file, recorded, start, stop), strict=True))
    for text, each in math.items():
        samples[text] = _computed(file, each.program, start, stop)
    return np.stack([samples[name] for name in columns])


def _computed(
    file: parquet.ParquetFile, program: Program, start: int, stop: int
) -> NDArray[np.float32]:
    reached = reach(program)
    begin = 0 if reached is None else max(0, start - reached)
    evaluation = Evaluation(program)
    parts = []
    for first in range(begin, stop, BLOCK):
        values = evaluation(read_ticks(file, program.channels, first, min(first + BLOCK, stop)))
        parts.append(values[max(0, start - first) :])
    return np.concatenate(parts)


def recording(
    file: parquet.ParquetFile, variants: Sequence[str], start: int, stop: int
) -> Recording:
    """Return samples [start, stop) as a recording; references are float32, as they are kept."""
    states = kept_states(column_descriptions(file.schema_arrow))
    columns = [name for name, _ in [*stream_columns(variants), *states]]
    samples = read_ticks(file, columns, start, stop)
    rows = {name: row for row, name in enumerate(columns)}
    failed: dict[str, int | None] = {}
    first = int(file.read_row_group(0, columns=["tick"])["tick"][0].as_py()) + start
    recorded = ~np.isnan(samples[0])  # what is missing for all is a gap of the recording
    for name in variants:  # the command is there also where drives measure nothing
        missing = np.flatnonzero(np.isnan(samples[rows[f"{name}.x.force_command"]]) & recorded)
        failed[name] = first + int(missing[0]) if missing.size else None
    return as_recording(first, samples, failed, states=states)


def reference_path(
    file: parquet.ParquetFile, start: int, stop: int, most: int | None
) -> ReferencePath:
    """Return the reference of samples [start, stop) and around them, but none from `most` on."""
    begin, end = max(0, start - AROUND), stop + AROUND
    end = end if most is None else max(stop, min(end, most))
    columns = [f"{axis}.position_reference" for axis in AXES]
    return ReferencePath(read_ticks(file, columns, begin, end).T.astype(np.float64), start - begin)
