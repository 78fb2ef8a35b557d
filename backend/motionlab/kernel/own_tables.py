"""The tables that some lanes read, apart from all others of the process."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.force_sharing.functions import function_of
from motionlab.force_sharing.tables import INVERSE_CELLS
from motionlab.kernel.layout import parameter_row
from motionlab.lanes.bank import TABLES
from motionlab.plant.table_map import NORMAL_TERMS, THRUST_TERMS

Array = NDArray[np.float64]

_UNREAD = 64
"""Zeros before the first table, as in the bank: lanes without a table read them."""


class OwnTables(NamedTuple):
    """Tables that some lanes read.

    Attributes
    ----------
    lanes : ndarray, shape (epochs, variants, PARAMETER_ROWS, 2)
        The lanes, with places that count from the first number of these tables alone.
    spans : tuple of (int, int)
        First number of each table among all tables of the process, and how many it has.
    """

    lanes: Array
    spans: tuple[tuple[int, int], ...]

    def numbers(self) -> Array:
        """Return the tables one after another; empty where no lane reads one."""
        parts = [TABLES.values[first : first + size] for first, size in self.spans]
        return np.concatenate([np.zeros(_UNREAD), *parts]) if parts else np.empty(0)

    @property
    def sizes(self) -> tuple[int, ...]:
        """Numbers of each table, in the order in which the lanes name them."""
        return tuple(size for _, size in self.spans)


def own_tables(lanes: Array) -> OwnTables:
    """Return the tables that lanes read; valid within the lease that placed them.

    Parameters
    ----------
    lanes : ndarray, shape (epochs, variants, PARAMETER_ROWS, 2)
        Lane parameters.
    """
    moved = lanes.copy()
    spans: list[tuple[int, int]] = []
    places: dict[float, int] = {}
    end = _UNREAD
    for row, size_of in _SIZES:
        there = lanes[..., row, :]
        for place in dict.fromkeys(there[there >= 0.0].tolist()):
            if place not in places:
                epoch, variant, axis = np.argwhere(there == place)[0]
                size = size_of(lanes[epoch, variant, :, axis])
                spans.append((int(place), size))
                places[place] = end
                end += size
            moved[..., row, :][there == place] = places[place]
    return OwnTables(moved, tuple(spans))


def _cells(table: str, terms: int) -> Callable[[Array], int]:
    """Return what gives the size of a map's table from the parameters of a lane."""
    rows = [parameter_row(f"{table}.{name}") for name in ("positions", "currents")]

    def size(lane: Array) -> int:
        positions, currents = (int(lane[row]) for row in rows)
        return positions * currents * terms

    return size


def sharing_table_size(lane: Array) -> int:
    """Return how many numbers the own table of a lane's sharing function has."""
    table = function_of(lane[parameter_row("force_model.sharing.law")]).table
    return 0 if table is None else math.prod(table.shape)


_SIZES: tuple[tuple[int, Callable[[Array], int]], ...] = (
    *(
        (parameter_row(f"{table}.{force}"), _cells(table, terms))
        for table in ("force_map.table", "force_model.map.table")
        for force, terms in (("thrust", THRUST_TERMS), ("normal", NORMAL_TERMS))
    ),
    (parameter_row("force_model.sharing.inverse"), lambda _: math.prod(INVERSE_CELLS)),
    (parameter_row("force_model.sharing.table"), sharing_table_size),
)
"""Rows of places of tables, each with the size of its table."""
