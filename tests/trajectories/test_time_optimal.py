"""Time-optimal profiles: within every limit at every tick, and as fast as closed forms."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w
from pydantic import ValidationError

import motionlab
from motionlab.cli.main import main
from motionlab.config.drawn_path import DrawnPath
from motionlab.config.load import epochs, load_scenario
from motionlab.config.planned_motor import PlannedMotor
from motionlab.config.trajectory import Sequence
from motionlab.errors import ConfigError
from motionlab.simulation.prepare import limit_sets, planned_for, prepare
from motionlab.timing import CONTROL_PERIOD
from motionlab.trajectories.motion_limits import MotionLimits, demands
from motionlab.trajectories.motion_profile import jerk_limited_times
from motionlab.trajectories.reference import Reference, sample
from motionlab.trajectories.retiming import slow_down
from motionlab.trajectories.spline import spline
from motionlab.trajectories.time_optimal_limits import Along, Nodes
from motionlab.trajectories.time_optimal_solver import (
    FAILED,
    _constraints,
    _linear,
    _spacing,
    tied,
)
from tests.trajectories.random_splines import largest_shares, random_splines, time_optimal

EASY: dict[str, Any] = {"v_max": 0.05, "a_max": 0.3, "j_max": 20.0}
HARD: dict[str, Any] = {"v_max": 0.5, "a_max": 5.0, "j_max": 200.0}
MAP = {"plant.force_map": "new-design"}


def flower(count: int) -> list[list[float]]:
    """Return points of a closed curve with narrow and wide bends, m."""
    angle = np.arange(count) * (2 * math.pi / count)
    radius = 0.03 * (1 + 0.25 * np.sin(5 * angle) + 0.1 * np.sin(11 * angle + 1))
    return np.column_stack((radius * np.cos(angle), radius * np.sin(angle))).tolist()


def planned(points: Any, changes: dict[str, Any] | None = None, **table: Any) -> DrawnPath:
    trajectory = {"kind": "path", "points": points, "law": "time_optimal"} | table
    scenario = load_scenario("circle", {"trajectory": trajectory} | (changes or {}))
    found = prepare(scenario).scenario.trajectory  # refuses any tick beyond a limit
    assert isinstance(found, DrawnPath)
    return found


def speed_along(reference: Reference) -> np.ndarray:
    return np.hypot(*reference.velocity.T)


def limits() -> MotionLimits:
    return limit_sets(tuple(epochs(load_scenario("circle"))))[0][1]


@pytest.mark.parametrize("geometry", ["spline", "polyline"])
@pytest.mark.parametrize("limit", [EASY, HARD, HARD | {"j_max": 2000.0}])
@pytest.mark.parametrize("changes", [{}, MAP])
def test_no_tick_is_beyond_a_limit(
    geometry: str, limit: dict[str, float], changes: dict[str, Any]
) -> None:
    path = planned(flower(24), changes, closed=True, geometry=geometry, **limit)
    reference = sample(path)
    assert speed_along(reference).max() <= limit["v_max"] * (1 + 1e-9)
    assert np.allclose(reference.velocity[0], 0.0)
    assert math.dist(reference.end, path.points[0]) < 1e-9
    along = np.sum(reference.velocity * reference.acceleration, axis=1)
    speed = speed_along(reference)
    gain = along[speed > 1e-3] / speed[speed > 1e-3]
    assert np.abs(gain).max() <= limit["a_max"] * (1 + 1e-6)


def test_a_thrust_bound_profile_uses_the_thrust() -> None:
    reference = sample(planned(flower(24), closed=True, geometry="spline", **HARD))
    shares = []
    for demand in demands(reference, limits()):
        reach = np.array([demand.limit_at(4, k) for k in range(0, reference.ticks, 7)])
        shares.append(np.abs(demand.samples.thrust[::7]) / reach)
    busiest = np.max(shares, axis=0)
    assert busiest.max() <= 1.0
    assert np.mean(busiest > 0.9) > 0.5


def test_a_straight_line_takes_the_time_of_its_closed_form() -> None:
    reference = sample(planned([[-0.02, 0.0], [0.02, 0.0]], **EASY))
    best = sum(jerk_limited_times(0.04, **EASY))
    assert 0.0 <= reference.ticks * CONTROL_PERIOD - best < CONTROL_PERIOD


def test_a_smooth_straight_line_is_within_a_percent_of_its_closed_form() -> None:
    points = [[0.01 * k - 0.02, 0.0] for k in range(5)]
    reference = sample(planned(points, geometry="spline", **EASY))
    best = sum(jerk_limited_times(0.04, **EASY))
    assert best <= reference.ticks * CONTROL_PERIOD < 1.01 * best


def test_a_circle_within_limits_of_acceleration_has_its_closed_form() -> None:
    # With x = v^2 and |acceleration| <= A of both axes, d(x sin^2 t)/dt <= 2 A R sin t from the
    # axis at t = 0 on, so x = A R / cos^2(t/2) up to 45 degrees, then the same backwards.
    radius, most = 0.03, 0.3
    angle = np.arange(48) * (2 * math.pi / 48)
    points = (radius * np.column_stack((np.cos(angle), np.sin(angle)))).tolist()
    changes = {f"plant.{axis}.acceleration_max": most for axis in ("x", "y")}
    fast = {"v_max": 1.0, "a_max": 10.0, "j_max": 50.0}
    path = planned(points, changes, closed=True, geometry="spline", **fast)
    reference = sample(path)
    turned = np.unwrap(np.arctan2(reference.position[:, 1], reference.position[:, 0]))
    inner = (turned > math.pi / 2) & (turned < 3 * math.pi / 2)
    folded = (turned[inner] + math.pi / 4) % (math.pi / 2) - math.pi / 4
    expected = math.sqrt(most * radius) / np.cos(folded / 2)
    found = speed_along(reference)[inner]
    assert found == pytest.approx(expected, rel=0.005)
    assert (found <= expected).all()
    time = 8 * math.sqrt(radius / most) * math.sin(math.pi / 8)
    assert inner.sum() * CONTROL_PERIOD == pytest.approx(time, rel=0.003)


def test_it_is_faster_than_the_other_profiles_slowed_until_feasible() -> None:
    points = flower(24)
    fast = sample(planned(points, closed=True, geometry="spline", **HARD)).ticks
    sets = limit_sets(tuple(epochs(load_scenario("circle"))))
    for law in ("minimum_jerk", "jerk_limited"):
        limit = HARD if law == "jerk_limited" else {"v_max": 0.5, "a_max": 5.0}
        table = {"points": points, "closed": True, "geometry": "spline", "law": law} | limit
        slowed, _ = slow_down(DrawnPath.model_validate(table), sets)
        assert fast < 0.8 * sample(slowed).ticks


@pytest.fixture(scope="module")
def motor() -> PlannedMotor:
    return planned_for(load_scenario("circle"))


@pytest.mark.parametrize("path", list(random_splines(seed=30, count=8)))
def test_random_splines_are_at_a_limit_nearly_all_the_time(
    path: dict[str, Any], motor: PlannedMotor
) -> None:
    reference = sample(time_optimal(path, motor))
    shares = largest_shares(reference, path, limits())
    assert reference.notes == ()
    assert shares.max() <= 1.0 + 1e-6
    assert np.mean(shares >= 0.95) >= 0.6


@pytest.mark.parametrize("path", list(random_splines(seed=31, count=6)))
def test_no_lower_limit_and_no_seven_phases_are_faster(
    path: dict[str, Any], motor: PlannedMotor
) -> None:
    ticks = sample(time_optimal(path, motor)).ticks
    for name in ("v_max", "a_max", "j_max"):
        for factor in (0.9, 0.5):
            lower = path | {name: factor * path[name]}
            assert ticks <= 1.003 * sample(time_optimal(lower, motor)).ticks
    phases = DrawnPath.model_validate(path | {"law": "jerk_limited"})
    slowed, _ = slow_down(phases, limit_sets(tuple(epochs(load_scenario("circle")))))
    assert ticks <= sample(slowed).ticks


def test_a_nearly_straight_spline_is_no_slower_than_the_seven_phases() -> None:
    points = [[0.01 * k - 0.03, 1e-5 * (-1) ** k] for k in range(7)]
    fast = sample(planned(points, geometry="spline", **EASY)).ticks
    table = {"points": points, "geometry": "spline", "law": "jerk_limited"} | EASY
    assert fast <= sample(DrawnPath.model_validate(table)).ticks


@pytest.mark.parametrize(
    "limit",
    [{"v_max": 3e-4, "a_max": 1.0, "j_max": 20.0}, {"v_max": 0.3, "a_max": 1e-4, "j_max": 20.0}],
)
def test_limits_along_the_path_alone_give_the_seven_phases_unsolved(
    limit: dict[str, float], motor: PlannedMotor, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Minutes of motion would be a million ticks for every attempt of the solver.
    monkeypatch.setattr("motionlab.trajectories.time_optimal.solve", None)
    path = next(random_splines(seed=902, count=1)) | limit
    reference = sample(time_optimal(path, motor))
    phases = sample(DrawnPath.model_validate(path | {"law": "jerk_limited"}))
    assert reference.notes == ()
    assert abs(reference.ticks - phases.ticks) <= 3


def test_a_cusp_between_two_points_is_passed_slowly(motor: PlannedMotor) -> None:
    # The curvature radius is 2 um between the ninth point and the tenth.
    points = [[16.6, -2.1], [21.8, 13.1], [9.7, 22.4], [-7.3, 28.3], [-12.4, 13.7], [-37.4, 10.7]]
    points += [[-42.6, -7.8], [-7.4, -9.7], [-5.1, -46.3], [8.8, -12.7], [18.2, -15.1]]
    path = {"points": [[x / 1e3, y / 1e3] for x, y in points], "closed": True}
    path |= {"geometry": "spline", "v_max": 5.8, "a_max": 94.0, "j_max": 22_000.0}
    reference = sample(time_optimal(path, motor))
    shares = largest_shares(reference, path, limits())
    assert shares.max() <= 1.0 + 1e-6
    assert np.mean(shares >= 0.95) >= 0.6


def test_a_motion_that_has_not_converged_says_so_and_keeps_the_limits(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(
        "motionlab.trajectories.time_optimal.solve", lambda *all: (all[5].copy(), FAILED)
    )
    path = planned(flower(24), closed=True, geometry="spline", **HARD)
    table = path.model_dump(mode="json")
    (note,) = motionlab.trajectory(table).notes
    assert "has not converged from 0 to 0.2" in note
    with pytest.warns(motionlab.RunWarning, match="has not converged"):
        document = motionlab.run("circle", set={"trajectory": table}).document
    assert note in document["variants"]["A"]["notes"]
    file = tmp_path / "path.toml"
    file.write_text(tomli_w.dumps(path.model_dump(mode="json", exclude_none=True)))
    assert main(["check", str(file)]) == 0
    assert note in capsys.readouterr().out


def test_laps_repeat_sample_for_sample() -> None:
    reference = sample(planned(flower(24), closed=True, geometry="spline", laps=3, **HARD))
    lap = reference.period
    assert reference.ticks == 3 * lap
    assert np.array_equal(reference.acceleration[:lap], reference.acceleration[lap : 2 * lap])


def test_a_path_that_is_planned_keeps_its_motion_with_another_motor() -> None:
    path = planned(flower(12), closed=True, geometry="spline", **EASY)
    other = {"trajectory": path.model_dump(mode="json"), "plant.x.mass": 6.0}
    again = prepare(load_scenario("circle", other))
    assert np.array_equal(again.reference.position, sample(path).position)


def test_without_a_motor_it_cannot_be_sampled() -> None:
    path = DrawnPath.model_validate({"points": flower(6), "law": "time_optimal"} | EASY)
    with pytest.raises(ConfigError, match="planned_for"):
        sample(path)


def test_a_sequence_refuses_it() -> None:
    part = {"kind": "path", "points": flower(6), "law": "time_optimal"} | EASY
    with pytest.raises(ValidationError, match="part of a sequence"):
        Sequence.model_validate({"parts": [part]})


def test_a_lap_time_is_refused() -> None:
    with pytest.raises(ValidationError, match="no lap_time"):
        DrawnPath.model_validate({"points": flower(6), "law": "time_optimal", "lap_time": 2.0})


def test_without_much_limit_of_jerk_it_is_as_fast_as_a_fine_grid() -> None:
    limit = HARD | {"j_max": 50_000.0}
    path = planned(flower(24), None, closed=True, geometry="spline", **limit)
    least = grid_time(path, limits(), a_max=HARD["a_max"], v_max=HARD["v_max"])
    found = sample(path).ticks * CONTROL_PERIOD
    assert 0.997 * least < found < 1.02 * least


def grid_time(path: DrawnPath, limits: MotionLimits, *, v_max: float, a_max: float) -> float:
    """Return the time from rest to rest by a forward and a backward pass, without jerk, s."""
    curve = spline(path.points, closed=path.closed)
    ways = np.linspace(0.0, curve.length, 6001)
    places, slopes, bends = curve.path(ways)
    step = ways[1]
    thrust = [
        [
            limits.available_thrust(k, places[:, k].copy(), np.full(len(ways), s))
            for s in (-1.0, 1.0)
        ]
        for k in range(2)
    ]

    def gains(x: np.ndarray, at: Any) -> tuple[np.ndarray, np.ndarray]:
        low, high = np.full(x.shape, -a_max), np.full(x.shape, a_max)
        for k in range(2):
            slope, bend = slopes[at, k], bends[at, k]
            against = limits.friction(k, slope * np.sqrt(x))
            down = np.minimum(limits.a_max[k], (thrust[k][0][at] + against) / limits.mass[k])
            up = np.minimum(limits.a_max[k], (thrust[k][1][at] - against) / limits.mass[k])
            ends = np.array([(-down - bend * x) / slope, (up - bend * x) / slope])
            low, high = np.maximum(low, ends.min(axis=0)), np.minimum(high, ends.max(axis=0))
        return low, high

    everywhere = slice(None)
    x, least = np.full(len(ways), v_max**2), np.zeros(len(ways))
    for _ in range(40):
        middle = 0.5 * (x + least)
        low, high = gains(middle, everywhere)
        x, least = np.where(low > high, middle, x), np.where(low > high, least, middle)
    x[0] = x[-1] = 0.0
    for k in range(len(ways) - 1):
        x[k + 1] = min(x[k + 1], x[k] + 2.0 * step * gains(x[k : k + 1], slice(k, k + 1))[1][0])
    for k in range(len(ways) - 1, 0, -1):
        x[k - 1] = min(x[k - 1], x[k] - 2.0 * step * gains(x[k : k + 1], slice(k, k + 1))[0][0])
    speed = np.sqrt(x)
    return float(np.sum(2.0 * step / (speed[1:] + speed[:-1])))


@pytest.mark.parametrize("rows", [5, 9])
def test_the_solver_has_the_derivatives_of_its_constraints(rows: int) -> None:
    random = np.random.default_rng(4)
    way = np.cumsum(random.uniform(0.5, 1.5, 12)) * 1e-3
    count = len(way) - 1
    knots = Nodes(way, np.zeros((12, 2)), random.normal(size=(12, 2)), random.normal(size=(12, 2)))
    along, reach = Along(0.5, 5.0, 200.0), random.uniform(3.0, 5.0, (12, 3, 2))
    share, most = random.uniform(0.9, 1.0, 12), random.uniform(0.1, 0.2, 12)
    spacing, start = _spacing(way), random.uniform(0.02, 0.1, count)

    def of(inner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        c, g, jacobian = np.empty(count), np.zeros((count, rows)), np.zeros((count, rows, 3))
        c[1:-1] = inner
        tied(way, c)
        for k in range(1, count):
            _linear(knots, spacing, reach[k], share[k], most[k], k, jacobian[k])
        _constraints(knots, spacing, along, reach, share, most, start, c, g, jacobian)
        return g, jacobian

    inner = random.uniform(0.02, 0.1, count - 2)
    _, jacobian = of(inner)
    dense = np.zeros((count, rows, count))
    for k in range(1, count):
        for near in range(3):
            if k - 1 + near < count:
                dense[k, :, k - 1 + near] = jacobian[k, :, near]
    for i in range(count - 2):
        step = np.zeros(count - 2)
        step[i] = 1e-6 * inner[i]
        slope = (of(inner + step)[0] - of(inner - step)[0]) / (2.0 * step[i])
        assert dense[:, :, i + 1] == pytest.approx(slope, rel=1e-5, abs=1e-5)
    # Nothing is left for the intervals at the ends: they follow their neighbours.
    assert not dense[:, :, 0].any()
    assert not dense[:, :, -1].any()


@pytest.mark.parametrize(
    ("fields", "message"),
    [
        ({"points": 2001}, r"trajectory.points: too many for law = 'time_optimal'.*<= 2000"),
        (
            {"points": 500, "geometry": "spline", "corners": list(range(1, 202))},
            r"trajectory.corners: too many for law = 'time_optimal'.*<= 200",
        ),
        ({"points": 10, "geometry": "spline", "v_max": 1e-6}, "trajectory: lasts too long"),
        ({"points": 10, "geometry": "polyline", "v_max": 1e-5}, "trajectory: lasts too long"),
    ],
)
def test_what_takes_too_long_to_plan_is_refused(fields: dict[str, Any], message: str) -> None:
    count = fields["points"]
    points = [(-0.07 + 0.14 * k / count, 0.01 * (k % 2)) for k in range(count)]
    limits = {"v_max": 1.0, "a_max": 10.0, "j_max": 2000.0}
    table = {"kind": "path", "law": "time_optimal"} | limits | fields | {"points": points}
    with pytest.raises(ConfigError, match=message):
        prepare(load_scenario("circle", {"trajectory": table}))
