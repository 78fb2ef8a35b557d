"""What a force-sharing function declares, and what it may know.

A sharing function is one module of this folder: a name, its source, parameters with unit, range and
default, and one function of lanes that splits a force command among the phases. Everything else
comes from here: fields of a config, schema, sliders, the study of sharing, rows of the kernel,
exported C, and the kernel in the page.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from motionlab.declarations import OURS, PAPER, Parameter
from motionlab.lanes import Lanes, Mask
from motionlab.plant.magnetics import AnalyticMap, Phases

Array = NDArray[np.float64]

__all__ = ["OURS", "PAPER", "Demand", "Parameter", "Phase", "Share", "SharingFunction", "Table"]

TINY = 1e-30
"""In place of a sum of zero, by which shares are divided."""


class Phase(NamedTuple):
    """Capability of one phase in the commanded direction."""

    turns: Lanes  # where it stands in its pole pitch, 0 to 1
    x: Lanes  # analytic shape, 0 where it pulls the other way
    most: Lanes  # thrust at the current limit, N
    whole: Lanes  # thrust at the largest current of the map, N


class Demand(NamedTuple):
    """What a sharing function may know of a force command, of each lane."""

    magnitude: Lanes  # of the command, N
    forward: Mask  # whether the command is positive
    a: Phase
    b: Phase
    c: Phase
    tabled: Mask  # whether the map is a table; if so, `formula` and the shapes mean nothing
    formula: AnalyticMap  # the controller's map
    table: Lanes  # first number of the function's own table among all tables; -1: none


class Share(NamedTuple):
    """Current commands and realised force of one axis."""

    current: Phases  # current commands, A
    force: Lanes  # force that these currents give on the controller's map, N
    limited: Mask  # some phase is at its current limit


@dataclass(frozen=True)
class Table:
    """Numbers that a sharing function reads where the controller's map is a table.

    Attributes
    ----------
    shape : tuple of int
        Of the array.
    about : str
        Quantity, unit and axes, as in exported C.
    numbers : callable
        ``numbers(thrust, i_max)``: the array, from the thrust of one phase, N, over turns of its
        pole pitch and current, A, and from the map's largest current.
    """

    shape: tuple[int, ...]
    about: str
    numbers: Callable[[Callable[[Array, Array], Array], float], Array]


@dataclass(frozen=True)
class SharingFunction:
    """A force-sharing function.

    Attributes
    ----------
    name, label, description, source : str
        Name in configs, name on the screen, what it is in a sentence, where it comes from.
    shares : callable
        ``shares(par, demand, tables) -> Phases``, a function of lanes: the part of the command that
        each phase is to give. `par` has the parameters by name.
    parameters : tuple of Parameter
        Numbers among the fields of the config.
    passes_on : bool
        Whether the other phases give what one cannot.
    table : Table, optional
        Its own table.
    closed : callable, optional
        ``closed(force_map, current_limit, position, force) -> Share`` of lanes: all of the sharing
        on an analytic map, which lanes without tables run. One function has it.
    """

    name: str
    label: str
    description: str
    source: str
    shares: Callable[[Any, Demand, Array], Phases]
    parameters: tuple[Parameter, ...] = ()
    passes_on: bool = False
    table: Table | None = None
    closed: Callable[[AnalyticMap, Lanes, Lanes, Lanes], Share] | None = None
