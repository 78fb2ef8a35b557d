"""What the loop computes with: the lane parameters of one variant, with the tables they read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.force_sharing.tables import INVERSE_CELLS
from motionlab.kernel.layout import parameter_row, reads_tables
from motionlab.kernel.own_tables import sharing_table_size
from motionlab.lanes.bank import TABLES
from motionlab.plant.table_map import ANALYTIC, THRUST_TERMS, TableMap

Array = NDArray[np.float64]

TABLE_NUMBERS = 2**19
"""Room for the tables of one set of parameters: 4 MiB, two maps of 10,000 cells each."""

_FIRST = 64  # zeros, as in the bank: lanes without a table read from 0 on, and discard it
_EXACT = {"encoder.resolution": 0.0, "encoder.sde_amplitude": 0.0, "controller.delay": 1.0}
"""The position is read as it comes, and a command acts one period after it."""

_PLANT, _MODEL = (
    [parameter_row(f"{owner}.table.{field}") for field in TableMap._fields]
    for owner in ("force_map", "force_model.map")
)
_INVERSE, _OWN = (parameter_row(f"force_model.sharing.{name}") for name in ("inverse", "table"))


class LoopParameters(NamedTuple):
    """One set of parameters."""

    lanes: Array  # (PARAMETER_ROWS, WIDTH); even lanes are x, odd lanes y
    tabled: NDArray[np.int64]  # whether x, and y, needs the kernel with tables
    tables: Array  # at most TABLE_NUMBERS, which the lanes refer to


def loop_parameters(scenario: Scenario, lanes: Array) -> LoopParameters:
    """Return lane parameters as the loop takes them, for positions that have been measured.

    The tables of the controller's model and of its sharing function go with them. The plant's map
    is of the simulated machine: it is left out, and each axis is computed by the kernel that a
    simulation computes it by. Errors name fields of `scenario`, which is from `on_drives`.

    Raises
    ------
    ConfigError
        If the tables are too large for the loop, or a number is none.
    """
    tabled = np.array(reads_tables(lanes)[: len(AXES)], np.int64)
    lanes = lanes.copy()
    for path, value in _EXACT.items():
        lanes[parameter_row(path)] = value
    lanes[_PLANT] = np.array(ANALYTIC)[:, None]
    pieces: list[Array] = [np.zeros(_FIRST)]
    places: dict[float, int] = {}
    for axis, name in enumerate(AXES):
        for row, size in _tables(lanes[:, axis]):
            first = lanes[row, axis]
            # The axes share a table where their maps are the same: it goes along once.
            if first not in places:
                places[first] = sum(piece.size for piece in pieces)
                pieces.append(TABLES.values[int(first) : int(first) + size])
            lanes[row, axis::2] = places[first]
        if sum(piece.size for piece in pieces) > TABLE_NUMBERS:
            (variant,) = scenario.variants
            raise ConfigError(
                FieldError(
                    f"variants.{variant}.controller.model.{name}.force_map",
                    "its tables are too large for the drive loop",
                    sum(piece.size for piece in pieces),
                    bounds={"maximum": TABLE_NUMBERS},
                    unit="numbers",
                )
            )
    if np.isnan(lanes).any():
        raise ConfigError(FieldError("variants", "gives the controller a parameter that is NaN"))
    return LoopParameters(lanes, tabled, np.concatenate(pieces))


def _tables(lane: Array) -> list[tuple[int, int]]:
    """Return the rows of a lane that hold the place of a table, and the size of each."""
    model = TableMap(*lane[_MODEL].tolist())
    sizes = {
        _MODEL[0]: int(model.positions * model.currents) * THRUST_TERMS,
        _INVERSE: math.prod(INVERSE_CELLS),
        _OWN: sharing_table_size(lane),
    }
    return [(row, size) for row, size in sizes.items() if lane[row] >= 0.0]
