"""Fields of one phase by finite elements: closed form, symmetry, energy, and peaks."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.named_configs import config_root
from motionlab.motor_design.fem import compute as computing
from motionlab.motor_design.fem.circuit import circuit
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.field import FieldModel
from motionlab.motor_design.fem.gap_permeance import Cell
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.fem.mesh import Columns, Resolution, mover, stator
from motionlab.motor_design.fem.steel import MU_0, m19
from motionlab.motor_design.fem.uncertainty import uncertainty
from motionlab.motor_design.kept_maps import map_in
from tests.motor_design.carter import carter

GEOMETRY = Geometry()
COARSE = Resolution(24, 1)
SMALL = Geometry(n=1, limb=3e-3, coil=2.4e-3, g=0.5e-3, N=40, l_m=0.16)
"""A mover of few teeth, a wide gap and hardly saturated: fields are quick to find."""


@pytest.fixture(scope="module")
def model():
    return FieldModel(GEOMETRY, COARSE)


@pytest.fixture(scope="module")
def aside(model):
    """Return fields at 6 A, a quarter of a pitch to either side of the aligned position."""
    return model.at(6).solve(6.0), model.at(-6).solve(6.0)


@pytest.fixture(scope="module")
def small_map():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(computing, "CURRENTS", 3)
        return compute(SMALL, resolution=Resolution(16, 2), workers=1)


@pytest.mark.parametrize(("cells", "error"), [(24, 5e-3), (48, 3e-3)])
def test_the_permeance_of_a_cell_is_carters(cells, error):
    cell = Cell(GEOMETRY, Resolution(cells, 2), smooth_stator=True)
    # The mesh is stiffer than the field, never softer.
    assert 1 < cell.permeance(0) / carter(GEOMETRY) < 1 + error


def test_a_smooth_stator_has_no_positions():
    cell = Cell(GEOMETRY, COARSE, smooth_stator=True)
    assert cell.permeance(7) == pytest.approx(cell.permeance(0), rel=1e-4)


def test_a_cell_is_symmetric_and_largest_where_teeth_are_aligned():
    cell = Cell(GEOMETRY, COARSE)
    half = [cell.permeance(shift) for shift in range(13)]
    assert [cell.permeance(-shift) for shift in range(13)] == pytest.approx(half, rel=1e-12)
    assert np.all(np.diff(half) < 0)


@pytest.mark.parametrize(
    "geometry",
    [
        GEOMETRY,
        Geometry(p=3.3e-3),
        Geometry(n=1, tau=9e-3, p=5e-3, coil=1e-3, limb=4.9e-3),
        Geometry(n=4, limb=25e-3, coil=1.5e-3),
    ],
    ids=["paper", "narrow teeth", "one tooth a limb", "limbs almost as wide as shoes"],
)
def test_the_mesh_has_the_areas_of_the_geometry(geometry):
    g = geometry
    columns = Columns(g, COARSE)
    upper, lower = mover(g, columns), stator(g, columns)

    def area(half, region):
        corners = half.mesh.p[:, half.mesh.t[:, half.region == region]]
        (ax, ay), (bx, by) = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        return np.sum(np.abs(ax * by - ay * bx)) / 2

    iron = (
        2 * g.n * g.p * g.tooth_depth
        + 2 * g.shoe_width * g.shoe
        + 2 * g.limb * g.window
        + g.width * g.yoke
    )
    assert area(upper, 1) == pytest.approx(iron, rel=1e-9)
    assert area(upper, 4) == pytest.approx(2 * g.coil * g.window, rel=1e-9)
    assert area(upper, 5) == pytest.approx(2 * g.coil * g.window, rel=1e-9)
    assert area(lower, 1) == pytest.approx(columns.length * g.stator_back, rel=1e-9)
    teeth = columns.pitches * g.p * g.stator_tooth_depth
    assert area(lower, 2) == pytest.approx(teeth, rel=1e-9)
    assert area(lower, 0) == pytest.approx(columns.length * g.g / 2, rel=1e-9)


def test_steel_is_monotone_passes_its_data_and_is_saturated_above():
    b = np.linspace(0.0, 3.0, 3001)
    h = m19().field(b)
    assert np.all(np.diff(h) > 0)
    assert m19().field(np.array([0.05, 1.5, 2.3])) == pytest.approx(
        [15.120714, 1108.325569, 234024.751347]
    )
    assert np.diff(h[2400:]) == pytest.approx(1e-3 / MU_0, rel=1e-6)
    nu, slope = m19().reluctivity(b[1:])
    assert nu * b[1:] == pytest.approx(h[1:])
    middle = (b[1:] + b[:-1]) / 2
    assert m19().reluctivity(middle[1:])[1] == pytest.approx(np.diff(nu) / 1e-3, rel=0.05, abs=2)
    assert np.diff(m19().energy(b)) == pytest.approx(m19().field(middle) * 1e-3, rel=1e-3, abs=1e-4)
    assert slope.shape == nu.shape


def test_thrust_vanishes_where_teeth_are_aligned_and_unaligned(model):
    for shift in (0, 12):
        position = model.at(shift)
        for current in (2.0, 10.0):
            assert abs(position.solve(current).thrust) < 0.02


def test_the_other_side_is_the_mirror_image(aside):
    here, there = aside
    assert there.thrust == pytest.approx(-here.thrust, rel=1e-6)
    assert there[:2] == pytest.approx(here[:2], rel=1e-9)
    assert there.normal_force == pytest.approx(here.normal_force, rel=1e-6)


def test_a_pitch_further_on_is_the_same(model, aside):
    assert model.at(6 - 24).solve(6.0) == pytest.approx(aside[0], rel=1e-6)


def test_the_peaks_at_10_A_are_those_expected(model):
    thrusts = [model.at(-shift).solve(10.0).thrust for shift in (6, 7, 8)]
    assert max(thrusts) == pytest.approx(38.8, rel=0.05)
    assert model.at(0).solve(10.0).normal_force == pytest.approx(415, rel=0.05)


def test_thrust_pulls_towards_the_aligned_position(aside):
    assert aside[0].thrust < -10
    assert aside[1].thrust > 10


def test_a_field_does_not_depend_on_the_currents_before(model):
    straight = model.at(6).solve(8.0)
    position = model.at(6)
    for current in (3.0, 10.0, 8.0):
        stepped = position.solve(current)
    assert stepped == pytest.approx(straight, rel=1e-5)


def test_the_linkage_is_the_slope_of_the_coenergy(model):
    position = model.at(4)
    below, at, above = (position.solve(current) for current in (5.9, 6.0, 6.1))
    assert (above.coenergy - below.coenergy) / 0.2 == pytest.approx(at.linkage, rel=1e-4)


def test_linear_fields_grow_with_the_square_of_the_current(model):
    position = model.at(6)  # below the knee steel hardly matters
    one, two = position.solve(1.0), position.solve(2.0)
    assert two.coenergy / one.coenergy == pytest.approx(4, rel=0.02)


def test_quadratic_elements_agree_with_linear_ones(model):
    fine = FieldModel(GEOMETRY, Resolution(24, 2)).at(-6).solve(4.0)
    coarse = model.at(-6).solve(4.0)
    assert fine.thrust == pytest.approx(coarse.thrust, rel=0.05)
    assert fine.coenergy == pytest.approx(coarse.coenergy, rel=0.03)


def test_the_splines_thrust_is_the_stress_tensors(small_map):
    d = small_map.document
    x, i = np.array(d.positions)[:, None], np.array(d.currents)[None, :]
    assert np.max(np.abs(d.thrust)) > 6
    assert np.max(np.abs(small_map.thrust(x, i) - d.thrust)) < 0.03  # 0.1 of 38 N


@pytest.mark.parametrize("name", ["new-design", "previous-design"])
def test_thrust_of_a_shipped_map_is_the_stress_tensors(name):
    shipped = map_in(config_root() / "maps" / f"{name}.json", name)
    d = shipped.document
    x, i = np.array(d.positions)[:, None], np.array(d.currents)[None, :]
    off = shipped.thrust(x, i) - d.thrust
    assert np.max(np.abs(d.thrust)) > 20
    assert np.max(np.abs(off)) < 0.1
    assert np.sqrt(np.mean(off**2)) < 0.03
    ends = np.array(d.thrust)[[0, len(x) // 2, -1]]
    assert np.max(np.abs(ends)) < 0.02


def test_the_cells_forces_are_slopes_of_their_coenergy(small_map):
    x, i = np.linspace(-4.4e-3, 4.4e-3, 37)[:, None], np.linspace(0.05, 9.95, 21)[None, :]
    h, k = 1e-8, 1e-5
    slope_x = small_map.coenergy(x + h, i) - small_map.coenergy(x - h, i)
    slope_i = small_map.coenergy(x, i + k) - small_map.coenergy(x, i - k)
    assert slope_x / (2 * h) == pytest.approx(small_map.thrust(x, i), abs=2e-4)
    assert slope_i / (2 * k) == pytest.approx(small_map.linkage(x, i), abs=1e-8)


def test_coenergy_grows_with_current_everywhere(small_map):
    x, i = np.linspace(-4e-3, 4e-3, 81)[:, None], np.linspace(0, 10, 101)[None, :]
    assert np.all(np.diff(small_map.coenergy(x, i), axis=1) > 0)
    assert np.all(small_map.coenergy(x, np.zeros_like(x)) == pytest.approx(0, abs=1e-12))


def test_thrust_does_no_work_over_a_pitch(small_map):
    x = np.linspace(0.0, small_map.tau, 4001)
    assert np.trapezoid(small_map.thrust(x, 10.0), x) == pytest.approx(0, abs=1e-8)


def test_a_circuit_is_near_finite_elements(model):
    finite = [model.at(shift).solve(2.0) for shift in (0, 12)]
    found = circuit(GEOMETRY, np.array([0.0, 3.6e-3]), np.array([0.0, 1.0, 2.0]))
    for row, solution in zip(found[:, 2], finite, strict=True):
        assert row[1] == pytest.approx(solution.linkage, rel=0.3)
        assert row[2] == pytest.approx(0, abs=1e-3)


@pytest.mark.parametrize(
    ("change", "shifts"),
    [
        ({}, [8]),
        ({"p": 2.16e-3}, [8, 12]),
        ({"p": 2.88e-3}, [10]),
        ({"g": 0.1e-3}, [10, 0]),
    ],
)
def test_a_circuit_is_as_near_finite_elements_as_it_says(change, shifts):
    geometry = GEOMETRY.model_copy(update=change)
    x, i = np.linspace(0.0, geometry.tau / 2, 13), np.linspace(0.0, 10.0, 11)
    by_circuit, by_fields = circuit(geometry, x, i), FieldModel(geometry, COARSE)
    said = uncertainty("preview", geometry)
    for shift in shifts:
        finite = by_fields.at(shift).solve(10.0)
        thrust, normal = by_circuit[shift, -1, 2:]
        assert abs(finite.thrust - thrust) <= said.thrust * abs(thrust) + 0.1
        assert abs(finite.normal_force - normal) <= said.normal_force * normal
