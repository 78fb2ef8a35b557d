"""What a law of friction compensation declares, and what it may know.

A law is one module of this room: a name, parameters with unit, range and default, its state, and
one function of lanes that is called once in a control period. Everything else comes from here: the
fields of a config, the schema, sliders, ``motionlab laws``, the rows of the kernel, margins,
recordings, exported C, and the kernel in the page.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from motionlab.declarations import OURS, PAPER, Parameter
from motionlab.lanes import Lanes
from motionlab.plant.friction import LuGre

ROWS = 8
"""Most parameters of a law in the kernel, and numbers of its state."""

__all__ = ["OURS", "PAPER", "ROWS", "Estimate", "Law", "NoState", "Parameter", "Refusal", "Seen"]


class Seen(NamedTuple):
    """What a law may know in a control period, of each lane."""

    p_ref: Lanes  # position reference, m
    v_ref: Lanes  # velocity reference, m/s
    a_ref: Lanes  # acceleration reference, m/s^2
    p: Lanes  # measured position, m
    v: Lanes  # its difference over a period, m/s
    a: Lanes  # its second difference, m/s^2
    error: Lanes  # following error, m
    error_rate: Lanes  # its difference over a period, m/s
    u: Lanes  # PD force within its limit, N
    f_acting: Lanes  # force in effect since the last period, within all limits, N
    estimate_acting: Lanes  # the law's friction estimate of that period, N
    K_acting: Lanes  # the law's adaptation term of that period, m/s
    age: Lanes  # control periods since the start; differences are 0 in the first
    p_ref_1: Lanes  # position reference a period ahead, m
    v_ref_1: Lanes  # velocity reference a period ahead, m/s
    a_ref_1: Lanes  # acceleration reference a period ahead, m/s^2
    p_ref_2: Lanes  # position reference two periods ahead, m
    v_ref_2: Lanes  # velocity reference two periods ahead, m/s
    a_ref_2: Lanes  # acceleration reference two periods ahead, m/s^2
    phase: Lanes  # share of the lap that is done, 0 to 1; of the whole motion where it has no laps
    k_p: Lanes  # proportional gain, N/m
    k_d: Lanes  # derivative gain, N s/m
    M: Lanes  # mass in the controller's model, kg
    friction: LuGre  # friction in the controller's model


class Estimate(NamedTuple):
    """What a law gives in a control period."""

    force: Lanes  # friction estimate, which is added to the command, N
    z: Lanes  # bristle estimate at the end of the period, m; 0 of a law without a bristle
    K: Lanes  # adaptation term, m/s; 0 of a law without one


class NoState(NamedTuple):
    """The state of a law that has none."""


@dataclass(frozen=True)
class Refusal:
    """Why a law does not work with the value of a parameter."""

    parameter: str
    value: float
    reason: str
    limit: float  # from which on it does not, in the parameter's unit


def _nothing(*_: Any) -> None:
    return None


@dataclass(frozen=True, kw_only=True)
class Law:
    """A law of friction compensation.

    Attributes
    ----------
    name, label, description, source : str
        Name in configs, name on the screen (left out: the same), what it is in a sentence, where it
        comes from.
    step : callable
        ``step(par, state, seen) -> (Estimate, state)``, a function of lanes: records of the types
        `Parameters` and `State`, and a `Seen`.
    Parameters, State : type
        NamedTuples of lanes; the comment of a field says what it is, and its unit.
    parameters : tuple of Parameter
        The fields of its config.
    lane : callable
        ``lane(values, friction) -> Parameters``: plain numbers from the values of the config by
        name, and the friction of the controller's model. Left out, the values themselves.
    adds : bool
        Whether its estimate is added to the command at all.
    sliding : callable
        ``sliding(friction, v) -> State`` about which the loop is linearised: friction compensated
        at the velocity v, m/s. Left out, all zero.
    limits : tuple of str
        Fields of `Parameters` that bound something, which a linear loop does not have.
    resets : tuple of str
        Fields of `State` that begin at zero where another version of the law is taken while it
        runs. All others keep their numbers.
    quotient : callable
        ``quotient(values) -> str or None``: name of the parameter, or ``law``, with whose value
        the law has no linearisation.
    refuse : callable
        ``refuse(values, friction) -> Refusal or None``.
    """

    name: str
    label: str = ""
    description: str
    source: str = "a law of one's own"
    step: Callable[[Any, Any, Seen], tuple[Estimate, Any]]
    Parameters: Any
    State: Any = NoState
    parameters: tuple[Parameter, ...] = ()
    lane: Callable[[Mapping[str, Any], LuGre], Any] | None = None
    adds: bool = True
    sliding: Callable[[LuGre, float], Any] | None = None
    limits: tuple[str, ...] = field(default=())
    resets: tuple[str, ...] = ()
    quotient: Callable[[Mapping[str, Any]], str | None] = _nothing
    refuse: Callable[[Mapping[str, Any], LuGre], Refusal | None] = _nothing

    def __post_init__(self) -> None:
        """Take the name as the label where there is none."""
        if self.label == "":
            object.__setattr__(self, "label", self.name)

    def lane_parameters(self, values: Mapping[str, Any], friction: LuGre) -> Any:
        """Return `Parameters` of one lane, as plain numbers."""
        if self.lane is not None:
            return self.lane(values, friction)
        return self.Parameters(**{name: values[name] for name in self.Parameters._fields})
