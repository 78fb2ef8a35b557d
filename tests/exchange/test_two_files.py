"""Two files with a clock each become one run: offset and drift are estimated, or given."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from motionlab.cli.main import main
from motionlab.errors import ConfigError
from motionlab.exchange.measurements.channels import Measurement, read_measurement
from motionlab.exchange.measurements.document import ImportOptions, Merged
from motionlab.exchange.measurements.table_file import read_file
from motionlab.exchange.measurements.two_files import merged

OFFSET, DRIFT = 1.2345, 120e-6  # of the second clock


def motion(t: NDArray[Any]) -> NDArray[Any]:
    """Return a motion that does not repeat."""
    return 0.01 * np.sin(2 * np.pi * (0.3 * t + 0.04 * t**2)) + 0.003 * np.sin(7.7 * t + 1)


def force(t: NDArray[Any]) -> NDArray[Any]:
    return 30.0 * np.tanh(40 * np.sin(1.3 * t)) + 5 * np.cos(3.1 * t)


def second_clock(t: NDArray[Any]) -> NDArray[Any]:
    """Return what the second clock shows: t = OFFSET + (1 + DRIFT) t2."""
    return (t - OFFSET) / (1 + DRIFT)


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, Path]:
    """Write a servo's log at 1.5 kHz, and a sensor's at 2 kHz that begins and ends elsewhere."""
    rng = np.random.default_rng(3)
    t = np.arange(18_000) / 1500
    log = np.c_[t, motion(t) + rng.normal(0, 2e-6, t.size)]
    shown = np.arange(20_000) / 2000
    real = OFFSET + (1 + DRIFT) * shown
    sensor = np.c_[shown, 1e3 * motion(real) + rng.normal(0, 2e-3, real.size), force(real)]
    paths = tmp_path / "servo.csv", tmp_path / "sensor.csv"
    for path, header, rows in zip(
        paths, ("t [s],x_ist [m]", "t [s],x_ist [mm],force [N]"), (log, sensor), strict=True
    ):
        np.savetxt(path, rows, delimiter=",", header=header, comments="", fmt="%.9g")
    return paths


def both(files: tuple[Path, Path], *mapping: str, **said: Any) -> tuple[Measurement, Merged]:
    options = ImportOptions(mapping=mapping, **said)
    first, second = (read_file(path, options) for path in files)
    file, about, options = merged(first, second, options)
    return read_measurement(file, options), about


def test_offset_and_drift_are_estimated(files: tuple[Path, Path]) -> None:
    found, about = both(files)
    assert (about.first, about.second) == ("x_ist [m]", "x_ist [mm]")
    assert about.offset_half_width is not None
    assert about.drift_half_width is not None
    assert about.offset == pytest.approx(OFFSET, abs=2 * about.offset_half_width)
    assert about.drift == pytest.approx(DRIFT, abs=2 * about.drift_half_width)
    assert about.offset_half_width < 50e-6
    assert about.drift_half_width < 10e-6
    assert about.correlation == pytest.approx(1.0, abs=1e-3)
    assert (about.rows, found.document.ticks, found.document.rate) == (20_000, 18_000, 1500.0)
    merged_force = found.values["M.x.thrust"]
    t = np.arange(18_000) / 1500
    covered = (second_clock(t) >= 0) & (second_clock(t) <= 19_999 / 2000)
    assert about.samples == pytest.approx(np.count_nonzero(covered), abs=1)
    inner = covered & np.roll(covered, 2) & np.roll(covered, -2)
    np.testing.assert_allclose(merged_force[inner], force(t[inner]), atol=0.2)
    assert np.isnan(merged_force[~covered & ~np.roll(covered, 2) & ~np.roll(covered, -2)]).all()
    assert "x_ist" in found.values  # the sensor's own


def test_an_offset_that_is_stated(files: tuple[Path, Path]) -> None:
    found, about = both(files, offset=2.0)
    assert (about.offset, about.drift, about.correlation, about.offset_half_width) == (
        2.0, 0.0, None, None
    )  # fmt: skip
    t = np.arange(18_000) / 1500
    real = OFFSET + (1 + DRIFT) * (t - 2.0)
    inner = (t > 2.01) & (t < 11.9)
    np.testing.assert_allclose(found.values["M.x.thrust"][inner], force(real[inner]), atol=0.2)
    with pytest.raises(ConfigError, match="no sample while the first lasts"):
        both(files, offset=50.0)
    with pytest.raises(ConfigError, match="offset: is out of range"):
        both(files, offset=float("nan"))


def test_columns_that_are_named_and_of_opposite_signs(
    files: tuple[Path, Path], tmp_path: Path
) -> None:
    text = files[1].read_text().splitlines()
    rows = [",".join([a, f"{-float(b)!r}", c]) for a, b, c in (row.split(",") for row in text[1:])]
    other = tmp_path / "other.csv"
    other.write_text("\n".join(["ms,laser,F", *rows]))
    pair = files[0], other
    _, about = both(pair, "ms=time[s]", align="x_ist [m]=-laser")
    assert about.offset == pytest.approx(OFFSET, abs=1e-4)
    with pytest.raises(ConfigError, match="align: no column is in both files: name one of each"):
        both(pair, "ms=time[s]")
    with pytest.raises(ConfigError, match=r"do not show one motion.*give the offset"):
        both(pair, "ms=time[s]", align="x_ist [m]=F")
    with pytest.raises(ConfigError, match="align: no column of that name; got 'nothing'"):
        both(pair, "ms=time[s]", align="x_ist [m]=nothing")


def test_a_motion_that_repeats_is_refused(tmp_path: Path) -> None:
    t = np.arange(8000) * 1e-3
    paths = tmp_path / "a.csv", tmp_path / "b.csv"
    for path, late in zip(paths, (0.0, 0.25), strict=True):
        rows = np.c_[t, 0.01 * np.sin(2 * np.pi * (t + late))]
        np.savetxt(path, rows, delimiter=",", header="t [s],x_ist [m]", comments="")
    with pytest.raises(ConfigError, match=r"offset: offsets of .* fit about as well"):
        both(paths)
    assert both(paths, offset=0.25)[0].document.notes == []


def written(path: Path, t: NDArray[Any], values: NDArray[Any], fmt: str = "%.9g") -> Path:
    rows = np.c_[t, values]
    np.savetxt(path, rows, delimiter=",", header="t [s],x_ist [m]", comments="", fmt=fmt)
    return path


def test_a_motion_that_nearly_repeats_is_refused_in_noise_and_not_without(tmp_path: Path) -> None:
    t = np.arange(8000) * 1e-3
    real = 0.01 * np.sin(2 * np.pi * t) + 1e-4 * np.sin(2 * np.pi * 0.37 * t)
    for noise, refused in ((1e-3, True), (1e-7, False)):
        rng = np.random.default_rng(5)
        paths = (
            written(tmp_path / "a.csv", t, real + noise * rng.standard_normal(len(t))),
            written(tmp_path / "b.csv", t - 0.25, real + noise * rng.standard_normal(len(t))),
        )
        if refused:
            with pytest.raises(ConfigError, match=r"offset: offsets of .* fit about as well"):
                both(paths)
        else:
            assert both(paths)[1].offset == pytest.approx(0.25, abs=1e-4)


@pytest.mark.parametrize("empty", [False, True])
@pytest.mark.parametrize("swapped", [False, True])
def test_a_gap_takes_nothing_of_the_offset(tmp_path: Path, empty: bool, swapped: bool) -> None:
    """A gap, or cells without a number, in the middle of one file: a third of it is missing."""
    rng = np.random.default_rng(9)
    t = np.arange(12_000) * 1e-3
    values = motion(t) + rng.normal(0, 2e-6, t.size)
    there = (t < 4.0) | (t > 8.0)
    shown = second_clock(t)
    whole = written(tmp_path / "whole.csv", t, motion(t) + rng.normal(0, 2e-6, t.size))
    if empty:
        gap = written(tmp_path / "gap.csv", shown, np.where(there, values, np.nan))
    else:
        gap = written(tmp_path / "gap.csv", shown[there], values[there])
    about = both((gap, whole) if swapped else (whole, gap))[1]
    start = shown[0] if swapped else 0.0
    drift = 1 / (1 + DRIFT) - 1 if swapped else DRIFT
    # Offsets hold at the first row of the first file: t1 - s = offset + (1 + drift) (t2 - s).
    offset = -OFFSET / (1 + DRIFT) + drift * start if swapped else OFFSET
    assert about.offset_half_width is not None
    assert about.offset_half_width < 20e-6
    assert about.offset == pytest.approx(offset, abs=2 * about.offset_half_width)


def test_clocks_of_large_numbers(tmp_path: Path) -> None:
    t = np.arange(4000) * 1e-3
    first = written(tmp_path / "a.csv", t + 1.7e9, motion(t), "%.17g")
    second = written(tmp_path / "b.csv", t, motion(t), "%.17g")
    _, about = both((first, second))
    assert about.offset == pytest.approx(1.7e9, abs=1e-5)
    assert both((first, second), offset=1.7e9)[1].samples >= 3999
    with pytest.raises(ConfigError, match=r"at an offset of 1700000004\.25 s: the first lasts"):
        both((first, second), offset=1.7e9 + 4.25)


def test_instants_say_where_the_clocks_were(tmp_path: Path) -> None:
    """Both clocks show the time of day: an offset of 0 is that of equal times."""
    import pandas as pd

    t = np.arange(3000) * 1e-3
    paths = tmp_path / "a.parquet", tmp_path / "b.parquet"
    for path, late, name in zip(paths, (0.0, 0.5), ("x_ist", "force"), strict=True):
        stamps = pd.Timestamp("2026-01-01") + pd.to_timedelta(t + late, unit="s")
        pd.DataFrame({"time": stamps, name: motion(t + late)}).to_parquet(path)
    found, about = both(paths, offset=0.0)
    assert about.samples == 2500
    expected = motion(t[500:])
    np.testing.assert_allclose(found.values["M.x.thrust"][500:], expected, rtol=1e-5, atol=1e-9)


def test_the_command(files: tuple[Path, Path], capsys: pytest.CaptureFixture[str]) -> None:
    names = [str(path) for path in files]
    assert main(["import", *names, "--preview"]) == 0
    out = capsys.readouterr().out
    assert "second file: 20000 rows, " in out
    assert "offset 1234.5" in out
    assert "by 'x_ist [m]' and 'x_ist [mm]', correlation " in out
    assert main(["import", *names, "--preview", "--json", "--offset", "1.2345"]) == 0
    assert json.loads(capsys.readouterr().out)["merged"]["offset"] == 1.2345
    for arguments, message in (
        ([*names, names[0]], "FILE: too many files; got 3"),
        ([names[0], "--offset", "1"], "--offset: is of two files"),
        ([names[0], "--align", "x"], "--align: is of two files"),
        ([*names, "--rate", "1000"], "rate: two files are merged by their own times"),
        ([names[0], "nothing.csv"], "FILE: is no file; got 'nothing.csv'"),
    ):
        assert main(["import", *arguments]) == 2
        assert message in capsys.readouterr().err


def test_samples_at_uneven_times(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng = np.random.default_rng(7)
    t = np.cumsum(rng.uniform(0.2e-3, 1.8e-3, 6000))
    path = tmp_path / "uneven.csv"
    rows = np.c_[t, motion(t)]
    np.savetxt(path, rows, delimiter=",", header="t [s],x_ist [m]", comments="", fmt="%.9g")
    assert main(["import", str(path), "--preview"]) == 0
    median = 1 / np.median(np.diff(t))
    assert f"the median rate is {median:.3f}"[:23] in capsys.readouterr().err
    options = ImportOptions(resample=1000.0)
    found = read_measurement(read_file(path, options), options)
    assert found.document.median_rate == pytest.approx(median, rel=1e-4)
    at = t[0] + np.arange(len(found.values["M.x.position_measured"])) * 1e-3
    np.testing.assert_allclose(found.values["M.x.position_measured"], motion(at), atol=2e-6)
    assert main(["import", str(path), "--preview", "--resample", "1000"]) == 0
    assert "by linear interpolation" in capsys.readouterr().out


def test_a_second_file_without_time_is_named_with_its_columns(tmp_path: Path) -> None:
    one, two = tmp_path / "one.csv", tmp_path / "two.csv"
    one.write_text("t [s],x [mm]\n" + "".join(f"{0.001 * k},{k}\n" for k in range(50)))
    two.write_text("t2 [s],x2 [mm]\n" + "".join(f"{0.001 * k},{k}\n" for k in range(50)))
    with pytest.raises(ConfigError, match=r"the second file has no column of time.*'t2 \[s\]'"):
        merged(read_file(one, ImportOptions()), read_file(two, ImportOptions()), ImportOptions())
