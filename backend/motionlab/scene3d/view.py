"""The scene of one viewer: all nodes belong to its client, so no history accumulates.

viser keeps updates of shared nodes for ever, numbered, and a joining client goes through all
numbers. Updates of one client's nodes are dropped once sent: the shared buffer stays as small as at
the start, however long the scene runs.
"""

from __future__ import annotations

import viser

from motionlab.scene3d.cameras import camera_of, stage_offsets
from motionlab.scene3d.drawn_variant import DrawnVariant
from motionlab.scene3d.geometry import Layout
from motionlab.scene3d.protocol import SceneDescription, Values
from motionlab.scene3d.section import Section
from motionlab.scene3d.section_view import SectionView
from motionlab.scene3d.stage_view import StageView
from motionlab.scene3d.view_settings import ViewSettings

_RESIZED = 0.03  # change of width over height from which on the camera is placed anew


class View:
    """Everything that one viewer sees."""

    def __init__(
        self,
        client: viser.ClientHandle,
        name: str,
        start: SceneDescription,
        settings: ViewSettings,
    ) -> None:
        self.client = client
        self.name = name
        self.settings = settings
        self._start = start
        self._names = list(start.variants)
        self._beat = 0
        self._aspect = 0.0
        self._sections: dict[str, SectionView] = {}
        layout = self._layout = Layout.of(start.axes)
        scene = client.scene
        # Reflections and shadows would halve the rate of a browser without a GPU.
        scene.configure_environment_map(None)
        scene.configure_default_lights(cast_shadow=False)
        scene.add_light_ambient("/ambient", intensity=1.2)
        self._root = scene.add_frame("/lab", show_axes=False)
        self._stages = [
            StageView(
                scene,
                f"/lab/{name}",
                layout,
                index=index,
                name=name,
                label=label,
                path=start.path,
            )
            for index, (name, label) in enumerate(start.variants.items())
        ]
        self._arrange()
        self.look()

    def show(self, trail: Values, forces: Values, *, complete: bool = True) -> None:
        """Show the newest pose and the trace of those before.

        Platforms follow each pose, the rest every other one, in turns, unless it has to be
        complete.

        Parameters
        ----------
        trail : ndarray, shape (poses, width)
            Oldest first.
        forces : ndarray, shape (variants, 2, 2, 3)
            Thrust and normal force of each phase at the newest pose, N.
        complete : bool
            Whether all parts follow this pose.
        """
        self._beat += 1
        movers = [DrawnVariant(trail[-1], index, forces) for index in range(len(self._stages))]
        chosen = movers[self._chosen]
        with self.client.atomic():
            if self.settings.camera == "section":
                if chosen.holds:
                    section = self._section()
                    section.show(chosen, self.settings, complete=complete)
                return
            for stage, variant in zip(self._stages, movers, strict=True):
                if not variant.holds:
                    continue
                stage.show(variant, self.settings.magnification)
                if complete or self._beat % 2:
                    stage.draw_trace(trail, self.settings.magnification)
                    stage.draw_forces(variant, self.settings)
                if complete or self._beat % 2 == 0:
                    stage.show_currents(variant)
            self._keep_in_middle()

    def apply(self, settings: ViewSettings) -> None:
        """Show what the viewer has chosen; the same again takes up its camera anew."""
        before, self.settings = self.settings, settings
        same = settings == before
        with self.client.atomic():
            self._arrange()
        if same or _aim(settings) != _aim(before):
            self.look()

    def look(self) -> None:
        """Take up the camera that was chosen."""
        camera = camera_of(self.settings, self._start)
        viewer = self.client.camera
        self._aspect = max(viewer.image_width / max(viewer.image_height, 1), 0.1)
        with self.client.atomic():
            if self.settings.camera != "follow":
                self._root.position = (0.0, 0.0, 0.0)
            viewer.fov = camera.field_of_view
            viewer.up_direction = (0.0, 0.0, 1.0)
            viewer.position = camera.position(self._aspect)
            viewer.look_at = camera.middle

    def resized(self) -> bool:
        """Return whether the picture has another form than the camera was placed for."""
        viewer = self.client.camera
        aspect = max(viewer.image_width / max(viewer.image_height, 1), 0.1)
        return abs(aspect / self._aspect - 1.0) > _RESIZED

    @property
    def _chosen(self) -> int:
        """The stage that is followed or cut."""
        name = self.settings.machine
        return self._names.index(name) if name in self._names else 0

    def _arrange(self) -> None:
        """Show machines or section, the machines side by side or as ghosts."""
        cut = self.settings.camera == "section"
        self._root.visible = not cut
        shown = self._section() if cut else None
        for section in self._sections.values():
            section.frame.visible = section is shown
        self._offsets = stage_offsets(len(self._stages), self._layout, ghost=self.settings.ghost)
        for index, stage in enumerate(self._stages):
            stage.frame.position = (self._offsets[index], 0.0, 0.0)
            stage.set_ghost(self.settings.ghost and index > 0)

    def _section(self) -> SectionView:
        axis = self.settings.axis
        if axis not in self._sections:
            index = "xy".index(axis)
            self._sections[axis] = SectionView(
                self.client.scene,
                f"/section-{axis}",
                Section(self._start.axes[index]),
                index,
            )
        return self._sections[axis]

    def _keep_in_middle(self) -> None:
        """Move the lab under a camera that follows, so that the viewer may still turn it."""
        if self.settings.camera == "follow":
            x, y = self._stages[self._chosen].place
            self._root.position = (-x - self._offsets[self._chosen], -y, 0.0)


def _aim(settings: ViewSettings) -> tuple[object, ...]:
    """Return position and target of the camera."""
    follows = settings.machine if settings.camera == "follow" else ""
    return settings.camera, follows, settings.ghost
