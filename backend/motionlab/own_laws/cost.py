"""What a law costs in a control period, measured as the kernel calls it."""

from __future__ import annotations

import functools
import threading
import time

import numpy as np
from pydantic import BaseModel, Field

from motionlab.config.load import load_scenario
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS
from motionlab.kernel.tick import run_ticks
from motionlab.lanes import WIDTH
from motionlab.laws import SOURCES
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import prepare
from motionlab.simulation.timeline import Timeline
from motionlab.timing import CONTROL_PERIOD

_TICKS = 1024
_ROUNDS = 15
_DIGITS = 1  # of nanoseconds
_KEPT = 256  # versions of laws


class LawCost(BaseModel):
    """What a law costs, four controllers side by side, beyond no law at all."""

    ns: float = Field(description="Time of a control period, ns")
    share: float = Field(description="The same as a share of the control period")


def cost_of(law: str) -> LawCost:
    """Return what a law costs: measured once for each version, in some 50 ms.

    Parameters
    ----------
    law : str
        Its name.
    """
    with _LOCK:
        return _measured(law, SOURCES.get(law, ""))


@functools.lru_cache(_KEPT)
def _measured(law: str, _source: str) -> LawCost:
    lanes = {name: _parameters(name) for name in ("off", law)}
    inputs, start = _motion()
    samples = np.empty((_TICKS, SAMPLE_ROWS, WIDTH), dtype=np.float32)
    least = dict.fromkeys(lanes, float("inf"))
    for _ in range(1 + _ROUNDS):  # in the first, code may have to be loaded
        for name, parameters in lanes.items():
            state = start.copy()
            begun = time.perf_counter()
            run_ticks(parameters, state, inputs, samples)
            least[name] = min(least[name], time.perf_counter() - begun)
    # The scatter of two times may leave a cheap law below nothing.
    seconds = max(0.0, (least[law] - least["off"]) / _TICKS)
    return LawCost(ns=round(1e9 * seconds, _DIGITS), share=seconds / CONTROL_PERIOD)


def _parameters(law: str) -> np.ndarray:
    """Return the parameters of eight lanes of the circle, all with a law."""
    changes = {f"variants.{name}.controller.compensation.law": law for name in "AB"}
    return lane_parameters(load_scenario("circle", changes))[0]


@functools.cache
def _motion() -> tuple[np.ndarray, np.ndarray]:
    """Return inputs of the circle from its start on, and the state there."""
    prepared = prepare(load_scenario("circle"), checked=True)
    timeline = Timeline(prepared.reference, prepared.load, endless=False)
    pages = [page_inputs(prepared.scenario, timeline, page) for page in range(-(-_TICKS // PAGE))]
    x, y = prepared.reference.position[0]
    inputs = np.concatenate(pages)[:_TICKS]
    return inputs, initial_state(1, (float(x), float(y)))[0]


_LOCK = threading.Lock()
"""Two that measure at once would slow each other down."""
