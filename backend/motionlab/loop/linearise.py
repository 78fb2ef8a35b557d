"""The sampled loop of one axis, linearised about standing still or about sliding at one velocity.

The plant, from force command to position, is held over a control period (zero-order hold), as
`motionlab.loop.lane_plant` has it. Its gain is the thrust that one more newton of command gives, as
a mean over the pole pitch. The controller is the kernel's own control half, differenced. Limits,
quantisation, commutation and other changes along the pitch are left out.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.kernel.build import lane
from motionlab.kernel.force_gain import force_gain, lanes_of
from motionlab.kernel.force_maps import check_maps, map_digests
from motionlab.kernel.law_calls import LAWS_BY_NUMBER, laws_of
from motionlab.kernel.layout import (
    INPUT_ROWS,
    LAW_NUMBER,
    LAW_PARAMETERS,
    MODEL_FRICTION,
    STATE_ROWS,
    LawState,
    Parameters,
)
from motionlab.kernel.motion import Ahead
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDTH, cached
from motionlab.lanes.bank import TABLES
from motionlab.laws import LAWS, OWN, SOURCES, Law
from motionlab.loop import lane_plant
from motionlab.loop.lane_controller import (
    COMMAND_STATES,
    CONTROLLER_SIZE,
    MEMORY_STATES,
    about,
    linear_numbers,
    read_probes,
    write_probes,
)
from motionlab.loop.lane_plant import PLANT_SIZE, sliding_force
from motionlab.plant.friction import LuGre
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]

T_S = CONTROL_PERIOD
SLIDING = 4.0
"""Velocity at which limits of stability are looked for, in Stribeck velocities: friction no longer
falls with velocity, and no sticking stabilises the loop."""


QUOTIENT = "has no linearisation: its K is a quotient that passes through 0/0"


class NoLinearisation(ConfigError):
    """A law that cannot be linearised."""


@dataclass(frozen=True)
class StateSpace:
    """A sampled linear system ``x+ = A x + B u, y = C x + D u`` of one input and one output."""

    A: Array
    B: Array
    C: Array
    D: float

    def response(self, frequency: Array) -> Complex:
        """Return the frequency response at `frequency`, Hz, shape (n,)."""
        used = _in_path(self.A != 0.0, self.B != 0.0, self.C != 0.0)
        A, B, C = self.A[np.ix_(used, used)], self.B[used], self.C[used]
        z = np.exp(2j * np.pi * frequency * T_S)
        pencil = z[:, None, None] * np.eye(len(A)) - A
        inside = np.linalg.solve(pencil, np.broadcast_to(B[:, None], (len(z), len(B), 1)))
        return np.asarray(inside[..., 0] @ C + self.D, dtype=np.complex128)


@dataclass(frozen=True)
class Loop:
    """The linearised loop of one axis.

    Attributes
    ----------
    plant : StateSpace
        Force command, N, to position, m.
    controller : StateSpace
        Position, m, to the opposite of the force command, N.
    """

    plant: StateSpace
    controller: StateSpace

    def open(self, frequency: Array) -> Complex:
        """Return the open loop ``L = C P`` at `frequency`, Hz; closed, ``1/(1 + L)`` remains."""
        return self.plant.response(frequency) * self.controller.response(frequency)

    def closed(self) -> Array:
        """Return the matrix of the closed loop, whose eigenvalues are its poles in the z plane."""
        p, c = self.plant, self.controller
        closed = [
            [p.A - c.D * np.outer(p.B, p.C), -np.outer(p.B, c.C)],
            [np.outer(c.B, p.C), c.A],
        ]
        return np.block(closed)

    def to_error(self, frequency: Array, *, delay: bool) -> Complex:
        """Return the response of the following error, m, to a force that the controller adds, N.

        ``-P S_f/(1 + L)``, where S_f is what the controller makes of knowing that force: its
        disturbance observer takes it for its own. With `delay` it acts a period later.
        """
        p, c = self.plant, self.controller
        known = np.zeros(len(c.A))
        known[-COMMAND_STATES] = 1.0  # the pending force, and the acting one where nothing is late
        if not delay:
            known[-2 * COMMAND_STATES] = 1.0
        enters = np.concatenate([p.B * (0.0 if delay else 1.0), known])
        leaves = np.concatenate([-p.C, np.zeros(len(c.A))])
        return StateSpace(self.closed(), enters, leaves, 0.0).response(frequency)

    @property
    def stable(self) -> bool:
        """Whether every pole lies inside the unit circle."""
        return _is_stable(self.closed())


@TABLES.lease()
def linearise(scenario: Scenario, variant: str, axis: str, *, v: float) -> Loop:
    """Return the loop of one axis of one variant about one velocity.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers.
    variant : str
        Which controller.
    axis : str
        ``x`` or ``y``.
    v : float
        Sliding velocity, m/s; 0 is stuck.

    Raises
    ------
    NoLinearisation
        For the law ``published-k``, and ``reversed-k`` with a share of k_d: their K is a quotient.
    ConfigError
        If a force map is not there, or its currents do not reach far enough.
    """
    return _loop(parameters(scenario, variant, axis), v)


@TABLES.lease()
def is_stable(scenario: Scenario, variant: str, axis: str, *, v: float) -> bool:
    """Return whether the loop of `linearise` is stable; a slider moves one loop, the others stay.

    Raises
    ------
    ConfigError
        As `linearise`.
    """
    versions = (*map_digests([(0, scenario)]), *SOURCES.values())
    return _stable(parameters(scenario, variant, axis), v, (variant, axis, *versions))


@functools.lru_cache(maxsize=64)
def _stable(par: Parameters, v: float, _versions: tuple[str, ...]) -> bool:
    return _loop(par, v).stable


def _in_path(leads: Flags, enters: Flags, leaves: Flags) -> NDArray[np.intp]:
    """Return the controllable and observable states; the others change no response."""
    reach = np.linalg.matrix_power(leads | np.eye(len(leads), dtype=bool), len(leads))
    return np.flatnonzero((reach @ enters) & (leaves @ reach))


def _is_stable(A: Array) -> bool:
    return bool(np.abs(np.linalg.eigvals(A)).max() < 1.0)


def parameters(scenario: Scenario, variant: str, axis: str) -> Parameters:
    """Return the linearisation's parameters of a scenario: one lane, as plain numbers.

    Parameters
    ----------
    scenario, variant, axis
        As `linearise`.

    Raises
    ------
    ConfigError
        As `linearise`.
    """
    check_maps(scenario)
    controller = scenario.variants[variant].controller
    par, compensation = lane(scenario, controller, axis), controller.compensation
    field = LAWS[compensation.law].quotient(compensation.values())
    if par.compensation.enabled and field is not None:
        raise NoLinearisation(
            FieldError(
                loc=f"variants.{variant}.controller.compensation.{field}",
                message=QUOTIENT,
                value=getattr(compensation, field),
            )
        )
    return par


def _loop(par: Parameters, v: float) -> Loop:
    return Loop(plant_about(par, v), controller_about(par, v))


def plant_about(par: Parameters, v: float, *, disturbance: bool = False) -> StateSpace:
    """Return the plant of one lane about a velocity, m/s, from a force held over a control period.

    The force, N, is the command, or, with `disturbance`, one that adds to the thrust, such as its
    ripple; the output is the position, m.
    """
    numbers, gains = lanes_of(par), plant_gains(par, np.array([v]))
    system = np.empty((1, PLANT_SIZE, PLANT_SIZE))
    n = write_plants(numbers, np.array([v]), gains, system, disturbance)
    return _state_space(system[0], n)


def controller_about(par: Parameters, v: float) -> StateSpace:
    """Return the controller of one lane about a velocity, m/s: position to minus the force command.

    The kernel's own control half is differenced about sliding with the reference: a step up and a
    step down of each number that it remembers, and of the measured position.
    """
    system = np.empty((CONTROLLER_SIZE, CONTROLLER_SIZE))
    controller = par.controller
    n = write_controller(lanes_of(par), controller.k_p, controller.k_d, v, system)
    return _state_space(system, n)


def _state_space(system: Array, n: int) -> StateSpace:
    A, B, C = system[:n, :n].copy(), system[:n, n].copy(), system[n, :n].copy()
    return StateSpace(A, B, C, float(system[n, n]))


def plant_gains(par: Parameters, v: Array) -> Array:
    """Return the loop's force gain about velocities, m/s, (n,); 1 for an ideal force."""
    if par.controller.ideal_force > 0.0:
        return np.ones(len(v))
    return force_gain(par, np.array([sliding_force(par.friction, float(each)) for each in v]))


@cached
def write_plants(
    numbers: Array, velocity: Array, gains: Array, systems: Array, disturbance: bool
) -> int:
    """Write the plant at velocities, shapes (v,) and (v, PLANT_SIZE, PLANT_SIZE); return states."""
    A, product = np.empty_like(systems[0]), np.empty_like(systems[0])
    states = 0
    for k in range(len(velocity)):
        v, gain = velocity[k], gains[k]
        states = lane_plant.plant_about(numbers, v, gain, disturbance, systems[k], A, product)
    return states


def write_controller(numbers: Array, k_p: float, k_d: float, v: float, system: Array) -> int:
    """Write the controller with gains at a velocity; return the number of its states."""
    numbers = numbers.copy()
    inputs = np.empty((1, INPUT_ROWS + len(Ahead._fields), 2))
    sliding = np.empty(len(LawState._fields))
    law_states = _begin(numbers, k_p, k_d, v, inputs, sliding)
    if (law := LAWS_BY_NUMBER[int(numbers[LAW_NUMBER, 0])]).name in OWN:
        law_states = _own_law_about(law, numbers, v, sliding)
        inputs[0, INPUT_ROWS:, :] = np.array(_sliding_ahead(v))[:, None]
    states, measured = np.empty((STATE_ROWS, WIDTH)), np.empty((1, WIDTH))
    laws = laws_of(numbers)
    end = law_states + MEMORY_STATES
    for first in range(0, end + 1, WIDTH // 2):
        _probe(first, numbers, v, sliding, law_states, states, measured, system, False)
        control_once(numbers, states, inputs, measured, laws)
        _probe(first, numbers, v, sliding, law_states, states, measured, system, True)
    return end


def _sliding_ahead(v: float) -> Any:
    """Return what a law knows of a motion at a velocity, m/s, whose position now is 0."""
    way = v * CONTROL_PERIOD
    return Ahead(way, v, 0.0, 2.0 * way, v, 0.0, 0.0)


def _own_law_about(law: Law, numbers: Array, v: float, sliding: Array) -> int:
    """Do for a law of one's own what `linear_numbers` and `about` do for those that ship."""
    for name in law.limits:
        numbers[LAW_PARAMETERS + law.Parameters._fields.index(name)] = np.inf
    states = len(law.State._fields)
    friction = LuGre(*numbers[MODEL_FRICTION : MODEL_FRICTION + len(LuGre._fields), 0].tolist())
    sliding[:states] = 0.0 if law.sliding is None else law.sliding(friction, v)
    return states


@cached
def _begin(  # noqa: PLR0913, PLR0917 - as `about`
    numbers: Array, k_p: float, k_d: float, v: float, inputs: Array, sliding: Array
) -> int:
    linear_numbers(numbers, k_p, k_d)
    return about(numbers, v, inputs, sliding)


@cached
def _probe(  # noqa: PLR0913, PLR0917 - as `write_probes`
    first: int,
    numbers: Array,
    v: float,
    sliding: Array,
    law_states: int,
    states: Array,
    measured: Array,
    system: Array,
    read: bool,
) -> None:
    if read:
        read_probes(first, numbers, v, sliding, law_states, states, system)
    else:
        write_probes(first, numbers, v, sliding, law_states, states, measured)
