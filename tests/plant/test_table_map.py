"""Force maps as tables: the kernel's lookup against the spline, the inverse, and its round trip."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.controller import SharingConfig, SharingLaw
from motionlab.config.force_map import TableMapConfig
from motionlab.force_sharing.functions import FUNCTIONS
from motionlab.force_sharing.pole_pitch import Shared, forces_over, share_over
from motionlab.kernel.force_maps import force_model, map_lanes
from motionlab.lanes import WIDTH
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.workers import FieldTask, fields
from motionlab.motor_design.kept_maps import named_map

Array = NDArray[np.float64]
NAMES = ("new-design", "previous-design")
ROUND_TRIP = 0.15
"""N: what a force may differ from the one that its current was looked up for."""


@pytest.fixture(params=NAMES)
def config(request: pytest.FixtureRequest) -> TableMapConfig:
    return TableMapConfig(name=request.param, offset=1.3e-4)


def share(config: TableMapConfig, law: SharingLaw, position: Array, force: Array | float) -> Shared:
    model = force_model(config, SharingConfig(law=law), 10.0)
    return share_over(model, position=position, force=force)


def test_forces_are_those_of_the_spline(config: TableMapConfig) -> None:
    random = np.random.Generator(np.random.Philox(1))
    position = random.uniform(-0.1, 0.1, 500)
    current = random.uniform(0.0, 10.0, (3, 500))
    force_map, found = named_map(config.name), map_lanes(config)
    x = position + config.offset - force_map.tau / 2 - np.arange(3)[:, None] * force_map.tau / 3
    forces = forces_over(found, position=position, current=current)
    thrust = force_map.thrust(x, current).sum(axis=0)
    normal = force_map.normal_force(x, current).sum(axis=0)
    assert forces.thrust == pytest.approx(thrust, abs=1e-8)
    assert forces.normal == pytest.approx(normal, abs=1e-8)


def test_a_current_counts_by_its_magnitude(config: TableMapConfig) -> None:
    found, place = map_lanes(config), np.linspace(0.0, 0.01, WIDTH)
    current = np.linspace(0.5, 3.0, 3 * WIDTH).reshape(3, WIDTH)
    there, back = (forces_over(found, position=place, current=i) for i in (current, -current))
    assert (there.thrust == back.thrust).all()


def test_nan_stays_nan_and_reads_nothing_that_is_not_there(config: TableMapConfig) -> None:
    found = map_lanes(config)
    place = np.array([np.nan, 0.0, np.inf, 1e300])
    current = np.full((3, 4), 2.0)
    current[0, 1] = np.nan
    forces = forces_over(found, position=place, current=current)
    assert np.isnan(forces.thrust[:3]).all()


@pytest.mark.parametrize("law", FUNCTIONS)
@pytest.mark.parametrize("force", [0.05, 0.5, 5.0, 20.0, -20.0, 26.0])
def test_inverse_round_trip(config: TableMapConfig, law: SharingLaw, force: float) -> None:
    """Not between the nodes of some table alone: positions are of no grid."""
    position = np.linspace(0.0, 0.009, 4001)
    shared = share(config, law, position, force)
    free = ~shared.limited
    assert free.mean() > 0.6
    # The narrow rise of the last one begins between two nodes.
    least = 0.007 if law == "least-normal-force" else 0.002
    assert np.abs(shared.force - force)[free].max() < min(ROUND_TRIP, 0.02 * abs(force) + least)
    found = map_lanes(config)
    given = forces_over(found, position=position, current=shared.current)
    assert shared.force == pytest.approx(given.thrust, abs=1e-9)
    assert shared.current.min() >= 0.0
    assert shared.current.max() <= 10.0


def test_a_shipped_map_is_what_its_command_computes() -> None:
    """Its position of most thrust, solved again on the preset's mesh."""
    document = named_map("new-design").document
    currents = np.array([0.0, 5.0, 10.0])
    (found,) = fields(
        FieldTask(document.geometry, Resolution(24, 2), currents, [7]), workers=1, progress=None
    )
    row = int(np.abs(np.array(document.positions) - 7 / 24 * document.geometry.tau).argmin())
    columns = [0, 5, 10]
    tables = (document.coenergy, document.linkage, document.thrust, document.normal_force)
    shipped = np.array([[table[row][column] for table in tables] for column in columns])
    assert found == pytest.approx(shipped, rel=1e-6, abs=1e-9)
