"""The circle on the virtual drive is that of the simulation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from motionlab.drive.link.shared import Order, State
from motionlab.telemetry.channels import Sample
from tests.drive.link.rig import CIRCLE, Rig
from tests.simulated import play

pytestmark = pytest.mark.realtime

AFTER = 100
"""Ticks over which a missed answer is still felt."""

ROWS = [Sample._fields.index(name) for name in ("following_error", "position_measured")]


def largest_and_rms(values: Any) -> tuple[float, float]:
    return float(np.abs(values).max()), float(np.sqrt(np.mean(values**2)))


def disturbed(errors: Any, positions: Any) -> Any:
    """Return the ticks that feel an answer that was missed, or was of another period.

    On a busy machine a frame may reach the drives before or after its period: the error then jumps
    by what the mover covers in a period, on both axes.
    """
    jumps = np.linalg.norm(np.diff(errors, axis=0, prepend=np.nan), axis=1)
    steps = np.linalg.norm(np.diff(errors + positions, axis=0), axis=1)
    felt = np.isnan(errors).any(axis=1) | (jumps > 0.5 * np.nanmax(steps))
    return np.convolve(felt, np.ones(AFTER))[: len(felt)] > 0.5


def test_an_answer_of_another_period_is_a_disturbance() -> None:
    time = np.arange(2000)
    circle = 1e-3 * np.stack([np.cos(1e-2 * time), np.sin(1e-2 * time)], axis=1)
    errors = np.full_like(circle, 1e-6)
    assert not disturbed(errors, circle - errors).any()
    errors[700] -= circle[700] - circle[699]
    errors[900] = np.nan
    felt = np.flatnonzero(disturbed(errors, circle - errors))
    assert felt.tolist() == [*range(700, 701 + AFTER), *range(900, 900 + AFTER)]


def test_the_circle_is_followed_as_in_the_simulation(rig: Rig) -> None:
    rig.ready()
    rig.arm()
    motion = rig.motion()
    samples = rig.take(motion)
    assert motion.fault is None
    assert motion.tick == motion.timeline.end == len(samples)
    assert motion.failed_ticks == [None]
    assert not motion.stopped
    rig.until(State.HOLDING)

    simulated = play("circle", CIRCLE | {"variants.B.controller.delay": 1})
    window = slice(*simulated.prepared.reference.window)
    errors, positions = (samples[:, row].astype(np.float64) for row in ROWS)
    same = ~disturbed(errors, positions)[window]
    assert same.mean() > 0.5, f"{1 - same.mean():.0%} of the ticks were disturbed"
    for axis, name in enumerate("xy"):
        expected = simulated.channel("B", "following_error", name)
        found = largest_and_rms(errors[window, axis][same])
        assert found == pytest.approx(largest_and_rms(expected[window][same]), rel=0.1)


def test_disarmed_at_rest_it_is_ready_again(rig: Rig) -> None:
    rig.ready()
    rig.arm()
    rig.link.order(Order.DISARM)
    rig.until(State.READY)
    rig.wait(
        lambda: all(d.state == "ready to switch on" for d in rig.link.drives), "without torque"
    )
