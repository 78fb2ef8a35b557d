"""Effects wherever a motor is: configs, runs beside others, batches, REST, loops, exports."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError, Infeasible
from motionlab.export.plant import export_plant
from motionlab.kernel.build import lane_parameters
from motionlab.kernel.law_calls import laws_of
from motionlab.loop.document import loop_document
from motionlab.loop.linearise import linearise
from motionlab.simulation.batch import CaseTask, run_batch
from motionlab.simulation.lane_run import Known, Obstacle, lane_run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from tests.library.served import API
from tests.simulated import SHORT, play

GMS = {"effect": "gms"}


def instead(*effects: dict[str, Any]) -> dict[str, Any]:
    """Return changes that give both axes effects in place of their friction."""
    return {
        key: value
        for axis in AXES
        for key, value in (
            (f"plant.{axis}.effects", list(effects)),
            (f"plant.{axis}.friction.enabled", False),
        )
    }


def error(changes: dict[str, Any], variant: str = "B", axis: str = "x") -> float:
    return play("circle-resonant", SHORT | changes).largest_error(variant, axis)


def test_without_effects_the_kernel_has_none_of_it() -> None:
    scenario = load_scenario("circle")
    assert laws_of(lane_parameters(scenario)).effects is None
    changed = load_scenario("circle", {"plant.y.effects": [GMS, GMS]})
    assert laws_of(lane_parameters(changed)).effects.rows.shape[0] == 2


@pytest.mark.parametrize("map", [{}, {"plant.force_map": "new-design"}])
def test_an_axis_without_effects_has_the_same_bits_beside_one_that_has_some(
    map: dict[str, Any],
) -> None:
    alone = play("circle-resonant", SHORT | map).recording
    beside = play("circle-resonant", SHORT | map | {"plant.y.effects": [GMS]}).recording
    for name in alone.variants:
        x, with_y = (each.variants[name].samples[:, 0] for each in (alone, beside))
        assert np.array_equal(x, with_y)
        y, changed = (each.variants[name].samples[:, 1] for each in (alone, beside))
        assert not np.array_equal(y, changed)


def test_lugre_as_an_effect_is_that_of_the_motor() -> None:
    built_in, effect = play("circle", SHORT), play("circle", SHORT | instead({"effect": "lugre"}))
    for name in ("friction", "position"):
        own, other = (each.channel("A", name, "x") for each in (built_in, effect))
        assert np.abs(own - other).max() < 1e-2 * np.abs(own).max()


def test_batches_give_what_a_run_gives() -> None:
    scenario = load_scenario("circle-resonant", SHORT).model_dump(mode="json")
    effects: list[list[dict[str, Any]]] = [
        [],
        [GMS],
        [{"effect": "static-stribeck"}],
        [{"effect": "dahl"}, {"effect": "cogging"}],
        *([GMS | {"F_s": 4.0 + k}] for k in range(6)),
    ]
    changes = [instead(*each) for each in effects]
    batch = run_batch(CaseTask(scenario, 0, changes, 1, {}, {}))
    for case, each in enumerate(changes):
        prepared = prepare(load_scenario("circle-resonant", SHORT | each))
        result = document(prepared, run(prepared))
        for variant, name in enumerate(batch.variants):
            for place, axis in enumerate(AXES):
                figure = result["variants"][name]["axes"][axis]["max_abs_following_error"]
                peak = batch.metrics["max_abs_following_error"]
                assert peak[case, variant, place] == figure


@pytest.mark.parametrize("law", ["gms-observer", "dahl-observer", "static-stribeck-observer"])
@pytest.mark.parametrize("speed", [0.0, 0.5, 4.0])
def test_an_observer_that_sees_the_reference_is_no_feedback(law: str, speed: float) -> None:
    """Its loop is that of no compensation: no state of it has a slope towards the measurement."""
    place = "variants.B.controller.compensation"
    loops = {
        name: load_scenario("circle", {f"{place}.law": name, f"{place}.velocity": "reference"})
        for name in ("off", law)
    }
    v = speed * loops["off"].plant.x.friction.v_s
    frequency = np.array([1.0, 30.0, 300.0])
    plain, observed = (linearise(each, "B", "x", v=v) for each in loops.values())
    np.testing.assert_allclose(observed.open(frequency), plain.open(frequency), rtol=1e-6)
    assert observed.stable


def test_a_scenario_with_effects_goes_to_workers() -> None:
    scenario = load_scenario("circle", {"plant.x.effects": [GMS]})
    assert pickle.loads(pickle.dumps(scenario)) == scenario


def test_an_observer_of_the_plants_own_model_is_the_best() -> None:
    law = "variants.B.controller.compensation.law"
    reference = {"variants.B.controller.compensation.velocity": "reference"}
    for effect in ("gms", "static-stribeck"):
        errors = {
            name: error(instead({"effect": effect}) | reference | {law: name})
            for name in ("lugre-observer", "gms-observer", "static-stribeck-observer")
        }
        assert min(errors, key=lambda name: errors[name]) == f"{effect}-observer"


def test_an_effect_that_changes_during_a_run_begins_at_rest() -> None:
    at = [{"time": 1.0, "set": {"plant.x.effects": [{"effect": "dahl", "F_c": 1.0}]}}]
    played = play("circle", SHORT | instead(GMS) | {"schedule": at})
    before = play("circle", SHORT | instead(GMS))
    own, other = (each.channel("A", "friction", "x") for each in (before, played))
    v = played.channel("A", "velocity", "x")[2000]
    sigma_2 = load_scenario("circle").plant.x.friction.sigma_2
    assert abs(v) > 1e-3 and abs(own[2000]) > 1.0
    assert other[2000] == pytest.approx(sigma_2 * v, abs=1e-3)
    assert np.array_equal(own[:2000], other[:2000])
    assert not np.array_equal(own[2000:], other[2000:])


def test_a_motion_has_to_overcome_the_friction_of_effects() -> None:
    strong = {"effect": "static-stribeck", "F_c": 60.0, "F_s": 60.0}
    with pytest.raises(Infeasible, match="thrust"):
        prepare(load_scenario("circle", {"plant.x.effects": [strong]}))


@pytest.mark.parametrize(
    ("effects", "place", "words"),
    [
        ([{"effect": "gmss"}], "effects.0.effect", "did you mean 'gms'?"),
        ([{}], "effects.0.effect", "is missing"),
        ([GMS | {"F_c": -1.0}], "effects.0.F_c", "got -1.0; allowed >= 1e-06 and <= 100 N"),
        ([GMS, GMS | {"pitch": 1.0}], "effects.1.pitch", "unknown key"),
        ([GMS | {"F_c": 9.0}], "plant.x", "effect gms: F_s = 3.5908 N is below F_c = 9 N"),
        ([GMS] * 5, "plant.x.effects", "allowed 4 or fewer items"),
        (GMS, "plant.x.effects", "must be a list"),
    ],
)
def test_what_is_no_effect_is_refused(effects: Any, place: str, words: str) -> None:
    with pytest.raises(ConfigError) as refused:
        load_scenario("circle", {"plant.x.effects": effects})
    text = str(refused.value)
    assert place in text and words in text


def test_a_field_of_an_effect_is_set_by_its_path() -> None:
    changes = {"plant.x.effects": [GMS], "plant.x.effects.0.attraction": 30.0}
    (effect,) = load_scenario("circle", changes).plant.x.effects
    assert (effect.effect, getattr(effect, "attraction", None)) == ("gms", 30.0)


def test_rest_simulates_them(client: httpx.Client) -> None:
    body = {"scenario": "circle", "set": SHORT | {"plant.x.effects": [GMS]}}
    answer = client.post(f"{API}/simulate", json=body)
    assert answer.status_code == 200
    words = answer.json()["variants"]["A"]["notes"]
    assert any("friction acts twice: that of plant.x.friction" in each for each in words)
    body["set"] = {"plant.x.effects": [GMS | {"sigma_0": 0.0}]}
    refused = client.post(f"{API}/simulate", json=body)
    assert refused.status_code == 422
    assert "plant.x.effects.0.sigma_0" in refused.text


def test_the_page_the_loop_and_the_fmu_say_that_they_have_none(tmp_path: Path) -> None:
    scenario = load_scenario("circle", {"plant.y.effects": [GMS]})
    prepared = prepare(scenario)
    with pytest.raises(Obstacle, match="the motor has effects"):
        lane_run(prepared, None, 100, Known())
    assert loop_document(scenario).variants["B"].note == "without the plant's effects: gms"
    assert loop_document(load_scenario("circle")).variants["B"].note is None
    with pytest.raises(ConfigError, match=r"plant\.y\.effects: cannot be exported"):
        export_plant(scenario, tmp_path / "motor.fmu")


def test_jitter_reads_where_the_mover_is_a_little_later() -> None:
    exact = {"plant.x.encoder.resolution": 0.0, "plant.x.encoder.sde_amplitude": 0.0}
    jitter = 5e-6
    quiet = play("circle", SHORT | exact)
    played = play("circle", SHORT | exact | {"plant.x.encoder.jitter": jitter})
    assert np.array_equal(played.channel("A", "position", "y"), quiet.channel("A", "position", "y"))
    p, p_meas, v = (
        played.channel("A", name, "x") for name in ("position", "position_measured", "velocity")
    )
    moving = np.abs(v) > 5e-3
    late = (p_meas - p)[moving] / v[moving]
    assert late.std() == pytest.approx(jitter, rel=0.1)
    assert abs(late.mean()) < 0.1 * jitter
    again = play("circle", SHORT | exact | {"plant.x.encoder.jitter": jitter})
    assert np.array_equal(p_meas, again.channel("A", "position_measured", "x"))
    other = play("circle", SHORT | exact | {"plant.x.encoder.jitter": jitter, "seed": 7})
    assert not np.array_equal(p_meas, other.channel("A", "position_measured", "x"))
