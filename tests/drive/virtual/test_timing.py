"""The motor behind the drives is that of the simulation, period by period."""

from __future__ import annotations

import numpy as np
import pytest

from motionlab.config.load import load_scenario
from motionlab.drive.virtual.layout import CLOCK, MAX_CURRENT, MAX_TORQUE, STEPS, SYNC_NEXT
from motionlab.drive.virtual.machine import run_machine
from motionlab.drive.virtual.segment import Segment
from motionlab.kernel.build import initial_state, lane_parameters
from motionlab.kernel.law_calls import laws_of
from motionlab.kernel.layout import SAMPLE_ROWS, parameter_row, state_row
from motionlab.kernel.tick import control_once, run_ticks
from motionlab.lanes import WIDTH
from motionlab.simulation.inputs import page_inputs
from motionlab.simulation.prepare import prepare
from motionlab.simulation.timeline import Timeline
from motionlab.telemetry.channels import Sample
from motionlab.timing import SUBSTEPS
from tests.drive.virtual.bus import PERIOD, Bus

COUNT = 50e-9


def next_sync0(segment: Segment) -> int:
    """Return the next SYNC0 of the first drive, ns of the segment's clock."""
    node = segment.arrays.nodes[0]
    return int(node[SYNC_NEXT] - node[CLOCK])


@pytest.mark.parametrize("motor", ["nominal", "matched-resonant"])
def test_its_steps_are_those_of_the_kernel(motor: str) -> None:
    changes = {"plant": motor, "variants.A.controller.delay": 1}
    parameters = lane_parameters(load_scenario("circle", changes))[0]
    state = initial_state(1, (0.01, -0.02))[0]
    segment = Segment(motor, start=(0.01, -0.02))
    random = np.random.default_rng(1)
    for _ in range(200):
        command = np.tile(random.uniform(0.0, 10.0, (3, 2)), WIDTH // 2)
        rows = [state_row(f"pending.current_{phase}") for phase in "abc"]
        state[rows] = command  # with a delay, what is pending acts in the next tick
        inputs = np.zeros((1, 8, 2))
        run_ticks(parameters, state, inputs, np.empty((1, SAMPLE_ROWS, WIDTH), np.float32))
        segment.arrays.command[:] = command
        run_machine(segment.arrays, SUBSTEPS)
        np.testing.assert_allclose(
            segment.arrays.plant[:, :2], state[:8, :2], rtol=1e-9, atol=1e-15
        )


@pytest.mark.parametrize(("rated", "largest"), [(10.0, 80e-9), (1.0, 40e-9)])
def test_in_lockstep_it_is_the_simulation_with_a_delay_of_one_period(
    rated: float, largest: float
) -> None:
    """They part by the steps of the current, 1/1000 of the rated one: 44 and 17 nm."""
    noise = {"plant.x.encoder.noise": 5e-8, "plant.y.amplifiers.noise": 0.02}
    delay = {f"variants.{variant}.controller.delay": 1 for variant in "AB"}
    scenario = load_scenario("circle", {**noise, **delay, "trajectory.lead_in": 0.1, "seed": 0})
    prepared = prepare(scenario)
    ticks = 800
    reference = prepared.reference
    parameters = lane_parameters(scenario)[0]
    variant = slice(2, 4)  # B, with compensation
    parameters = np.tile(parameters[:, variant], WIDTH // 2).copy()
    inputs = page_inputs(scenario, Timeline(reference, prepared.load), 0)[:ticks]
    start = tuple(reference.position[0].tolist())

    samples = np.empty((ticks, SAMPLE_ROWS, WIDTH), np.float32)
    state = initial_state(1, start)[0]
    run_ticks(parameters, state.copy(), inputs, samples)

    segment = Segment(changes=noise, start=start)
    segment.arrays.ratings[:] = 1e3 * rated
    bus = Bus(segment.exchange)
    bus.to_op(sync0=True)
    segment.arrays.objects[:, [MAX_TORQUE, MAX_CURRENT]] = 1e4 / rated
    bus.enable()
    delays = np.random.default_rng(2).integers(0, PERIOD, ticks)
    bus.now -= bus.now % PERIOD
    first = next_sync0(segment)
    segment.arrays.clock[STEPS] = -SUBSTEPS  # so that noise begins at `first`
    encoders, rows = [0, 3], [state_row(f"pending.current_{phase}") for phase in "abc"]
    positions, readings = np.empty((ticks, 2)), np.empty((ticks, 2))
    for k in range(ticks):
        # Anywhere in the period: a frame acts the same.
        bus.now = int(first + k * PERIOD + delays[k] * 0.9)
        readings[k] = COUNT * bus.read_inputs()["position"][encoders]
        positions[k] = segment.position
        p_meas = np.tile(readings[k], WIDTH // 2)[None]
        control_once(parameters, state, inputs[k : k + 1], p_meas, laws_of(parameters))
        state[state_row("age")] += 1.0
        currents = state[rows, :2].T.ravel()  # a, b, c of x, then of y
        bus.outputs["torque"] = np.rint(currents / (1e-3 * rated))
        bus.write_outputs()
    assert segment.status()["nodes"][0]["missed"] < 5

    simulated, measured = (
        samples[:, Sample._fields.index(channel), :2]
        for channel in ("position", "position_measured")
    )
    assert np.ptp(simulated) > 5e-3
    assert np.abs(positions - simulated).max() < largest
    assert np.abs(readings - measured).max() < 1.5 * COUNT
    thrust = segment.arrays.parameters[parameter_row("force_map.formula.F_pk"), 0]
    assert thrust == pytest.approx(34.1)


def test_frames_at_any_moment_have_the_same_effect() -> None:
    found = []
    for share in (0.02, 0.5, 0.97):
        segment = Segment()
        bus = Bus(segment.exchange)
        bus.to_op(sync0=True)
        bus.enable()
        first = next_sync0(segment)
        for k in range(100):
            bus.now = first + k * PERIOD + int(share * PERIOD)
            bus.outputs["torque"] = (0, 9 * k, 0, 0, 0, 7 * k)
            bus.exchange_all()
        segment.advance(first + 100 * PERIOD)
        found.append(segment.position)
    assert found[0] == found[1] == found[2]
    assert found[0][0] != 0.0


def test_outputs_act_from_the_next_sync0() -> None:
    segment = Segment()
    bus = Bus(segment.exchange)
    bus.to_op(sync0=True)
    bus.enable()
    first = next_sync0(segment)
    bus.now = first + 100_000
    bus.outputs["torque"] = 500
    bus.write_outputs()
    segment.advance(first + PERIOD - 1)
    assert not segment.arrays.command.any()
    segment.advance(first + PERIOD)
    assert (segment.arrays.command == 5.0).all()


def test_without_clocks_the_motor_moves_on_with_the_outputs() -> None:
    segment = Segment()
    bus = Bus(segment.exchange)
    bus.to_op()
    bus.enable()
    steps = segment.arrays.clock[STEPS]
    times = [500_000, 550_000, 450_000, 70_000, 30_000, 900_000]
    for time in times:
        bus.now += time
        bus.write_outputs()
    assert segment.arrays.clock[STEPS] - steps in {sum(times) // 100_000, sum(times) // 100_000 + 1}


def test_a_push_moves_it(bus: Bus, segment: Segment) -> None:
    segment.switch(push={"axis": "x", "force": 20.0, "time": 0.1})
    segment.advance(300_000_000)
    x, y = segment.position
    assert x > 1e-3
    assert y == 0.0


def test_noise_is_that_of_the_scenario() -> None:
    changes = {"plant.x.encoder.noise": 1e-7, "plant.y.amplifiers.noise": 0.01}
    segment = Segment(changes=changes, seed=3)
    scenario = load_scenario("circle", {**changes, "seed": 3})
    prepared = prepare(scenario)
    expected = page_inputs(scenario, Timeline(prepared.reference, prepared.load), 0)[:, 4:]
    np.testing.assert_array_equal(segment.arrays.inputs[: len(expected), 4:], expected)
    assert expected[:, 0, 0].std() == pytest.approx(1e-7, rel=0.1)
