"""The section through the movers of one axis, in one viewer."""

from __future__ import annotations

from typing import Any

import numpy as np
import viser

from motionlab.scene3d.arrows import ForceArrows
from motionlab.scene3d.colours import (
    CUT_IRON,
    PHASE_COLOURS,
    PHASES,
    STEEL,
    TOOTH,
    current_levels,
    linear,
)
from motionlab.scene3d.drawn_variant import DrawnVariant
from motionlab.scene3d.protocol import Values
from motionlab.scene3d.section import IN_FRONT, NORMAL_SCALE, THRUST_SCALE, Section
from motionlab.scene3d.stage_view import arrays, move
from motionlab.scene3d.view_settings import ViewSettings

_CARRIES = 0.05  # A, from where on a phase counts as carrying current
_IDENTITY = (1.0, 0.0, 0.0, 0.0)
_TEXT: dict[str, Any] = {"font_size_mode": "scene", "font_scene_height": 2.4e-3}
_LABEL_EVERY = 6  # poses from one text to the next: five a second


class SectionView:
    """The section of one axis, for any machine.

    Parameters
    ----------
    scene : viser.SceneApi
        The client's own.
    root : str
        Name of the frame it hangs on.
    section : Section
        Its shapes.
    axis : int
        Which axis it shows.
    """

    def __init__(self, scene: viser.SceneApi, root: str, section: Section, axis: int) -> None:
        self.section = section
        self._axis = axis
        self._beat = 0
        self.frame = scene.add_frame(root, show_axes=False)
        self._comb = scene.add_frame(f"{root}/comb", show_axes=False)
        for name, mesh, colour in (
            ("back", section.back(), STEEL),
            ("comb/teeth", section.comb(), TOOTH),
        ):
            scene.add_mesh_simple(
                f"{root}/{name}", *arrays(mesh), color=colour, flat_shading=True, cast_shadow=False
            )
        places = np.zeros((3, 3))
        places[:, 0] = section.movers
        common = {
            "batched_wxyzs": np.tile(_IDENTITY, (3, 1)),
            "batched_positions": places,
            "lod": "off",
            "flat_shading": True,
        }
        scene.add_batched_meshes_simple(
            f"{root}/iron",
            *arrays(section.iron()),
            **common,
            batched_colors=linear(np.array(CUT_IRON)),
        )
        self._coils = scene.add_batched_meshes_simple(
            f"{root}/coils", *arrays(section.windings()), **common, batched_colors=PHASE_COLOURS[0]
        )
        self._flux = scene.add_line_segments(
            f"{root}/flux",
            np.zeros((1, 2, 3), np.float32),
            (255, 255, 255),
            thickness=0.5e-3,
        )
        self._arrows = ForceArrows(scene, f"{root}/forces", np.array(PHASES * 2), 3e-3)
        below = -14e-3
        self._labels = [
            scene.add_label(
                f"{root}/phase{k}",
                name,
                position=(x, IN_FRONT, below),
                anchor="top-center",
                **_TEXT,
            )
            for k, (name, x) in enumerate(zip("abc", section.movers, strict=True))
        ]
        scene.add_label(
            f"{root}/gap",
            f"gap {1e3 * section.axis.gap:g} mm",
            position=(-0.089, IN_FRONT, section.gap / 2),
            anchor="center-left",
            **_TEXT,
        )
        self._levels: list[int] = []

    def show(self, variant: DrawnVariant, settings: ViewSettings, *, complete: bool) -> None:
        """Show the movers of a machine at their true position."""
        position = float(variant.position[self._axis])
        currents = variant.currents[self._axis]
        move(self._comb, (self.section.comb_shift(position), 0.0, 0.0))
        levels = current_levels(currents)
        if levels != self._levels:
            self._levels = levels
            self._coils.batched_colors = PHASE_COLOURS[levels, range(3)]
        carrying = np.abs(currents) > _CARRIES
        lines = self.section.flux(self.section.to_aligned(position), carrying).astype(np.float32)
        self._flux.visible = bool(carrying.any())
        if carrying.any():
            colours = np.repeat(np.array(PHASES, np.uint8)[carrying], 6, axis=0)
            self._flux.points = lines
            self._flux.colors = np.repeat(colours[:, None], 2, axis=1)
        starts, vectors = section_arrows(self.section, self._axis, variant)
        drawn = np.repeat([kind in settings.arrows for kind in ("phases", "normal")], 3)
        self._arrows.draw(starts, vectors, drawn)
        self._beat += 1
        if complete or self._beat % _LABEL_EVERY == 0:
            for k, label in enumerate(self._labels):
                thrust = variant.phase_thrust[self._axis, k]
                text = f"{'abc'[k]}   {currents[k]:.2f} A   {thrust:+.2f} N"
                label.text = text.replace("-", "\N{MINUS SIGN}")


def section_arrows(section: Section, axis: int, variant: DrawnVariant) -> tuple[Values, Values]:
    """Return starts and vectors of each phase's thrust, then of its normal force; shape (6, 3).

    Thrust starts in the middle of the yoke; the normal force ends on it.
    """
    low, high = section.yoke
    starts = np.zeros((2, 3, 3), np.float32)
    starts[..., 0] = section.movers
    starts[..., 1] = IN_FRONT
    starts[0, :, 2] = (low + high) / 2
    starts[1, :, 2] = high
    vectors = np.zeros_like(starts)
    vectors[0, :, 0] = THRUST_SCALE * variant.phase_thrust[axis]
    vectors[1, :, 2] = -NORMAL_SCALE * variant.phase_normal[axis]
    starts[1] -= vectors[1]
    return starts.reshape(6, 3), vectors.reshape(6, 3)
