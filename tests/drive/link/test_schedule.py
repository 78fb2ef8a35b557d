"""The schedule of a scenario on drives: each change at its own tick, or none after a stop."""

from __future__ import annotations

from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.shared import Command, State, Status
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.errors import ConfigError
from motionlab.timing import CONTROL_PERIOD
from tests.drive.link.test_gains import K_P, PURE, B, Moved

FIRST, SECOND = 1200, 1500
D = f"{B}.x.k_d"


def at(tick: int, changes: dict[str, Any]) -> dict[str, Any]:
    """Return an event of a schedule."""
    return {"time": tick * CONTROL_PERIOD, "set": changes}


@pytest.fixture
def moved() -> Moved:
    return Moved(at(FIRST, PURE), at(SECOND, {f"{B}.x.k_p": 2 * K_P}))


def k_p(moved: Moved) -> float:
    """Return the gain that is in effect at the tick of a motion."""
    return moved.motion.scenario.variants["B"].controller.x.k_p


def in_use(moved: Moved) -> int:
    """Return which of its two sets the loop computes with."""
    return int(moved.loop.shared.status[Status.PARAMETERS])


def test_each_change_holds_from_its_tick_on(moved: Moved) -> None:
    before = k_p(moved)
    moved.reach(FIRST)
    assert moved.take() == FIRST
    assert k_p(moved) == K_P != before  # the next tick has it
    moved.reach(FIRST + 20)
    assert moved.take() == FIRST + 20  # and the next change goes to the loop
    moved.reach(SECOND + 20)
    assert abs(moved.ratio(FIRST - 1, FIRST)[0] / K_P - 1.0) > 1e-3
    assert moved.ratio(FIRST, SECOND) == pytest.approx(K_P, rel=1e-5)
    assert moved.ratio(SECOND, SECOND + 20) == pytest.approx(2 * K_P, rel=1e-5)
    assert k_p(moved) == K_P
    moved.take()
    assert k_p(moved) == 2 * K_P


def test_periods_slept_through_do_not_shift_it(moved: Moved) -> None:
    moved.reach(FIRST - 5)
    moved.loop.sleep(10)
    moved.reach(FIRST + 20)
    assert moved.link.taken == FIRST


def test_a_change_of_a_person_meanwhile_keeps_those_to_come(moved: Moved) -> None:
    moved.reach(FIRST - 400)
    moved.take()
    tick = moved.change({f"{B}.x.k_p": 0.8 * K_P, D: 0.0})
    assert tick < FIRST - 300
    moved.reach(FIRST)
    moved.take()
    moved.reach(FIRST + 10)
    moved.take()
    assert moved.ratio(tick, tick + 20) == pytest.approx(0.8 * K_P, rel=1e-5)
    assert moved.ratio(FIRST - 1, FIRST) == pytest.approx(0.8 * K_P, rel=1e-5)
    assert moved.ratio(FIRST, FIRST + 10) == pytest.approx(K_P, rel=1e-5)
    moved.reach(SECOND + 10)
    moved.take()
    assert moved.ratio(SECOND, SECOND + 10) == pytest.approx(2 * K_P, rel=1e-5)


def test_a_change_does_not_come_between_a_scheduled_one_and_its_taking(moved: Moved) -> None:
    moved.reach(FIRST - 190)
    moved.take()
    changes = moved.ready({f"{B}.y.k_p": K_P})
    with pytest.raises(LinkError, match="takes effect at this moment"):
        moved.motion.adopt(changes)
    moved.reach(FIRST + 10)  # not taken yet: `changes` lack what has taken effect
    assert moved.motion.switches_within(0.1)
    with pytest.raises(LinkError, match="takes effect at this moment"):
        moved.motion.adopt(changes)
    moved.take()
    assert not moved.motion.switches_within(0.1)
    moved.change({f"{B}.y.k_p": K_P})
    assert k_p(moved) == K_P


def test_a_set_that_was_taken_back_is_not_taken(moved: Moved) -> None:
    moved.reach(FIRST)
    present = in_use(moved)
    assert moved.link.withdraw()
    moved.loop.cycle(3)
    assert in_use(moved) == present


def test_other_gains_take_the_place_of_a_set_that_waits(moved: Moved) -> None:
    held = held_parameters(on_drives(load_scenario("circle"), "A"))
    moved.link.load(held)
    moved.reach(FIRST + 10)
    assert (moved.loop.shared.parameters[in_use(moved)] == held.lanes).all()


def test_a_set_taken_in_the_very_cycle_stays(moved: Moved, monkeypatch: pytest.MonkeyPatch) -> None:
    moved.reach(FIRST)
    first, wait = moved.loop.shared.first, moved.link._await
    latest = int(moved.loop.shared.command[Command.PARAMETERS])

    def late(condition: Any) -> None:
        first[latest] = FIRST  # the loop had read it before it was taken back
        wait(condition)

    monkeypatch.setattr(moved.link, "_await", late)
    monkeypatch.setattr(moved.motion, "switches_within", lambda _: False)
    with pytest.raises(LinkError, match="takes effect at this moment"):
        moved.change({f"{B}.y.k_p": K_P})
    moved.loop.cycle(5)
    assert in_use(moved) == latest
    assert moved.link.taken == FIRST
    moved.take()
    assert k_p(moved) == K_P


def test_after_a_stop_nothing_that_waits_takes_effect(moved: Moved) -> None:
    moved.reach(FIRST - 20)
    moved.take()
    present = in_use(moved)
    moved.loop.stop()
    while moved.link.state != State.READY:
        moved.loop.cycle()
    assert moved.link.recorded[1] > FIRST
    assert in_use(moved) == present
    assert not moved.motion.switches_within(1e3)
    moved.take()
    assert k_p(moved) != K_P
    held = held_parameters(on_drives(load_scenario("circle"), "A"))
    moved.link.load(held)  # nor with the next arming
    moved.loop.arm()
    assert (moved.loop.shared.parameters[in_use(moved)] == held.lanes).all()


def test_a_change_that_comes_too_late_ends_the_motion(moved: Moved) -> None:
    moved.reach(SECOND + 20)  # by now the second should long have been there
    with pytest.raises(LinkError, match=r"scheduled at 0.75 s came too late"):
        moved.take()
        moved.loop.cycle()
        moved.take()


def test_only_what_is_of_the_chosen_variant_is_carried_out() -> None:
    scenario = load_scenario("fig5")
    (event,) = on_drives(scenario, "B").schedule
    assert set(event.set) == {path for path in scenario.schedule[0].set if "variants.B" in path}
    assert len(event.set) == 3
    others = [at(10, {"variants.A.label": "x"}), at(900, {B: "pd"})]
    (event,) = on_drives(load_scenario("circle", {"schedule": others}), "B").schedule
    assert event.set == {B: "pd", f"{B}.delay": 1}


@pytest.mark.parametrize(
    ("events", "told"),
    [
        ([at(900, {"plant.x.mass": 6.0})], "schedule.0.set.plant.x.mass: is of the simulated mac"),
        ([at(900, {"load.x": 1.0})], "schedule.0.set.load.x: is of the simulated machine"),
        ([at(900, {f"{B}.delay": 0})], f"schedule.0.set.{B}.delay: is 1 on drives"),
        ([at(199, PURE)], r"schedule.0.time: .*0.0995.*0.1.* s"),
        ([at(1199, PURE), at(1000, PURE)], r"schedule.0.time: .*0.5995.*0.6.* s"),
    ],
)
def test_what_drives_cannot_is_refused_by_name(events: list[Any], told: str) -> None:
    scenario = load_scenario("circle", {"schedule": events})
    with pytest.raises(ConfigError, match=told):
        on_drives(scenario, "B")
