"""Motions given by their positions over time run as they are."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from numpy.typing import NDArray
from pyarrow import parquet

import motionlab
from motionlab.cli.main import main
from motionlab.config.load import validate_trajectory
from motionlab.errors import ConfigError
from motionlab.exchange.paths.reading import ReadOptions, read_trajectory
from motionlab.trajectories.reference import Reference, sample

Rows = NDArray[Any]


def eased(step: float = 0.005, seconds: float = 4.0) -> Rows:
    """Return time, x and y of a Lissajous figure from rest, s and m."""
    time = np.arange(round(seconds / step) + 1) * step
    share = np.clip(time / 1.5, 0.0, 1.0)
    clock = np.where(time < 1.5, 1.5 * share**4 * (2.5 - 3 * share + share**2), time - 0.75)
    angle = 2 * np.pi * 0.3 * clock
    return np.column_stack((time, 0.03 * np.sin(angle), 0.02 * np.sin(2 * angle)))


def table(rows: Rows) -> dict[str, Any]:
    return {"kind": "samples", "time": rows[:, 0], "x": rows[:, 1], "y": rows[:, 2]}


def sampled(rows: Rows) -> Reference:
    columns = {name: rows[:, k].tolist() for k, name in enumerate(("time", "x", "y"))}
    return sample(validate_trajectory({"kind": "samples"} | columns))


def test_the_motion_goes_through_every_sample_with_derivatives_that_fit() -> None:
    rows = eased()
    reference = sampled(rows)
    assert reference.ticks == 8000
    assert reference.position[::10] == pytest.approx(rows[:-1, 1:], abs=1e-15)
    assert reference.end == pytest.approx(tuple(rows[-1, 1:]), abs=1e-15)
    exact = eased(step=0.0005)
    assert reference.position == pytest.approx(exact[:-1, 1:], abs=1e-7)
    assert reference.position[:-200] == pytest.approx(exact[:-201, 1:], abs=2e-9)
    moved = reference.position[0] + np.cumsum(reference.velocity, axis=0) * 0.0005
    assert moved[:-1] == pytest.approx(reference.position[1:], abs=2e-5)
    gained = np.cumsum(reference.acceleration, axis=0) * 0.0005
    assert gained[:-1] == pytest.approx(reference.velocity[1:], abs=1e-4)
    assert reference.velocity[0] == pytest.approx((0.0, 0.0), abs=1e-12)


def test_uneven_times_that_begin_anywhere() -> None:
    rows = eased(step=0.0005)
    kept = np.sort(np.random.default_rng(3).choice(np.arange(1, 8000), 2000, replace=False))
    some = rows[np.concatenate(([0], kept, [8000]))]
    some[:, 0] += 123.4
    assert sampled(some).position == pytest.approx(rows[:-1, 1:], abs=1e-7)


@pytest.mark.parametrize(
    ("row", "column", "value", "message"),
    [
        (7, 0, 0.03, r"row 7 is 0\.03 s after 0\.03 s"),
        (7, 1, float("nan"), r"x: row 7 is nan m; allowed \+-1 m"),
        (7, 2, -1.5, r"y: row 7 is -1\.5 m; allowed \+-1 m"),
        (800, 0, 4000.0, r"lasts 4000 s from row 0 to row 800; allowed up to 3600 s"),
    ],
)
def test_a_wrong_row_is_named(row: int, column: int, value: float, message: str) -> None:
    rows = eased()
    rows[row, column] = value
    with pytest.raises(ConfigError, match=message):
        motionlab.trajectory(rows)


def test_a_start_at_speed_is_refused() -> None:
    rows = eased()[400:]
    with pytest.raises(ConfigError, match=r"must start at rest: x moves at .* m/s at row 0, 2 s"):
        motionlab.trajectory(rows)


def test_columns_of_other_lengths_text_and_shapes_are_refused() -> None:
    with pytest.raises(ConfigError, match="equally many values, not 3, 2 and 3"):
        motionlab.trajectory({"kind": "samples", "time": [0, 1, 2], "x": [0, 0], "y": [0, 0, 0]})
    with pytest.raises(ConfigError, match="row 1 is no number: 'a'"):
        motionlab.trajectory({"kind": "samples", "time": [0, 1], "x": [0, "a"], "y": [0, 0]})
    with pytest.raises(ConfigError, match=r"\(n, 3\)"):
        motionlab.trajectory(np.zeros((5, 4)))
    with pytest.raises(ConfigError, match="too many rows; got 100001"):
        motionlab.trajectory(np.zeros((100_001, 2)))
    with pytest.raises(ConfigError, match="1 masked values"):
        motionlab.trajectory(np.ma.masked_greater(np.array([[0, 0], [0, 1e-3]]), 0.0))


def test_what_leaves_the_stroke_is_infeasible_and_slower_is_no_help() -> None:
    rows = eased()
    rows[:, 1] *= 3.0
    found = motionlab.trajectory(rows)
    assert not found.feasible
    assert {each.quantity for each in found.check.violations} == {"position"}


def test_a_motion_that_is_too_fast_is_slowed_down() -> None:
    rows = eased()
    rows[:, 0] /= 4.0
    fast = motionlab.trajectory(rows)
    slow = fast.slowed()
    assert not fast.feasible
    assert slow.feasible
    assert 1.0 < slow.check.duration < 4.0


def test_arrays_and_files_are_one_motion(tmp_path: Path) -> None:
    rows = eased()
    np.save(tmp_path / "a.npy", rows)
    names = ("time [ms]", "x [mm]", "y [mm]")
    columns = {name: rows[:, k] * 1e3 for k, name in enumerate(names)}
    parquet.write_table(pa.table(columns), tmp_path / "a.parquet")
    np.savetxt(tmp_path / "a.csv", rows * 1e3, delimiter=",", header=",".join(names), comments="")
    expected = motionlab.trajectory(rows)
    assert expected.feasible
    for name in ("a.npy", "a.parquet", "a.csv"):
        for options in ([], ["--samples"]):
            if name == "a.csv" and not options:
                continue
            file = str(tmp_path / f"{name}.toml")
            found = motionlab.trajectory(tmp_path / name)
            assert found.position == pytest.approx(expected.position, abs=1e-11)
            imported = ["trajectory", "import", str(tmp_path / name), file, "--overwrite"]
            assert main([*imported, *options]) == 0
            again = motionlab.trajectory(file)
            assert np.array_equal(again.position, found.position)


def test_instants_since_1970_begin_at_zero() -> None:
    rows = np.zeros((5, 3))
    rows[:, 0] = 1_764_172_800 + 0.005 * np.arange(5)
    motion = motionlab.trajectory(rows)
    assert motion.table["time"] == pytest.approx([0.0, 0.005, 0.01, 0.015, 0.02], abs=1e-12)


def test_rows_of_two_columns_are_those_of_control_periods() -> None:
    rows = eased(step=0.0005)
    assert np.array_equal(
        motionlab.trajectory(rows[:, 1:]).position, motionlab.trajectory(rows).position
    )


def test_a_kept_run_replays_and_is_a_motion_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    run = motionlab.run("circle", set={"trajectory": table(eased())}, keep=True)
    again = motionlab.trajectory({"kind": "samples", "run": run.id})
    # Telemetry is float32.
    assert again.position == pytest.approx(sampled(eased()).position[:-1], abs=4e-9)
    assert motionlab.run("circle", set={"trajectory": {"kind": "samples", "run": run.id}})
    assert main(["replay", str(run.id)]) == 0
    file = tmp_path / "again.toml"
    assert main(["trajectory", "import", str(run.id), str(file)]) == 0
    assert np.array_equal(motionlab.trajectory(file).position, again.position)


def test_a_table_keeps_its_times_where_that_is_said() -> None:
    text = b"time [s],x [mm],y [mm]\n0,0,0\n0.1,1,0\n0.2,4,0\n0.3,9,1\n"
    kept = read_trajectory(text, ReadOptions(samples=True, placement="centre"))
    assert kept.trajectory.kind == "samples"
    assert kept.trajectory.model_dump()["time"] == (0.0, 0.1, 0.2, 0.3)
    assert kept.trajectory.model_dump()["x"][0] == pytest.approx(-0.0045)
    with pytest.raises(ConfigError, match="no column of time"):
        read_trajectory(b"x,y\n0,0\n1,1\n", ReadOptions(samples=True))
    with pytest.raises(ConfigError, match="line 4"):
        read_trajectory(text.replace(b"0.2,", b"0.1,"), ReadOptions(samples=True))
