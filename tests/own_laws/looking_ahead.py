"""What is checked of a law that looks ahead, in a process that has it.

Its state holds what it is told of the motion to come, which recordings have as channels.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.drive.link.shared import Command
from motionlab.drive.motion import held_parameters, on_drives
from motionlab.gym.motors import Motors, Options
from motionlab.kernel.layout import INPUT_ROWS
from motionlab.kernel.motion import Ahead
from motionlab.simulation.batch import run_prepared
from motionlab.simulation.inputs import PAGE
from motionlab.simulation.prepare import Prepared, prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.simulation.simulation import Simulation, sample_page, variant_columns
from motionlab.telemetry.channels import CHANNELS
from tests.drive.link.lockstep import Lockstep
from tests.export.controller_unit import current_error

LAW = {"variants.B.controller.compensation.law": "preview"}
TEXT = '''\
"""Mass feedforward that looks two control periods ahead."""
from typing import NamedTuple
from motionlab.lanes import Lanes, compiled
from motionlab.laws.law import Estimate, Law, Parameter
SHARE = Parameter("advance", "Share that is added early", unit="1", default=1, ge=0, le=2)
class Parameters(NamedTuple):
    advance: Lanes  # 1
class State(NamedTuple):
    p_1: Lanes  # position a period ahead, m
    v_1: Lanes  # m/s
    a_1: Lanes  # m/s^2
    p_2: Lanes  # m
    v_2: Lanes  # m/s
    a_2: Lanes  # m/s^2
    phase: Lanes  # share of the lap
@compiled
def preview(par, state, seen):
    force = par.advance * seen.M * (0.5 * (seen.a_ref_1 + seen.a_ref_2) - seen.a_ref)
    force = force + 5.0 * (seen.p_ref_2 - seen.p_ref_1) * seen.phase
    force = force + 1e-3 * (seen.v_ref_2 - seen.v_ref_1)
    after = State(seen.p_ref_1, seen.v_ref_1, seen.a_ref_1, seen.p_ref_2, seen.v_ref_2,
                  seen.a_ref_2, seen.phase)
    return Estimate(force, z=0.0, K=0.0), after
LAW = Law(name="preview", description="Mass feedforward ahead of time", step=preview,
          Parameters=Parameters, State=State, parameters=(SHARE,))
'''
STATES = ("p_1", "v_1", "a_1", "p_2", "v_2", "a_2", "phase")
SHORT = {"trajectory.radius": 0.002, "trajectory.frequency": 1.0, "trajectory.lead_in": 0.5}
NOISE = {"plant.x.encoder.noise": 1e-8, "plant.y.encoder.noise": 1e-8}
Samples = NDArray[np.float32]


def _prepared(**changes: object) -> Prepared:
    return prepare(load_scenario("circle", LAW | {"trajectory.laps": 3} | changes))


def _expected(prepared: Prepared, axis: int) -> Samples:
    """Return what the law is told in each tick, shape (fields, ticks)."""
    reference = prepared.reference
    last = reference.ticks - 1
    motion = [each[:, axis] for each in (reference.position, reference.velocity)]
    motion.append(reference.acceleration[:, axis])
    rows = []
    for ahead in (1, 2):
        at = np.minimum(np.arange(reference.ticks) + ahead, last)
        rows += [each[at] for each in motion]
    lap = reference.period
    rows.append((np.arange(reference.ticks) - reference.ticks) % lap / lap)
    return np.array(rows, dtype=np.float32)


def a_run_has_what_comes() -> None:
    """Compare each tick's with the reference: over pages, laps, and at the end, where it stays."""
    prepared = _prepared()
    assert prepared.reference.ticks > 3 * PAGE
    record = run(prepared).variants["B"]
    assert [channel.name for channel in record.states] == [f"law_{name}" for name in STATES]
    assert [channel.unit for channel in record.states] == [
        *("m", "m/s", "m/s^2", "m", "m/s", "m/s^2", "1")
    ]
    for axis, name in enumerate("xy"):
        seen = np.array([record.channel(f"law_{state}", name) for state in STATES])
        np.testing.assert_array_equal(seen, _expected(prepared, axis))
    phase = record.channel("law_phase", "x")
    assert phase.min() == 0.0
    assert 0.999 < phase.max() < 1.0
    assert not run(prepared).variants["A"].states


def pieces_give_the_same_bits() -> None:
    """Cut a run at odd ticks, and begin in its middle."""
    prepared = _prepared(**NOISE)
    whole = run(prepared).variants["B"]
    simulation = Simulation(prepared)
    page = sample_page(2, states=True)
    parts = []
    while count := simulation.advance(page[:, : 1 + simulation.tick % 613]):
        parts.append(variant_columns(page, 1, count).copy())
    cut = np.concatenate(parts, axis=2)
    np.testing.assert_array_equal(cut[: len(CHANNELS)], whole.samples)
    later = Simulation(prepared)
    later.advance(page[:, :1000])
    rest = run(prepared, start=later.snapshot()).variants["B"]
    np.testing.assert_array_equal(rest.samples, whole.samples[:, :, 1000:])


def batches_give_the_same_metrics() -> None:
    """Score a case beside others, some of which do not look ahead."""
    cases = [_prepared(**NOISE), _prepared(**NOISE, **dict.fromkeys(LAW, "off"))]
    cases.append(_prepared(**NOISE, **{"variants.B.controller.compensation.advance": 0.5}))
    batch = run_prepared(cases)
    errors = []
    for number, case in enumerate(cases):
        result = document(case, run(case))["variants"]["B"]["axes"]
        for axis, name in enumerate("xy"):
            error = batch.metrics["rms_following_error"][number, 1, axis]
            assert error == result[name]["rms_following_error"]
        errors.append(batch.metrics["rms_following_error"][number, 1, 0])
    assert len(set(errors)) == 3


def a_live_session_has_what_is_known() -> None:
    """Go on after the end, where laps repeat, and stop, which is known from its first tick on."""
    prepared = _prepared()
    lap, ticks = prepared.reference.period, prepared.reference.ticks
    simulation = Simulation(prepared, endless=True)
    page = sample_page(2, states=True)
    parts: list[Samples] = []

    def go_on(to: int) -> None:
        while simulation.tick < to:
            count = simulation.advance(page[:, : to - simulation.tick])
            parts.append(variant_columns(page, 1, count)[len(CHANNELS) :, 0].copy())

    stop = ticks + lap + 100
    go_on(stop)
    simulation.stop()
    go_on(stop + 20)
    seen = np.concatenate(parts, axis=1)[: len(STATES)]
    expected = _expected(prepared, 0)
    inside = slice(ticks - lap, ticks - 2)
    for laps in (0, 1):
        first = ticks - lap + laps * lap
        np.testing.assert_array_equal(seen[:, first : first + lap - 2], expected[:, inside])
    # The last two ticks of a lap see the beginning of the next.
    np.testing.assert_array_equal(seen[0, ticks - 1], expected[0, ticks - lap - 1])
    # Two ticks before the stop nothing is known of it; from then on acceleration is the brake's.
    last = simulation.timeline.at(stop, stop + 20)[2][:, 0].astype(np.float32)
    np.testing.assert_array_equal(seen[2, stop - 2 : stop], expected[2, ticks - lap + 98 :][:2])
    np.testing.assert_array_equal(seen[2, stop : stop + 18], last[1:19])
    assert len(set(seen[6, stop:].tolist())) == 1


def an_environment_has_it_too() -> None:
    """Advance a motor of `motionlab.gym` without actions: the errors of a run."""
    options = Options(scenario="circle", set=LAW, scaled=False, ticks=1)
    motors = Motors(1, options)
    motors.begin(0, np.random.default_rng(0))
    errors = [motors.observation[0, 0]]
    for _ in range(1500):
        motors.advance(np.zeros((1, 2), dtype=np.float32))
        errors.append(motors.observation[0, 0])
    prepared = prepare(load_scenario("circle", LAW))
    error = run(prepared).variants["B"].channel("following_error", "x")
    np.testing.assert_allclose(errors, error[:1501], rtol=0, atol=1e-9)


def interpreted() -> None:
    """Compare a few ticks of what plain Python gives with the reference."""
    prepared = _prepared()
    record = run(prepared, stop=40).variants["B"]
    expected = _expected(prepared, 0)[:, :40]
    seen = np.array([record.channel(f"law_{state}", "x") for state in STATES])
    np.testing.assert_array_equal(seen, expected)


def a_unit_takes_it() -> None:
    """Step the exported FMU beside a simulation."""
    references = ("position_reference", "velocity_reference", "acceleration_reference")
    inputs = [*references, *(f"{name}_{k}" for k in (1, 2) for name in references)]
    inputs += ["phase", "position_measured"]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "controller.fmu"
        assert current_error(path, LAW, 0.2, tuple(inputs)) < 1e-9


def drives_have_it() -> None:
    """Carry a motion out on drives in lockstep: what comes, and their law's state, by tick."""
    prepared = prepare(on_drives(load_scenario("circle", LAW | SHORT), "B"))
    reference = prepared.reference
    drives = Lockstep(start=(float(reference.position[0, 0]), float(reference.position[0, 1])))
    drives.put(held_parameters(prepared.scenario))
    drives.arm()
    at_rest = drives.memory.inputs[0, INPUT_ROWS:, 0]
    assert at_rest[[0, 3]].tolist() == [drives.memory.reference[0, 0]] * 2
    assert not at_rest[[1, 2, 4, 5, 6]].any()
    motion = (reference.position, reference.velocity, reference.acceleration)
    drives.shared.command[Command.MOTION_TICKS] = reference.ticks
    drives.shared.command[Command.LAP_TICKS] = reference.period
    drives.follow(np.stack(motion, axis=1))
    drives.cycle(reference.ticks)
    for axis in (0, 1):
        seen = drives.shared.samples[: reference.ticks, len(CHANNELS) :, axis].T
        np.testing.assert_array_equal(seen[: len(STATES)], _expected(prepared, axis))
    # Held after it, still; and a stop brakes from its first tick on.
    drives.cycle(3)
    assert not drives.memory.inputs[0, INPUT_ROWS:, :][[1, 2, 4, 5]].any()
    drives.line()
    drives.cycle(600)
    before = drives.memory.reference[1, 0]
    drives.shared.command[Command.STOPS] += 1
    drives.cycle(2)
    ahead = drives.memory.inputs[0, INPUT_ROWS:, 0]
    assert ahead[4] < ahead[1] < drives.memory.reference[1, 0] <= before


assert Ahead._fields == ("p_ref_1", "v_ref_1", "a_ref_1", "p_ref_2", "v_ref_2", "a_ref_2", "phase")
