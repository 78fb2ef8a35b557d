"""Gains that change while drives move: at one tick, which the loop reports, or not at all."""

from __future__ import annotations

import threading
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.config.load import epochs, load_scenario
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.link import DriveLink
from motionlab.drive.link.shared import Command, Order, State, Status
from motionlab.drive.motion import DriveMotion, changes_on_drives, held_parameters, on_drives
from motionlab.errors import ConfigError
from motionlab.kernel.layout import SAMPLE_ROWS, parameter_row
from motionlab.lanes import WIDTH
from motionlab.simulation.change import changed
from motionlab.simulation.prepare import prepare
from motionlab.simulation.simulation import ReadyEpoch, ready
from motionlab.telemetry.channels import Sample
from tests.drive.link.lockstep import Lockstep
from tests.simulated import SHORT

B = "variants.B.controller"
K_P = 2e5
PURE = {
    f"{B}.x.k_p": K_P,
    f"{B}.x.k_d": 0.0,
}
"""Gains with which the PD force is the following error times a number."""


class LockstepLink(DriveLink):
    """A link to a loop in lockstep: while it waits, cycles pass."""

    ended = False  # pyright: ignore[reportAssignmentType, reportIncompatibleMethodOverride]

    def __init__(self, loop: Lockstep) -> None:
        self.loop, self.config = loop, loop.config
        self._shared = loop.shared
        self._lock, self._stops, self._loads = threading.RLock(), threading.Lock(), 0

    def _await(self, condition: Callable[[], bool]) -> None:
        for _ in range(5):
            if condition():
                return
            self.loop.cycle()
        raise LinkError("the drive loop does not answer")


class Moved:
    """A motion along the circle, with the changes of a schedule."""

    def __init__(self, *schedule: dict[str, Any]) -> None:
        self.loop = Lockstep()
        self.link = LockstepLink(self.loop)
        prepared = prepare(on_drives(load_scenario("circle", SHORT | {"schedule": schedule}), "B"))
        self.motion = DriveMotion(prepared, self.link, 1)
        self.loop.arm()
        self.motion.begin()

    def reach(self, tick: int) -> None:
        """Let the drives move up to a tick of the trajectory."""
        while self.loop.shared.status[Status.END] < tick:
            self.loop.cycle()

    def take(self) -> int:
        """Take what has been recorded, as a session does, and return the next tick."""
        page = np.empty((1, 4096, SAMPLE_ROWS, WIDTH), np.float32)
        while self.motion.advance(page):
            pass
        return self.motion.tick

    def ready(self, changes: dict[str, Any]) -> list[ReadyEpoch]:
        """Check changes, as a session does."""
        tick = self.motion.tick
        scenario, _ = changed(self.motion.scenario, changes_on_drives(changes, "B"), tick)
        return ready(tuple(epochs(scenario, tick)))

    def change(self, changes: dict[str, Any]) -> int:
        """Put changes in effect, and return the tick."""
        return self.motion.adopt(self.ready(changes))

    @property
    def in_effect(self) -> tuple[Any, ...]:
        """Scenario of the motion, and which set of parameters the loop is to read."""
        return self.motion.scenario, int(self.loop.shared.command[Command.PARAMETERS])

    def ratio(self, start: int, stop: int) -> NDArray[np.float64]:
        """Return PD force over following error in x."""
        samples = self.link.samples(start, stop)[:, :, 0].astype(np.float64)
        columns = [Sample._fields.index(name) for name in ("pd_force", "following_error")]
        force, error = samples[:, columns].T
        return force / error


@pytest.fixture
def moved() -> Moved:
    return Moved()


def test_a_change_is_in_effect_from_the_tick_that_the_loop_reports(moved: Moved) -> None:
    moved.reach(1200)
    tick = moved.change(PURE)
    assert tick in {1200, 1201}
    moved.reach(tick + 50)
    assert moved.ratio(tick, tick + 50) == pytest.approx(K_P, rel=1e-5)
    assert abs(moved.ratio(tick - 1, tick)[0] / K_P - 1.0) > 1e-3
    assert moved.motion.scenario.variants["B"].controller.x.k_p == K_P
    second = moved.change({f"{B}.x.k_p": 2 * K_P})
    moved.reach(second + 5)
    assert moved.ratio(second - 1, second) == pytest.approx(K_P, rel=1e-5)
    assert moved.ratio(second, second + 5) == pytest.approx(2 * K_P, rel=1e-5)


def test_on_the_way_to_the_start_it_holds_from_tick_0(moved: Moved) -> None:
    assert moved.link.state == State.MOVING
    assert moved.change(PURE) == 0


def test_after_the_end_it_changes_the_held_position(moved: Moved) -> None:
    while moved.link.state == State.MOVING:
        moved.loop.cycle()
    assert moved.change(PURE) == moved.motion.timeline.end
    assert moved.link.state == State.HOLDING
    lane = moved.loop.shared.parameters[moved.loop.shared.status[Status.PARAMETERS], :, 0]
    assert lane[parameter_row("controller.k_p")] == K_P


def test_gains_of_arming_are_not_replaced_by_a_motion_that_is_over(moved: Moved) -> None:
    moved.reach(10)
    moved.link.load(held_parameters(on_drives(load_scenario("circle"), "A")))
    before = moved.in_effect
    with pytest.raises(LinkError, match="of another motion, or of arming"):
        moved.change(PURE)
    assert moved.in_effect == before


def test_a_loop_that_does_not_answer_keeps_its_gains(
    moved: Moved, monkeypatch: pytest.MonkeyPatch
) -> None:
    moved.reach(10)
    before = moved.in_effect
    changes = moved.ready(PURE)
    with monkeypatch.context() as patch:
        patch.setattr(moved.loop, "cycle", lambda: None)
        with pytest.raises(LinkError, match="does not answer"):
            moved.motion.adopt(changes)
    assert moved.in_effect == before
    moved.reach(20)
    assert moved.motion.adopt(changes) in {20, 21}


def test_drives_without_torque_refuse(moved: Moved) -> None:
    moved.reach(10)
    assert moved.loop.order(Order.DISARM)
    with pytest.raises(LinkError, match="without torque"):
        moved.change(PURE)


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"plant.x.mass": 2.0}, "set.plant.x.mass: is of the simulated machine"),
        ({"plant.x.encoder.resolution": 1e-9}, "set.plant.x.encoder.resolution: is of the sim"),
        ({"load.x": 1.0}, "set.load.x: is of the simulated machine"),
        ({"variants.A.controller.x.k_p": 1.0}, "is not what the drives run: they run B now"),
        ({f"{B}.delay": 0}, f"set.{B}.delay: is 1 on drives"),
        ({"trajectory.radius": 0.01}, "set.trajectory.radius: cannot change during a run"),
        ({f"{B}.x.k_p": float("nan")}, "k_p"),
        ({f"{B}.x.k_p": 1e12}, "k_p"),
        ({f"{B}.model.x.force_map": "none-such"}, "none-such"),
    ],
)
def test_what_is_refused_loses_nothing(moved: Moved, changes: dict[str, Any], told: str) -> None:
    before = moved.in_effect
    with pytest.raises(ConfigError, match=told):
        moved.change(changes)
    assert moved.in_effect == before
    moved.loop.cycle(5)
    assert moved.link.state == State.MOVING


def test_a_controller_that_is_swapped_keeps_its_delay(moved: Moved) -> None:
    moved.change({f"{B}": "published-k"})
    controller = moved.motion.scenario.variants["B"].controller
    assert (controller.name, controller.delay) == ("published-k", 1)
