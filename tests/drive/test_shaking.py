"""The multisine of commissioning: small enough for the axis, and large enough to tell its mass."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from motionlab.config.multisine import Multisine
from motionlab.drive.commissioning import shaking
from motionlab.drive.commissioning.run import Stopped
from motionlab.drive.plug.response_step import finding_of, rows_of
from motionlab.drive.virtual.segment import default_drive
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.response.documents import ResponseRequest
from motionlab.studies.response.measure import measure, plan
from motionlab.timing import CONTROL_PERIOD


def step(**limits: float) -> Any:
    config = default_drive()
    axes = {axis: getattr(config, axis).model_copy(update=limits) for axis in "xy"}
    return SimpleNamespace(config=config.model_copy(update=axes))


def motion(axis: str, mass: float | None = None, **limits: float) -> Multisine:
    trajectory = shaking.shaking(step(**limits), axis, mass).trajectory
    assert isinstance(trajectory, Multisine)
    return trajectory


def test_smaller_currents_and_a_narrower_window_make_it_smaller() -> None:
    size = motion("x").acceleration
    assert motion("x", current_max=4.0).acceleration < 0.5 * size
    assert motion("x", following_error=1e-4).acceleration < 0.8 * size
    assert motion("y", mass=40.0).acceleration < 0.6 * motion("y").acceleration


def test_a_short_stroke_slides_slower_or_not_at_all() -> None:
    assert motion("x").velocity == pytest.approx(0.0432)
    assert motion("x", position_min=-0.03, position_max=0.03).velocity == pytest.approx(0.0144)
    with pytest.raises(Stopped, match=r"positions range over 0\.019 m"):
        motion("x", position_min=-0.0095, position_max=0.0095)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_motor_is_told_within_the_bounds_of_the_axis(axis: str) -> None:
    scenario = shaking.shaking(step(), axis, None)
    prepared = prepare(scenario)
    recording = run(prepared)
    assert prepared.reference.ticks * CONTROL_PERIOD < 30.0
    record = recording.variants["A"]
    limits = getattr(default_drive(), axis)
    assert np.abs(record.channel("following_error", axis)).max() < 0.5 * limits.following_error
    position = record.channel("position", axis)
    assert limits.position_min < position.min() < position.max() < limits.position_max
    identifier = library().keep(prepared, recording, {}, name=f"shaken {axis}").id
    document = measure(plan(ResponseRequest(run=identifier, axis="x" if axis == "x" else "y")))
    rows = {row.name: row for row in rows_of(document)}
    assert all(row.holds for row in rows.values())
    assert not any("mode" in name for name in rows)
    for name in ("crossover", "phase margin", "mass"):
        row = rows[f"{axis} {name}"]
        here, there = (float(each.split()[0]) for each in (row.found, row.expected))
        assert here == pytest.approx(there, rel=0.03), name
    finding = finding_of(list(rows.values()), [identifier, identifier])
    assert finding.holds and f"{identifier} (x)" in finding.text
