"""A learnt force over the laps of a motion: where it acts, and of which motion it is."""

from __future__ import annotations

import base64
from typing import Any

import numpy as np
import pytest

from motionlab.config.learnt_force import LearntForce
from motionlab.config.load import load_scenario
from motionlab.drive.motion import on_drives
from motionlab.errors import ConfigError
from motionlab.export.export import export_controller
from motionlab.simulation.learnt import Lap, lap_of
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.simulation.timeline import Timeline
from motionlab.trajectories.reference import sample
from tests.learnt_forces import known

TICKS = 6000
RAMP = np.repeat(np.linspace(0.0, 1.0, TICKS)[:, None], 2, axis=1).astype(np.float32)
USED = {"learnt": known(RAMP).model_dump(), "variants.B.controller.learnt": True}


@pytest.mark.parametrize(
    ("scenario", "lap"),
    [("circle", Lap(3000, 6000)), ("pentagram", Lap(0, 6000)), ("stair-y-50mm", Lap(0, 31490))],
)
def test_laps_of_shipped_motions(scenario: str, lap: Lap) -> None:
    assert lap_of(sample(load_scenario(scenario).trajectory)) == lap


def test_it_acts_in_whole_laps_and_not_before_and_after() -> None:
    reference = sample(load_scenario("circle").trajectory)
    timeline = Timeline(reference, np.zeros((1, 2)))
    force = timeline.learnt(known(RAMP), 0, reference.ticks + 10)
    assert not force[:3000].any()
    assert not force[reference.ticks :].any()
    np.testing.assert_array_equal(force[3000:9000], RAMP)
    np.testing.assert_array_equal(force[9000:12000], RAMP[:3000])


def test_it_goes_on_for_ever_until_a_stop() -> None:
    reference = sample(load_scenario("circle").trajectory)
    timeline = Timeline(reference, np.zeros((1, 2)), endless=True)
    there = reference.ticks + 5 * TICKS + 17
    np.testing.assert_array_equal(timeline.learnt(known(RAMP), there, there + 9), RAMP[17:26])
    timeline.stop(there + 4, (1.0, 1.0))
    assert not timeline.learnt(known(RAMP), there + 4, there + 9).any()


def test_it_is_added_after_the_friction_estimate_and_realised() -> None:
    record = run(prepare(load_scenario("circle", USED)))
    step = np.zeros((TICKS, 2))
    plain = run(prepare(load_scenario("circle", USED | {"learnt": known(step).model_dump()})))
    first = 3001  # the ramp's second value acts: the state is still the same
    changed = (
        record.variants["B"].channel("force_command", "x")[first]
        - plain.variants["B"].channel("force_command", "x")[first]
    )
    assert changed == pytest.approx(RAMP[1, 0], abs=1e-6)
    for name in ("force_command", "position"):  # A does not add it
        np.testing.assert_array_equal(
            record.variants["A"].channel(name, "x"), plain.variants["A"].channel(name, "x")
        )


def test_of_a_lap_of_another_length_it_is_stretched_and_said() -> None:
    prepared = prepare(load_scenario("circle", USED | {"trajectory.frequency": 0.25}))
    force = Timeline(prepared.reference, prepared.load).learnt(known(RAMP), 4000, 12000)
    np.testing.assert_allclose(force[:7990, 0], np.linspace(0.0, 1.0, 8000)[:7990], atol=2e-3)
    assert any("stretched over one of 4 s" in note for note in prepared.reference.notes)


@pytest.mark.parametrize("pitches", [0.0, 1.0])
def test_a_motion_moved_by_pole_pitches_is_the_same(pitches: float) -> None:
    tau = load_scenario("circle").plant.x.force_map.tau  # pyright: ignore[reportAttributeAccessIssue]
    assert prepare(load_scenario("circle", USED | {"trajectory.center.x": pitches * tau}))


@pytest.mark.parametrize("change", [{"trajectory.radius": 0.0151}, {"trajectory.center.x": 0.001}])
def test_it_is_refused_for_another_motion(change: dict[str, Any]) -> None:
    with pytest.raises(ConfigError, match="another motion") as refused:
        prepare(load_scenario("circle", USED | change))
    assert refused.value.errors[0].unit == "m"


def test_one_that_no_controller_adds_is_of_any_motion_and_one_that_is_not_there_is_noted() -> None:
    unused = USED | {"variants.B.controller.learnt": False, "trajectory.radius": 0.01}
    assert prepare(load_scenario("circle", unused)).reference.notes == ()
    missing = prepare(load_scenario("circle", USED | {"learnt": None}))
    assert any("the scenario has none" in note for note in missing.reference.notes)


def _letters(values: list[float]) -> str:
    return base64.b64encode(np.array(values, dtype="<f4").tobytes()).decode()


@pytest.mark.parametrize(
    ("values", "why"),
    [
        ({"x": "?"}, "base64"),
        ({"x": _letters([0.0])}, "holds no 400 to"),
        ({"x": _letters([0.0, np.nan, *[0.0] * 398])}, "in period 1"),
        ({"x": _letters([0.0, 101.0, *[0.0] * 398])}, "101 N in period 1"),
        ({"x": _letters([0.0] * 400)}, "equally many"),
        ({"places": [[0.0, 0.0]]}, "places"),
    ],
)
def test_what_is_no_force_is_refused(values: dict[str, Any], why: str) -> None:
    with pytest.raises(ConfigError, match=why):
        load_scenario("circle", USED | {"learnt": USED["learnt"] | values})


def test_drives_and_exported_c_refuse_it(tmp_path: Any) -> None:
    scenario = load_scenario("circle", USED)
    with pytest.raises(ConfigError, match="no learnt force"):
        on_drives(scenario, "B")
    with pytest.raises(ConfigError, match="not written as C"):
        export_controller(scenario, "B", tmp_path / "c")
    assert isinstance(scenario.learnt, LearntForce)
