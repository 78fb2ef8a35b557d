"""Fields of a controller whose values a report's page copies into parameters of lanes."""

from __future__ import annotations

import operator
from typing import Any, NamedTuple

import numpy as np

from motionlab.config.controller import ControllerConfig, GainsConfig
from motionlab.config.fields import fields_of
from motionlab.config.planar import AXES
from motionlab.kernel.build import mover_parameters
from motionlab.kernel.layout import parameter_row
from motionlab.lanes.bank import TABLES
from motionlab.simulation.prepare import Prepared

SWITCHES = {
    "compensation.enabled": "compensation",
    "feedforward": "feedforward",
    "disturbance_observer.enabled": "disturbance observer",
}
"""Switches of a controller, as people read them."""

_GAINS = {
    name: (parameter_row(f"controller.{name}"), entry.bounds or {})
    for name, entry in fields_of(GainsConfig).items()
    if name in {"k_p", "k_d"}
}
"""Rows and ranges of fields that are lane parameters as they are, and that no other check reads."""


class Switch(NamedTuple):
    """A switch of a variant's controller.

    Attributes
    ----------
    name : str
        As people read it.
    on : bool
        That of the run.
    values : dict
        Of each parameter of lanes that it changes, the value where it is off, and where it is on.
    """

    name: str
    on: bool
    values: dict[str, tuple[float, float]]


def copied_gains(prepared: Prepared) -> dict[str, dict[str, Any]]:
    """Return the gains, by dotted path, that a change of copies into a row of lane parameters.

    Those that a schedule sets are left out.
    """
    scheduled = [path for event in prepared.scenario.schedule for path in event.set]
    paths = {
        f"variants.{variant}.controller.{axis}.{name}": {
            "variant": number,
            "axis": axis,
            "row": row,
            **bounds,
        }
        for number, variant in enumerate(prepared.scenario.variants)
        for axis in AXES
        for name, (row, bounds) in _GAINS.items()
    }
    return {
        path: place
        for path, place in paths.items()
        if not any(path == other or path.startswith(f"{other}.") for other in scheduled)
    }


def copied_switches(prepared: Prepared) -> tuple[dict[str, list[Switch]], dict[str, Any]]:
    """Return the switches of each variant, and what they change in the form of `copied_gains`.

    A schedule may change what a switch does, so there are none with one.
    """
    scenario = prepared.scenario
    switches: dict[str, list[Switch]] = {name: [] for name in scenario.variants}
    copies: dict[str, Any] = {}
    for index, (variant, each) in enumerate(scenario.variants.items()):
        for path, name in () if scenario.schedule else SWITCHES.items():
            with TABLES.lease():
                off, on = (
                    np.array(
                        mover_parameters(scenario, _switched(each.controller, path, value=value))
                    )
                    for value in (False, True)
                )
            values = {}
            for axis, row in np.argwhere(off != on).tolist():
                ends = (float(off[axis, row]), float(on[axis, row]))
                key = f"variants.{variant}.controller.{path} {AXES[axis]} {row}"
                values[key] = ends
                copies[key] = {
                    "variant": index,
                    "axis": AXES[axis],
                    "row": row,
                    "minimum": min(ends),
                    "maximum": max(ends),
                }
            if values:
                is_on = operator.attrgetter(path)(each.controller)
                switches[variant].append(Switch(name, is_on, values))
    return switches, copies


def _switched(controller: ControllerConfig, path: str, *, value: bool) -> ControllerConfig:
    """Return a controller with a switch on or off."""
    table, _, name = path.rpartition(".")
    if not table:
        return controller.model_copy(update={name: value})
    inner = getattr(controller, table).model_copy(update={name: value})
    return controller.model_copy(update={table: inner})
