"""Learn a force beside the compensating controller B, by the cross-entropy method.

The policy is linear in what B itself sees: on each axis ``action = w . observation``. Each of 64
environments tries other weights on the first lap of the circle, under the friction fitted to the
paper's measurement, which B's model does not know. Then the mean of the best drives the whole
circle. Run with ``.venv/bin/python examples/learn_residual.py``; needs ``motionlab[gym]``.
"""

from __future__ import annotations

import gymnasium
import numpy as np

import motionlab.gym
from motionlab.config.load import load_scenario
from motionlab.gym.motors import SCALES
from motionlab.simulation.prepare import prepare

SCENARIO, LAP = "circle-matched", 3.0  # s
POLICIES, ELITE, GENERATIONS = 64, 8, 25


def returns(weights: np.ndarray) -> np.ndarray:
    """Return the reward summed over one lap of each policy, (policies, axes, 8), until it fails."""
    envs = gymnasium.make_vec(
        motionlab.gym.ID, num_envs=len(weights), scenario=SCENARIO, duration=LAP, copy=False
    )
    observation, _ = envs.reset(seed=1)
    total, running = np.zeros(len(weights)), np.ones(len(weights), dtype=bool)
    while running.any():
        seen = observation.reshape(weights.shape)
        observation, reward, terminated, truncated, _ = envs.step((weights * seen).sum(axis=2))
        total += np.where(running, reward - 1e6 * terminated, 0.0)
        running &= ~(terminated | truncated)
    return total


def rms_errors(weights: np.ndarray) -> np.ndarray:
    """Return the RMS following error on x and y over the scenario's window, um."""
    env = gymnasium.make(motionlab.gym.ID, scenario=SCENARIO)
    start, end = prepare(load_scenario(SCENARIO)).window
    observation, _ = env.reset(seed=1)
    errors = []
    for _ in range(end - 1):
        errors.append(observation.reshape(2, -1)[:, 0] * SCALES.following_error * 1e6)
        action = (weights * observation.reshape(2, -1)).sum(axis=1)
        observation, _, _, _, _ = env.step(action.clip(-1.0, 1.0))
    return np.sqrt(np.mean(np.square(errors[start:]), axis=0))


random = np.random.default_rng(2019)
mean, spread = np.zeros((2, 8)), np.full((2, 8), 0.1)
for generation in range(GENERATIONS):
    tried = mean + spread * random.standard_normal((POLICIES, 2, 8))
    tried[0] = mean
    scores = returns(tried)
    best = tried[np.argsort(scores)[-ELITE:]]
    mean, spread = best.mean(axis=0), best.std(axis=0) + 0.1 * 0.8**generation
    if generation % 6 == 0:
        print(f"generation {generation:2}: mean policy {scores[0]:.0f}, best {scores.max():.0f}")
for name, weights in (("B alone", np.zeros((2, 8))), ("with the residual", mean)):
    x, y = rms_errors(weights)
    print(f"{name}: RMS error {x:.2f} um on x, {y:.2f} um on y")
