"""What a law may know in a control period: the motion, its controller, the model of friction."""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.extending import overload

from motionlab.control.position import PositionController
from motionlab.lanes import Lanes
from motionlab.laws.law import Seen
from motionlab.plant.friction import LuGre

_PARAMETERS = ("k_p", "k_d", "M", "friction")
"""The last fields of `Seen`: those that do not change from period to period."""

_NAMES: Any = [(name, Lanes) for name in Seen._fields[: -len(_PARAMETERS)]]
Motion: Any = NamedTuple("Motion", _NAMES)
Motion.__doc__ = "What a law may know of the motion in a control period."
Motion._like = Seen  # whose comments say what the fields are


def seen(controller: PositionController, friction: LuGre, motion: Any) -> Seen:
    """Return what a law may know of a controller, its model of friction, and the motion."""
    rest = (controller.k_p, controller.k_d, controller.M, friction)
    return Seen(*motion, *rest)  # pyright: ignore[reportCallIssue]


@overload(seen, jit_options={"error_model": "numpy", "forceinline": True}, strict=False)
def _overload_seen(controller: Any, friction: Any, motion: Any) -> Any:
    fields = ", ".join(f"motion[{k}]" for k in range(len(Motion._fields)))
    rest = "controller.k_p, controller.k_d, controller.M, friction"
    scope = {"Seen": Seen}
    exec(f"def seen(controller, friction, motion):\n    return Seen({fields}, {rest})", scope)
    return scope["seen"]
