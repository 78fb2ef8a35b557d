"""Section III: the stability proof and eqs (39) to (42), along runs of the loop.

With ``beta = e e_z``, ``e_z = z - z*`` the paper takes ``V = beta^2/2`` of eq. (37) and argues that
(25) makes ``dV/dt = -(k_p/k_d + abs(v)/g) beta^2 <= 0``, eq. (38). Along a simulated run every term
is known, the true bristle state z among them, so that V, its derivative by the argument and its
true derivative can be compared.

The paper states formulas here and no numbers. Their values for the circle's gains are used as the
printed numbers, and the sampled loop as the machine.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.plant import FrictionConfig
from motionlab.loop.linearise import linearise
from motionlab.loop.margins import margins
from motionlab.loop.steady_state_error import crossover, parabola_error, sine_error
from motionlab.paper.experiments import Experiments, Run
from motionlab.paper.printed_number import (
    COUNT,
    Compute,
    PrintedNumber,
    RowResult,
    RowSource,
    by_run,
    from_run,
    gains,
)
from motionlab.plant.friction import stribeck_level
from motionlab.telemetry.recording import VariantRecord
from motionlab.timing import CONTROL_PERIOD

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Lyapunov:
    """The terms of the argument along a run; all arrays of shape (ticks,).

    Attributes
    ----------
    time : ndarray
        From the first tick on, s.
    speed : ndarray
        Measured speed, m/s.
    error, bristle_error : ndarray
        e and e_z of eq. (27), m.
    V : ndarray
        Eq. (37), m^4.
    argued : ndarray
        dV/dt by the argument, eq. (38), m^4/s: never above 0.
    rate : ndarray
        dV/dt by central differences of V, m^4/s.
    denominator : ndarray
        Of K in eq. (25), N^2 s/m.
    """

    time: Array
    speed: Array
    error: Array
    bristle_error: Array
    V: Array
    argued: Array
    rate: Array
    denominator: Array

    @property
    def rising_share(self) -> float:
        """Share of the ticks at which V rises; zero by (38)."""
        return float((self.rate > 0.0).mean())

    @property
    def singular_places(self) -> NDArray[np.int_]:
        """Ticks after which the denominator of (25) has another sign: K has no bound there."""
        signs = np.sign(self.denominator)
        moves = np.flatnonzero(signs != 0.0)  # at rest on the reference it is 0/0, not a crossing
        return moves[np.flatnonzero(np.diff(signs[moves]) != 0.0)]

    @property
    def singular_rate(self) -> float:
        """Rate of zero crossings of the denominator, 1/s."""
        return len(self.singular_places) / (len(self.time) * CONTROL_PERIOD)

    @property
    def singular_speeds(self) -> Array:
        """Speeds at which it does, m/s."""
        return self.speed[self.singular_places]

    @property
    def zero_error_bristle(self) -> float:
        """Largest abs(e_z) at zero crossings of e, m; zero by (34).

        V is 0 there although the state is not: V is only semidefinite.
        """
        signs = np.sign(self.error)
        crossings = np.flatnonzero(signs[1:] * signs[:-1] < 0.0)
        at_rest = np.flatnonzero(signs == 0.0)
        places = np.concatenate([crossings, at_rest])
        return float(np.abs(self.bristle_error[places]).max()) if len(places) else 0.0


def lyapunov(
    record: VariantRecord, axis: str, *, friction: FrictionConfig, k_p: float, k_d: float
) -> Lyapunov:
    """Return the terms of the argument along one axis of a run.

    Parameters
    ----------
    record : VariantRecord
        Samples of a window, at least three ticks.
    axis : str
        ``x`` or ``y``.
    friction : FrictionConfig
        Of the controller's model.
    k_p, k_d : float
        Gains, N/m and N s/m.

    Raises
    ------
    ValueError
        If the window is shorter than three ticks or holds samples that are not finite.
    """
    e, z, z_hat, v, u = (
        record.channel(name, axis).astype(np.float64)
        for name in (
            "following_error",
            "bristle",
            "bristle_estimate",
            "velocity_measured",
            "pd_force",
        )
    )
    if len(e) < 3 or not np.isfinite([e, z, z_hat, v, u]).all():
        raise ValueError("a window needs three ticks, all of them before a divergence")
    steady = stribeck_level(v, friction.F_c, friction.F_s, friction.v_s)
    decay = friction.sigma_0 * np.abs(v) / steady
    e_z = z - z_hat
    beta = e * e_z
    V = 0.5 * beta**2
    return Lyapunov(
        time=np.arange(float(len(e))) * CONTROL_PERIOD,
        speed=np.abs(v),
        error=e,
        bristle_error=e_z,
        V=V,
        argued=-(k_p / k_d + decay) * beta**2,
        rate=np.gradient(V, CONTROL_PERIOD),
        denominator=friction.sigma_1 * u + e * k_d * (friction.sigma_1 * decay - friction.sigma_0),
    )


STABILITY = "stability"

NOISELESS: dict[str, Any] = {
    f"plant.{axis}.{field}": value
    for axis in "xy"
    for field, value in (("encoder.resolution", 0.0), ("amplifiers.bandwidth", 100e3))
}
"""No quantisation and no noticeable lag: only the control period can be the cause."""

_PRINTED = {"x": 10.4e-6, "y": 11.6e-6}


def terms(run: Run, variant: str, axis: str) -> Lyapunov | None:
    """Return the terms of the proof over a run's main window; None if it diverged."""
    record = run.recording.variants[variant]
    if record.diverged is not None:
        return None
    controller = run.prepared.scenario.variants[variant].controller
    gains = getattr(controller, axis)
    return lyapunov(
        record.cut(*run.prepared.window),
        axis,
        friction=getattr(controller.model, axis).friction,
        k_p=gains.k_p,
        k_d=gains.k_d,
    )


def published(experiments: Experiments, axis: str) -> Lyapunov | None:
    """Return the terms along the circle with K of (25) and a motor without noise or lag."""
    return terms(experiments.run("circle-published-k", NOISELESS), "B", axis)


def _along(axis: str, name: str) -> RowSource:
    """Return one number of the terms along that circle."""

    def compute(experiments: Experiments) -> RowResult:
        proof = published(experiments, axis)
        if proof is None:
            return RowResult(None, error="it diverged")
        return RowResult(getattr(proof, name))

    return RowSource(compute, by_run("circle-published-k", NOISELESS))


def _rows(axis: str) -> tuple[PrintedNumber, ...]:
    find = f"variants.B.axes.{axis}.max_abs_following_error"
    bound = partial(
        PrintedNumber, group=STABILITY, comparison="at_most", doing="circle with K as published"
    )
    claim = partial(
        bound,
        kind="claim",
        basis="circle with K of (25), nominal motor without encoder counts or current lag",
        figure=f"lyapunov-{axis}",
    )
    return (
        claim(
            *(f"lyapunov-rate-{axis}", "(32), (38)", f"Share of the time at which V rises, {axis}"),
            *("1", 0.0, "dV/dt <= 0"),
            band=0.01,
            reason="1 %: where V stands still, rounding of the record decides the sign of its "
            "difference",
            source=_along(axis, "rising_share"),
        ),
        claim(
            *(f"lyapunov-bristle-{axis}", "(34)"),
            f"Largest e_z where e passes through zero, {axis}",
            *("m", 0.0, "e_z = 0 if e = 0"),
            band=COUNT,
            reason="what one encoder count would hide, although this motor has none",
            source=_along(axis, "zero_error_bristle"),
        ),
        bound(
            *(f"published-k-{axis}", "(25), Fig. 5"),
            f"Following error of the circle with K of (25), {axis}",
            *("m", _PRINTED[axis], f"±{_PRINTED[axis] * 1e6:.1f} um"),
            band=0.1e-6,
            reason="half of the last printed digit and one encoder count, 50 nm each",
            basis="nominal motor, K exactly as printed",
            note="A chaotic run: its digits depend on the machine, its size does not",
            source=from_run(
                "circle-published-k",
                find,
                others={
                    "without compensation": ("circle-published-k", {}, find.replace(".B.", ".A.")),
                    "with K = 0": ("circle", {}, find),
                    "without encoder counts or lag": ("circle-published-k", NOISELESS, find),
                },
            ),
        ),
    )


STABILITY_ROWS = (*_rows("x"), *_rows("y"))


PERFORMANCE = "performance"
NO_FRICTION: dict[str, Any] = {
    "plant.force": "ideal",
    "plant.x.friction.enabled": False,
    "plant.y.friction.enabled": False,
}
"""Plant of eqs (39) to (42), (19): a mass without friction under the commanded force."""

_OMEGA = 2.0 * math.pi / 3.0
_RADIUS = 0.015
_SLOPE = 0.5
"""R of R t^2, m/s^2."""

_FORMULA = "the paper prints the formula, not the number"
_BASIS = "nominal mass without friction, any force commanded, PD alone, the circle's gains"


def _motion(kind: str, **fields: Any) -> dict[str, Any]:
    return NO_FRICTION | {"trajectory": {"kind": kind} | fields}


def _parabola(axis: str) -> dict[str, Any]:
    start, slope = {axis: -0.05}, {axis: _SLOPE}
    return _motion("parabola", start=start, coefficient=slope, duration=0.25)


def _ramp(axis: str) -> dict[str, Any]:
    start, velocity = {axis: -0.03}, {axis: 0.03}
    return _motion("ramp", start=start, velocity=velocity, lead_in=0.2, duration=2.0)


def _step(axis: str) -> dict[str, Any]:
    return _motion("step", height={axis: 1e-6}, delay=0.1, dwell=1.0)


def _error(run: Run, axis: str) -> np.ndarray:
    record = run.recording.variants["A"]
    return record.channel("following_error", axis).astype(np.float64)


def _late_mean(axis: str, changes: dict[str, Any]) -> Compute:
    """Return a computation of the mean following error over the last fifth of a run."""

    def compute(experiments: Experiments) -> RowResult:
        error = _error(experiments.run("circle", changes), axis)
        return RowResult(float(error[-len(error) // 5 :].mean()))

    return compute


def error_gain(run: Run, axis: str) -> complex:
    """Return error over reference at the circle's frequency, amplitude and phase."""
    start, stop = run.prepared.window
    time = np.arange(start, stop) * CONTROL_PERIOD
    turning = np.exp(-1j * _OMEGA * time)
    reference = run.prepared.reference.position[start:stop, "xy".index(axis)]
    error = _error(run, axis)[start:stop]
    return complex((error * turning).sum() / (reference * turning).sum())


def _amplitude(axis: str) -> Compute:
    def compute(experiments: Experiments) -> RowResult:
        gain = error_gain(experiments.run("circle", NO_FRICTION), axis)
        return RowResult(abs(gain) * _RADIUS)

    return compute


def _phase(axis: str) -> Compute:
    def compute(experiments: Experiments) -> RowResult:
        gain = error_gain(experiments.run("circle", NO_FRICTION), axis)
        return RowResult(float(np.angle(gain)) % (2.0 * math.pi))

    return compute


def _crossover(axis: str) -> Compute:
    def compute(_: Experiments) -> RowResult:
        loop = linearise(load_scenario("circle", NO_FRICTION), "A", axis, v=0.02)
        crossover = margins(loop.open).crossover
        return RowResult(None if crossover is None else 2.0 * math.pi * crossover)

    return compute


def _performance_rows(axis: str) -> tuple[PrintedNumber, ...]:
    M, k_p, k_d = gains("circle", axis)
    w_c = crossover(M, k_p, k_d)
    lag = 0.5 * k_p * k_d * w_c**2 * CONTROL_PERIOD / (k_p**2 + (k_d * w_c) ** 2)
    sine = sine_error(M, k_p, k_d, B=_RADIUS, w=_OMEGA)
    row = partial(PrintedNumber, group=PERFORMANCE, kind="formula", comparison="value")
    counted = partial(row, band=COUNT, reason="one encoder count, 50 nm")
    settled = partial(counted, doing="steps, ramps and parabolas without friction")
    basis, doing = f"{_BASIS}; at 1/3 Hz, over two laps", "circle without friction"
    recipe = by_run("circle", NO_FRICTION)
    return (
        row(
            *(f"crossover-{axis}", "(39)", f"Crossover frequency of the open loop, {axis}"),
            *("rad/s", w_c, _FORMULA),
            band=lag * w_c,
            reason=f"{lag:.1%}: the sampled loop differences the error, which lags by half a "
            "control period; that turns k_d w_c by w_c T/2, which adds k_p k_d w_c^2 T to "
            "abs(k_p + j k_d w_c)^2",
            basis="the sampled loop, linearised; without friction",
            source=RowSource(_crossover(axis)),
            doing="linearised loop",
        ),
        settled(
            *(f"step-error-{axis}", "(40)", f"Steady-state error of a step, {axis}", "m", 0.0, "0"),
            basis=f"{_BASIS}; step of 1 um, last fifth",
            source=RowSource(_late_mean(axis, _step(axis))),
        ),
        settled(
            *(f"ramp-error-{axis}", "(40)", f"Steady-state error of a ramp, {axis}", "m", 0.0, "0"),
            basis=f"{_BASIS}; 30 mm/s, last fifth",
            source=RowSource(_late_mean(axis, _ramp(axis))),
        ),
        settled(
            *(f"parabola-error-{axis}", "(40)"),
            f"Steady-state error of R t^2, R = 0.5 m/s^2, {axis}",
            *("m", parabola_error(M, k_p, _SLOPE), "2 M R/(k k_p)"),
            basis=f"{_BASIS}; last fifth of 0.25 s",
            source=RowSource(_late_mean(axis, _parabola(axis))),
        ),
        counted(
            *(f"sine-amplitude-{axis}", "(41), (42)", f"Error amplitude of the circle, {axis}"),
            *("m", sine.amplitude, _FORMULA),
            source=RowSource(_amplitude(axis), recipe),
            basis=basis,
            doing=doing,
        ),
        row(
            *(f"sine-phase-{axis}", "(42)", f"Error phase of the circle, {axis}"),
            *("rad", sine.phase % (2.0 * math.pi), "arctan(...)"),
            band=COUNT / sine.amplitude,
            reason="one encoder count over the amplitude",
            note="Of the two-argument arc tangent, 0 to 2 pi; as printed it is off by pi: errata",
            source=RowSource(_phase(axis), recipe),
            basis=basis,
            doing=doing,
        ),
    )


PERFORMANCE_ROWS = (*_performance_rows("x"), *_performance_rows("y"))
