"""The paper's example, the design before it, and their printed values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

PresetName = Literal["paper", "previous"]


@dataclass(frozen=True)
class DesignPreset:
    """A design described by the paper.

    Attributes
    ----------
    title : str
        Display name.
    choices : mapping of str to value
        Fields of requirements and dimensions that differ from the defaults.
    unknown : tuple of str
        Dotted fields of dimensions that the paper does not give.
    notes : tuple of str
        Remarks.
    """

    title: str
    choices: Mapping[str, Any] = field(default_factory=dict)
    unknown: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


PRESETS: Mapping[str, DesignPreset] = {
    "paper": DesignPreset("The paper's example"),
    "previous": DesignPreset(
        "The design before the paper's",
        choices={"tau": 9e-3, "n": 2},
        unknown=(
            "l_m",
            "N",
            "single_phase_force",
            "two_phase_force",
            "x.mass",
            "x.stroke",
            "y.mass",
            "y.stroke",
        ),
        notes=(
            "Of the previous design the paper gives tau = 9 mm and n = 2 only. Two limbs, teeth as "
            "wide as slots, and all else are the new design's: what it would be by the same rules.",
        ),
    ),
}

VELOCITY_SINGLE_PHASE = {"x": 1.01, "y": 0.89}
"""Printed in section II-B, m/s."""

VELOCITY_TWO_PHASE = {"x": 1.58, "y": 1.34}
"""Printed in section IV-A, m/s."""

ACCELERATION = {"x": 7.31, "y": 3.10}
"""Printed in section IV-A, m/s^2."""
