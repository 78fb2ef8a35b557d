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


def largest_and_rms(values: Any) -> tuple[float, float]:
    return float(np.abs(values).max()), float(np.sqrt(np.mean(values**2)))


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
    row = Sample._fields.index("following_error")
    window = slice(*simulated.prepared.reference.window)
    for axis, name in enumerate("xy"):
        errors = samples[:, row, axis].astype(np.float64)
        expected = simulated.channel("B", "following_error", name)
        disturbed = np.convolve(np.isnan(errors), np.ones(AFTER))[: len(errors)] > 0.5
        same = ~disturbed[window]
        assert same.mean() > 0.5, f"{disturbed.mean():.0%} of the ticks were disturbed"
        found = largest_and_rms(errors[window][same])
        assert found == pytest.approx(largest_and_rms(expected[window][same]), rel=0.1)


def test_disarmed_at_rest_it_is_ready_again(rig: Rig) -> None:
    rig.ready()
    rig.arm()
    rig.link.order(Order.DISARM)
    rig.until(State.READY)
    rig.wait(
        lambda: all(d.state == "ready to switch on" for d in rig.link.drives), "without torque"
    )
