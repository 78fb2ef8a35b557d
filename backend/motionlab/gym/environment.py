"""The planar motor as a gymnasium environment, single and vectorised; docs/gymnasium.md."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Box
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError
from motionlab.gym.motors import Motors, Options, whole
from motionlab.gym.step import ENDED

Observation = NDArray[np.float32]


class PlanarMotorEnv(gymnasium.Env[Any, Any]):
    """Follow a trajectory with a planar motor by forces on x and y.

    Parameters
    ----------
    render_mode : None
        There is none.
    **options
        Fields of `motionlab.gym.motors.Options`.
    """

    metadata = {"render_modes": []}  # noqa: RUF012 - as gymnasium declares it

    def __init__(self, *, render_mode: None = None, **options: Any) -> None:
        self.render_mode = render_mode
        self._motors = Motors(1, Options(**options))
        self.observation_space, self.action_space = _spaces(self._motors)

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode.

        Parameters
        ----------
        seed : int, optional
            Of everything that is drawn, from here on.
        options : dict, optional
            See `Motors.begin`.

        Returns
        -------
        observation : ndarray of float32, shape (16,)
            See docs/gymnasium.md.
        info : dict
            ``seed`` of the noise and ``case``.
        """
        super().reset(seed=seed)
        info = self._motors.begin(0, self.np_random, options)
        return self._motors.observation[0].copy(), info

    def step(self, action: Observation) -> tuple[Observation, float, bool, bool, dict[str, Any]]:
        """Advance by one step; `action` on x and y is clipped to [-1, 1]."""
        self._motors.advance(_forces(action, (2,))[None])
        terminated, truncated = self._motors.over[0].tolist()
        reward = float(self._motors.reward[0])
        return self._motors.observation[0].copy(), reward, terminated, truncated, {}


class PlanarMotorVectorEnv(VectorEnv[Any, Any, NDArray[Any]]):
    """Many `PlanarMotorEnv` in one compiled step.

    Environment i gives the same bits as a single one with the same seed. One that has ended begins
    anew in the same step: ``final_obs`` of the infos has its last observation.

    Parameters
    ----------
    num_envs : int
        How many.
    copy : bool
        Whether arrays returned stay as they are; else the next step overwrites them.
    render_mode : None
        There is none.
    **options
        Fields of `motionlab.gym.motors.Options`.
    """

    metadata = {  # noqa: RUF012 - as gymnasium declares it
        "render_modes": [],
        "autoreset_mode": AutoresetMode.SAME_STEP,
    }

    def __init__(
        self, num_envs: int = 1, *, copy: bool = True, render_mode: None = None, **options: Any
    ) -> None:
        if whole("num_envs", num_envs, ">= 1") < 1:
            raise ConfigError(FieldError("num_envs", "needs at least one", num_envs, ">= 1"))
        self.num_envs, self.render_mode, self._copy = int(num_envs), render_mode, copy
        self._motors = Motors(self.num_envs, Options(**options))
        self._randoms: list[np.random.Generator] = []
        self.single_observation_space, self.single_action_space = _spaces(self._motors)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)

    def reset(
        self,
        *,
        seed: int | Sequence[int | None] | None = None,
        options: dict[str, Any] | None = None,
    ) -> tuple[Observation, dict[str, Any]]:
        """Begin an episode of each environment.

        Parameters
        ----------
        seed : int or sequence, optional
            Of each environment; of a single one, ``seed``, ``seed + 1``, ...
        options : dict, optional
            See `Motors.begin`; the same for all.
        """
        seeds = [seed] * self.num_envs if seed is None else seed
        if isinstance(seeds, int | np.integer):
            seeds = range(int(seeds), int(seeds) + self.num_envs)
        if len(seeds) != self.num_envs:
            raise ConfigError(
                FieldError("seed", "has another length", len(seeds), f"{self.num_envs}")
            )
        before = self._randoms or [None] * self.num_envs
        self._randoms = [
            random if random is not None and own is None else seeding.np_random(own)[0]
            for random, own in zip(before, seeds, strict=True)
        ]
        infos: dict[str, Any] = {}
        for number, random in enumerate(self._randoms):
            infos = self._add_info(infos, self._motors.begin(number, random, options), number)
        return self._returned(self._motors.observation), infos

    def step(
        self, actions: Observation
    ) -> tuple[Observation, NDArray[Any], NDArray[Any], NDArray[Any], dict[str, Any]]:
        """Advance every environment by one step; `actions`, (num_envs, 2), are clipped."""
        if not self._randoms:
            raise gymnasium.error.ResetNeeded("call reset before step")
        motors, infos = self._motors, {}
        events = motors.advance(_forces(actions, (self.num_envs, 2)))
        over = self._returned(motors.over)
        if events & ENDED:
            for number in np.flatnonzero(over.any(axis=1)).tolist():
                final = {"final_obs": motors.observation[number].copy(), "final_info": {}}
                begun = motors.begin(number, self._randoms[number])
                infos = self._add_info(infos, final | begun, number)
        return (
            self._returned(motors.observation),
            self._returned(motors.reward),
            over[:, 0],
            over[:, 1],
            infos,
        )

    def _returned(self, array: NDArray[Any]) -> NDArray[Any]:
        return array.copy() if self._copy else array


def _spaces(motors: Motors) -> tuple[Box, Box]:
    """Return the spaces of the observations and of the actions of one motor."""
    largest = motors.largest
    return Box(-largest, largest, dtype=np.float32), Box(-1.0, 1.0, (2,), dtype=np.float32)


def _forces(action: Any, shape: tuple[int, ...]) -> NDArray[np.float32]:
    """Return actions as the compiled step takes them."""
    forces = np.ascontiguousarray(action, dtype=np.float32)
    if forces.shape != shape:
        raise ConfigError(
            FieldError("action", "has another shape", list(forces.shape), f"{list(shape)}")
        )
    return forces
