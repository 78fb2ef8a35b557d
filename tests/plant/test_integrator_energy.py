"""Energy: friction only ever takes it, and none is lost or made by the integrator."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionlab.kernel.layout import Inputs
from motionlab.timing import PLANT_STEP as H
from tests.kernel.lane_runs import (
    IDEAL,
    at_rest,
    channel,
    circle,
    inputs,
    lane,
    positions,
    rows,
    run,
)
from tests.nominal_motor import CONTROL_PERIOD, Axis, X, Y
from tests.plant.pushed_movers import Array, friction_force, pushed

AXES = pytest.mark.parametrize("axis", [X, Y], ids=["x", "y"])
STEP = st.sampled_from([0.25 * H, H, 5.0 * H])


def sine_forces(amplitude: Array, phase: Array, steps: int, cycles: int) -> Array:
    turns = np.arange(steps * cycles)[:, None] / steps
    return amplitude * np.sin(2.0 * np.pi * (turns + phase))


@AXES
@settings(max_examples=30)
@given(
    amplitude=st.lists(st.floats(0.05, 40.0), min_size=8, max_size=8),
    phase=st.lists(st.floats(0.0, 1.0), min_size=8, max_size=8),
    frequency=st.floats(2.0, 40.0),
    h=STEP,
)
def test_friction_dissipates_over_closed_cycles(
    axis: Axis, amplitude: list[float], phase: list[float], frequency: float, h: float
) -> None:
    """Work of the force less the energy left in mass and bristles is what friction has taken."""
    steps, cycles = round(1.0 / (frequency * h)), 8
    forces = sine_forces(np.array(amplitude), np.array(phase), steps, cycles)
    history = pushed(axis, np.zeros((3, 8)), forces, h)
    p, v, z = history.transpose(1, 0, 2)
    work = np.cumsum(forces * np.diff(p, axis=0), axis=0)
    stored = 0.5 * axis.M * v**2 + 0.5 * axis.sigma_0 * z**2
    taken = (work - stored[1:])[steps - 1 :: steps]
    each_cycle = np.diff(taken, axis=0, prepend=0.0)
    assert (each_cycle >= -1e-12 * work.max(axis=0)).all()
    assert (taken[-1] > 0.0).all()


@AXES
@settings(max_examples=30)
@given(
    force=st.lists(st.floats(-200.0, 200.0), min_size=8, max_size=8),
    speed=st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=8),
    bristle=st.lists(st.floats(-1.0, 1.0), min_size=8, max_size=8),
    h=STEP,
)
def test_bristle_stays_within_stiction(
    axis: Axis, force: list[float], speed: list[float], bristle: list[float], h: float
) -> None:
    """abs(z) <= F_s/sigma_0 is invariant under eq. (21), and under its exact exponential too."""
    limit = axis.F_s / axis.sigma_0
    state = np.array([np.zeros(8), speed, np.array(bristle) * limit])
    forces = np.repeat(np.array([force, np.negative(force), np.zeros(8)]), 60, axis=0)
    z = pushed(axis, state, forces, h)[:, 2]
    assert np.abs(z).max() <= limit * (1.0 + 1e-12)


def unexplained_energy(axis: Axis, h: float) -> Array:
    """Return what is missing from the energy balance after 0.4 s, over the work of the thrust."""
    steps = round(0.4 / h)
    t = (np.arange(steps)[:, None] + 0.5) * h
    lanes = np.arange(8)
    thrust = (6.0 + lanes) * np.sin(2.0 * np.pi * (5.0 + lanes) * t)
    load = 1.5 * np.cos(2.0 * np.pi * 3.0 * t) + 0.1 * lanes
    p, v, z = pushed(axis, np.zeros((3, 8)), thrust - load, h).transpose(1, 0, 2)
    moved = np.diff(p, axis=0)
    kinetic = 0.5 * axis.M * (v[-1] ** 2 - v[0] ** 2)
    loss = friction_force(axis, v, z) * v
    friction = 0.5 * h * (loss[1:] + loss[:-1]).sum(axis=0)
    work = (thrust * moved).sum(axis=0)
    assert (friction > 0.1 * work).all()
    return np.abs(work - (load * moved).sum(axis=0) - kinetic - friction) / work


@AXES
def test_work_of_thrust_is_kinetic_energy_friction_and_load(axis: Axis) -> None:
    """Friction comes from eqs (20) to (22) at the ends of each step, not from the integrator."""
    missing = unexplained_energy(axis, H)
    assert missing.max() < 2e-4
    # What is missing is the error of a second-order method and of the trapezium rule.
    assert missing / unexplained_energy(axis, H / 4.0) == pytest.approx(16.0, rel=0.1)


def test_balance_holds_for_what_the_kernel_records() -> None:
    """Recorded thrust, friction and velocity account for the motion under a load that steps."""
    motion = circle(4000)
    load = np.zeros((4000, 2))
    load[1000:3000, 0] = 2.0
    load[:, 1] = -1.0
    driven = inputs(motion)
    driven[:, Inputs._fields.index("load")] = load
    axes = [X, Y] * 4
    parameters = rows([lane(axis, changes=IDEAL) for axis in axes])
    samples = run(parameters, at_rest(motion[0, 0]), driven)
    reached = positions(parameters, at_rest(motion[0, 0]), driven)

    moved = np.diff(reached, axis=0, prepend=np.tile(motion[:1, 0], 4))[:-1]
    v = channel(samples, "velocity")
    loss = channel(samples, "friction") * v
    work = (channel(samples, "thrust")[:-1] * moved).sum(axis=0)
    against_load = (np.tile(load, 4)[:-1] * moved).sum(axis=0)
    friction = 0.5 * CONTROL_PERIOD * (loss[1:] + loss[:-1]).sum(axis=0)
    kinetic = 0.5 * np.array([axis.M for axis in axes]) * (v[-1] ** 2 - v[0] ** 2)
    assert (np.abs(against_load) > 0.1 * np.abs(work)).all()
    assert work == pytest.approx(against_load + friction + kinetic, rel=5e-5)
