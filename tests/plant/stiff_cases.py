"""Closed loops that integrator and stiff solver both run: law, delay, resonance, currents."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from motionlab.kernel.layout import Inputs, Parameters
from motionlab.plant.resonance import sampled
from motionlab.timing import PLANT_STEP as H
from tests.kernel.lane_runs import Array, at_rest, inputs, lane, positions, rows
from tests.nominal_motor import Axis, X, Y
from tests.plant.stiff_reference import Loop, Mode, Phases

LAWS = {
    "off": "off",
    "observer": "lugre-observer",
    "residual": "residual-k",
    "reversed": "reversed-k",
}
MODE = Mode(frequency=150.0, damping=0.02, coupling=-0.05)
# Of configs/motors/matched.toml and as-measured.toml.
FRICTION = ({"F_s": 3.7251, "v_s": 0.022079}, {"F_s": 3.0052, "v_s": 0.0095793})
PEAK, THIRD, OFFSET, RIPPLE = 38.4, 0.039, (0.1, -0.1, 0.05), (40e-9, 20e-6)


class Case(NamedTuple):
    """A closed loop with an exact encoder, of both axes."""

    law: str = "observer"
    delay: int = 0
    mode: Mode | None = None
    phases: bool = False  # currents that lag, in place of an ideal force
    matched: bool = False  # the motor `matched`, with its encoder's error, under a nominal model
    x: Axis = X
    y: Axis = Y


class Compared(NamedTuple):
    """What came of a case, per tick, m."""

    difference: Array  # between the integrator and the stiff solver
    error: Array  # of following, by the stiff solver


CASES = {
    "residual-k": Case("residual"),
    "reversed-k": Case("reversed"),
    "delay": Case(delay=1),
    "resonance": Case(mode=MODE),
    "currents": Case(phases=True),
    "matched": Case(phases=True, matched=True),
    "matched, residual-k": Case("residual", phases=True, matched=True),
    "matched, delay": Case(delay=1, phases=True, matched=True),
    "matched, resonance": Case(mode=MODE, phases=True, matched=True),
}
"""Unless they say otherwise: ideal force, the observer with K = 0, no delay, no resonance."""


def overload(ticks: int) -> tuple[Array, Array]:
    """Return a reference at rest, and 45 N of load for 0.1 s: more than the phases can hold."""
    load = np.zeros(ticks)
    load[100:300] = 45.0
    return np.zeros((ticks, 3, 2)), load


def compare(case: Case, motion: Array, axis: int, load: Array | None = None) -> Compared:
    """Run an axis of a case both ways.

    Parameters
    ----------
    case : Case
        The loop.
    motion : ndarray, shape (ticks, 3, 2)
        Reference, see `motionlab.kernel.layout.Inputs`.
    axis : int
        0 is x, 1 is y.
    load : ndarray, shape (ticks,), optional
        External load force, N.
    """
    driven = inputs(motion)
    if load is not None:
        driven[:, Inputs._fields.index("load")] = load[:, None]
    lanes = rows([_lane(case, each, index) for index, each in enumerate((case.x, case.y))] * 4)
    reached = positions(lanes, at_rest(motion[0, 0]), driven)[:, axis]
    p_ref = motion[:, 0, axis]
    model, start = (case.x, case.y)[axis], float(p_ref[0])
    loop = Loop(model, start, case.law, case.delay, case.mode, Phases() if case.phases else None)
    if case.matched:
        loop.phases = Phases(PEAK, THIRD, OFFSET)
        loop.truth, loop.ripple = model._replace(**FRICTION[axis]), RIPPLE
    expected = loop.follow(p_ref, load)
    return Compared(np.abs(reached - expected), np.abs(p_ref - expected))


def _lane(case: Case, axis: Axis, index: int) -> Parameters:
    changes: dict[str, Any] = {
        "encoder.resolution": 0.0,
        "controller.delay": float(case.delay),
        "controller.ideal_force": float(not case.phases),
    }
    if case.law in {"residual", "reversed"}:
        changes["law.z_limit"] = 1.2 * axis.F_s / axis.sigma_0
    if case.matched:
        changes |= {f"friction.{name}": value for name, value in FRICTION[index].items()}
        changes |= {"force_map.formula.F_pk": PEAK, "force_map.formula.h_3": THIRD}
        changes |= {f"amplifiers.offset_{k}": i for k, i in zip("abc", OFFSET, strict=True)}
        changes |= {"encoder.sde_amplitude": RIPPLE[0], "encoder.sde_period": RIPPLE[1]}
    parameters = lane(axis, LAWS[case.law], changes)
    if case.mode is None:
        return parameters
    resonance = sampled(**vars(case.mode), mass=axis.M, h=H)
    return parameters._replace(resonance=resonance)
