"""The motion of a kept run as a trajectory of kind `samples`."""

from __future__ import annotations

from typing import Any

import numpy as np

from motionlab.config.planar import AXES
from motionlab.config.samples import SAMPLES_MAX
from motionlab.errors import ConfigError, FieldError
from motionlab.exchange.paths.samples import samples_table
from motionlab.library.columns import of_run
from motionlab.library.library import library

_CHANNELS = ("position_reference", "position_measured", "position")


def motion_of_run(run: str, loc: str) -> dict[str, Any]:
    """Return the commanded motion of a run, of a measurement without one the measured motion.

    Raises
    ------
    ConfigError
        If there is no such run, or it has no positions, gaps, or too many samples.
    """
    columns = of_run(library().named(run, loc))
    names = [_channel(list(columns.units), axis, loc, run) for axis in AXES]
    count = columns.grid.ticks
    if not 2 <= count <= SAMPLES_MAX:
        message = f"{run} has too {'few' if count < 2 else 'many'} samples"
        bounds = {"minimum": 2.0, "maximum": float(SAMPLES_MAX)}
        raise ConfigError(FieldError(loc, message, count, unit="samples", bounds=bounds))
    values = columns.read(names).astype(np.float64)
    missing = np.flatnonzero(~np.isfinite(values).all(axis=0))
    period = columns.grid.period
    if missing.size:
        message = f"{run} has no position at {missing[0] * period:.6g} s, row {missing[0]}"
        raise ConfigError(FieldError(loc, message))
    return samples_table(np.arange(count) * period, values[0], values[1])


def _channel(names: list[str], axis: str, loc: str, run: str) -> str:
    for channel in _CHANNELS:
        for name in names:
            if name == f"{axis}.{channel}" or name.endswith(f".{axis}.{channel}"):
                return name
    raise ConfigError(FieldError(loc, f"{run} has no position of {axis}"))
