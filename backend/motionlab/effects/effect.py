"""What an effect of the plant declares, and what it may know: own friction, cogging, cables.

An effect is one module: a name, parameters with unit, range and default, its state, and one
function of lanes that is called once in a step of the plant. Its force *resists*: like the friction
f_f and the load f_d of eq. (16) it is subtracted from the thrust, ``M a = f - f_f - f_d``, so
friction is positive where the velocity is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from motionlab.declarations import OURS, PAPER, Parameter
from motionlab.lanes import Lanes
from motionlab.plant.friction import LuGre

SLOTS = 4
"""Most effects on one axis."""
PARAMETER_ROWS = 12
"""Most parameters of an effect in the kernel."""
STATE_ROWS = 8
"""Most numbers of its state."""

__all__ = [
    "OURS",
    "PAPER",
    "PARAMETER_ROWS",
    "SLOTS",
    "STATE_ROWS",
    "Effect",
    "MidStep",
    "NoState",
    "Parameter",
    "Resistance",
]


class MidStep(NamedTuple):
    """What an effect may know of a step of the plant, of each lane; all but h is of its middle."""

    position: Lanes  # m
    velocity: Lanes  # m/s
    time: Lanes  # s
    current_a: Lanes  # phase currents, A
    current_b: Lanes
    current_c: Lanes
    normal_force: Lanes  # attraction of the motor N(i, p), N; 0 with an ideal force
    thrust: Lanes  # N
    M: Lanes  # moving mass, kg
    h: Lanes  # length of the step, s


class Resistance(NamedTuple):
    """What an effect gives for a step."""

    force: Lanes  # mean over the step, subtracted from the thrust, N
    damping: Lanes  # its derivative with respect to the velocity, >= 0, N s/m; 0 if it is small


class NoState(NamedTuple):
    """The state of an effect that has none."""


def _nothing(*_: Any) -> None:
    return None


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An effect of the plant.

    Attributes
    ----------
    name, label, description, source : str
        Name in configs, name on the screen (left out: the same), what it is in a sentence, where it
        comes from.
    step : callable
        ``step(par, state, seen) -> (Resistance, state)``, a function of lanes: records of the types
        `Parameters` and `State`, and a `MidStep`. The state is that of the step's start, returned
        is that of its end.
    Parameters, State : type
        NamedTuples of lanes; the comment of a field says what it is, and its unit. At rest before
        the first step the state is zero.
    parameters : tuple of Parameter
        The fields of its config.
    friction : bool
        Whether its force is recorded in the channel ``friction``; an acceleration has it always.
    lane : callable
        ``lane(values, friction) -> Parameters``: plain numbers from the values of the config by
        name, and the numbers of ``plant.x.friction``, be that enabled or not. Left out, the values
        themselves.
    level : callable
        ``level(par, v) -> force``, N: at constant velocities v, m/s, (n,); what the check of a
        motion counts as friction. Left out, nothing.
    sliding : callable
        ``sliding(friction, v) -> State`` of steady sliding at v, m/s, about which the loop of an
        observer with this effect is linearised. Left out, all zero.
    refuse : callable
        ``refuse(par) -> str or None``: why it does not work with its parameters.
    """

    name: str
    label: str = ""
    description: str
    source: str = "an effect of one's own"
    step: Callable[[Any, Any, MidStep], tuple[Resistance, Any]]
    Parameters: Any
    State: Any = NoState
    parameters: tuple[Parameter, ...] = ()
    friction: bool = True
    lane: Callable[[Mapping[str, Any], LuGre], Any] | None = None
    level: Callable[[Any, Any], Any] | None = None
    sliding: Callable[[LuGre, float], Any] | None = None
    refuse: Callable[[Any], str | None] = _nothing

    def __post_init__(self) -> None:
        """Take the name as the label where there is none."""
        if self.label == "":
            object.__setattr__(self, "label", self.name)

    def lane_parameters(self, values: Mapping[str, Any], friction: LuGre) -> Any:
        """Return `Parameters` of one lane, as plain numbers."""
        if self.lane is not None:
            return self.lane(values, friction)
        return self.Parameters(**{name: values[name] for name in self.Parameters._fields})
