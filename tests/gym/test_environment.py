"""The environments obey gymnasium's rules, and give the kernel's bits."""

import importlib
import sys
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box
from gymnasium.utils.env_checker import check_env, data_equivalence
from gymnasium.vector import AutoresetMode, SyncVectorEnv

import motionlab.gym
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError
from motionlab.gym.environment import PlanarMotorEnv, PlanarMotorVectorEnv
from motionlab.gym.motors import SCALES
from motionlab.gym.step import OBSERVED, Observed
from motionlab.simulation.inputs import PAGE
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.simulation.simulation import Simulation, sample_page
from motionlab.studies.montecarlo.documents import Variation
from motionlab.studies.montecarlo.draw import draw
from motionlab.timing import CONTROL_PERIOD

IMPERFECT = {
    "plant.x.encoder.noise": 3e-8,
    "plant.y.encoder.noise": 2e-8,
    "plant.x.amplifiers.noise": 0.02,
    "plant.y.amplifiers.bandwidth": 800.0,
    "plant.x.amplifiers.ripple_amplitude": 0.05,
    "plant.x.resonance.coupling": -0.05,
    "load.noise": 0.3,
    "load.steps": [{"time": 0.1, "x": 2.0, "y": -1.0}],
    "variants.B.controller.delay": 1,
    "variants.B.controller.disturbance_observer.enabled": True,
    "variants.B.controller.compensation.law": "residual-k",
    "variants.B.controller.x.notch.gain": 0.2,
}
"""Every source of noise, and controllers with every memory."""

CHANNELS = {
    "following_error": "following_error",
    "position_measured": "position_measured",
    "velocity_measured": "velocity_measured",
}
"""Channels of a run that are observed, by field."""

TICKS = 3 * PAGE - 6  # the ring of inputs has been filled twice
SHORT = {"duration": 0.02, "ticks": 3}


def seen(observations, field, axis):
    return observations[..., axis * OBSERVED + Observed._fields.index(field)]


@pytest.mark.parametrize("ticks", [1, 6])
def test_without_action_it_is_the_run_of_the_kernel_bit_for_bit(ticks):
    envs = PlanarMotorVectorEnv(5, set=IMPERFECT, ticks=ticks, scaled=False)
    first, info = envs.reset(seed=7)
    observations = [first] + [
        envs.step(np.zeros((5, 2), np.float32))[0] for _ in range(TICKS // ticks)
    ]
    for number in (0, 4):  # of a full block of lanes, and of one with idle lanes
        changes = IMPERFECT | {"seed": int(info["seed"][number])}
        prepared = prepare(load_scenario("circle", changes))
        simulation, page = Simulation(prepared), sample_page(2)
        while simulation.tick < TICKS:
            simulation.advance(page[:, : TICKS - simulation.tick])
        place = 2 * (number % 4)
        state = envs._motors._state[number // 4, :, place : place + 2]
        np.testing.assert_array_equal(state, simulation.snapshot().state[0, :, 2:4])

        record = run(prepared, stop=TICKS + 1).variants["B"]
        shown = np.array(observations)[:, number]
        for axis, name in enumerate("xy"):
            for field, channel in CHANNELS.items():
                recorded = record.channel(channel, name)[: TICKS + 1 : ticks]
                np.testing.assert_array_equal(seen(shown, field, axis), recorded)


def test_a_force_takes_the_controllers_place():
    # without friction, phases and encoder steps: v = F/M t
    mass = 4.0
    free = {"plant.force": "ideal", "load.x": 0.0}
    for axis in "xy":
        free |= {
            f"plant.{axis}.mass": mass,
            f"plant.{axis}.friction.enabled": False,
            f"plant.{axis}.encoder.resolution": 0.0,
        }
    env = PlanarMotorEnv(set=free, action="force", scaled=False, ticks=10)
    first, _ = env.reset(seed=1)
    last = [env.step(np.array([0.5, -0.25], np.float32))[0] for _ in range(6)][-1]
    time = 60 * CONTROL_PERIOD
    for axis, force in enumerate((20.0, -10.0)):  # of 40 N
        assert seen(last, "force_realised", axis) == pytest.approx(force)
        moved = seen(last, "position_measured", axis) - seen(first, "position_measured", axis)
        assert moved == pytest.approx(0.5 * force / mass * time**2, rel=1e-3)


def test_a_residual_meets_the_force_limit():
    env = PlanarMotorEnv(action_scale=100.0, scaled=False, set={"plant.force": "ideal"})
    env.reset(seed=1)
    last, *_ = env.step(np.array([1.0, -1.0], np.float32))
    assert [seen(last, "force_realised", axis) for axis in (0, 1)] == [40.0, -40.0]


def test_gymnasiums_checker_finds_nothing():
    env = gymnasium.make("motionlab.gym:motionlab/PlanarMotor-v0", action="force", ticks=4)
    check_env(env.unwrapped)  # warnings are errors in this suite


def test_many_are_as_many_single_ones_in_gymnasiums_own_vector():
    options = {
        "set": {"load.noise": 0.5, "plant.x.encoder.noise": 1e-8, "divergence_error": 2e-4},
        "cases": [{}, {"plant.x.mass": 5.0}, {"trajectory": "rhombus"}],
        "action": "force",
        **SHORT,
    }
    made = gymnasium.make_vec(motionlab.gym.ID, num_envs=6, **options)
    assert made.metadata["autoreset_mode"] is AutoresetMode.SAME_STEP
    single = SyncVectorEnv(
        [lambda: PlanarMotorEnv(**options)] * 6, autoreset_mode=AutoresetMode.SAME_STEP
    )
    assert made.single_observation_space == single.single_observation_space
    assert made.observation_space == single.observation_space
    assert made.action_space == single.action_space
    random = np.random.default_rng(3)
    assert data_equivalence(made.reset(seed=11), single.reset(seed=11), exact=True)
    ends = np.zeros(2, dtype=int)
    for k in range(60):
        actions = random.uniform(-1.2, 1.2, (6, 2)).astype(np.float32)
        actions[0] = 1.0  # diverges
        got, expected = made.step(actions), single.step(actions)
        assert data_equivalence(got, expected, exact=True), k
        assert got[0] in made.observation_space
        ends += got[2].sum(), got[3].sum()
        for number, final in enumerate(got[4].get("final_obs", [])):
            assert (final is not None) == got[4]["_final_obs"][number]
            assert final is None or final in made.single_observation_space
    assert min(ends) > 0, ends
    seeds: Any = [5, 6, 7, None, 9, 1]
    assert data_equivalence(made.reset(seed=seeds), single.reset(seed=seeds), exact=True)


def test_same_seed_same_bits_however_many_there_are():
    actions = np.random.default_rng(1).uniform(-1, 1, (40, 9, 2)).astype(np.float32)
    found = []
    for count in (9, 2):
        envs = PlanarMotorVectorEnv(count, set={"load.noise": 0.5}, **SHORT)
        steps = [envs.reset(seed=4)[0]]
        steps += [np.column_stack(envs.step(a[:count])[:2]) for a in actions]
        found.append([step[:2] for step in steps])
    for one, other in zip(*found, strict=True):
        np.testing.assert_array_equal(one, other)


def test_the_reward_is_the_documented_one():
    weights = {"error_scale": 2e-5, "effort": 0.5, "divergence": 100.0}
    env = PlanarMotorEnv(
        reward=weights, scaled=False, action="force", set={"divergence_error": 1e-3}
    )
    env.reset(seed=2)
    action, terminated = np.array([0.6, -1.0], np.float32), False
    while not terminated:
        last, reward, terminated, _, _ = env.step(action)
        errors = np.array([seen(last, "following_error", axis) for axis in (0, 1)], np.float64)
        squares = np.minimum(np.abs(errors), 1e-3) ** 2 / 2e-5**2
        cost = squares.sum() + 0.5 * (0.36 + 1.0) + 100.0 * terminated
        assert reward == pytest.approx(-cost, rel=1e-6)


def test_held_over_several_ticks_errors_count_by_their_mean():
    one, six = (PlanarMotorEnv(ticks=n, reward={"effort": 0.0}) for n in (1, 6))
    one.reset(seed=1)
    six.reset(seed=1)
    action = np.array([0.3, 0.3], np.float32)
    for _ in range(5):
        rewards = [one.step(action)[1] for _ in range(6)]
        assert six.step(action)[1] == pytest.approx(np.mean(rewards), rel=1e-5)


def test_an_action_that_is_no_number_ends_the_episode_with_a_finite_observation():
    env = PlanarMotorEnv()
    env.reset(seed=1)
    last, reward, terminated, truncated, _ = env.step(np.array([np.nan, 0.0], np.float32))
    assert (terminated, truncated) == (True, False)
    assert last in env.observation_space
    assert np.isfinite(reward)


def test_scaled_observations_are_si_ones_divided():
    scaled, si = PlanarMotorEnv(), PlanarMotorEnv(scaled=False)
    scaled.reset(seed=1)
    si.reset(seed=1)
    action = np.ones(2, np.float32)
    one, other = ([env.step(action)[0] for _ in range(20)] for env in (scaled, si))
    np.testing.assert_allclose(one, other / np.tile(SCALES, 2), rtol=1e-6)
    one, other = scaled.observation_space, si.observation_space
    assert isinstance(one, Box)
    assert isinstance(other, Box)
    np.testing.assert_allclose(one.high, other.high / np.tile(SCALES, 2), rtol=1e-6)


def test_episodes_end_with_the_trajectory():
    changes = {"trajectory": {"kind": "point", "duration": PAGE * CONTROL_PERIOD}}
    env = PlanarMotorEnv(set=changes, ticks=100)
    env.reset(seed=1)
    ends = [env.step(np.zeros(2, np.float32))[2:4] for _ in range(PAGE // 100)]
    assert ends == [(False, False)] * (PAGE // 100 - 1) + [(False, True)]


def test_plausible_motors_of_the_monte_carlo_study_are_cases():
    vary = [Variation(path="friction.F_s", kind="log-normal", sigma=0.2)]
    plant = load_scenario("circle").model_dump(mode="json")["plant"]
    cases = draw(plant, vary, cases=4, seed=1)
    envs = PlanarMotorVectorEnv(8, cases=cases)
    _, info = envs.reset(seed=3)
    assert len(set(info["case"].tolist())) > 1
    _, info = envs.reset(options={"case": 2, "seed": 5})
    assert set(info["case"].tolist()) == {2}
    assert set(info["seed"].tolist()) == {5}
    drawn = PlanarMotorEnv(cases=lambda random: cases[int(random.integers(4))])
    assert set(drawn.reset(seed=1)[1]) == {"seed"}


def test_arrays_are_kept_unless_asked_not_to():
    actions = np.ones((2, 2), np.float32)
    for copy in (True, False):
        envs = PlanarMotorVectorEnv(2, copy=copy)
        first, _ = envs.reset(seed=1)
        before = first.copy()
        last, *_ = envs.step(actions)
        assert np.array_equal(first, before) == copy
        assert np.shares_memory(first, last) != copy


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"action": "gains"}, r"action: .*got 'gains'; allowed one of residual, force"),
        ({"variant": "C"}, "variant: .*got 'C'; allowed one of A, B"),
        ({"scenario": "fig5"}, "scenario: schedule: an episode's motor keeps its parameters"),
        ({"cases": [{}, {"plant.x.mass": -1.0}]}, r"cases\.1: plant\.x\.mass: .*kg"),
        ({"cases": []}, "cases: needs at least one"),
        ({"cases": [{"plant.force_map": "new-design"}]}, "all or none of them read tables"),
        ({"ticks": 0}, "ticks: .*got 0; allowed 1 to 1024"),
        ({"ticks": 1.5}, "ticks: is no whole number; got 1.5"),
        ({"ticks": float("nan")}, "ticks: is no whole number"),
        ({"duration": -1.0}, "duration: is no length of an episode; got -1"),
        ({"duration": float("nan")}, "duration: is no length of an episode"),
        ({"duration": 0.0001}, "duration: .*allowed >= 0.0005 s"),
        ({"reward": {"errors": 1.0}}, "reward: .*got 'errors'; allowed one of error_scale"),
        ({"action_scale": 0.0}, "action_scale: .*allowed > 0 N"),
    ],
)
def test_errors_name_what_is_wrong(options, words):
    with pytest.raises(ConfigError, match=words):
        PlanarMotorEnv(**options)


def test_wrong_calls_are_refused():
    envs = PlanarMotorVectorEnv(3)
    with pytest.raises(gymnasium.error.ResetNeeded):
        envs.step(np.zeros((3, 2), np.float32))
    envs.reset(seed=1)
    with pytest.raises(ConfigError, match=r"action: .*got \[2, 2\]; allowed \[3, 2\]"):
        envs.step(np.zeros((2, 2), np.float32))
    with pytest.raises(ConfigError, match=r"seed: .*got 2; allowed 3"):
        envs.reset(seed=[1, 2])
    with pytest.raises(ConfigError, match=r"options\.case: is no whole number; got 0\.5"):
        envs.reset(options={"case": 0.5})
    with pytest.raises(ConfigError, match="num_envs: is no whole number"):
        PlanarMotorVectorEnv(1.5)  # pyright: ignore[reportArgumentType]


def test_without_gymnasium_an_import_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    monkeypatch.delitem(sys.modules, "motionlab.gym")
    with pytest.raises(ImportError, match=r"needs the extra gym: "):
        importlib.import_module("motionlab.gym")
