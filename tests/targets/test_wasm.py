"""The WebAssembly module under node, against the kernel that this machine compiles."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from motionlab.analysis.contouring import nearest
from motionlab.config.load import load_scenario
from motionlab.kernel.accumulator import tally_metrics
from motionlab.kernel.layout import PARAMETERS, SAMPLE_ROWS, STATES, Inputs, parameter_row
from motionlab.lanes.sources import PACKAGE, SOURCES
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.targets.wasm_compile import description
from motionlab.targets.wasm_module import module_of
from motionlab.telemetry.channels import CHANNELS
from tests.learnt_forces import known
from tests.paths import ROOT
from tests.targets import module_run
from tests.targets.module_run import Memory, module
from tests.targets.scenario_runs import differences, run_in_module

NODE = subprocess.run(
    [ROOT / "frontend" / "npm", "--version"], capture_output=True, text=True, check=False
)
pytestmark = pytest.mark.skipif(NODE.returncode != 0, reason="node cannot be had")

COUNT = 50e-9
"""One count of the encoder, m."""
SINGLE = 1e-6
"""Of the largest magnitude of a channel: rounding of recorded samples, amplified by differences."""
EXACT = {f"plant.{axis}.encoder.resolution": 0.0 for axis in "xy"}
NARROW = {"divergence_error": 1.5e-5}
"""A limit of the following error that A passes, and B does not."""
SHARING = {
    "plant.force_map": "new-design",
    "variants.A.controller.sharing.law": "sine",
    "variants.B.controller.sharing.law": "force-per-ampere",
}
SCHEDULE = {"schedule": [{"time": 1.2345, "set": {"variants.B.controller.x.k_p": 2e5}}]}
_A = "variants.A.controller"
_PLANT = "plant.x"
DRAWN = st.fixed_dictionaries(
    {
        f"{_A}.compensation.law": st.sampled_from(
            ["off", "lugre-observer", "residual-k", "canudas-de-wit", "reversed-k"]
        ),
        f"{_A}.compensation.velocity": st.sampled_from(["reference", "measured"]),
        f"{_A}.sharing.law": st.sampled_from(["least-norm", "least-normal-force", "sine", "cubic"]),
        f"{_A}.disturbance_observer.enabled": st.booleans(),
        f"{_A}.feedforward": st.booleans(),
        f"{_A}.delay": st.integers(0, 1),
        f"{_A}.x.k_p": st.floats(1e5, 3e5),
        f"{_A}.x.k_d": st.floats(800.0, 2000.0),
        f"{_PLANT}.mass": st.floats(5.0, 7.0),
        f"{_PLANT}.friction.F_c": st.floats(0.1, 3.0),
        f"{_PLANT}.friction.sigma_1": st.floats(600.0, 1500.0),
        "load.x": st.floats(-2.0, 2.0),
    }
)

LEARNT = {
    "learnt": known(np.random.default_rng(7).normal(0.0, 0.1, (6000, 2))).model_dump(),
    "variants.B.controller.learnt": True,
    "variants.B.controller.model.x.subdivision.sine": 4e-8,
}


def ran(name: str, changes: dict[str, Any]) -> tuple[Any, Any]:
    """Return a prepared scenario and its run in the module."""
    prepared = prepare(load_scenario(name, changes))
    return prepared, run_in_module(prepared)


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("circle", {}),
        ("circle-reversed-k", {}),
        ("circle-resonant", {}),
        ("pentagram", {}),
        ("circle", {"plant.force_map": "new-design"}),
        ("circle", SHARING),
        ("circle", SCHEDULE),
        ("circle", NARROW),
        ("circle", {"variants.B.controller.disturbance_observer.enabled": True}),
        ("circle", LEARNT),
    ],
)
def test_with_an_exact_encoder_nothing_but_rounding_differs(
    name: str, changes: dict[str, Any]
) -> None:
    prepared, run = ran(name, EXACT | changes)
    for variant in differences(prepared, run.recording).values():
        for channel, gap in variant.channels.items():
            assert gap <= SINGLE * variant.scales[channel], channel
        assert max(variant.metrics.values(), default=0.0) <= SINGLE


@settings(max_examples=8)
@given(changes=DRAWN)
def test_with_drawn_parameters_nothing_but_rounding_differs(changes: dict[str, Any]) -> None:
    prepared, run = ran("circle", EXACT | changes)
    for variant in differences(prepared, run.recording).values():
        for channel, gap in variant.channels.items():
            assert gap <= SINGLE * variant.scales[channel], channel


@pytest.mark.parametrize("name", ["circle", "pentagram", "stair-y-500nm", "trapezoid-y"])
def test_following_errors_agree_to_one_count(name: str) -> None:
    prepared, run = ran(name, {})
    for variant in differences(prepared, run.recording).values():
        assert variant.channels["following_error"] < 1.01 * COUNT


def test_a_variant_diverges_at_the_kernels_tick() -> None:
    prepared, run = ran("circle", EXACT | NARROW)
    differences(prepared, run.recording)  # compares the ticks
    diverged = run.recording.variants["A"].diverged
    assert diverged is not None
    assert 0 < diverged.tick < prepared.reference.ticks


def test_tallies_and_nearest_points_give_the_metrics() -> None:
    prepared, run = ran("circle", {})
    start, end = prepared.window
    result = document(prepared, run.recording)["variants"]
    for name, record in run.recording.variants.items():
        for metric, values in tally_metrics(run.tallies[name], end - start).items():
            exact = [result[name]["axes"][axis][metric] for axis in "xy"]
            np.testing.assert_allclose(values, exact, rtol=1e-12, err_msg=metric)
        errors = np.stack([record.channel("following_error", axis) for axis in "xy"], axis=1)
        points = nearest(prepared.reference.position, (start, end), errors[start:end].astype(float))
        np.testing.assert_allclose(run.nearest[name][:, 0], np.abs(points.contour), rtol=1e-9)
        np.testing.assert_allclose(run.nearest[name][:, 1], points.lag, atol=1e-15)
        np.testing.assert_allclose(run.nearest[name][:, 2:4], points.foot, atol=1e-15)


@pytest.mark.parametrize("ticks", [1, 999, 1000])
def test_extremes_of_bins(ticks: int) -> None:
    size, column = 7, 5
    samples = np.random.default_rng(3).normal(size=(ticks, SAMPLE_ROWS * 2)).astype(np.float32)
    samples[ticks // 2, column] = np.nan  # makes its whole bin one
    bins = [samples[first : first + size, column] for first in range(0, ticks, size)]
    written = np.zeros((2, len(bins)), dtype=np.float32)
    memory = Memory()
    at, low = memory.put(samples) + 4 * column, memory.result(written)
    high = low + 4 * len(bins)
    memory.call("extremes", at, size, low, high, ticks, samples.shape[1], len(bins))
    memory.run()
    np.testing.assert_array_equal(written, [[f(each) for each in bins] for f in (np.min, np.max)])


def test_two_runs_give_the_same_bytes() -> None:
    prepared = prepare(load_scenario("circle"))
    first, second = (run_in_module(prepared) for _ in range(2))
    for name, record in first.recording.variants.items():
        assert record.samples.tobytes() == second.recording.variants[name].samples.tobytes()
        assert first.tallies[name].tobytes() == second.tallies[name].tobytes()


def test_the_module_says_what_its_rows_are() -> None:
    declared = module_run.description(module())
    assert declared == json.loads(json.dumps(description()))
    assert declared["parameters"] == list(PARAMETERS)
    assert declared["state"] == list(STATES)
    assert declared["inputs"] == list(Inputs._fields)
    assert declared["channels"] == [channel.name for channel in CHANNELS]
    assert declared["parameters"].index("controller.k_p") == parameter_row("controller.k_p")


def test_make_compiles_it_anew_for_every_source_of_the_model() -> None:
    show = ["make", "--silent", "--eval=show: ; @echo $(MODULE_SOURCES)", "show"]
    sources = set(subprocess.check_output(show, cwd=ROOT, text=True).split())
    model = {path for pattern in SOURCES for path in PACKAGE.glob(pattern)}
    assert {path.relative_to(ROOT).as_posix() for path in model} <= sources


def test_an_object_that_needs_more_than_memory_is_refused() -> None:
    data = b"\x0b\x01\x00"  # a section of data, no segments
    with pytest.raises(ValueError, match=r"sections beside types, functions and code: \[11\]"):
        module_of(b"\0asm\1\0\0\0" + data, ["run"])
