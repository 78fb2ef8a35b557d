"""Speed of the environments, beside the kernel's own over as many motors and ticks."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np

import motionlab.gym
from motionlab.config.load import load_scenario
from motionlab.gym.step import MOTORS
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.kernel.tick import run_ticks
from motionlab.lanes import WIDTH
from motionlab.simulation.inputs import PAGE
from motionlab.simulation.prepare import prepare
from tests.bench.speed import arrays
from tests.bench.table import Row

_ENVS = 64
_TARGET = 2e6  # steps/s
_TURNS = 30
_HELD = 10
_NOISE = {
    f"plant.{axis}.{path}": rms
    for axis in "xy"
    for path, rms in (("encoder.noise", 1e-8), ("amplifiers.noise", 0.01))
} | {"load.noise": 0.1}
_NEW_DESIGN = {"plant.force_map": "new-design"}


def gym() -> Iterator[Row]:
    """Measure steps of 64 environments: processor time, the best of turns of one page each."""
    kinds: dict[str, dict[str, Any]] = {
        f"{_ENVS} environments, one thread": {},
        "  arrays not copied": {"copy": False},
        "  every source of noise": {"set": _NOISE},
        "  force maps by finite elements": {"set": _NEW_DESIGN},
    }
    contenders = {name: _steps(PAGE, **options) for name, options in kinds.items()}
    contenders["held"] = _steps(PAGE // _HELD, ticks=_HELD)
    contenders["kernel"] = _kernel()
    contenders["single"] = _single()
    times = _best(contenders)

    alone = _ENVS * PAGE / times["kernel"]
    for name in kinds:
        rate = _ENVS * PAGE / times[name]
        target = f">= {_TARGET / 1e6:g} M steps/s" if name[0] != " " else ""
        yield Row(
            name,
            target,
            f"{rate / 1e6:.2f} M steps/s",
            f"kernel: {alone / 1e6:.2f} M",
            f"{rate / alone:.2f}",
            rate >= _TARGET if target else None,
        )
    ticks = _ENVS * (PAGE // _HELD) * _HELD / times["held"]
    yield Row(
        f"  {_HELD} ticks a step",
        "",
        f"{ticks / 1e6:.2f} M ticks/s",
        f"kernel: {alone / 1e6:.2f} M",
        f"{ticks / alone:.2f}",
    )
    yield Row("one environment by gymnasium.make", "", f"{PAGE / times['single']:.0f} steps/s")


def _steps(count: int, **options: Any) -> Callable[[], None]:
    envs = gymnasium.make_vec(motionlab.gym.ID, num_envs=_ENVS, **options)
    envs.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-1, 1, (_ENVS, 2)).astype(np.float32)

    def steps() -> None:
        for _ in range(count):
            envs.step(actions)

    return steps


def _single() -> Callable[[], None]:
    env = gymnasium.make(motionlab.gym.ID)
    env.reset(seed=1)
    action = np.zeros(2, dtype=np.float32)

    def steps() -> None:
        for _ in range(PAGE):
            if any(env.step(action)[2:4]):
                env.reset()

    return steps


def _kernel() -> Callable[[], None]:
    parameters, state, inputs = arrays(prepare(load_scenario("circle")))
    page = np.empty((PAGE, SAMPLE_ROWS, WIDTH), dtype=np.float32)

    def run() -> None:
        for _ in range(_ENVS // MOTORS):
            run_ticks(parameters, state.copy(), inputs[:PAGE], page)

    return run


def _best(contenders: dict[str, Callable[[], None]]) -> dict[str, float]:
    times = dict.fromkeys(contenders, np.inf)
    for _ in range(_TURNS):
        for name, call in contenders.items():
            before = time.thread_time()
            call()
            times[name] = min(times[name], time.thread_time() - before)
    return times
