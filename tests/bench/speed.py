"""Speed of the kernel against the scalar C reference, in turns, on the shipped circle."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator

import numpy as np

from motionlab.config.load import load_scenario
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.layout import SAMPLE_ROWS, state_row
from motionlab.kernel.tick import run_ticks
from motionlab.lanes import WIDTH
from motionlab.simulation.inputs import PAGE, page_inputs
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.run import run
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import Sample
from motionlab.timing import CONTROL_PERIOD
from tests.bench.machine import vector_unit
from tests.bench.scalar_c import Array, ScalarC
from tests.bench.table import Row

_REPETITIONS = 15
_LANES = 4  # of A and B on x and y; the kernel's other lanes are spare
_TARGETS = {"AVX-512": (2.0, 500.0), "AVX2": (1.4, 350.0)}
_EXACT_TOLERANCE = 1e-12  # m, exact encoder: nothing but rounding
_COUNT_TOLERANCE = 50e-9  # m, one count: rounding moves a transition by a tick now and then


def speed(arch: str) -> Iterator[Row]:
    """Measure the user's run and the bare kernel; check that C computes the same."""
    prepared = prepare(load_scenario("circle"))
    ticks = prepared.reference.ticks
    parameters, start, inputs = arrays(prepared)
    page = np.empty((PAGE, SAMPLE_ROWS, WIDTH), dtype=np.float32)

    def bare() -> Array:
        state = start.copy()
        for first in range(0, ticks, PAGE):
            some = inputs[first : first + PAGE]
            run_ticks(parameters, state, some, page[: len(some)])
        return state

    contenders: dict[str, Callable[[], object]] = {"run": lambda: run(prepared), "bare": bare}
    try:
        c = ScalarC(arch)
    except FileNotFoundError:
        c = None
    else:
        lanes = np.ascontiguousarray(parameters.T[:_LANES])
        states = np.ascontiguousarray(start.T[:_LANES])
        contenders["C"] = lambda: c.run(lanes, states.copy(), inputs)
    times = in_turns(contenders)

    ratio_target, real_time_target = _TARGETS.get(vector_unit(), _TARGETS["AVX2"])
    laps = {"run": "run(), A and B, x and y, all channels kept", "bare": "bare kernel, same lanes"}
    for name, what in laps.items():
        ratio = times["C"] / times[name] if c else None
        yield Row(
            what,
            f">= {ratio_target:g} x C",
            f"{times[name] / ticks * 1e9:.0f} ns/tick",
            f"C: {times['C'] / ticks * 1e9:.0f} ns/tick" if c else "no gcc here",
            f"{ratio:.2f}" if ratio else "",
            ratio >= ratio_target if ratio else None,
        )
    for name, what in laps.items():
        factors = {key: ticks * CONTROL_PERIOD / value for key, value in times.items()}
        yield Row(
            what,
            f">= {real_time_target:g} x real",
            f"{factors[name]:.0f} x real",
            f"C: {factors['C']:.0f} x real" if c else "no gcc here",
            "",
            factors[name] >= real_time_target,
        )
    if c:
        yield _agreement("C agrees, 50 nm encoder", c, prepared, _COUNT_TOLERANCE)
        exact = {"plant.x.encoder.resolution": 0.0, "plant.y.encoder.resolution": 0.0}
        sharp = prepare(load_scenario("circle", exact))
        yield _agreement("C agrees, exact encoder", c, sharp, _EXACT_TOLERANCE)
        rings: dict[str, float] = {}
        for axis in "xy":
            rings[f"plant.{axis}.resonance.coupling"] = -0.1
            rings |= {f"variants.{name}.controller.{axis}.notch.gain": 0.1 for name in "AB"}
        ringing = prepare(load_scenario("circle", exact | rings))
        yield _agreement("C agrees, resonance and notch", c, ringing, _EXACT_TOLERANCE)


def simulation_time() -> float:
    """Return the median time of `run` on the shipped circle, s."""
    prepared = prepare(load_scenario("circle"))
    return in_turns({"run": lambda: run(prepared)})["run"]


def arrays(prepared: Prepared) -> tuple[Array, Array, Array]:
    """Return parameters and initial state of the one block of lanes, and all inputs."""
    (parameters,) = lane_parameters(prepared.scenario)
    place = prepared.reference.position[0]
    (state,) = initial_state(1, (float(place[0]), float(place[1])))
    timeline = Timeline(prepared.reference, prepared.load)
    pages = range(-(-prepared.reference.ticks // PAGE))
    inputs = np.concatenate([page_inputs(prepared.scenario, timeline, page) for page in pages])
    return parameters, state, inputs


def in_turns(contenders: dict[str, Callable[[], object]]) -> dict[str, float]:
    """Return the median time of each contender, all measured in turns after one warm round."""
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(_REPETITIONS + 1):
        for name, call in contenders.items():
            before = time.perf_counter()
            call()
            times[name].append(time.perf_counter() - before)
    return {name: statistics.median(taken[1:]) for name, taken in times.items()}


def _agreement(what: str, c: ScalarC, prepared: Prepared, tolerance: float) -> Row:
    """Compare final positions and largest following errors of C with those of the kernel."""
    parameters, state, inputs = arrays(prepared)
    lanes = np.ascontiguousarray(parameters.T[:_LANES])
    states = np.ascontiguousarray(state.T[:_LANES])
    largest = c.run(lanes, states, inputs)
    samples = np.empty((len(inputs), SAMPLE_ROWS, WIDTH), dtype=np.float32)
    run_ticks(parameters, state, inputs, samples)

    moved = np.abs(states.T - state[:, :_LANES])[state_row("plant.p")].max()
    errors = np.abs(samples[:, Sample._fields.index("following_error"), :_LANES])
    single = np.finfo(np.float32).eps  # the kernel's errors are recorded in single precision
    differ = np.abs(largest - errors.max(axis=0)) - single * largest
    worst = max(float(moved), float(differ.max()))
    return Row(
        what,
        f"<= {tolerance * 1e9:g} nm",
        f"{max(worst, 0.0) * 1e9:.1g} nm",
        "final p and max |e|",
        "",
        worst <= tolerance,
    )
