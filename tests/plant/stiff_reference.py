"""One axis under its controller, solved by scipy's stiff solvers: the truth for the integrator.

Written from eqs (15) to (24) of the paper and docs/physics.md: it imports no part of the simulator.
The plant is a mass with LuGre friction, the encoder is exact, and the command is held for each
control period, at whose start the solver begins afresh. The force is ideal, or that of three phases
whose currents follow their commands.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import odeint, solve_ivp

from tests.nominal_motor import (
    CONTROL_PERIOD,
    CURRENT_BANDWIDTH,
    FORCE_LIMIT,
    KNEE_CURRENT,
    PEAK_CURRENT,
    PEAK_FORCE,
    POLE_PITCH,
    Axis,
    low_pass,
)

Array = NDArray[np.float64]
Force = Callable[[float, float], float]
"""Net force, N, at a time since the start of the period, s, and a displacement since then, m."""


def rates(t: float, y: Array, axis: Axis, force: float | Force) -> tuple[float, float, float]:
    """Return d/dt of displacement, velocity and bristle state: eqs (16), (20) to (22)."""
    net = force(t, float(y[0])) if callable(force) else force
    v, z = float(y[1]), float(y[2])
    g = (axis.F_c + (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))) / axis.sigma_0
    dz = v - abs(v) / g * z
    friction = axis.sigma_0 * z + axis.sigma_1 * dz + axis.sigma_2 * v
    return v, (net - friction) / axis.M, dz


def jacobian(_t: float, y: Array, axis: Axis, _force: float | Force) -> Array:
    """Return the derivatives of `rates` with respect to the state, at a force without slope."""
    v, z = float(y[1]), float(y[2])
    drop = (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))
    g = (axis.F_c + drop) / axis.sigma_0
    dg = -2.0 * v / axis.v_s**2 * drop / axis.sigma_0
    zz = -abs(v) / g
    zv = 1.0 - z * (math.copysign(1.0, v) * g - abs(v) * dg) / g**2
    vv = -(axis.sigma_1 * zv + axis.sigma_2) / axis.M
    vz = -(axis.sigma_0 + axis.sigma_1 * zz) / axis.M
    return np.array([[0.0, 1.0, 0.0], [0.0, vv, vz], [0.0, zv, zz]])


def hold(
    axis: Axis,
    state: tuple[float, float, float],
    force: float | Force,
    *,
    duration: float = CONTROL_PERIOD,
    method: str = "LSODA",
    tolerance: float = 1e-10,
) -> tuple[float, float, float]:
    """Return position, velocity and bristle state after `duration` seconds of `force`.

    The position is solved for as a displacement, so that its tolerance is not one of the whole
    stroke. Absolute tolerances are `tolerance` times 0.1 mm, 1 mm/s and 1 um.
    """
    p, v, z = state
    absolute = tolerance * np.array([1e-4, 1e-3, 1e-6])
    if method == "LSODA":  # as solve_ivp has it, but with its steps in Fortran
        reached, told = odeint(
            rates,
            (0.0, v, z),
            (0.0, duration),
            args=(axis, force),
            Dfun=jacobian,
            full_output=True,
            rtol=tolerance,
            atol=absolute,
            mxstep=100_000,
            tfirst=True,
        )
        if told["message"] != "Integration successful.":
            raise RuntimeError(told["message"])
        moved, v, z = (float(value) for value in reached[-1])
        return p + moved, v, z
    solution = solve_ivp(
        rates,
        (0.0, duration),
        (0.0, v, z),
        method=method,
        jac=jacobian,
        args=(axis, force),
        rtol=tolerance,
        atol=absolute,
        t_eval=(duration,),
    )
    if not solution.success:
        raise RuntimeError(solution.message)
    moved, v, z = (float(value) for value in solution.y[:, -1])
    return p + moved, v, z


_GAUSS = np.polynomial.legendre.leggauss(12)
"""Nodes and weights over a period: exact to rounding for a mode, and currents, far slower."""


@dataclass(frozen=True)
class Mode:
    """A structural resonance between guides and encoder; what it adds is in closed form."""

    frequency: float  # Hz
    damping: float
    coupling: float

    def advance(
        self, y: float, rate: float, force: Callable[[float], float], M: float
    ) -> tuple[float, float]:
        """Return deflection and rate after a period of `force` over time: Duhamel's integral."""
        w, zeta, T = 2.0 * math.pi * self.frequency, self.damping, CONTROL_PERIOD
        pole = complex(-zeta * w, w * math.sqrt(1.0 - zeta**2))
        # y is Re(c e^(pole t)), its rate Re(c pole e^(pole t)); an impulse turns the rate alone
        c = complex(y, (y * pole.real - rate) / pole.imag) * np.exp(pole * T)
        for node, weight in zip(*_GAUSS, strict=True):
            t = 0.5 * T * (1.0 + float(node))
            impulse = 0.5 * T * float(weight) * self.coupling * force(t) / M
            c += complex(0.0, -impulse / pole.imag) * np.exp(pole * (T - t))
        return c.real, (c * pole).real


@dataclass
class Phases:
    """Three phases with currents that lag; the controller takes them for the nominal ones.

    Parameters
    ----------
    peak : float
        Thrust of one phase at 10 A, N.
    third : float
        Third harmonic of the thrust over position.
    offset : tuple of float
        Currents at zero command, A.
    """

    peak: float = PEAK_FORCE
    third: float = 0.0
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)
    _current: Array = field(default_factory=lambda: np.zeros(3), init=False)

    def share(self, force: float, p: float) -> tuple[Array, float]:
        """Return the current commands at position `p`, and the force that they would give."""
        shape = np.sin(2.0 * math.pi * (p / POLE_PITCH - np.arange(3) / 3.0))
        pull = np.maximum(0.0, math.copysign(1.0, force) * shape)
        y = np.clip(abs(force) * pull / (PEAK_FORCE * (pull**2).sum()), 0.0, 1.0)
        B = (PEAK_CURRENT / KNEE_CURRENT) ** 2
        current = PEAK_CURRENT * np.sqrt(y / (1.0 + B * (1.0 - y)))
        return current, math.copysign(PEAK_FORCE * float(y @ pull), force)

    def thrust(self, command: Array, p: float) -> Force:
        """Return the thrust over the period that begins now, under a `command`."""
        B, w = (PEAK_CURRENT / KNEE_CURRENT) ** 2, 2.0 * math.pi * CURRENT_BANDWIDTH
        settled = np.clip(command + self.offset, -PEAK_CURRENT, PEAK_CURRENT)
        each = list(zip(settled.tolist(), (self._current - settled).tolist(), strict=True))
        scale = self.peak / (1.0 - self.third)

        def force(t: float, moved: float) -> float:
            rest, theta = math.exp(-w * t), 2.0 * math.pi * (p + moved) / POLE_PITCH
            total = 0.0
            third = self.third * math.sin(3.0 * theta)  # the same for all phases
            for k, (target, off) in enumerate(each):
                q = ((target + off * rest) / PEAK_CURRENT) ** 2
                shape = math.sin(theta - 2.0 * math.pi * k / 3.0) + third
                total += (1.0 + B) * q / (1.0 + B * q) * shape
            return scale * total

        self._current = settled + (self._current - settled) * math.exp(-w * CONTROL_PERIOD)
        return force


def _over_time(net: float | Force, speed: float, load: float) -> Callable[[float], float]:
    """Return the thrust over the time in a period, at a steady speed."""
    return lambda t: (net(t, speed * t) if callable(net) else net) + load


@dataclass
class Loop:
    """One axis under PD control, eq. (15), with the LuGre observer, eqs (23), (24).

    Parameters
    ----------
    axis : Axis
        The controller's model of the motor, and its gains.
    p : float
        Where it begins, at rest, m.
    law : str
        ``off``, ``observer`` (K = 0), ``residual`` or ``reversed``; docs/compensation.md.
    delay : int
        Control periods until a command acts, 0 or 1.
    mode : Mode, optional
        A resonance, for an ideal force.
    truth : Axis, optional
        The motor, where it is another than the model.
    ripple : tuple of float
        Amplitude and period of the encoder's error, m.
    phases : Phases, optional
        In place of the ideal force. A mode then feels the thrust at the place where the period
        began and ended, straight between them.
    method : str
        Solver of `scipy.integrate.solve_ivp`.
    """

    axis: Axis
    p: float
    law: str = "off"
    delay: int = 0
    mode: Mode | None = None
    phases: Phases | None = None
    truth: Axis | None = None
    ripple: tuple[float, float] = (0.0, 1.0)
    method: str = "LSODA"
    _state: tuple[float, float] = field(default=(0.0, 0.0), init=False)  # v and z
    _swing: tuple[float, float] = field(default=(0.0, 0.0), init=False)
    _last: tuple[float, float, float] | None = field(default=None, init=False)  # e, p_meas, v
    _z_hat: float = field(default=0.0, init=False)
    _residual: float = field(default=0.0, init=False)
    _acting: tuple[float, float] = field(default=(0.0, 0.0), init=False)  # f - f_f*, and K

    def follow(self, p_ref: Array, load: Array | None = None) -> Array:
        """Follow a reference, one value a control period; return the positions reached after each.

        Parameters
        ----------
        p_ref : ndarray, shape (ticks,)
            Position reference, m.
        load : ndarray, shape (ticks,), optional
            External load force, N.

        Returns
        -------
        ndarray, shape (ticks,)
            True position at the end of each period, m.
        """
        reached = np.empty(len(p_ref))
        pending = (0.0, np.zeros(3), (0.0, 0.0))
        for k, reference in enumerate(p_ref):
            seen = self.p + self._swing[0]
            p_meas = seen + self.ripple[0] * math.sin(2.0 * math.pi * seen / self.ripple[1])
            wanted, estimate, K = self._control(float(reference), p_meas)
            current, force = np.zeros(3), wanted
            if self.phases is not None:
                current, force = self.phases.share(wanted, p_meas)
            now = (force, current, (force - estimate, K))
            acts, pending = (pending, now) if self.delay else (now, now)
            force, current, self._acting = acts
            against = 0.0 if load is None else float(load[k])
            net = self._net(force, current, against)
            began = self.p
            motor = self.truth or self.axis
            self.p, *rest = hold(motor, (self.p, *self._state), net, method=self.method)
            self._state = (rest[0], rest[1])
            if self.mode is not None:
                speed = (self.p - began) / CONTROL_PERIOD
                thrust = _over_time(net, speed, against)
                self._swing = self.mode.advance(*self._swing, thrust, motor.M)
            reached[k] = self.p
        return reached

    def _net(self, force: float, current: Array, load: float) -> float | Force:
        if self.phases is None:
            return force - load
        thrust = self.phases.thrust(current, self.p)
        return lambda t, moved: thrust(t, moved) - load

    def _control(self, reference: float, p: float) -> tuple[float, float, float]:
        """Return the limited force command, the friction estimate and K."""
        axis, T = self.axis, CONTROL_PERIOD
        e = reference - p
        first = self._last is None
        e_last, p_last, v_last = self._last or (e, p, 0.0)
        de, v = (e - e_last) / T, (p - p_last) / T
        a = 0.0 if first else (v - v_last) / T
        self._last = (e, p, v)
        u = min(max(axis.k_p * e + axis.k_d * de, -FORCE_LIMIT), FORCE_LIMIT)
        g = (axis.F_c + (axis.F_s - axis.F_c) * math.exp(-((v / axis.v_s) ** 2))) / axis.sigma_0
        decay = abs(v) / g
        K = 0.0 if first else self._adapt(a, decay)
        # Exact for a velocity held over the period; expm1 keeps its digits near rest.
        gain = -math.expm1(-decay * T) / decay if decay > 0.0 else T
        z = self._z_hat * math.exp(-decay * T) + (v + K) * gain
        if self.law in {"residual", "reversed"}:
            most = 1.2 * axis.F_s / axis.sigma_0
            z = min(max(z, -most), most)
        force = axis.sigma_0 * z + axis.sigma_1 * (z - self._z_hat) / T + axis.sigma_2 * v
        self._z_hat = z
        added = 0.0 if self.law == "off" else force
        return min(max(u + added, -FORCE_LIMIT), FORCE_LIMIT), force, K

    def _adapt(self, a: float, decay: float) -> float:
        """Return K of the laws that filter the force balance at 30 Hz."""
        axis = self.axis
        known, K_acting = self._acting
        own = axis.sigma_1 * K_acting if self.law == "residual" else 0.0
        self._residual += low_pass(30.0) * (axis.M * a - known - own - self._residual)
        D = axis.sigma_1 * decay - axis.sigma_0
        if self.law == "residual" and D < 0.0:
            return 40.0 * D * self._residual / (D**2 + (0.4 * axis.sigma_0) ** 2)
        return -self._residual / axis.sigma_1 if self.law == "reversed" else 0.0
