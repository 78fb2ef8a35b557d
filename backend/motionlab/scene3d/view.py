"""The scene of one viewer: all nodes belong to its client, so no history accumulates.

viser keeps updates of shared nodes for ever, numbered, and a joining client goes through all
numbers. Updates of one client's nodes are dropped once sent: the shared buffer stays as small as at
the start, however long the scene runs.
"""

from __future__ import annotations

import math

import numpy as np
import viser
from viser._messages import SetPositionMessage

from motionlab.scene3d.cameras import Camera, stage_offsets
from motionlab.scene3d.geometry import AIR_GAP, Array, Layout, Mesh, coils, core, turned
from motionlab.scene3d.protocol import CURRENTS, OWN, SHARED, SceneDescription, Values

ACCENTS = ((213, 94, 0), (0, 114, 178))
PHASES = ((0, 158, 115), (230, 159, 0), (86, 180, 233))
FRICTION, LOAD = (134, 142, 150), (148, 87, 178)
STEEL, TOOTH, IRON = (96, 104, 112), (150, 158, 166), (70, 72, 78)
RAIL, BED = (176, 183, 190), (58, 64, 71)
Y_PLATFORM, X_PLATFORM = (120, 130, 142), (206, 211, 216)

FORCE_SCALE = 8e-3
"""Length of an arrow, m/N."""

_HEAD = 7e-3
_BESIDE = 14e-3  # m between two arrows
_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_FULL_CURRENT = 10.0  # A, the paper's peak
LEVELS = 24


class DrawnVariant:
    """The numbers of one variant in a pose.

    Parameters
    ----------
    pose : ndarray, shape (width,)
        One pose, as `motionlab.scene3d.protocol` orders it.
    index : int
        Which variant.
    """

    def __init__(self, pose: Values, index: int) -> None:
        first = self.first(index)
        self.position, self.thrust, self.friction = pose[first : first + 6].reshape(3, 2)
        self.currents = pose[first + 6 : first + 12].reshape(2, 3)

    @staticmethod
    def first(index: int) -> int:
        """Return where the numbers of a variant begin."""
        return 2 * len(SHARED) + index * 2 * (len(OWN) + len(CURRENTS))

    @property
    def holds(self) -> bool:
        """Whether there is anything to show: a variant that diverged has no numbers."""
        return math.isfinite(self.position[0]) and math.isfinite(self.position[1])


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
    ) -> None:
        self._scene = scene
        self._index = index
        self._layout = layout
        accent = ACCENTS[index]
        self._build_stator(root, accent)
        self._y = scene.add_frame(f"{root}/y", show_axes=False)
        self._x = scene.add_frame(f"{root}/y/x", show_axes=False)
        self._mesh(f"{root}/y/platform", layout.y_platform(), Y_PLATFORM, shadow=True)
        self._mesh(f"{root}/y/rails", layout.x_rails(), RAIL)
        self._mesh(f"{root}/y/x/platform", layout.x_platform_mesh(), X_PLATFORM, shadow=True)
        scene.add_icosphere(
            f"{root}/y/x/tool", radius=5e-3, color=accent, position=(0, 0, layout.tool)
        )
        self._coils = [
            self._movers(f"{root}/y/x/movers", axis=0),
            self._movers(f"{root}/y/movers", axis=1),
        ]
        self._arrow_colours = linear(np.array([accent, FRICTION, LOAD] * 2))
        self._arrows = scene.add_arrows(
            f"{root}/forces",
            np.zeros((1, 2, 3), np.float32),
            self._arrow_colours[:1],
            shaft_radius=1.8e-3,
            head_radius=4.5e-3,
            head_length=_HEAD,
            visible=False,
        )
        self._trace = scene.add_line_segments(
            f"{root}/trace",
            np.zeros((1, 2, 3), np.float32),
            accent,
            thickness=2.0e-3,
        )
        scene.add_label(
            f"{root}/name",
            f"{name}  {label}".strip(),
            position=(0, -layout.half[1] - 0.035, 0.0),
            anchor="top-center",
            font_screen_scale=1.1,
        )
        self._arrow_starts = np.full((2, 3, 3), layout.tool, np.float32)
        self._arrow_starts[0, :, :2] = [(0.0, _BESIDE * (1 - i)) for i in range(3)]
        self._arrow_starts[1, :, :2] = [(_BESIDE * (i - 1) - layout.rail, 0.0) for i in range(3)]
        self._drawn_arrows = np.zeros(6, bool)
        self._levels: list[list[int]] = [[], []]
        self._place = (0.0, 0.0)

    def show(self, variant: DrawnVariant) -> None:
        """Put the platforms where they are."""
        x, y = variant.position.tolist()
        if y != self._place[1]:
            _move(self._y, (0.0, y, 0.0))
        if x != self._place[0]:
            _move(self._x, (x, 0.0, 0.0))
        self._place = (x, y)

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

    def draw_forces(self, *forces: Values) -> None:
        """Draw x forces at the inner platform, y forces at the outer, side by side.

        A force too small for a head of its own is left out.
        """
        lengths = FORCE_SCALE * np.array(forces).T  # axis, force
        ends = self._arrow_starts.copy()
        ends[0, :, 0] += lengths[0]
        ends[1, :, 1] += lengths[1]
        points = np.stack([self._arrow_starts, ends], axis=2)
        points[0, ..., 0] += self._place[0]
        points[..., 1] += self._place[1]
        long = (np.abs(lengths) > _HEAD).reshape(-1)
        if not np.array_equal(long, self._drawn_arrows):
            self._drawn_arrows = long
            self._arrows.visible = bool(long.any())
            self._arrows.colors = self._arrow_colours[long]
        if long.any():
            self._arrows.points = points.reshape(-1, 2, 3)[long]

    def _build_stator(self, root: str, accent: tuple[int, int, int]) -> None:
        layout = self._layout
        self._mesh(f"{root}/bed", layout.bed(), BED)
        self._mesh(f"{root}/plate", layout.plate(), STEEL)
        self._mesh(f"{root}/rails", layout.y_rails(), RAIL)
        self._mesh(f"{root}/teeth", layout.teeth(), TOOTH)
        x, y = (axis.stroke for axis in layout.axes)
        corners = np.array([[-x, -y], [x, -y], [x, y], [-x, y], [-x, -y]])
        outline = np.pad(corners, ((0, 0), (0, 1)), constant_values=AIR_GAP)
        self._scene.add_line_segments(
            f"{root}/stroke",
            np.stack([outline[:-1], outline[1:]], axis=1).astype(np.float32),
            accent,
            thickness=1.6e-3,
        )

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
        self._scene.add_batched_meshes_simple(
            f"{name}/iron", *_arrays(iron), **common, batched_colors=linear(np.array(IRON))
        )
        return self._scene.add_batched_meshes_simple(
            f"{name}/coils", *_arrays(winding), **common, batched_colors=PHASE_COLOURS[0]
        )

    def _mesh(
        self, name: str, mesh: Mesh, colour: tuple[int, int, int], *, shadow: bool = False
    ) -> None:
        self._scene.add_mesh_simple(
            name, *_arrays(mesh), color=colour, flat_shading=True, cast_shadow=shadow
        )


def _move(node: viser.FrameHandle, place: tuple[float, float, float]) -> None:
    """Move a node.

    Assigning its position would first compare it by ``numpy.allclose``, which takes longer than all
    the rest of a pose, and would drop what moves it by less than a hundred-thousandth.
    """
    node.position[:] = place  # viser's copy
    node._impl.api._queue_scene_message(SetPositionMessage(node.name, place))


def _arrays(mesh: Mesh) -> tuple[np.ndarray, np.ndarray]:
    return mesh.vertices.astype(np.float32), mesh.faces.astype(np.uint32)


def linear(colours: Array) -> np.ndarray:
    """Return sRGB colours, 0 to 255, as viser's batched meshes and arrows take them: linear."""
    return np.rint(255.0 * (np.asarray(colours) / 255.0) ** 2.2).astype(np.uint8)


def current_levels(currents: Values) -> list[int]:
    """Return the level of each phase's colour: 0 without current, LEVELS at 10 A and beyond.

    The root shows the few ampere of a slow motion, too.
    """
    return [min(round(LEVELS * math.sqrt(abs(i) / _FULL_CURRENT)), LEVELS) for i in currents]


def _phase_colours() -> np.ndarray:
    dim = 0.4 * np.array(PHASES) + 30.0
    share = np.linspace(0.0, 1.0, LEVELS + 1)[:, None, None]
    return linear(dim + share * (np.array(PHASES) - dim))


PHASE_COLOURS = _phase_colours()
"""Colour of each level and phase, uint8 of shape (LEVELS + 1, 3, 3)."""


class View:
    """Everything that one viewer sees.

    Parameters
    ----------
    client : viser.ClientHandle
        The viewer.
    start : SceneDescription
        What is shown.
    """

    def __init__(self, client: viser.ClientHandle, start: SceneDescription) -> None:
        self.client = client
        self.magnification = 300.0
        self._follows: int | None = None
        self._beat = 0
        layout = Layout.of(start.axes)
        scene = client.scene
        # Reflections and shadows would halve the rate of a browser without a GPU.
        scene.configure_environment_map(None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_ambient("/ambient", intensity=1.2)
        self._root = scene.add_frame("/lab", show_axes=False)
        self._offsets = stage_offsets(len(start.variants), layout)
        self._stages: list[StageView] = []
        for index, (name, label) in enumerate(start.variants.items()):
            root = f"/lab/{name}"
            scene.add_frame(root, show_axes=False, position=(self._offsets[index], 0, 0))
            stage = StageView(scene, root, layout, index=index, name=name, label=label)
            self._stages.append(stage)
            if len(start.path) > 1:
                path = np.pad(np.array(start.path), ((0, 0), (0, 1)), constant_values=layout.tool)
                scene.add_line_segments(
                    f"{root}/path",
                    np.stack([path[:-1], path[1:]], axis=1).astype(np.float32),
                    (134, 142, 150),
                    thickness=1.2e-3,
                )

    def show(self, trail: Values, *, complete: bool = True) -> None:
        """Show the newest pose and the trace of those before.

        Platforms follow each pose, the rest every other one, in turns, unless it has to be
        complete.
        """
        self._beat += 1
        pose = trail[-1]
        load = -pose[2:4]  # positive load forces push towards negative positions
        with self.client.atomic():
            for index, stage in enumerate(self._stages):
                variant = DrawnVariant(pose, index)
                if not variant.holds:
                    continue
                stage.show(variant)
                if complete or self._beat % 2:
                    stage.draw_trace(trail, self.magnification)
                    stage.draw_forces(variant.thrust, -variant.friction, load)
                if complete or self._beat % 2 == 0:
                    stage.show_currents(variant)
            self._keep_in_middle(pose)

    def look(self, camera: Camera) -> None:
        """Take up a camera preset."""
        self._follows = camera.follows
        with self.client.atomic():
            if camera.follows is None:
                self._root.position = (0.0, 0.0, 0.0)
            self.client.camera.up_direction = (0.0, 0.0, 1.0)
            viewer = self.client.camera
            aspect = viewer.image_width / max(viewer.image_height, 1)
            self.client.camera.position = camera.position(max(aspect, 0.1))
            self.client.camera.look_at = camera.middle

    def _keep_in_middle(self, pose: Values) -> None:
        """Move the lab under a camera that follows, so that the viewer may still turn it."""
        if self._follows is None:
            return
        variant = DrawnVariant(pose, self._follows)
        if variant.holds:
            x, y = (float(p) for p in variant.position)
            self._root.position = (-x - self._offsets[self._follows], -y, 0.0)
