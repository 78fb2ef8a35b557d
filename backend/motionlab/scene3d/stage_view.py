"""One machine of one viewer: platforms, windings, forces and trace."""

from __future__ import annotations

import numpy as np
import viser
from viser._messages import SetPositionMessage

from motionlab.scene3d.arrows import NORMAL_SCALE, THRUST_SCALE, ForceArrows
from motionlab.scene3d.cameras import label_place
from motionlab.scene3d.colours import (
    ACCENTS,
    BED,
    FRICTION,
    IRON,
    LOAD,
    PATH,
    PHASE_COLOURS,
    PHASES,
    RAIL,
    STEEL,
    TOOTH,
    X_PLATFORM,
    Y_PLATFORM,
    current_levels,
    linear,
)
from motionlab.scene3d.drawn_variant import DrawnVariant
from motionlab.scene3d.geometry import AIR_GAP, BEAM, TOP, Array, Layout, Mesh, coils, core, turned
from motionlab.scene3d.protocol import Values
from motionlab.scene3d.view_settings import ViewSettings

_BESIDE = 14e-3  # m between two arrows
_ASIDE = 9e-3  # m from a phase's thrust to its normal force, and from an arrow of A to B's
_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_GHOST = 0.35  # opacity


class StageView:
    """One stage of one viewer.

    Parameters
    ----------
    scene : viser.SceneApi
        The client's own.
    root : str
        Name of the frame it hangs on.
    layout : Layout
        Where its parts are.
    index : int
        Which variant it shows.
    name, label : str
        Its name and what is written on it.
    path : list of pairs
        Commanded path, m.
    """

    def __init__(  # noqa: PLR0913 - everything about a stage, once
        self,
        scene: viser.SceneApi,
        root: str,
        layout: Layout,
        *,
        index: int,
        name: str,
        label: str,
        path: list[tuple[float, float]],
    ) -> None:
        self._scene = scene
        self._index = index
        self._layout = layout
        self._reach = (layout.axes[0].stroke, layout.axes[1].stroke)
        self._solid: list[viser.MeshHandle | viser.BatchedMeshHandle] = []
        accent = ACCENTS[index]
        self.frame = scene.add_frame(root, show_axes=False)
        self._stator = scene.add_frame(f"{root}/stator", show_axes=False)
        self._build_stator(f"{root}/stator", accent, path)
        self._y = scene.add_frame(f"{root}/y", show_axes=False)
        self._x = scene.add_frame(f"{root}/y/x", show_axes=False)
        self._solid += [
            self._mesh(f"{root}/y/platform", layout.y_platform(), Y_PLATFORM, shadow=True),
            self._mesh(f"{root}/y/rails", layout.x_rails(), RAIL),
            self._mesh(f"{root}/y/x/platform", layout.x_platform_mesh(), X_PLATFORM, shadow=True),
        ]
        scene.add_icosphere(
            f"{root}/y/x/tool", radius=5e-3, color=accent, position=(0, 0, layout.tool)
        )
        self._coils = [
            self._movers(f"{root}/y/x/movers", axis=0),
            self._movers(f"{root}/y/movers", axis=1),
        ]
        self._totals = ForceArrows(
            scene, f"{root}/forces", np.array([accent, FRICTION, LOAD] * 2), 7e-3
        )
        self._of_phases = ForceArrows(scene, f"{root}/phases", np.array(PHASES * 4), 5e-3)
        self._trace = scene.add_line_segments(
            f"{root}/trace",
            np.zeros((1, 2, 3), np.float32),
            accent,
            thickness=2.0e-3,
        )
        self._label = scene.add_label(
            f"{root}/name",
            f"{name}  {label}".strip(),
            position=(0.0, label_place(layout), 0.0),
            anchor="top-center",
            font_screen_scale=1.1,
        )
        self._total_starts = np.full((2, 3, 3), layout.tool, np.float32)
        self._total_starts[0, :, :2] = [(0.0, _BESIDE * (1 - i)) for i in range(3)]
        self._total_starts[1, :, :2] = [(_BESIDE * (i - 1) - layout.rail, 0.0) for i in range(3)]
        self._phase_starts = phase_starts(layout)
        self._levels: list[list[int]] = [[], []]
        self.place = (0.0, 0.0)
        self._aside = 0.0
        self._ghost = False

    def set_ghost(self, ghost: bool) -> None:
        """Draw the machine translucent, without the stator that it shares with the first one."""
        if ghost == self._ghost:
            return  # viser builds a mesh anew even when its opacity stays
        self._ghost = ghost
        self._stator.visible = not ghost
        for node in self._solid:
            node.opacity = _GHOST if ghost else None
        self._label.position = (0.0, label_place(self._layout, ghost=ghost), 0.0)
        self._aside = _ASIDE if ghost else 0.0

    def show(self, variant: DrawnVariant, magnification: float) -> None:
        """Put the platforms where they are, errors magnified."""
        x, y = variant.drawn_position(magnification, self._reach)
        if y != self.place[1]:
            move(self._y, (0.0, y, 0.0))
        if x != self.place[0]:
            move(self._x, (x, 0.0, 0.0))
        self.place = (x, y)

    def show_currents(self, variant: DrawnVariant) -> None:
        """Colour the windings by their currents."""
        for axis, node in enumerate(self._coils):
            levels = current_levels(variant.currents[axis])
            if levels != self._levels[axis]:
                self._levels[axis] = levels
                node.batched_colors = PHASE_COLOURS[levels, range(3)]

    def draw_trace(self, poses: Values, magnification: float) -> None:
        """Draw the latest positions, errors magnified."""
        if len(poses) < 2:
            self._trace.points = np.zeros((1, 2, 3), np.float32)
            return
        line = np.empty((len(poses), 3), np.float32)
        reference = poses[:, :2]
        own = DrawnVariant.first(self._index)
        line[:, :2] = reference + magnification * (poses[:, own : own + 2] - reference)
        line[:, 2] = self._layout.tool
        self._trace.points = np.stack([line[:-1], line[1:]], axis=1)

    def draw_forces(self, variant: DrawnVariant, settings: ViewSettings) -> None:
        """Draw the forces that are wanted.

        Totals of x start at the inner platform, those of y at the outer; thrust and normal force of
        a phase at its own mover.
        """
        kinds = settings.arrows
        x, y = self.place
        starts = self._total_starts.copy()
        starts[0, :, 0] += x
        starts[..., 1] += y
        starts[0, :, 1] -= self._aside
        starts[1, :, 0] -= self._aside
        # Positive friction and load forces push towards negative positions.
        forces = np.array([variant.thrust, -variant.friction, -variant.load]).T
        self._totals.draw(
            starts.reshape(6, 3),
            along_axes(THRUST_SCALE * forces).reshape(6, 3),
            np.array([kind in kinds for kind in ("thrust", "friction", "load")] * 2),
        )
        starts, vectors = phase_arrows(self._phase_starts, self.place, variant)
        starts[..., 0] -= self._aside * np.array([0, 1], np.float32)[:, None]
        starts[..., 1] -= self._aside * np.array([1, 0], np.float32)[:, None]
        self._of_phases.draw(
            starts.reshape(12, 3),
            vectors.reshape(12, 3),
            np.repeat([kind in kinds for kind in ("phases", "normal")], 6),
        )

    def _build_stator(
        self, root: str, accent: tuple[int, int, int], path: list[tuple[float, float]]
    ) -> None:
        layout = self._layout
        self._mesh(f"{root}/bed", layout.bed(), BED)
        self._mesh(f"{root}/plate", layout.plate(), STEEL)
        self._mesh(f"{root}/rails", layout.y_rails(), RAIL)
        self._mesh(f"{root}/teeth", layout.teeth(), TOOTH)
        x, y = (axis.stroke for axis in layout.axes)
        corners = np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]])
        self._line(f"{root}/stroke", corners, AIR_GAP, accent, 1.6e-3)
        if len(path) > 1:
            self._line(f"{root}/path", np.array(path), layout.tool, PATH, 1.2e-3)

    def _line(
        self, name: str, points: Array, z: float, colour: tuple[int, int, int], thickness: float
    ) -> None:
        line = np.pad(points, ((0, 0), (0, 1)), constant_values=z).astype(np.float32)
        segments = np.stack([line[:-1], line[1:]], axis=1)
        self._scene.add_line_segments(name, segments, colour, thickness=thickness)

    def _movers(self, name: str, *, axis: int) -> viser.BatchedMeshHandle:
        """Add iron and windings of an axis' movers and return the windings."""
        pitch = self._layout.axes[axis].pitch
        places = np.pad(self._layout.movers[axis], ((0, 0), (0, 1)))
        iron, winding = core(pitch), coils(pitch)
        if axis == 1:
            iron, winding = turned(iron), turned(winding)
        common = {
            "batched_wxyzs": np.tile(_IDENTITY, (3, 1)),
            "batched_positions": places,
            "lod": "off",
            "flat_shading": True,
        }
        cores = self._scene.add_batched_meshes_simple(
            f"{name}/iron", *arrays(iron), **common, batched_colors=linear(np.array(IRON))
        )
        wound = self._scene.add_batched_meshes_simple(
            f"{name}/coils", *arrays(winding), **common, batched_colors=PHASE_COLOURS[0]
        )
        self._solid += [cores, wound]
        return wound

    def _mesh(
        self, name: str, mesh: Mesh, colour: tuple[int, int, int], *, shadow: bool = False
    ) -> viser.MeshHandle:
        return self._scene.add_mesh_simple(
            name, *arrays(mesh), color=colour, flat_shading=True, cast_shadow=shadow
        )


def phase_starts(layout: Layout) -> Values:
    """Return the start points of each phase's arrows on their platforms, above their movers.

    Returns
    -------
    ndarray, shape (axis, phase, 3)
        m, at mid-stroke.
    """
    tops = np.array([TOP + 14e-3, TOP + BEAM + 4e-3])
    heights = np.broadcast_to(tops[:, None, None], (2, 3, 1))
    return np.concatenate([layout.movers, heights], axis=2).astype(np.float32)


def along_axes(lengths: Values) -> Values:
    """Return vectors along x and y, shape (axis, n, 3), of their lengths, shape (axis, n)."""
    vectors = np.zeros((*lengths.shape, 3), np.float32)
    vectors[0, :, 0], vectors[1, :, 1] = lengths
    return vectors


def phase_arrows(
    starts: Values, place: tuple[float, float], variant: DrawnVariant
) -> tuple[Values, Values]:
    """Return starts and vectors of each phase's thrust and normal force.

    Thrust is drawn along its axis; the normal force, which pulls the mover onto the stator, from
    above down to the platform.

    Parameters
    ----------
    starts : ndarray, shape (axis, phase, 3)
        As `phase_starts` returns them.
    place : tuple of float
        Where the platforms are drawn, m.
    variant : DrawnVariant
        What is drawn.

    Returns
    -------
    starts, vectors : ndarray, shape (2, axis, phase, 3)
        Of thrust and normal force, m.
    """
    begin = np.stack([starts, starts])
    begin[:, 0, :, 0] += place[0]
    begin[..., 1] += place[1]
    vectors = np.zeros_like(begin)
    vectors[0] = along_axes(THRUST_SCALE * variant.phase_thrust)
    vectors[1, ..., 2] = -NORMAL_SCALE * variant.phase_normal
    begin[1] -= vectors[1]
    begin[1, 0, :, 1] += _ASIDE
    begin[1, 1, :, 0] += _ASIDE
    return begin, vectors


def move(node: viser.FrameHandle, place: tuple[float, float, float]) -> None:
    """Move a node.

    Assigning its position would first compare it by ``numpy.allclose``, which takes longer than all
    the rest of a pose, and would drop what moves it by less than a hundred-thousandth.
    """
    node.position[:] = place  # viser's copy
    node._impl.api._queue_scene_message(SetPositionMessage(node.name, place))


def arrays(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles as viser takes them."""
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)
