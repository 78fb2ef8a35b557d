"""What a law may know in a control period: the motion, what comes of it, controller and model."""

from __future__ import annotations

from typing import Any, NamedTuple

from numba.extending import overload

from motionlab.control.position import PositionController
from motionlab.lanes import Lanes, compiled
from motionlab.laws.law import Seen
from motionlab.plant.friction import LuGre

_FIRST_AHEAD, _FIRST_PARAMETER = (Seen._fields.index(name) for name in ("p_ref_1", "k_p"))
"""Where in `Seen` the motion to come begins, and what does not change from period to period."""


def _part(name: str, what: str, fields: tuple[str, ...]) -> Any:
    """Return a record of some fields of `Seen`."""
    kinds: Any = [(field, Lanes) for field in fields]
    record: Any = NamedTuple(name, kinds)
    record.__doc__ = f"What a law may know of the {what}."
    record._like = Seen  # whose comments say what the fields are
    return record


Motion = _part("Motion", "motion in a control period", Seen._fields[:_FIRST_AHEAD])
Ahead = _part("Ahead", "motion to come", Seen._fields[_FIRST_AHEAD:_FIRST_PARAMETER])
AHEAD = 2
"""Control periods by which a law may know the reference in advance."""


def seen(controller: PositionController, friction: LuGre, motion: Any, ahead: Any) -> Seen:
    """Return what a law may know of a controller, its model of friction, and the motion."""
    rest = (controller.k_p, controller.k_d, controller.M, friction)
    return Seen(*motion, *ahead, *rest)  # pyright: ignore[reportCallIssue]


@overload(seen, jit_options={"error_model": "numpy", "forceinline": True}, strict=False)
def _overload_seen(controller: Any, friction: Any, motion: Any, ahead: Any) -> Any:
    names = [f"motion[{k}]" for k in range(len(Motion._fields))]
    names += [f"ahead[{k}]" for k in range(len(Ahead._fields))]
    fields = ", ".join([*names, "controller.k_p", "controller.k_d", "controller.M", "friction"])
    scope = {"Seen": Seen}
    exec(f"def seen(controller, friction, motion, ahead):\n    return Seen({fields})", scope)
    return scope["seen"]


@compiled
def none_ahead(motion: Any) -> Any:
    """Return an `Ahead` for laws that ship, which do not look ahead."""
    none = motion.p_ref * 0.0
    return Ahead(none, none, none, none, none, none, none)
