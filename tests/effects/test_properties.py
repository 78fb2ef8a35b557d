"""What holds of friction whatever its parameters: passivity, and the memory of Maxwell slip."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.effects.free_mover import pushed

FRICTION = ("static-stribeck", "lugre", "dahl", "gms")


@pytest.mark.parametrize("name", FRICTION)
@settings(max_examples=15, deadline=None)
@given(
    amplitude=st.floats(1e-6, 5e-3),
    frequency=st.floats(0.5, 50.0),
    F_c=st.floats(0.1, 10.0),
    ratio=st.floats(1.0, 4.0),
    mu=st.floats(0.0, 0.1),
    share=st.floats(0.0, 0.5),
)
def test_friction_does_no_positive_work_over_a_closed_cycle(
    name: str,
    amplitude: float,
    frequency: float,
    F_c: float,
    ratio: float,
    mu: float,
    share: float,
) -> None:
    steps = 400
    h = 1.0 / (frequency * steps)
    t = h * np.arange(2 * steps)
    v = amplitude * 2.0 * np.pi * frequency * np.cos(2.0 * np.pi * frequency * t)
    values = {"F_c": F_c, "mu": mu, "position_amplitude": share, "position_period": 2e-3}
    values |= {} if name == "dahl" else {"F_s": ratio * F_c}
    force, _ = pushed(name, values, v, h, normal=50.0)
    work = h * force * v  # taken from the mover
    assert work[steps:].sum() >= -1e-6 * np.abs(work[steps:]).sum()


@pytest.mark.parametrize("name", FRICTION)
def test_friction_never_pushes_where_the_normal_force_jumps(name: str) -> None:
    """As it does within a commutation, from 5 to 125 N and back in half a millisecond."""
    normal = np.where(np.arange(400) // 5 % 2, 125.0, 5.0)
    force, _ = pushed(name, {"mu": 0.01}, np.full(400, 0.02), 1e-4, normal)
    assert force[20:].min() > 0.0


def test_maxwell_slip_returns_to_the_point_where_a_minor_loop_began() -> None:
    """Non-local memory: after a loop inside another, the outer one goes on as if it had not been.

    Of bristles with one state, such as Dahl's, it does not.
    """
    h, speed = 1e-3, 1e-3
    out = np.full(4, speed)  # 4 um of some 40 that it takes to slip throughout
    loop = np.concatenate([out, -out / 2, out / 2, out])
    straight = np.concatenate([out, out])
    values = {"F_c": 2.0, "F_s": 2.0, "sigma_0": 1e5}
    with_loop, _ = pushed("gms", values, loop, h)
    without, _ = pushed("gms", values, straight, h)
    np.testing.assert_allclose(with_loop[-3:], without[-3:], rtol=1e-12)
    values.pop("F_s")
    with_loop, _ = pushed("dahl", values, loop, h)
    without, _ = pushed("dahl", values, straight, h)
    assert abs(with_loop[-1] - without[-1]) > 1e-3


def test_maxwell_slip_has_the_stiffness_before_and_the_level_after_sliding() -> None:
    values = {"F_c": 2.0, "F_s": 2.0, "sigma_0": 1e5, "sigma_2": 0.0}
    first, p = pushed("gms", values, np.full(200, 1e-6), 1e-3)
    np.testing.assert_allclose(first, 1e5 * p, rtol=1e-9)
    slid, _ = pushed("gms", values, np.full(2000, 1e-3), 1e-3)
    assert slid[-1] == pytest.approx(2.0, rel=1e-9)
    x = 1e-6 * np.arange(1, 2000)
    curve = 2.0 * (1.0 - np.exp(-1e5 * x[:1999] / 2.0))
    assert np.abs(slid[:1999] - curve).max() < 0.06 * 2.0
