"""Plates against Timoshenko's tables, ribs against beams, gaps in balance with forces."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.errors import ConfigError
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.fem.geometry import Geometry
from motionlab.motor_design.platform.bending import Plate
from motionlab.motor_design.platform.gap import closing, ratio
from motionlab.motor_design.platform.inputs import Load, read_platform_request
from motionlab.motor_design.platform.ribs import rib
from tests.motor_design.textbook_plates import (
    POINT,
    TEXTBOOK,
    THICKNESS,
    E,
    coefficient,
    flat,
)


@pytest.mark.parametrize("case", TEXTBOOK)
def test_a_plate_bends_as_the_textbook_says(case):
    support, longer, load, expected = TEXTBOOK[case]
    assert coefficient(support, longer, load) == pytest.approx(expected, rel=5e-3)


def test_the_elements_converge():
    # Navier's and Levy's series, summed; a point load has no fourth derivative
    for load, exact, order in (("uniform", 0.004062353, 4), ("point", 0.011600840, 2)):
        errors = [abs(coefficient("edges", 1, load, cells=n) - exact) for n in (4, 8, 16)]
        orders = np.log2(np.array(errors[:-1]) / errors[1:])
        assert orders == pytest.approx(order, abs=0.35)


def test_deflection_falls_with_the_cube_of_the_thickness():
    thin, thick = (Plate(flat(thickness=t), POINT, cells=8).compliance for t in (5e-3, 10e-3))
    assert thin == pytest.approx(8 * thick, rel=1e-6)


def test_what_one_mover_does_to_another_it_does_back():
    request = read_platform_request({})
    compliance = Plate(request.new, request.load, cells=8).compliance
    assert compliance == pytest.approx(compliance.T, rel=1e-6)
    assert np.all(np.linalg.eigvalsh(compliance) > 0)


def test_a_ribs_inertia_is_that_of_a_tee():
    shape = flat(length=0.4, width=0.05, rib_width=6e-3, rib_height=20e-3, ribs_x=1)
    w, h, t, b = 6e-3, 20e-3, THICKNESS, 0.05
    areas, middles = np.array([b * t, w * h]), np.array([0.0, (t + h) / 2])
    axis = np.sum(areas * middles) / np.sum(areas)
    own = np.array([b * t**3, w * h**3]) / 12
    tee = np.sum(own + areas * (middles - axis) ** 2)
    found = rib(shape, 1, along=0.4, across=0.05)
    assert found.bending == pytest.approx(E * (tee - own[0]), rel=1e-12)
    assert found.places == (0.0,)


def test_a_narrow_ribbed_plate_is_a_beam():
    # along y, between two lines of support; no lateral contraction
    length, b, w, h = 0.5, 0.04, 8e-3, 24e-3
    shape = flat(
        length=b,
        width=length,
        nu=0.0,
        ribs_y=1,
        rib_width=w,
        rib_height=h,
        support="guides",
        span_y=length,
    )
    load = Load(length=b, width=length, spacing_x=0, spacing_y=0, forces=(25, 25, 25, 25))
    surface = Plate(shape, load, cells=32).surface(np.array(load.forces))
    stiffness = E * b * THICKNESS**3 / 12 + rib(shape, 1, along=length, across=b).bending
    expected = 5 * (100 / length) * length**4 / (384 * stiffness)
    middle = float(surface.at(np.zeros(1), np.zeros(1))[0, 0])
    assert middle == pytest.approx(expected, rel=0.01)


def test_ribs_stiffen_and_lie_where_they_should():
    request = read_platform_request({})
    forces = np.array(request.load.forces)
    largest = []
    for height in (0.0, 10e-3, 30e-3):
        shape = request.new.model_copy(update={"rib_height": height})
        found = Plate(shape, request.load, cells=8).surface(forces).unknowns[0]
        assert found == pytest.approx(found[::-1], rel=1e-6, abs=1e-12)
        assert found == pytest.approx(found[:, ::-1], rel=1e-6, abs=1e-12)
        largest.append(found.max())
    assert largest[0] > 1.1 * largest[1] > 2 * largest[2]


def test_the_picture_passes_through_the_nodes():
    request = read_platform_request({"axis": "x"})
    surface = Plate(request.new, request.load, cells=8).surface(np.array(request.load.forces))
    assert surface.at(surface.x, surface.y) == pytest.approx(surface.unknowns[0], abs=1e-15)


@pytest.fixture(scope="module")
def force_map() -> ForceMap:
    return compute(Geometry(), "preview")


def test_forces_and_gaps_are_in_balance(force_map):
    request = read_platform_request({})
    plate, grows = Plate(request.new, request.load, cells=8), ratio(Geometry(), 0.0, 10.0)
    assert np.polyval(grows.normal, 0.0) == pytest.approx(1.0)
    found = closing(plate, force_map, grows, position=0.0, current=10.0, name="new")
    assert found.closed == pytest.approx(plate.compliance @ found.forces, abs=1e-11)
    # A map of the gap that is left pulls as hard.
    left = Geometry(g=0.3e-3 - float(found.closed.mean()))
    again = compute(left, "preview").normal_force(0.0, 10.0)
    assert found.forces.mean() == pytest.approx(float(again), rel=5e-3)
    assert found.forces.mean() > 1.02 * float(force_map.normal_force(0.0, 10.0))
    assert found.steps < 60


def test_a_platform_that_the_movers_pull_down_is_refused(force_map):
    request = read_platform_request({"new": {"thickness": 8e-3, "rib_height": 0.0}})
    plate, grows = Plate(request.new, request.load, cells=8), ratio(Geometry(), 0.0, 10.0)
    with pytest.raises(ConfigError, match=r"too soft.*<= 0\.00015 m"):
        closing(plate, force_map, grows, position=0.0, current=10.0, name="new")
