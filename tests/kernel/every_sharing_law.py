"""Eight lanes that between them use every force-sharing function, on tables and on formulas."""

from __future__ import annotations

from motionlab.config.controller import SharingConfig, SharingLaw
from motionlab.config.force_map import TableMapConfig
from motionlab.force_sharing.functions import function_number
from motionlab.kernel.force_maps import force_model, map_lanes
from motionlab.kernel.layout import Parameters
from tests.kernel.lane_runs import changed, lane
from tests.nominal_motor import X, Y

NEW = TableMapConfig(name="new-design", offset=3e-5)
PREVIOUS = TableMapConfig(name="previous-design", gain=0.97)


def with_plant(parameters: Parameters, config: TableMapConfig) -> Parameters:
    """Return a lane whose plant has a table."""
    return parameters._replace(force_map=map_lanes(config))


def with_model(parameters: Parameters, config: TableMapConfig, law: SharingLaw) -> Parameters:
    """Return a lane whose controller has a table and shares its force by a law."""
    limit = parameters.force_model.sharing.current_limit
    return parameters._replace(force_model=force_model(config, SharingConfig(law=law), limit))


def with_law(parameters: Parameters, law: SharingLaw) -> Parameters:
    """Return a lane that shares its force by a law on the analytic map."""
    return changed(parameters, {"force_model.sharing.law": function_number(law)})


def table_lanes(resolution: float) -> list[Parameters]:
    """Return eight different lanes, none of which is plain; even ones are x, odd ones y."""
    x, y = (lane(axis, "lugre-observer", {"encoder.resolution": resolution}) for axis in (X, Y))
    return [
        with_plant(x, NEW),
        with_model(y, NEW, "least-norm"),
        with_model(with_plant(x, PREVIOUS), PREVIOUS, "force-per-ampere"),
        with_model(with_plant(y, NEW), NEW, "sine"),
        with_law(x, "force-per-ampere"),
        with_law(y, "least-normal-force"),
        with_law(with_plant(x, NEW), "cubic"),
        with_model(y, PREVIOUS, "least-normal-force"),
    ]
