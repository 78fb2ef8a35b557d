"""Arrows and section: each equals what the recorded channels say."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.scene3d import arrows, protocol, section
from motionlab.scene3d.cameras import Camera, camera_of, label_place, stage_offsets
from motionlab.scene3d.drawn_variant import DrawnVariant
from motionlab.scene3d.geometry import TOP, Layout
from motionlab.scene3d.section import Section
from motionlab.scene3d.section_view import section_arrows
from motionlab.scene3d.stage_view import phase_arrows, phase_starts
from motionlab.scene3d.view_settings import CAMERAS, ViewSettings
from motionlab.server.view3d.phase_forces import PhaseForces
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run

PITCH = 7.2e-3
AXES = (protocol.DrawnAxis(0.085, PITCH, 0.0), protocol.DrawnAxis(0.145, PITCH, 0.4e-3))
START = protocol.SceneDescription("lab://x", AXES, {"A": "", "B": ""}, [])


TICK = 1411


@pytest.fixture(scope="module")
def channels() -> dict[str, float]:
    """Every column of variant B at a moment at which both axes move."""
    recording = run(prepare(load_scenario("circle")), stop=TICK + 1)
    b = recording.variants["B"]
    return {
        f"B.{axis}.{name}": float(b.channel(name, axis)[TICK])
        for axis in "xy"
        for name in (*protocol.OWN, *protocol.CURRENTS, "normal_force")
    }


@pytest.fixture(scope="module")
def drawn(channels: dict[str, float]) -> DrawnVariant:
    pose = np.array([channels.get(n, 0.0) for n in protocol.column_names(["A", "B"])], np.float32)
    position, currents = protocol.positions_and_currents(pose)
    forces = PhaseForces(load_scenario("circle").plant).at(position, currents)
    return DrawnVariant(pose, 1, forces.astype(np.float32))


def test_forces_of_phases_add_up_to_the_channels(
    channels: dict[str, float], drawn: DrawnVariant
) -> None:
    for a, axis in enumerate("xy"):
        thrust, normal = channels[f"B.{axis}.thrust"], channels[f"B.{axis}.normal_force"]
        assert drawn.phase_thrust[a].sum() == pytest.approx(thrust, rel=1e-3, abs=1e-3)
        assert drawn.phase_normal[a].sum() == pytest.approx(normal, rel=1e-3)
        assert abs(thrust) > 0.3
        assert normal > 1.0


def test_an_arrow_is_as_long_as_its_force(drawn: DrawnVariant) -> None:
    layout = Layout.of(AXES)
    starts, vectors = phase_arrows(phase_starts(layout), (0.01, -0.02), drawn)
    along = np.stack([vectors[0, 0, :, 0], vectors[0, 1, :, 1]])
    assert along == pytest.approx(arrows.THRUST_SCALE * drawn.phase_thrust)
    assert vectors[1, ..., 2] == pytest.approx(-arrows.NORMAL_SCALE * drawn.phase_normal)
    # Thrust at its own mover; the normal force ends above it.
    expected = layout.movers + np.array([0.0, -0.02])
    expected[0, :, 0] += 0.01
    assert starts[0, ..., :2] == pytest.approx(expected, abs=1e-6)
    assert ((starts + vectors)[1, ..., 2] > TOP).all()


def test_an_arrow_of_the_section_is_as_long_as_its_force(drawn: DrawnVariant) -> None:
    cut = Section(AXES[1])
    starts, vectors = section_arrows(cut, 1, drawn)
    assert vectors[:3, 0] == pytest.approx(section.THRUST_SCALE * drawn.phase_thrust[1])
    assert vectors[3:, 2] == pytest.approx(-section.NORMAL_SCALE * drawn.phase_normal[1])
    assert (starts + vectors)[3:, 2] == pytest.approx(cut.yoke[1])


@pytest.mark.parametrize("phase", [0, 1, 2])
def test_poles_face_teeth_in_the_section_where_a_phase_is_aligned(phase: int) -> None:
    cut = Section(AXES[1])
    aligned = PITCH / 2 + phase * PITCH / 3 - AXES[1].offset
    for position in (aligned, aligned - 1.1e-3):
        shift = cut.poles[phase] - cut.comb_shift(position)
        ahead = cut.to_aligned(position)[phase]
        turns = (shift + ahead) / PITCH
        assert turns == pytest.approx(np.round(turns), abs=1e-9)
        assert ahead == pytest.approx(aligned - position, abs=1e-12)
    lines = cut.flux(cut.to_aligned(position), np.array([False, True, False]))
    assert lines.shape == (6, 2, 3)
    assert lines[:, 0, 2] == pytest.approx(section.GAP_FACTOR * AXES[1].gap)


def test_the_thrust_of_a_current_pulls_to_where_its_phase_is_aligned() -> None:
    model = PhaseForces(load_scenario("circle").plant)
    position = np.linspace(-3e-3, 3e-3, 7)[:, None] * [1.0, 1.0] + 1e-5
    forces = model.at(position, np.full((7, 2, 3), 2.0))
    assert np.array_equal(np.sign(forces[:, :, 0]), np.sign(model.to_aligned(position)))


def test_a_ghost_stands_in_the_frame_of_the_first() -> None:
    layout = Layout.of(AXES)
    assert stage_offsets(2, layout, ghost=True) == [0.0, 0.0]
    assert stage_offsets(2, layout)[1] == -stage_offsets(2, layout)[0] > layout.rail


@pytest.mark.parametrize("camera", CAMERAS)
@pytest.mark.parametrize("aspect", [0.8, 3.0])
def test_what_a_camera_shows_fits_its_picture(camera, aspect: float) -> None:
    shown = camera_of(ViewSettings(camera=camera), START)
    distance = np.linalg.norm(np.subtract(shown.position(aspect), shown.middle))
    tall = 2.0 * distance * np.tan(shown.field_of_view / 2)
    assert tall >= shown.tall * (1 - 1e-9)
    assert tall * aspect >= shown.wide * (1 - 1e-9)
    if camera == "section":  # straight onto the cut, with nearly parallel rays
        assert shown.direction == (0.0, -1.0, 0.0)
        assert shown.field_of_view < 0.1


@pytest.mark.parametrize("camera", ["overview", "top", "side"])
@pytest.mark.parametrize("ghost", [False, True])
@pytest.mark.parametrize("aspect", [1.2, 1.7, 2.4, 3.4])
def test_names_of_both_machines_are_in_the_picture(camera, ghost: bool, aspect: float) -> None:
    layout = Layout.of(AXES)
    shown = camera_of(ViewSettings(camera=camera, ghost=ghost), START)
    for index, x in enumerate(stage_offsets(2, layout, ghost=ghost)):
        y = label_place(layout, ghost=ghost and index > 0)
        across, up = _in_picture(shown, aspect, (x, y, 0.0))
        assert abs(across) < 0.85
        assert -0.92 < up < 0.0


def _in_picture(camera: Camera, aspect: float, place: tuple[float, float, float]) -> tuple:
    """Return where a place appears, 1 at the right and at the upper edge."""
    at = np.array(camera.position(aspect))
    ahead = camera.middle - at
    ahead /= np.linalg.norm(ahead)
    right = np.cross(ahead, (0.0, 0.0, 1.0))
    right /= np.linalg.norm(right)
    up = np.cross(right, ahead)
    away = place - at
    half = np.tan(camera.field_of_view / 2) * (away @ ahead)
    return away @ right / (half * aspect), away @ up / half
