"""Spectra of a kept run, a following error's beside the response of the loop that made it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from motionlab.analysis.loop_spectrum import (
    COLUMNS_MAX,
    NO_LOOP,
    SAMPLES_MAX,
    OwnLoop,
    Samples,
    SpectrumOptions,
    Taken,
    error_of,
    take,
)
from motionlab.errors import ConfigError, FieldError
from motionlab.library.library import library
from motionlab.library.run import RunDetail
from motionlab.library.scenario_at import scenario_of
from motionlab.library.telemetry import check_columns, read_columns
from motionlab.telemetry.expressions.columns import MathChannel
from motionlab.telemetry.parquet import read_ticks


def run_spectra(
    run_id: str, columns: Sequence[str], start: int, stop: int | None, options: SpectrumOptions
) -> tuple[list[Taken], float]:
    """Return the spectra of some columns of a run, and the time between its samples, s.

    Parameters
    ----------
    run_id : str
        The run.
    columns : sequence of str
        Their names, or expressions as ``name=expression``.
    start, stop : int or None
        Samples [start, stop); None is the end of the run.
    options : SpectrumOptions
        Window and averages.

    Raises
    ------
    Unknown
        If there is no such run.
    Busy
        If it is being recorded.
    ConfigError
        If a column is not there, or there are too many of them or of samples, or too few samples.
    """
    run = library().complete(run_id)
    stop = min(stop or run.ticks, run.ticks)
    if len(columns) > COLUMNS_MAX:
        most: dict[str, float] = {"maximum": COLUMNS_MAX}
        raise ConfigError(FieldError("columns", "too many", len(columns), bounds=most))
    if not 0 < stop - start <= SAMPLES_MAX:
        ends: dict[str, float] = {"exclusive_minimum": start, "maximum": start + SAMPLES_MAX}
        raise ConfigError(FieldError("to", "too few or too many samples", stop, bounds=ends))
    with library().files.open(run_id) as file:
        math = check_columns(file, columns, run.period)
        units = {column["name"]: column["unit"] for column in run.columns}
        units |= {text: each.program.unit for text, each in math.items()}
        known = set(file.schema_arrow.names)
        taken = []
        for name in columns:
            values = read_columns(file, [name], _only(math, name), start, stop)[0]
            speed = None
            error = error_of(name)
            if error and (velocity := f"{error[1]}.velocity_reference") in known:
                reference = read_ticks(file, [velocity], start, stop)[0]
                speed = float(np.nanmedian(np.abs(reference)))
            samples = Samples(name, units[name], values.astype(np.float64), start)
            own = _loop(run, name, speed, start, stop)
            taken.append(take(samples, options, period=run.period, loop=own))
    return taken, run.period


def _only(math: Mapping[str, MathChannel], name: str) -> dict[str, MathChannel]:
    return {name: math[name]} if name in math else {}


def _loop(run: RunDetail, column: str, speed: float | None, start: int, stop: int) -> OwnLoop | str:
    """Return the loop of a column as it was at the first sample, or why there is none."""
    error = error_of(column)
    if error is None:
        return NO_LOOP
    if run.scenario_document is None or speed is None or not np.isfinite(speed):
        return "the run has no scenario, and so no loop that is known"
    variant, axis = error
    about = f"variants.{variant}", "plant"
    scenario = scenario_of(run, start, stop, lambda path: path.startswith(about))
    if isinstance(scenario, str):
        return scenario
    return OwnLoop(scenario, variant, axis, speed)
