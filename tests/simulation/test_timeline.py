"""The timeline: continuous beyond a motion's end and through a stop; pushes add up."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionlab.config.load import load_scenario
from motionlab.config.named_configs import names
from motionlab.simulation.prepare import prepare
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD

BRIEF = {
    "circle": {"trajectory.laps": 1, "trajectory.lead_in": 0.5},
    "rhombus": {"trajectory.laps": 1},
    "pentagram": {"trajectory.laps": 1},
    "trapezoid-y": {},
    "stair-y-50mm": {"trajectory.count": 2},
}
"""Smooth motions that come back to where they can go on."""

RAMP = {"kind": "ramp", "velocity": {"x": 0.02}, "duration": 1.0}


def timeline(name, changes=None, **options):
    prepared = prepare(load_scenario(name, changes))
    return Timeline(prepared.reference, prepared.load, **options), prepared


def largest_jump(position, velocity):
    """Return the largest change of position in one tick beyond what velocity explains, m."""
    travelled = 0.5 * (velocity[1:] + velocity[:-1]) * CONTROL_PERIOD
    return np.abs(np.diff(position, axis=0) - travelled).max()


@pytest.mark.parametrize("name", BRIEF)
def test_endless_motion_stays_continuous(name):
    line, prepared = timeline(name, BRIEF[name], endless=True)
    ticks = prepared.reference.ticks
    assert line.end is None
    position, velocity, acceleration, _ = line.at(0, 3 * ticks)
    once_velocity = prepared.reference.velocity
    # no jump, neither of position nor of velocity, is larger than within the motion itself
    once = largest_jump(prepared.reference.position, once_velocity)
    assert largest_jump(position, velocity) <= once + 1e-12
    steepest = np.abs(np.diff(once_velocity, axis=0)).max()
    assert np.abs(np.diff(velocity, axis=0)).max() <= steepest * (1 + 1e-6) + 1e-12
    assert np.abs(acceleration).max() == np.abs(prepared.reference.acceleration).max()
    # and it does move on
    assert np.ptp(position[ticks:], axis=0).max() > 1e-3


@pytest.mark.parametrize("name", BRIEF)
def test_within_the_motion_endless_changes_nothing(name):
    line, prepared = timeline(name, BRIEF[name], endless=True)
    ticks = prepared.reference.ticks
    for got, expected in zip(
        line.at(0, ticks),
        (
            prepared.reference.position,
            prepared.reference.velocity,
            prepared.reference.acceleration,
            prepared.load,
        ),
        strict=True,
    ):
        assert got.tobytes() == expected.tobytes()


@pytest.mark.parametrize("name", names("scenarios"))
def test_every_shipped_motion_goes_on(name):
    line, prepared = timeline(name, endless=True)
    assert line.end is None
    last = prepared.reference.position[-1]
    following = line.at(prepared.reference.ticks, prepared.reference.ticks + 1)[0][0]
    assert np.abs(following - last).max() < 1e-4


def test_a_motion_that_leads_away_ends():
    line, prepared = timeline("circle", {"trajectory": RAMP}, endless=True)
    assert line.end == prepared.reference.ticks


def test_without_endless_a_motion_ends():
    line, prepared = timeline("circle")
    assert line.end == prepared.reference.ticks


@given(cut=st.integers(0, 20_000), start=st.integers(0, 20_000), count=st.integers(1, 3000))
@settings(max_examples=30)
def test_pieces_are_the_whole(cut, start, count):
    line, _ = timeline("circle", BRIEF["circle"], endless=True)
    line.push(start + count // 3, axis=0, force=2.0, ticks=500)
    line.stop(start + count // 2, (3.0, 2.0))
    cut = start + cut % (count + 1)
    whole = line.at(start, start + count)
    for piece, first, second in zip(
        whole, line.at(start, cut), line.at(cut, start + count), strict=True
    ):
        assert np.concatenate((first, second)).tobytes() == piece.tobytes()


pushes = st.lists(
    st.tuples(
        st.integers(0, 2000), st.integers(0, 1), st.floats(-50, 50), st.integers(1, 1500)
    ).map(lambda p: {"tick": p[0], "axis": p[1], "force": p[2], "ticks": p[3]}),
    max_size=5,
)


@given(pushes=pushes)
@settings(max_examples=50)
def test_pushes_add_to_the_load_while_they_last(pushes):
    line, prepared = timeline("circle", BRIEF["circle"] | {"load.y": 1.0})
    expected = prepared.load.copy()
    moment = 0
    for push in sorted(pushes, key=lambda push: push["tick"]):
        moment = push["tick"]
        line.push(**{"tick": moment, **{k: v for k, v in push.items() if k != "tick"}})
        expected[moment : moment + push["ticks"], push["axis"]] += push["force"]
    load = line.at(moment, 4000)[3]  # what is over need not be remembered
    assert load.tobytes() == expected[moment:4000].tobytes()


def test_a_push_leaves_the_motion_alone():
    line, prepared = timeline("circle")
    line.push(100, axis=1, force=3.0, ticks=20)
    position, velocity, acceleration, load = line.at(90, 130)
    assert position.tobytes() == prepared.reference.position[90:130].tobytes()
    assert velocity.tobytes() == prepared.reference.velocity[90:130].tobytes()
    assert acceleration.tobytes() == prepared.reference.acceleration[90:130].tobytes()
    assert load[:, 1].tolist() == [0.0] * 10 + [3.0] * 20 + [0.0] * 10
    assert not load[:, 0].any()
    assert not prepared.load.any()


def test_a_load_is_replaced_from_its_tick_on():
    line, _ = timeline("circle", {"load.x": 1.0})
    line.load(50, lambda stop, start: np.full((stop - start, 2), 4.0))
    line.load(80, lambda stop, start: np.full((stop - start, 2), 5.0))
    line.load(70, lambda stop, start: np.arange(2.0 * start, 2.0 * stop).reshape(-1, 2))
    load = line.at(40, 100)[3]
    assert load[:10].tolist() == [[1.0, 0.0]] * 10
    assert load[10:30].tolist() == [[4.0, 4.0]] * 20
    assert load[30:].tolist() == [[2.0 * k, 2.0 * k + 1] for k in range(70, 100)]


def test_a_load_goes_on_after_the_motion_as_it_ended():
    steps = [{"time": 1.0, "x": 2.0}]
    changes = BRIEF["circle"] | {"load.steps": steps}
    line, prepared = timeline("circle", changes, endless=True)
    load = line.at(0, 3 * prepared.reference.ticks)[3][:, 0]
    assert not load[:2000].any()
    assert (load[2000:] == 2.0).all()


@given(
    name=st.sampled_from(["circle", "trapezoid-y", "rhombus"]),
    share=st.floats(0, 2.5),
    limits=st.tuples(st.floats(0.2, 20), st.floats(0.2, 20)),
)
@settings(max_examples=40)
def test_a_stop_is_smooth_keeps_its_deceleration_and_rests(name, share, limits):
    line, prepared = timeline(name, BRIEF[name], endless=True)
    tick = int(share * prepared.reference.ticks)
    before = [part.copy() for part in line.at(tick, tick + 1)]
    rest = line.stop(tick, limits)
    position, velocity, acceleration, _ = line.at(tick, rest + 500)
    # it begins where the motion was
    assert position[0].tolist() == before[0][0].tolist()
    assert velocity[0].tolist() == before[1][0].tolist()
    # the velocity never jumps, changes its sign, or grows; the position is its integral
    assert (np.abs(np.diff(velocity, axis=0)) <= np.array(limits) * CONTROL_PERIOD + 1e-12).all()
    assert (np.diff(np.abs(velocity), axis=0) <= 1e-15).all()
    assert (velocity * np.sign(before[1][0]) >= -1e-15).all()
    bound = max(limits) * CONTROL_PERIOD**2
    assert largest_jump(position, velocity) <= bound
    way = before[1][0] ** 2 / (2 * np.array(limits))
    assert np.abs(position[-1] - position[0]) == pytest.approx(way, abs=1e-12)
    assert (np.abs(acceleration) <= np.array(limits)).all()
    # it rests from the tick that was promised on, and not much earlier
    resting = velocity[rest - tick :], acceleration[rest - tick :]
    assert all(np.abs(part).max() <= 1e-12 for part in resting)
    assert (position[rest - tick :] == position[-1]).all()
    if rest - tick > 3:
        assert np.abs(velocity[rest - tick - 3]).max() > 0
    assert line.end is None
