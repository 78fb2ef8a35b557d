"""Steps of commissioning with torque, each in lockstep with a machine that is right or not."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.commissioning import commutation, currents, hold, homing
from motionlab.drive.commissioning.field import drawn, turned
from motionlab.drive.commissioning.record import ConfigChange, Finding, in_effect
from motionlab.drive.commissioning.run import Stopped
from motionlab.drive.link.shared import State
from motionlab.drive.virtual.segment import default_drive, mounted
from tests.drive.link.lockstep import Lockstep
from tests.drive.link.step_rig import StepRig

PITCH = 7.2e-3
SHORT = {"plant.x.stroke": 0.01, "plant.y.stroke": 0.01}
BLOCKED = {"plant.x.friction.F_s": 100.0}
START = (0.003, -0.002)
STEPS = {
    "currents": currents.phase_currents,
    "commutation": commutation.commutation_offset,
    "homing": homing.find_stops,
    "hold": hold.hold_with_low_gains,
}


@pytest.fixture(autouse=True)
def _quicker(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(currents, "RAMP", 0.05)
    monkeypatch.setattr(currents, "HOLD", 0.1)
    monkeypatch.setattr(commutation, "SPEED", 3.0)
    monkeypatch.setattr(commutation, "DWELL", 0.2)
    monkeypatch.setattr(hold, "REST", 0.4)


def short() -> DriveConfig:
    """Return the link of a machine whose stroke is 20 mm."""
    config = default_drive()
    limits = {"position_min": -0.0095, "position_max": 0.0095}
    axes = {axis: getattr(config, axis).model_copy(update=limits) for axis in AXES}
    return config.model_copy(update=axes)


def done(step: str, **machine: Any) -> tuple[Finding, Lockstep]:
    """Do a step; return what it found, and the loop."""
    loop = Lockstep(START, **machine)
    rig = StepRig(loop)
    finding = STEPS[step](rig.run)
    assert loop.state == State.READY
    assert loop.without_torque()
    shares = [share for share, _ in rig.told]
    assert shares == sorted(shares)
    assert 0.0 <= shares[0] <= shares[-1] <= 1.0
    assert finding.holds == all(row.holds for row in finding.rows)
    return finding, loop


def failing(finding: Finding) -> list[str]:
    return [row.name for row in finding.rows if not row.holds]


def test_every_drive_follows_alone() -> None:
    finding, _ = done("currents")
    assert (finding.holds, finding.text) == (True, "all 6 follow, each alone")


def test_a_dead_phase_is_named() -> None:
    finding, _ = done("currents", changes={"plant.y.amplifiers.gain": [1.0, 0.0, 1.0]})
    assert finding.text == "drive 5 (y b) does not follow"
    assert failing(finding) == ["5 y b"]


def test_a_current_where_none_should_be_is_named() -> None:
    finding, _ = done("currents", changes={"plant.x.amplifiers.offset": [0.0, 0.0, 0.3]})
    assert "x c has current while only y a should" in finding.text
    assert not finding.holds


def test_a_wrong_offset_is_found_and_a_wrong_order_said() -> None:
    machine = mounted(default_drive(), offset=(0.0013 - 3 * PITCH, 0.0), swapped="y")
    finding, loop = done("commutation", machine=machine)
    (change,) = finding.changes
    assert (change.path, change.now) == ("x.offset", 0.0)
    assert change.then == pytest.approx(0.0013, abs=0.1e-3)
    right = in_effect(loop.config, finding.changes)
    assert right.x.offset == change.then
    assert "y: the order of the phases is wrong, the mover goes backwards" in finding.text
    assert failing(finding) == ["x, position beside the aligned one", "y, from phase to phase"]


def test_a_blocked_mover_does_not_follow_and_a_right_offset_stays() -> None:
    machine = mounted(default_drive(), offset=(0.0, 0.0013))
    taken = ConfigChange(path="y.offset", now=0.0, then=0.0013 - PITCH)
    config = in_effect(default_drive(), [taken])
    finding, _ = done("commutation", config=config, machine=machine, changes=BLOCKED)
    assert "x: the mover does not follow; is it blocked" in finding.text
    assert "y: offset right within" in finding.text
    assert failing(finding) == ["x, from phase to phase"]
    assert finding.changes == []


def test_homing_tells_the_pitch() -> None:
    machine = mounted(short(), offset=(2 * PITCH + 0.05e-3, 0.0))
    finding, loop = done("homing", config=short(), machine=machine, changes=SHORT)
    (change,) = finding.changes
    assert (change.path, change.now) == ("x.offset", 0.0)
    assert change.then == pytest.approx(2 * PITCH)
    assert "x: offset wrong by -2 pitches" in finding.text
    assert "y: stroke 22.0" in finding.text
    assert not [name for name in failing(finding) if name.startswith("y")]
    np.testing.assert_allclose(loop.segment.position, 0.0, atol=1e-3)  # it is in the middle


def test_homing_of_a_blocked_mover_changes_nothing() -> None:
    finding, _ = done("homing", config=short(), changes=SHORT | BLOCKED)
    assert "x: stopped after" in finding.text
    assert finding.changes == []


def test_without_an_end_stop_homing_ends_by_itself() -> None:
    finding, loop = done("homing", config=short())
    assert "x: no positive end stop within 29 mm" in finding.text
    assert loop.segment.position[0] < 0.035


def test_low_gains_hold_and_follow() -> None:
    finding, _ = done("hold")
    assert finding.holds, finding.text
    assert "k_p at 25 %, k_d at 50 % of circle A" in finding.text


def test_a_loop_of_the_wrong_sign_is_a_fault() -> None:
    config = default_drive()
    machine = config.model_copy(update={"x": config.x.model_copy(update={"direction": -1})})
    rig = StepRig(Lockstep(machine=machine))
    rig.loop.segment.switch(push={"axis": "x", "force": 8.0, "time": 3.0})
    with pytest.raises(Stopped, match=r"^fault: x: "):
        hold.hold_with_low_gains(rig.run)


@pytest.mark.parametrize("step", list(STEPS))
def test_a_stop_ends_every_step(step: str) -> None:
    rig = StepRig(Lockstep(START))
    rig.at[300] = rig.loop.stop
    with pytest.raises(Stopped, match=r"^STOP$"):
        STEPS[step](rig.run)
    rig.loop.cycle(400)
    assert rig.loop.state == State.READY
    assert rig.loop.without_torque()
    with pytest.raises(Stopped, match=r"^STOP$"):  # and nothing of it begins any more
        STEPS[step](rig.run)
    assert rig.loop.without_torque()


def lose_control(rig: StepRig) -> None:
    rig.run.stop("control of the drives ended")


def switch_off(rig: StepRig) -> None:
    rig.loop.segment.switch(sto=True)


@pytest.mark.parametrize(
    ("what", "told"),
    [(lose_control, "^control of the drives ended$"), (switch_off, "^fault: drive 1: safe torque")],
)
def test_what_ends_a_step_is_told(what: Callable[[StepRig], None], told: str) -> None:
    rig = StepRig(Lockstep(START))
    rig.at[300] = lambda: what(rig)
    with pytest.raises(Stopped, match=told):
        currents.phase_currents(rig.run)


def test_a_field_is_as_strong_between_phases() -> None:
    angles = np.linspace(0.0, 3.0, 301)
    force = drawn(angles, 2.0, ramp=0.0) ** 2 @ np.exp(2j * np.pi * np.arange(3) / 3)
    np.testing.assert_allclose(np.abs(force), np.abs(force[0]))
    turns = np.unwrap(np.angle(force)) * 3 / (2 * np.pi)
    np.testing.assert_allclose(turns, angles, atol=1e-9)
    assert drawn(angles, 2.0).max() <= 2.0


@pytest.mark.parametrize(("end", "speed"), [(7.0, 2.0), (-0.1, 2.0), (0.0, 2.0)])
def test_a_field_turns_no_faster_than_asked(end: float, speed: float) -> None:
    angles = turned(0.0, end, speed)
    assert angles[-1] == pytest.approx(end)
    assert np.abs(np.diff(angles, prepend=0.0)).max() <= 1.001 * speed * 0.5e-3
