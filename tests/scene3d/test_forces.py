"""Arrows and section: each equals what the recorded channels say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.scene3d import arrows, protocol, section
from motionlab.scene3d.cameras import camera_of, stage_offsets
from motionlab.scene3d.geometry import Layout
from motionlab.scene3d.pose import DrawnVariant
from motionlab.scene3d.section import Section
from motionlab.scene3d.section_view import section_arrows
from motionlab.scene3d.stage_view import phase_arrows, phase_starts
from motionlab.scene3d.view_settings import CAMERAS, ViewSettings
from motionlab.service.view3d.phase_forces import PhaseForces
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

PITCH = 7.2e-3
AXES = (protocol.DrawnAxis(0.085, PITCH, 0.0), protocol.DrawnAxis(0.145, PITCH, 0.4e-3))
START = protocol.SceneDescription("lab://x", AXES, {"A": "", "B": ""}, [])


@pytest.fixture(scope="module")
def recording():
    changes = {"trajectory": {"kind": "circle", "radius": 0.015, "frequency": 2.0, "laps": 1}}
    return run(prepare(load_scenario("circle", changes))).recording


@pytest.fixture(scope="module")
def drawn(recording) -> DrawnVariant:
    """Variant B at a moment at which everything moves."""
    columns = recording.columns
    names = protocol.column_names(["A", "B"])
    pose = np.array([columns[name][411] for name in names], np.float32)
    position, currents = protocol.positions_and_currents(pose)
    forces = PhaseForces(load_scenario("circle").plant).at(position, currents)
    return DrawnVariant(pose, 1, forces.astype(np.float32))


def test_forces_of_phases_add_up_to_the_channels(recording, drawn) -> None:
    for a, axis in enumerate("xy"):
        thrust = recording.columns[f"B.{axis}.thrust"][411]
        normal = recording.columns[f"B.{axis}.normal_force"][411]
        assert drawn.phase_thrust[a].sum() == pytest.approx(thrust, rel=1e-4, abs=1e-4)
        assert drawn.phase_normal[a].sum() == pytest.approx(normal, rel=1e-4)
        assert np.ptp(drawn.phase_thrust[a]) > 0.1
