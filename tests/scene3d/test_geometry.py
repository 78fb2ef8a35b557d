"""What the 3-D view is drawn from: the paper's dimensions, the phases' places, the feed."""

from __future__ import annotations

import io
import subprocess
import sys

import numpy as np
import pytest

from motionlab.scene3d import geometry, protocol
from motionlab.scene3d.geometry import Layout
from motionlab.scene3d.protocol import DrawnAxis, SceneDescription

PITCH = 7.2e-3
AXES = (DrawnAxis(0.085, PITCH, 0.0), DrawnAxis(0.145, PITCH, 0.0))


def lengths(mesh: geometry.Mesh) -> np.ndarray:
    return np.ptp(mesh.vertices, axis=0)


def test_a_mover_has_the_papers_dimensions() -> None:
    assert lengths(geometry.core(PITCH)) == pytest.approx([39.6e-3, 42.3e-3, 36.0e-3])
    assert geometry.core(PITCH).vertices[:, 2].min() == pytest.approx(0.3e-3)


@pytest.mark.parametrize("offset", [0.0, 0.5e-3])
@pytest.mark.parametrize("axis", [0, 1])
@pytest.mark.parametrize("phase", [0, 1, 2])
def test_teeth_face_each_other_where_a_phase_is_aligned(
    axis: int, phase: int, offset: float
) -> None:
    """A phase is aligned at theta = 2 pi (p + offset)/tau - 2 pi k/3 = pi."""
    layout = Layout.of((DrawnAxis(0.085, PITCH, offset), DrawnAxis(0.145, PITCH, offset)))
    aligned = PITCH / 2 + phase * PITCH / 3 - offset
    tooth = layout.movers[axis, phase, axis] + aligned + PITCH / 2
    distance = np.abs(layout.tooth_places(axis) - tooth).min()
    assert distance == pytest.approx(0.0, abs=1e-12)


def test_the_toothed_plane_reaches_as_far_as_the_movers() -> None:
    layout = Layout.of(AXES)
    half = geometry.core(PITCH).vertices[:, 0].max()
    for axis in (0, 1):
        reach = np.abs(layout.movers[axis, :, axis]).max() + half + AXES[axis].stroke
        assert layout.half[axis] >= reach
        places = layout.tooth_places(axis)
        assert np.diff(places) == pytest.approx(PITCH)
        assert np.abs(places).max() + PITCH / 4 <= layout.half[axis]


def test_movers_do_not_touch() -> None:
    layout = Layout.of(AXES)
    winding = lengths(geometry.coils(PITCH))[:2]
    core = lengths(geometry.core(PITCH))[:2]
    size = np.maximum(winding, core)
    boxes = [(layout.movers[0, k], size) for k in range(3)]
    boxes += [(layout.movers[1, k], size[::-1]) for k in range(3)]
    for i, (one, a) in enumerate(boxes):
        for other, b in boxes[:i]:
            assert (np.abs(one - other) >= (a + b) / 2).any()


def test_too_many_teeth_are_not_drawn() -> None:
    fine = Layout.of((DrawnAxis(1.0, 1e-3, 0.0), DrawnAxis(1.0, 1e-3, 0.0)))
    assert len(fine.teeth().faces) == 0
    teeth = Layout.of(AXES).teeth()
    assert len(teeth.faces) == 10 * (len(teeth.vertices) // 8)
    assert teeth.vertices[:, 2].max() == 0.0
    assert lengths(teeth)[2] == pytest.approx(geometry.TOOTH_HEIGHT)


def test_what_is_told_is_understood() -> None:
    start = SceneDescription(
        "lab://x", AXES, {"A": "no compensation"}, [(0.0, 0.015), (0.015, 0.0)]
    )
    poses = np.arange(2 * protocol.width(1), dtype=np.float32).reshape(2, -1)
    pipe = io.BytesIO(start.encode() + protocol.poses(poses) + protocol.message(protocol.CLEAR))
    told = protocol.read(pipe)
    assert told is not None
    assert told[0] == protocol.START
    again = SceneDescription.decode(told[1])
    assert (again.origin, again.axes, again.variants) == (start.origin, start.axes, start.variants)
    assert np.array_equal(again.path, start.path)
    told = protocol.read(pipe)
    assert told is not None
    assert np.array_equal(np.frombuffer(told[1], "<f4").reshape(2, -1), poses)
    assert protocol.read(pipe) == (protocol.CLEAR, b"")
    assert protocol.read(pipe) is None


def test_a_cut_or_absurd_message_is_not_taken() -> None:
    assert protocol.read(io.BytesIO(protocol.message(protocol.CLEAR, b"1234")[:-1])) is None
    with pytest.raises(ValueError, match="4000001 bytes"):
        protocol.read(io.BytesIO(b"P" + (4_000_001).to_bytes(4, "little")))


def test_a_pose_has_as_many_numbers_as_names() -> None:
    names = protocol.column_names(["A", "B"])
    assert len(names) == len(set(names)) == protocol.width(2)
    assert names[:4] == [
        "x.position_reference",
        "y.position_reference",
        "x.load_force",
        "y.load_force",
    ]
    assert names[4:6] == ["A.x.position", "A.y.position"]


def test_the_web_process_does_not_import_viser() -> None:
    code = "import sys, motionlab.server.app; print('viser' in sys.modules)"
    done = subprocess.run((sys.executable, "-c", code), capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"
