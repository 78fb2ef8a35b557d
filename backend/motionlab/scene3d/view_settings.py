"""Settings of a viewer: camera, machines side by side or as ghosts, magnification, arrows."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import Any, Literal, Self, get_args

CameraName = Literal["overview", "top", "side", "section", "follow"]
Arrow = Literal["thrust", "phases", "normal", "friction", "load"]
CAMERAS: tuple[CameraName, ...] = get_args(CameraName)
ARROWS: tuple[Arrow, ...] = get_args(Arrow)


@dataclass(frozen=True)
class ViewSettings:
    """Choices of one viewer.

    Attributes
    ----------
    camera : str
        Preset of the camera, of `CAMERAS`.
    machine : str
        Variant that the camera follows, or whose section is shown.
    axis : str
        Axis of the section, x or y.
    ghost : bool
        Whether the second machine is drawn translucent in the frame of the first.
    magnification : float
        Factor by which errors are drawn larger, except in the section.
    arrows : tuple of str
        Forces that are drawn, of `ARROWS`.
    """

    camera: CameraName = "overview"
    machine: str = "A"
    axis: Literal["x", "y"] = "x"
    ghost: bool = False
    magnification: float = 1.0
    arrows: tuple[Arrow, ...] = ARROWS

    def encode(self) -> bytes:
        """Return the settings as JSON."""
        return json.dumps(asdict(self)).encode()

    @classmethod
    def decode(cls, content: dict[str, Any]) -> Self:
        """Return the settings that parsed JSON describes."""
        return cls(**{**content, "arrows": tuple(content["arrows"])})
