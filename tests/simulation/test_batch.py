"""A case in a batch is the run of that case alone, to the last bit."""

from __future__ import annotations

import math
import pickle
from typing import Any

import numpy as np
import pytest

from motionlab.analysis.metrics import DEFINITIONS
from motionlab.config.load import load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import ConfigError
from motionlab.kernel import score
from motionlab.kernel.build import lane_parameters
from motionlab.kernel.layout import parameter_row
from motionlab.simulation.batch import Batch, CaseTask, lanes_of, run_batch, run_prepared
from motionlab.simulation.batch_runner import BatchRunner, Scores
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run

SHORT = {"trajectory.frequency": 4.0, "trajectory.radius": 0.002}
NOISE = {"plant.x.encoder.noise": 2e-8, "plant.y.amplifiers.noise": 0.02, "load.noise": 0.1}
UNSTABLE = {"variants.B.controller.x.k_p": 1e8, "divergence_error": 3e-4}
SCHEDULE = {"schedule": [{"time": 0.3, "set": {"variants.B.controller.x.k_p": 100000.0}}]}
CASES: list[dict[str, Any]] = [
    {},
    {"plant": "matched"},
    {"plant.x.friction.F_s": 9.0, "variants.B.controller.y.k_d": 900.0},
    NOISE,
    NOISE | {"seed": 7},
    UNSTABLE,
    SCHEDULE,
    {"window": {"start": 0.1, "end": 0.4}},
    {"plant.x.force_map": {"kind": "table", "name": "new-design"}},
    *({"plant.y.mass": 13.0 + 0.01 * i} for i in range(17)),  # wide blocks, the last not full
]


def alone(name: str, changes: dict[str, Any]) -> dict[str, Any]:
    """Return the variants of the result document of one run."""
    prepared = prepare(load_scenario(name, changes))
    return document(prepared, run(prepared))["variants"]


def assert_same(batch: Batch, case: int, variants: dict[str, Any]) -> None:
    """Hold the metrics of a case to those of a run, bit by bit."""
    assert batch.variants == tuple(variants)
    for v, variant in enumerate(variants.values()):
        assert (batch.failed[case, v] >= 0) == (variant["diverged"] is not None)
        for a, axis in enumerate(AXES):
            expected = variant["axes"].get(axis, dict.fromkeys(DEFINITIONS))
            for metric, value in expected.items():
                found = batch.metrics[metric][case, v, a]
                assert math.isnan(found) if value is None else found == value, (metric, axis)


def batch(
    name: str, cases: list[dict[str, Any]], *, threads: int | None = None, **tell: Any
) -> Batch:
    tables = load_scenario(name, SHORT if name == "circle" else {}).model_dump(mode="json")
    return run_batch(CaseTask(tables, 0, cases, threads, {}, {}), **tell)


@pytest.fixture(scope="module")
def circle() -> Batch:
    return batch("circle", CASES, threads=3)


@pytest.mark.parametrize("case", range(len(CASES)))
def test_case_equals_its_run(circle: Batch, case: int) -> None:
    assert_same(circle, case, alone("circle", SHORT | CASES[case]))


def test_cases_differ(circle: Batch) -> None:
    rms = circle.metrics["rms_following_error"][:5, 1]
    assert len(np.unique(rms[:, 0])) == 5


def test_divergence_ends_both_axes_of_its_variant_only(circle: Batch) -> None:
    peak = circle.metrics["max_abs_following_error"][CASES.index(UNSTABLE)]
    assert np.isfinite(peak[0]).all()
    assert np.isnan(peak[1]).all()


@pytest.mark.parametrize("name", ["stair-x-500nm", "trapezoid-y"])
def test_motion_with_holds(name: str) -> None:
    cases: list[dict[str, Any]] = [{}, {"plant": "matched"}]
    found = batch(name, cases)
    assert not np.isnan(found.metrics["steady_state_error"]).all()
    for case, changes in enumerate(cases):
        assert_same(found, case, alone(name, changes))


def test_bits_do_not_depend_on_threads_or_neighbours(circle: Batch) -> None:
    few = batch("circle", CASES[:3], threads=1)
    for name, values in few.metrics.items():
        np.testing.assert_array_equal(values, circle.metrics[name][:3])


def test_what_no_case_changes_runs_once(monkeypatch: pytest.MonkeyPatch) -> None:
    movers: list[int] = []
    score = BatchRunner.score

    def counted(self: BatchRunner, lanes: np.ndarray[Any, Any], **options: Any) -> Scores:
        movers.append(lanes.shape[1])
        return score(self, lanes, **options)

    monkeypatch.setattr(BatchRunner, "score", counted)
    gains = [{"variants.B.controller.x.k_p": value} for value in (2e5, 3e5, 2e5)]
    found = batch("circle", gains)
    assert movers == [3]  # A, and B with either gain
    for case, changes in enumerate(gains):
        assert_same(found, case, alone("circle", SHORT | changes))


def test_progress_rises_to_one_and_can_end_a_batch() -> None:
    shares: list[float] = []
    batch("circle", CASES[-17:], progress=shares.append)
    assert shares == sorted(shares)
    assert shares[-1] == pytest.approx(1.0)

    def enough(share: float) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        batch("circle", CASES, progress=enough)


def test_watched_errors_are_those_of_the_run() -> None:
    prepared = [
        prepare(load_scenario("circle", SHORT | case)) for case in (*CASES[:2], NOISE, UNSTABLE)
    ]
    seen: dict[int, np.ndarray[Any, Any]] = {}

    def watch(movers: np.ndarray[Any, Any], errors: np.ndarray[Any, Any]) -> None:
        seen.update(zip(movers.tolist(), errors, strict=True))

    run_prepared(prepared, watch=watch)
    for case, one in enumerate(prepared):
        for v, record in enumerate(run(one).variants.values()):
            for a, axis in enumerate(AXES):
                error = record.channel("following_error", axis)
                part = seen[2 * case + v][a]
                going = ~np.isnan(error)  # a run's record ends with either axis
                np.testing.assert_array_equal(part[going], error[going])
                assert np.isnan(part).any() == ((case, v, axis) == (3, 1, "x"))


def test_gains_side_by_side_equal_runs_with_these_gains() -> None:
    prepared = prepare(load_scenario("circle", SHORT))
    gains = np.linspace(1e5, 3e5, 5)
    lanes = np.repeat(lanes_of(prepared.epochs)[:, :1], len(gains), axis=1)
    lanes[:, :, parameter_row("controller.k_p"), 0] = gains
    scores = BatchRunner(prepared).score(lanes)
    for i, k_p in enumerate(gains):
        axes = alone("circle", SHORT | {"variants.A.controller.x.k_p": float(k_p)})["A"]["axes"]
        assert scores.metrics["itae"][i].tolist() == [axes["x"]["itae"], axes["y"]["itae"]]


def test_another_process_runs_the_code_that_is_compiled() -> None:
    """Arrays that come out of a pickle can be written to, for which numba compiles anew."""
    prepared = prepare(load_scenario("circle", SHORT))
    lanes = lanes_of(prepared.epochs)[:, :1]
    expected = BatchRunner(prepared).score(lanes, threads=1).metrics["itae"]
    compiled = list(score._score_narrow.signatures)
    sent = pickle.loads(pickle.dumps(prepared))
    assert np.array_equal(BatchRunner(sent).score(lanes, threads=1).metrics["itae"], expected)
    assert score._score_narrow.signatures == compiled


def test_lanes_of_a_scenario_are_those_of_its_runs() -> None:
    scenario = load_scenario("circle")
    (block,) = lane_parameters(scenario)
    movers = lanes_of(prepare(scenario).epochs)[0]
    np.testing.assert_array_equal(block[:, :4].T, movers.transpose(0, 2, 1).reshape(4, -1))


def test_what_is_wrong_with_a_case_is_named() -> None:
    with pytest.raises(ConfigError, match=r"cases.1: plant\.x\.mass.*got -1"):
        batch("circle", [{}, {"plant.x.mass": -1.0}])
    with pytest.raises(ConfigError, match="needs at least one"):
        run_prepared([])
    with pytest.raises(ConfigError, match=r"cases.0: trajectory: is too long"):
        batch("circle", [{"trajectory.laps": 4000}])
    with pytest.raises(ConfigError, match="cannot add or remove a variant"):
        variants = load_scenario("circle").model_dump(mode="json")["variants"]
        batch("circle", [{"variants": variants | {"C": variants["A"]}}])


def test_a_case_that_cannot_be_followed_has_no_metrics(circle: Batch) -> None:
    found = batch("circle", [{"plant.x.mass": 900.0}, {}])
    assert found.feasible.tolist() == [False, True]
    for name, values in found.metrics.items():
        assert np.isnan(values[0]).all()
        np.testing.assert_array_equal(values[1], circle.metrics[name][0])


def test_thousands_of_cases_share_one_load() -> None:
    heavier = load_scenario("circle", {"plant.x.mass": 6.5, "seed": 3})
    loads = [prepare(scenario).load for scenario in (load_scenario("circle"), heavier)]
    assert loads[0] is loads[1]
    assert not loads[0].flags.writeable
    pushed = prepare(load_scenario("circle", {"load.x": 1.0})).load
    np.testing.assert_array_equal(pushed, loads[0] + (1.0, 0.0))
