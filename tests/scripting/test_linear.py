"""The linearised loop from Python, against python-control."""

from __future__ import annotations

import math

import control
import numpy as np
import pytest

import motionlab


@pytest.mark.parametrize("variant", ["A", "B"])
@pytest.mark.parametrize("scenario", ["circle", "circle-matched"])
def test_margins_are_those_of_python_control(scenario: str, variant: str) -> None:
    loop = motionlab.linearise(scenario, variant)
    systems = loop.to_control()
    assert systems.plant.dt == 0.0005
    # By frequencies: polynomials of so many poles near 1 lose every digit.
    grid = 2.0 * np.pi * np.geomspace(0.5, 999.0, 4_000)
    response = control.frequency_response(systems.open_loop, grid)
    gain, phase, sensitivity, *_ = control.stability_margins(response)
    assert loop.margins.gain_margin == pytest.approx(gain, rel=1e-3)
    assert loop.margins.phase_margin == pytest.approx(math.radians(phase), rel=1e-3)
    assert loop.margins.Ms == pytest.approx(1.0 / sensitivity, rel=1e-3)
    poles = np.abs(control.poles(systems.disturbance))
    assert loop.stable == bool((poles < 1.0).all())


def test_a_gain_beyond_its_limit_is_unstable() -> None:
    limit = motionlab.linearise().k_p_limit
    assert limit is not None
    for factor, stable in ((0.99, True), (1.01, False)):
        changes = {"variants.B.controller.x.k_p": factor * limit}
        loop = motionlab.linearise("circle", "B", "x", changes)
        assert loop.stable is stable
        poles = np.abs(control.poles(loop.to_control().disturbance))
        assert bool((poles < 1.0).all()) is stable


def test_the_velocity_is_ones_own() -> None:
    assert motionlab.linearise(velocity=0.0).velocity == 0.0


def test_what_is_not_there_is_named() -> None:
    with pytest.raises(motionlab.ConfigError, match=r"variant: is not there; got 'C'; .*A, B"):
        motionlab.linearise("circle", "C")
    with pytest.raises(motionlab.ConfigError, match="axis: is not there; got 'z'"):
        motionlab.linearise("circle", "A", "z")  # pyright: ignore[reportArgumentType]
    with pytest.raises(motionlab.ConfigError, match="published-k"):
        motionlab.linearise("circle-published-k", "B")
