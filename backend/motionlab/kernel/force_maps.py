"""Force maps of lanes: from a config to the numbers that the kernel reads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.controller import SharingConfig
from motionlab.config.force_map import AnyForceMapConfig, ForceMapConfig, TableMapConfig
from motionlab.config.planar import AXES
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.force_sharing.functions import FUNCTIONS, SharingParameters, function_number
from motionlab.force_sharing.share import ForceModel, Sharing
from motionlab.force_sharing.tables import inverse_cells
from motionlab.lanes.bank import TABLES
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.kept_maps import named_map
from motionlab.plant.magnetics import AnalyticMap
from motionlab.plant.table_map import ANALYTIC, MotorMap, TableMap, normal_cells, thrust_cells

Array = NDArray[np.float64]


def pole_pitch(config: AnyForceMapConfig) -> float:
    """Return the pole pitch of a map of either kind, m.

    Raises
    ------
    ConfigError
        If no map of that name is there, or it cannot be read.
    """
    return config.tau if isinstance(config, ForceMapConfig) else named_map(config.name).tau


def map_lanes(config: AnyForceMapConfig) -> MotorMap:
    """Return the lane parameters of a force map of either kind.

    Raises
    ------
    ConfigError
        If no map of that name is there, or it cannot be read.
    """
    match config:
        case ForceMapConfig():
            return MotorMap(AnalyticMap(**config.model_dump(exclude={"kind"})), ANALYTIC)
        case TableMapConfig():
            force_map = named_map(config.name)
            # The formula beside a table is computed but not used: any numbers without a 0/0 do.
            formula = AnalyticMap(
                force_map.tau, config.offset, 1.0, 0.0, force_map.i_max, force_map.i_max, 0, 0
            )
            return MotorMap(formula, _table(force_map, config.gain))


def force_model(
    config: AnyForceMapConfig, sharing: SharingConfig, current_limit: float
) -> ForceModel:
    """Return the lane parameters of a controller's map, sharing function and current limit, A.

    Raises
    ------
    ConfigError
        If no map of that name is there, or it cannot be read.
    """
    closed = Sharing(function_number(sharing.law), -1.0, -1.0, current_limit)
    model = ForceModel(map_lanes(config), closed, SharingParameters(**sharing.parameters()))
    if isinstance(config, ForceMapConfig):
        return model
    force_map = named_map(config.name)

    def thrust(turns: Array, i: Array) -> Array:
        return force_map.thrust((turns - 0.5) * force_map.tau, i)

    digest, i_max = force_map.digest, force_map.i_max
    inverse = TABLES.place((digest, "inverse"), lambda: inverse_cells(thrust, i_max))
    own, table = FUNCTIONS[sharing.law].table, -1
    if own is not None:
        table = TABLES.place((digest, sharing.law), lambda: own.numbers(thrust, i_max))
    return model._replace(sharing=closed._replace(inverse=float(inverse), table=float(table)))


def check_maps(scenario: Scenario) -> None:
    """Refuse force maps that are not there, and currents that a table does not reach.

    Raises
    ------
    ConfigError
        Naming the first map that cannot be used, else every current that is too large.
    """
    errors: list[FieldError] = []
    for loc, config in _tables(scenario):
        force_map = named_map(config.name, loc)
        owner = loc.split(".model.")[0]
        if owner == loc:
            axis = getattr(scenario.plant, loc.split(".")[1])
            field, limit = loc.replace("force_map", "amplifiers.limit"), axis.amplifiers.limit
        else:
            controller = scenario.variants[loc.split(".")[1]].controller
            field, limit = f"{owner}.current_limit", controller.current_limit
        if limit > force_map.i_max * (1.0 + 1e-9):
            errors.append(
                FieldError(
                    loc=field,
                    message=f"is more than force map {config.name!r} reaches",
                    value=limit,
                    bounds={"maximum": force_map.i_max},
                    unit="A",
                )
            )
    if errors:
        raise ConfigError(*errors)


def maps_of(scenario: Scenario) -> dict[str, dict[str, Any]]:
    """Return which tables a scenario uses, by field: name and hashes, for the record of a run."""
    return {
        loc: {
            "name": config.name,
            "content_hash": named_map(config.name).document.content_hash,
            "digest": named_map(config.name).digest,
        }
        for loc, config in _tables(scenario)
    }


def map_digests(epochs: Iterable[tuple[int, Scenario]]) -> tuple[str, ...]:
    """Return the hashes of the tables that some scenarios use, in their order.

    A map's file may change under its name: cached results of a scenario are valid for these hashes
    only.

    Raises
    ------
    ConfigError
        If no map of a name is there, or it cannot be read.
    """
    return tuple(
        named_map(config.name, loc).digest
        for _, scenario in epochs
        for loc, config in _tables(scenario)
    )


def _tables(scenario: Scenario) -> Iterator[tuple[str, TableMapConfig]]:
    for axis in AXES:
        config = getattr(scenario.plant, axis).force_map
        if isinstance(config, TableMapConfig):
            yield f"plant.{axis}.force_map", config
    for name, variant in scenario.variants.items():
        for axis in AXES:
            config = getattr(variant.controller.model, axis).force_map
            if isinstance(config, TableMapConfig):
                yield f"variants.{name}.controller.model.{axis}.force_map", config


def _table(force_map: ForceMap, gain: float) -> TableMap:
    positions, currents = (
        len(force_map.document.positions) - 1,
        len(force_map.document.currents) - 1,
    )
    dx, di = force_map.tau / positions, force_map.i_max / currents
    digest = force_map.digest
    thrust = TABLES.place((digest, "thrust"), lambda: thrust_cells(force_map.hermite(), dx, di))
    normal = TABLES.place(
        (digest, "normal"), lambda: normal_cells(force_map.hermite("normal_force"), dx, di)
    )
    return TableMap(float(thrust), float(normal), positions, currents, 1.0 / di, gain)
