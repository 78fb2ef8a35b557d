"""The sampled loop of one axis, linearised about standing still or about sliding at one velocity.

The plant, from force command to position, is held over a control period (zero-order hold)::

    M dv/dt = f - f_f,   df/dt = omega (gain f_command - f)
    f_f = sigma_0 z + sigma_1 dz/dt + sigma_2 v,   dz/dt = lambda g'(v_0) v - lambda z
    d^2y/dt^2 = omega_r^2 (compliance f - y) - 2 zeta omega_r dy/dt,   p_meas = p + y

with ``lambda = abs(v_0)/g(v_0)``; stuck (v_0 = 0), ``dz/dt = v``. The gain is the thrust that one
more newton of command gives, as a mean over the pole pitch. The controller is the kernel's own
control half, differenced. Limits, quantisation, commutation and other changes along the pitch are
left out.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError
from motionlab.force_sharing.functions import CLOSED_FORM
from motionlab.kernel.build import lane
from motionlab.kernel.force_maps import check_maps, force_gain, map_digests
from motionlab.kernel.law_calls import law_of, laws_of
from motionlab.kernel.layout import (
    INPUT_ROWS,
    STATE_ROWS,
    Command,
    ControllerState,
    Inputs,
    LawParameters,
    Parameters,
    column,
    state_row,
)
from motionlab.kernel.tick import control_once
from motionlab.lanes import WIDTH
from motionlab.lanes.bank import TABLES
from motionlab.laws import LAWS
from motionlab.plant.friction import LuGre, stribeck_fade, stribeck_level
from motionlab.plant.resonance import natural
from motionlab.timing import CONTROL_PERIOD, PLANT_STEP

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Flags = NDArray[np.bool_]

T_S = CONTROL_PERIOD
_NO_FRICTION = 1e-30
"""Below this stiction there is no bristle, N."""
SLIDING = 4.0
"""Velocity at which limits of stability are looked for, in Stribeck velocities: friction no longer
falls with velocity, and no sticking stabilises the loop."""
_COARSE, _FINE, _FURTHEST = 1.2, 1e-4, 1e3
_STEP, _SHARE = 1e-5, 1e-4
_STEP_AT_REST = 1e-10
"""Steps of a velocity, of a law's state and of a velocity at rest by which the controller is
differenced, as shares of their scale."""
_CREEP = 1e-3
"""Rate at which a stuck bristle relaxes, 1/s: a mover may rest anywhere, and no pole lies at 1."""


_MEMORY = (
    *(f"memory.{name}" for name in ControllerState._fields if name != "e_last"),
    *(
        f"{when}.{name}"
        for when in ("acting", "pending")
        for name in Command._fields
        if not name.startswith("current_")
    ),
)
"""States of the linearised controller beside those of its law. Its force needs no currents; the
reference is zero, so the last error is a position."""


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
    maps = map_digests([(0, scenario)])
    return _stable(parameters(scenario, variant, axis), v, (variant, axis, *maps))


@functools.lru_cache(maxsize=64)
def _stable(par: Parameters, v: float, _maps: tuple[str, ...]) -> bool:
    return _loop(par, v).stable


@TABLES.lease()
def stability_limits(
    scenario: Scenario, variant: str, axis: str, speed: float = SLIDING
) -> dict[str, float | None]:
    """Return the nearest gains of one axis at which its loop changes between stable and unstable.

    Each gain is moved alone, up from a stable loop and down from an unstable one.

    Parameters
    ----------
    scenario : Scenario
        Motor and controllers.
    variant : str
        Which controller.
    axis : str
        ``x`` or ``y``.
    speed : float
        Sliding velocity, in Stribeck velocities of the motor; 0 is stuck.

    Returns
    -------
    dict of str to float or None
        ``k_p``, N/m, and ``k_d``, N s/m; None where no such gain is found up to a thousandfold.

    Raises
    ------
    ConfigError
        As `linearise`.
    """
    par = parameters(scenario, variant, axis)
    return {gain: _edge(par, gain, speed * par.friction.v_s) for gain in ("k_p", "k_d")}


def _edge(par: Parameters, gain: str, v: float) -> float | None:
    """Return the gains at which stability changes; the closed loop is affine in each gain."""
    start = getattr(par.controller, gain)
    if start == 0.0:
        return None

    def closed(value: float) -> Array:
        controller = par.controller._replace(**{gain: value})
        return _loop(par._replace(controller=controller), v).closed()

    here = closed(start)
    slope = closed(2.0 * start) - here

    def stable(factor: float) -> bool:
        return _is_stable(here + (factor - 1.0) * slope)

    begins = stable(1.0)
    ratio = _COARSE if begins else 1.0 / _COARSE
    inside = 1.0
    while stable(inside * ratio) == begins:
        inside *= ratio
        if not 1.0 / _FURTHEST < inside < _FURTHEST:
            return None
    outside = inside * ratio
    while abs(outside / inside - 1.0) > _FINE:
        middle = math.sqrt(inside * outside)
        inside, outside = (middle, outside) if stable(middle) == begins else (inside, middle)
    return start * math.sqrt(inside * outside)


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
                message="has no linearisation: its K is a quotient that passes through 0/0",
                value=getattr(compensation, field),
            )
        )
    return par


def _loop(par: Parameters, v: float) -> Loop:
    return Loop(plant_about(par, v), controller_about(par, v))


class _Bristle(NamedTuple):
    """Bristle state about a velocity: ``dz/dt = slope v - rate z``."""

    slope: float  # lambda g'(v_0), 1; 1 where it sticks
    rate: float  # lambda, 1/s


def _bristle(f: LuGre, v: float) -> _Bristle:
    if f.F_s < _NO_FRICTION:
        return _Bristle(slope=0.0, rate=1.0)
    if v == 0.0:
        return _Bristle(slope=1.0, rate=_CREEP)
    speed = abs(v)
    dip = (f.F_s - f.F_c) * float(stribeck_fade(speed, f.v_s)) / f.sigma_0
    g = f.F_c / f.sigma_0 + dip
    bend = -2.0 * speed / f.v_s**2 * dip  # g'(v_0), s
    return _Bristle(slope=speed / g * bend, rate=speed / g)


def _force(f: LuGre, v: float) -> float:
    """Return the friction force of sliding at a velocity, N; the breakaway force at rest."""
    speed = abs(v)
    return float(stribeck_level(speed, f.F_c, f.F_s, f.v_s)) + f.sigma_2 * speed


def plant_about(par: Parameters, v: float, *, disturbance: bool = False) -> StateSpace:
    """Return the plant of one lane about a velocity, m/s, from a force held over a control period.

    The force, N, is the command, or, with `disturbance`, one that adds to the thrust, such as its
    ripple; the output is the position, m.
    """
    from scipy.linalg import expm

    f, M, mode = par.friction, par.mechanics.M, par.resonance
    bristle = _bristle(f, v)
    n = 4 if mode.compliance == 0.0 else 6  # position, velocity, bristle, force; deflection, rate
    A, B, C, per_force = np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n)
    A[0, 1] = C[0] = 1.0
    A[1, 1] = -(f.sigma_1 * bristle.slope + f.sigma_2) / M
    A[1, 2] = (f.sigma_1 * bristle.rate - f.sigma_0) / M
    A[2, 1], A[2, 2] = bristle.slope, -bristle.rate
    per_force[1] = 1.0 / M
    if mode.compliance != 0.0:
        stiffness, damping = natural(mode, PLANT_STEP)
        A[4, 5], A[5, 4], A[5, 5] = 1.0, -stiffness, -damping
        per_force[5] = stiffness * mode.compliance
        C[4] = 1.0

    ideal = par.controller.ideal_force > 0.0
    gain = 1.0 if ideal else force_gain(par, _force(f, v))
    rest = par.amplifiers.half_step
    if disturbance:
        B, A[3, 3] = per_force, -1.0
    elif ideal or rest == 0.0:  # the force is there at once
        B, A[3, 3] = gain * per_force, -1.0
    else:
        omega = -math.log(rest) / (0.5 * PLANT_STEP)
        A[:, 3] += per_force
        A[3, 3], B[3] = -omega, gain * omega
    held = np.zeros((n + 1, n + 1))
    held[:n, :n], held[:n, n] = A, B
    step = cast("Array", expm(held * T_S))
    return StateSpace(step[:n, :n], step[:n, n], C, 0.0)


def controller_about(par: Parameters, v: float) -> StateSpace:
    """Return the controller of one lane about a velocity, m/s: position to minus the force command.

    The kernel's own control half is differenced about sliding with the reference: a step up and a
    step down of each number that it remembers, and of the measured position.
    """
    rest = v == 0.0
    model = par.model_friction
    law = law_of(par)
    at_rest = law.State(*[0.0] * len(law.State._fields))
    sliding = at_rest if law.sliding is None else law.sliding(model, v)
    remembered = (*(f"law.s_{k}" for k in range(len(sliding))), *_MEMORY)
    rows = [state_row(path) for path in remembered]
    # At rest nothing cancels, and abs(v) is no straight line: a step so much smaller.
    speed = _STEP_AT_REST * model.v_s if rest else _STEP * min(model.v_s, abs(v))
    steps = np.ones(len(remembered) + 1)
    for path, step in (("p_last", speed * T_S), ("v_last", speed)):
        steps[remembered.index(f"memory.{path}")] = step
    steps[-1] = speed * T_S
    steps[: len(sliding)] = [_SHARE * abs(value) or _SHARE for value in sliding]
    numbers = np.array(column(_unbounded(par)))

    about = np.zeros(STATE_ROWS)
    about[state_row("age")] = 2.0  # differences of the encoder are taken from the second tick on
    about[state_row("failed")] = -1.0
    about[state_row("memory.p_last")] = -v * T_S
    about[state_row("memory.v_last")] = v
    force = 0.0 if rest else math.copysign(_force(model, v), v)
    about[state_row("law_number")] = par.compensation.law
    for k, value in enumerate(sliding):
        about[state_row(f"law.s_{k}")] = value
    for when in ("acting", "pending"):
        about[state_row(f"{when}.estimate")] = force
        about[state_row(f"{when}.added")] = force * (par.compensation.enabled > 0.0)
        about[state_row(f"{when}.force")] = about[state_row(f"{when}.added")]
    inputs = np.zeros((1, INPUT_ROWS, 2))
    inputs[0, Inputs._fields.index("v_ref")] = v

    n = len(remembered)
    probes = np.concatenate([np.diag(steps), -np.diag(steps)])
    blocks = -(-len(probes) // WIDTH)
    probes = np.concatenate([probes, np.zeros((blocks * WIDTH - len(probes), n + 1))])
    states = np.tile(about, (len(probes), 1))
    states[:, rows] += probes[:, :n]
    states[:, state_row("memory.e_last")] = -probes[:, remembered.index("memory.p_last")]
    parameters = np.tile(numbers[:, None], WIDTH)
    laws = laws_of(parameters)
    after = np.empty_like(states)
    for block in range(blocks):
        lanes = slice(block * WIDTH, (block + 1) * WIDTH)
        state = np.ascontiguousarray(states[lanes].T)
        measured = np.ascontiguousarray(probes[None, lanes, n])
        control_once(parameters, state, inputs, measured, laws)
        after[lanes] = state.T
    change = (after[: n + 1] - after[n + 1 : 2 * (n + 1)]) / (2.0 * steps[:, None])
    A, B = change[:n, rows].T, change[n, rows].copy()
    if rest:  # a mover may rest anywhere, and no pole lies at 1
        own = np.arange(len(sliding))
        stays = own[np.isclose(A[own, own], 1.0)]
        A[stays, stays] = math.exp(-_CREEP * T_S)
    acts = change[:, state_row("acting.force")]
    return StateSpace(np.ascontiguousarray(A), B, -acts[:n], -float(acts[n]))


def _unbounded(par: Parameters) -> Parameters:
    """Return parameters without limits, sharing and tables, which have no linearisation."""
    return par._replace(
        controller=par.controller._replace(force_limit=math.inf, ideal_force=1.0),
        law=_without(par, law_of(par).limits),
        force_model=par.force_model._replace(
            sharing=par.force_model.sharing._replace(law=CLOSED_FORM)
        ),
    )


def _without(par: Parameters, limits: tuple[str, ...]) -> LawParameters:
    """Return the parameters of a law without some of them that bound something."""
    fields = law_of(par).Parameters._fields
    return par.law._replace(**{f"p_{fields.index(name)}": math.inf for name in limits})
