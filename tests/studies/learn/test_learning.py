"""Learning from lap to lap: its response, its prediction, what it reaches, what it refuses."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, MotionLabError
from motionlab.kernel.force_maps import pole_pitch
from motionlab.lanes.bank import TABLES
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.learn.carry_over import Course, Lesson, fit_lessons
from motionlab.studies.learn.documents import LearnRequest
from motionlab.studies.learn.laps import Learning
from motionlab.studies.learn.learn import learn, learning_of, save
from motionlab.studies.learn.learning_filter import to_error
from motionlab.studies.learn.plan import LearnPlan, band, factors, plan
from motionlab.studies.learn.study import LearnStudy
from motionlab.trajectories.reference import sample
from tests.learnt_forces import known

MATCHED = {"plant": "matched", "variants.B.controller": "lugre-reference"}
NOISE = {f"plant.{axis}.amplifiers.noise": 0.01 for axis in AXES}
TICKS = 6000


def planned(scenario: str = "circle", **request: Any) -> LearnPlan:
    changes = MATCHED | NOISE | request.pop("set", {})
    return plan(LearnRequest(scenario=scenario, set=changes, variant="B", motors=0, **request))


def after_laps(planned: LearnPlan) -> Learning:
    learning = learning_of(planned)
    for _ in learning.run(planned.request.laps):
        pass
    return learning


@pytest.mark.parametrize("delay", [0, 1])
@pytest.mark.parametrize("axis", AXES)
def test_the_response_to_a_force_is_that_of_the_kernel(axis: str, delay: int) -> None:
    """A line of force in the lap, sliding: the line that the error of the run has."""
    cycles, amplitude = 240, 0.01  # in a lap of 3 s: 80 Hz
    angle = 2.0 * np.pi * cycles * np.arange(TICKS) / TICKS
    force = np.repeat(amplitude * np.sin(angle)[:, None], 2, axis=1)
    quiet = {
        f"plant.{each}.{path}": value
        for each in AXES
        for path, value in (("encoder.resolution", 0.0), ("friction.enabled", False))
    }
    quiet |= {f"variants.B.controller.model.{each}.friction.enabled": False for each in AXES}
    quiet |= {"variants.B.controller": "lugre-reference", "variants.B.controller.delay": delay}
    errors = []
    for added in (False, True):
        learnt = {"learnt": known(force).model_dump(), "variants.B.controller.learnt": added}
        record = run(prepare(load_scenario("circle", quiet | learnt))).variants["B"]
        errors.append(record.channel("following_error", axis)[-TICKS:].astype(float))
    with TABLES.lease():
        scenario = load_scenario("circle", quiet)
        expected = to_error(scenario, "B", axis, 4.0, np.array([cycles / 3.0]))[0]
    line = np.fft.rfft(errors[1] - errors[0])[cycles] / np.fft.rfft(force[:, 0])[cycles]
    assert abs(line / expected - 1.0) < 0.02


def test_both_axes_come_down_to_two_counts_and_stay_there() -> None:
    learning = after_laps(planned(laps=40))
    for axis in AXES:
        peaks = [lap.peak for lap in learning.axes[axis].laps]
        assert peaks[0] > 0.5e-6
        assert np.mean(peaks[8:]) < 0.1e-6
        assert np.mean([lap.true_peak for lap in learning.axes[axis].laps[8:]]) < 0.1e-6


def test_the_encoders_error_is_found_and_is_the_floor_without() -> None:
    """40 nm are in the matched motor: docs/physics.md."""
    known = after_laps(planned(laps=10)).axes["y"]
    left = after_laps(planned(laps=10, encoder=False)).axes["y"]
    assert np.hypot(*known.known) == pytest.approx(40e-9, abs=2e-9)
    assert left.known == (0.0, 0.0)
    assert known.laps[-1].true_rms < 0.75 * left.laps[-1].true_rms


def test_what_was_learnt_is_a_change_of_the_scenario() -> None:
    done = learn(planned(laps=10), lambda *_: None)
    scenario = load_scenario("circle", MATCHED | NOISE | done.document.changes)
    error = run(prepare(scenario)).variants["B"].channel("following_error", "x")
    assert np.abs(error[-TICKS:]).max() < 0.12e-6
    forgotten = load_scenario("circle", MATCHED | NOISE | done.document.changes | {"learnt": None})
    error = run(prepare(forgotten)).variants["B"].channel("following_error", "x")
    assert np.abs(error[-TICKS:]).max() > 0.4e-6
    again = plan(LearnRequest(laps=1, motors=0), source=scenario.model_dump(mode="json"))
    assert after_laps(again).axes["x"].laps[0].peak < 0.15e-6  # it goes on from what is known


def test_a_filter_of_the_wrong_sign_is_held_by_its_best_lap() -> None:
    honest = planned(laps=20, gain=0.3)
    filters = {
        axis: replace(each, response=-each.response) for axis, each in honest.filters.items()
    }
    learning = after_laps(replace(honest, filters=filters))
    for each in learning.axes.values():
        assert any(lap.went_back for lap in each.laps)
        assert max(lap.peak for lap in each.laps) < 4.0 * each.laps[0].peak


def test_after_going_back_it_learns_on() -> None:
    """The loop of K = 0, with a less damped observer of friction, has laps that are worse."""
    learning = after_laps(planned(set={"variants.B.controller": "lugre-observer"}, laps=20))
    for axis in AXES:
        laps = learning.axes[axis].laps
        assert not all(lap.went_back for lap in laps[-3:])
        assert laps[-1].peak < 0.1 * laps[0].peak
    assert any(lap.went_back for each in learning.axes.values() for lap in each.laps)


def test_it_goes_on_from_a_learnt_force_and_does_not_learn_from_the_way_to_it() -> None:
    """The paper's observer, whose first lap from rest is 7 um off with the force of the 16th."""
    paper = {"variants.B.controller": "lugre-observer"}
    done = learn(planned(set=paper, laps=16), lambda *_: None).document
    again = learn(planned(set=paper | done.changes, laps=4), lambda *_: None).document
    for axis in AXES:
        last = done.axes[axis].laps[-1].peak
        assert max(lap.peak for lap in again.axes[axis].laps) < 2.0 * last
    assert again.changes["learnt"]["laps"] == 20


def test_a_motor_that_diverges_is_said_and_not_written(tmp_path: Path) -> None:
    far = {"bandwidth": {"x": 900.0, "y": 900.0}, "gain": 2.0, "anyway": True}
    done = learn(planned(laps=12, **far), lambda *_: None)
    assert done.document.diverged
    assert LearnStudy().has_failed(done)
    assert all("diverged in lap" in text for text in done.document.summary)
    with pytest.raises(MotionLabError, match="diverged in lap"):
        save(done, str(tmp_path / "learnt.toml"))
    assert not (tmp_path / "learnt.toml").exists()


def test_effects_of_friction_are_predicted_as_the_guides() -> None:
    instead: dict[str, Any] = {f"plant.{axis}.friction.enabled": False for axis in AXES}
    instead |= {f"plant.{axis}.effects": [{"effect": "gms"}] for axis in AXES}
    paper = {"variants.B.controller": "lugre-observer"}
    with_effects, plain = planned(set=paper | instead), planned(set=paper)
    for axis in AXES:
        at = band(plain.filters[axis])
        rho = [factors(each, axis, each.scenario, at) for each in (with_effects, plain)]
        np.testing.assert_array_equal(rho[0], rho[1])


def test_laps_that_are_too_long_to_be_fitted_together_are_refused() -> None:
    slow = {"kind": "circle", "radius": 0.01, "frequency": 1 / 40, "laps": 2}
    with pytest.raises(ConfigError) as refused:
        planned(after=(slow, slow, slow))
    assert refused.value.errors[0].loc == "after"
    assert refused.value.errors[0].unit == "s"


def test_it_refuses_a_bandwidth_at_which_it_would_diverge() -> None:
    resonant = {"plant": "matched-resonant", "variants.B.controller": "lugre-reference-notch"}
    with pytest.raises(ConfigError) as refused:
        planned(set=resonant, bandwidth={"y": 200.0})
    error = refused.value.errors[0]
    assert error.loc == "bandwidth.y"
    assert "would grow by" in error.message
    assert planned(set=resonant, bandwidth={"y": 200.0}, anyway=True).filters


@pytest.mark.parametrize(
    ("request_", "loc"),
    [
        ({"variant": "C"}, "variant"),
        ({"scenario": "circle-published-k", "set": {}}, "variants.B.controller"),
    ],
)
def test_it_refuses_what_cannot_learn(request_: dict[str, Any], loc: str) -> None:
    with pytest.raises(ConfigError) as refused:
        plan(LearnRequest(**{"scenario": "circle", **request_}))
    assert refused.value.errors[0].loc.startswith(loc)


def test_it_refuses_a_motion_that_does_not_end_where_it_begins() -> None:
    line = {"start": {"x": 0.0, "y": 0.0}, "end": {"x": 0.01, "y": 0.0}, "edge_time": 1.0}
    one_way = {"kind": "line", **line}
    with pytest.raises(ConfigError, match="has no laps"):
        plan(LearnRequest(set={"trajectory": one_way}))


AFTER = ("rhombus", "pentagram", "trapezoid-y")


def test_what_other_motions_teach_is_carried_over_to_the_first_lap() -> None:
    done = learn(planned(laps=2, after=AFTER), lambda *_: None).document
    for axis, motions in (("x", AFTER[:2]), ("y", AFTER)):
        each = done.axes[axis]
        assert each.carried_over is not None
        assert each.carried_over.motions == list(motions)
        assert each.carried_over.explained > 0.98
        assert each.laps[0].peak < 0.35 * each.carried_over.peak
    assert "What rhombus and pentagram taught" in done.summary[0]


def test_an_axis_that_no_other_motion_moved_begins_without() -> None:
    done = learn(planned(laps=1, after=("trapezoid-y",)), lambda *_: None).document
    assert done.axes["x"].carried_over is None
    assert done.axes["x"].laps[0].force == 0.0
    assert done.axes["y"].carried_over is not None


def test_a_fit_finds_the_friction_that_made_the_force() -> None:
    """Of a made-up lap: other friction, mass and ripple than those of the model."""
    scenario = load_scenario("pentagram")
    model, reference = scenario.variants["B"].controller.model.y, sample(scenario.trajectory)
    course = Course(
        reference.position[:, 1],
        reference.velocity[:, 1],
        reference.acceleration[:, 1],
        np.ones(reference.ticks // 2 + 1),
    )
    known, tau = model.friction.parameters(), pole_pitch(model.force_map)
    true = known._replace(F_s=0.8 * known.F_s, v_s=0.7 * known.v_s, sigma_0=1.2 * known.sigma_0)
    force = 1.03 * model.mass * course.acceleration + 1.1 * true.sigma_2 * course.velocity
    force = force + course.friction(true) + 0.2 * np.sin(2.0 * np.pi * course.position / tau)
    found = fit_lessons([Lesson(course, force)], model, tau)
    assert found.explained > 0.999
    for name in ("F_s", "v_s", "sigma_0"):
        assert getattr(found.friction, name) == pytest.approx(getattr(true, name), rel=0.05)
    beyond = found.beyond_model(course)
    assert np.abs(beyond - (force - course.modelled(model))).max() < 0.1


def test_a_motor_that_diverges_while_it_learns_another_motion_is_said() -> None:
    far = {"bandwidth": {"x": 900.0, "y": 900.0}, "gain": 2.0, "anyway": True}
    with pytest.raises(MotionLabError, match=r"diverged in lap \d+ of rhombus"):
        learn(planned(laps=2, after=("rhombus",), **far), lambda *_: None)


def test_a_motion_to_learn_first_is_refused_by_its_number() -> None:
    with pytest.raises(ConfigError) as refused:
        planned(after=("rhombus", "nothing"))
    assert refused.value.errors[0].loc == "after.1"
