"""Feasibility as data says the same as the refusal, and slowing down is no more than needed."""

from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from motionlab.config.load import epochs, load_scenario
from motionlab.config.named_configs import names
from motionlab.config.trajectory import TrajectoryConfig
from motionlab.errors import ConfigError, Infeasible
from motionlab.simulation.prepare import limit_sets, prepare
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.feasibility import check
from motionlab.trajectories.motion_limits import ALWAYS, QUANTITIES, Span
from motionlab.trajectories.reference import sample
from motionlab.trajectories.retiming import slow_down, stretched
from motionlab.trajectories.trajectory_check import examine

ADAPTER: TypeAdapter[Any] = TypeAdapter(TrajectoryConfig)
SCENARIO = load_scenario("circle")
LIMITS = limit_sets(tuple(epochs(SCENARIO)))
RHOMBUS = [[0.03, 0.0], [0.0, 0.03], [-0.03, 0.0], [0.0, -0.03]]


def path(**change):
    table = {"kind": "path", "points": RHOMBUS, "closed": True, "v_max": 0.08, "a_max": 0.8}
    return ADAPTER.validate_python(table | change)


MOTIONS = {
    "feasible": path(laps=3),
    "too much thrust": path(a_max=6.0, v_max=0.5, laps=2),
    "out of the stroke": path(points=[[0.09, 0.0], [0.0, 0.03], [0.0, -0.15]]),
    "corners at speed": path(law="constant_speed", laps=2),
    "too fast": path(points=[[-0.08, 0.0], [0.08, 0.1]], closed=False, v_max=3.0, a_max=20.0),
    "a long step": ADAPTER.validate_python({"kind": "step", "height": {"x": 5e-5}}),
}


def slowed(motion: Any) -> tuple[Any, float]:
    return slow_down(motion, LIMITS)


def accepted(motion) -> Infeasible | None:
    try:
        for span, limits in LIMITS:
            check(sample(motion), limits, span=span)
    except Infeasible as refusal:
        return refusal
    return None


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_data_and_refusal_agree(motion):
    found = examine(motion, LIMITS, bins=300)
    refusal = accepted(motion)
    assert found.feasible == (refusal is None)
    assert found.violation_count >= len(found.violations)
    if refusal is None:
        return
    first = min(found.violations, key=lambda each: each.start)
    assert first.start == pytest.approx(refusal.time)
    shares = [each.share for each in found.violations]
    assert shares == sorted(shares, reverse=True)
    for each in found.violations:
        assert each.share > 1.0
        assert each.start <= each.time <= each.end


@pytest.mark.parametrize("motion", MOTIONS.values(), ids=MOTIONS)
def test_profiles_hold_every_extreme_and_flag_every_violation(motion):
    found = examine(motion, LIMITS, bins=97)
    curves = {profile.name: profile for profile in found.profiles}
    ref = sample(motion)
    ticks = round(found.examined / 0.0005)
    for axis, name in enumerate("xy"):
        velocity = ref.velocity[:ticks, axis]
        profile = curves[f"{name}.velocity"]
        assert profile.maximum.max() == np.float32(velocity.max())
        assert profile.minimum.min() == np.float32(velocity.min())
        available = curves[f"{name}.available_thrust"]
        assert (available.maximum > 0).all() and (available.minimum < 0).all()
    flags = curves["violated"].maximum.astype(int)
    for each in found.violations:
        bit = 1 << QUANTITIES.index(each.quantity)
        last = len(flags) - 1
        bins = slice(
            int(each.start / found.step + 1e-6), min(int(each.end / found.step + 1e-6), last) + 1
        )
        assert (flags[bins] & bit).all()
    if found.feasible:
        assert not flags.any()


def test_one_lap_stands_for_all_that_repeat():
    one, many = (examine(path(laps=laps), LIMITS, bins=100) for laps in (1, 5))
    assert many.duration == pytest.approx(5 * one.duration)
    assert many.examined == one.examined == one.duration
    assert many.length == pytest.approx(4 * np.hypot(0.03, 0.03), rel=1e-6)
    assert [vars(p) for p in many.peaks] == [vars(p) for p in one.peaks]


def test_the_extent_is_of_every_tick():
    found = examine(path(), LIMITS, bins=7)
    assert found.profiles[0].maximum.max() <= 0.03
    for axis, most in {"x": 0.03, "y": 0.03}.items():
        assert found.extent[axis] == pytest.approx((-most, most), abs=1e-8)


def test_laps_are_not_left_out_when_the_motor_changes_during_the_run():
    later = [*LIMITS, (Span(10_000), LIMITS[0][1])]
    found = examine(path(laps=5), later, bins=100)
    assert found.examined == found.duration


@pytest.mark.parametrize("name", names("trajectories"))
def test_what_ships_is_feasible(name):
    scenario = load_scenario("circle", {"trajectory": name})
    assert examine(scenario.trajectory, limit_sets(tuple(epochs(scenario))), bins=50).feasible


@pytest.mark.parametrize("law", ["minimum_jerk", "trapezoid", "jerk_limited", "constant_speed"])
def test_slowing_down_is_no_more_than_needed(law):
    extra = {"j_max": 500.0} if law == "jerk_limited" else {}
    geometry = "spline" if law == "constant_speed" else "polyline"
    motion = path(law=law, geometry=geometry, v_max=0.5, a_max=6.0, **extra)
    assert accepted(motion) is not None
    slower, stretch = slowed(motion)
    assert stretch > 1.0
    assert accepted(slower) is None
    assert accepted(stretched(motion, stretch / 1.01)) is not None
    before, after = sample(motion), sample(slower)
    assert after.ticks == pytest.approx(before.ticks * stretch, rel=0.02)


def test_a_lap_time_is_stretched_too():
    slower, stretch = slowed(path(v_max=None, a_max=None, lap_time=0.5))
    assert slower.lap_time == pytest.approx(0.5 * stretch)
    assert accepted(slower) is None


def test_what_is_feasible_stays_as_it_is():
    motion = path()
    assert slow_down(motion, LIMITS) == (motion, 1.0)


def test_no_stretch_brings_a_path_into_the_stroke():
    with pytest.raises(Infeasible, match=r"position on x is 0\.09 m"):
        slow_down(MOTIONS["out of the stroke"], LIMITS)


def test_what_has_no_time_law_stays_infeasible():
    with pytest.raises(ConfigError, match="however slow"):
        slow_down(MOTIONS["a long step"], LIMITS)


def test_other_kinds_are_slowed_down_by_their_own_numbers():
    circle = ADAPTER.validate_python({"kind": "circle", "radius": 0.03, "frequency": 3.0})
    slower, stretch = slowed(circle)
    assert slower.frequency == pytest.approx(3.0 / stretch)
    parts = ADAPTER.validate_python(
        {
            "kind": "sequence",
            "parts": [{"kind": "dwell"}, {"kind": "line", "end": {"x": 0.05}, "edge_time": 0.05}],
        }
    )
    slower, stretch = slowed(parts)
    assert slower.parts[0].duration == 1.0
    assert slower.parts[1].edge_time == pytest.approx(0.05 * stretch)


def test_a_feasible_path_runs():
    tables = SCENARIO.model_dump(mode="json") | {"trajectory": path(laps=2).model_dump(mode="json")}
    prepared = prepare(load_scenario(tables))
    assert prepared.reference.period * 2 == prepared.reference.ticks


def test_a_motion_of_more_than_five_minutes_is_not_slowed_down():
    motion = TypeAdapter(TrajectoryConfig).validate_python({"kind": "point", "duration": 300.5})
    with pytest.raises(ConfigError, match="too long to be slowed down") as caught:
        slow_down(motion, LIMITS)
    assert caught.value.errors[0].value == 300.5


def limits_over_time(*limits: tuple[float, float]) -> dict[str, Any]:
    """Return changes to `trapezoid-y`, which stands still until 1 s: when which force limit."""
    path = "variants.A.controller.force_limit"
    (_, first), *later = limits
    schedule = [{"time": time, "set": {path: newtons}} for time, newtons in later]
    return {path: first, "schedule": schedule}


@pytest.mark.parametrize("limits", [[(0, 2.0), (0.5, 40.0)], [(0, 40.0), (0.2, 2.0), (0.9, 40.0)]])
def test_limits_hold_until_they_are_changed(limits):
    scenario = load_scenario("trapezoid-y", limits_over_time(*limits))
    assert prepare(scenario).epochs[-1][0] > 0
    assert examine(scenario.trajectory, limit_sets(tuple(epochs(scenario))), bins=50).feasible


def test_limits_that_come_while_it_moves_are_refused_from_there_on():
    scenario = load_scenario("trapezoid-y", limits_over_time((0, 40.0), (1.02, 2.0), (1.04, 40.0)))
    with pytest.raises(Infeasible, match=r"t = 1\.0200 s.*allowed -1\.98 to 1\.98 N, 1 % are left"):
        prepare(scenario)
    (violation,) = examine(
        scenario.trajectory, limit_sets(tuple(epochs(scenario))), bins=50
    ).violations
    assert (violation.start, violation.end) == pytest.approx((1.02, 1.04 - CONTROL_PERIOD))


def test_a_change_that_does_not_touch_the_limits_begins_none():
    (one,) = limit_sets(tuple(epochs(load_scenario("fig5"))))
    assert one[0] == ALWAYS
