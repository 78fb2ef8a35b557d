"""Comparison of two runs: instants, interpolation, tolerances, verdicts."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import ArrayLike, NDArray
from pyarrow import parquet

from motionlab.analysis.alignment import Alignment, Grid, by_reference, by_time
from motionlab.analysis.comparison_document import Comparison
from motionlab.analysis.comparison_options import Comparing, Rule, Tolerance
from motionlab.analysis.curve_difference import (
    Bounds,
    beyond_in_time,
    beyond_in_value,
    resampled,
    within,
)
from motionlab.analysis.run_comparison import compare
from motionlab.errors import ConfigError, StoreError
from motionlab.library.columns import Columns, of_file_or_run
from motionlab.telemetry import recorder
from tests.recordings import make_recording, noise

T = 0.0005
PERIOD = 0.002
NAN = np.nan

numbers = st.floats(-3.0, 3.0, width=32) | st.integers(-2, 2).map(float) | st.just(NAN)


def file_of(
    path: Path,
    columns: Mapping[str, ArrayLike],
    *,
    first: int = 0,
    period: float = T,
    ticks: ArrayLike | None = None,
    units: Mapping[str, str] | None = None,
) -> Columns:
    """Write columns as telemetry and return it, read back."""
    arrays = {name: np.asarray(values, dtype=np.float32) for name, values in columns.items()}
    count = len(next(iter(arrays.values())))
    at = np.arange(first, first + count) if ticks is None else np.asarray(ticks)
    fields = [
        pa.field("tick", pa.int64(), metadata={"unit": "1"}),
        pa.field("time", pa.float64(), metadata={"unit": "s"}),
        *(
            pa.field(name, pa.float32(), metadata={"unit": (units or {}).get(name, "m")})
            for name in arrays
        ),
    ]
    data = [pa.array(at), pa.array(at * period)]
    data += [pa.array(values, from_pandas=True) for values in arrays.values()]
    parquet.write_table(pa.table(data, schema=pa.schema(fields)), path, row_group_size=7)
    return of_file_or_run(str(path))


class Pair:
    """Two runs in files, and their comparison."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder

    def compare(
        self, first: Mapping[str, ArrayLike], second: Mapping[str, ArrayLike], **how: Any
    ) -> Comparison:
        of = {key: how.pop(key, {}) for key in ("a", "b")}
        a = file_of(self._folder / "a.parquet", first, **of["a"])
        b = file_of(self._folder / "b.parquet", second, **of["b"])
        how.setdefault("exact", True)
        return compare(a, b, Comparing(**how))


@pytest.fixture
def pair(tmp_path: Path) -> Pair:
    return Pair(tmp_path)


# -- verdicts -------------------------------------------------------------------------------------


def test_a_run_holds_against_itself(tmp_path: Path) -> None:
    for name in ("run.parquet", "run.csv"):
        recorder.write(noise(300), str(tmp_path / name), metadata={})
    run, text = (of_file_or_run(str(tmp_path / name)) for name in ("run.parquet", "run.csv"))
    for other in (run, text):
        found = compare(run, other, Comparing(exact=True))
        assert found.headline == "identical on 108 of 108"
        assert (found.holds, found.instants) == (True, 300)
        assert {(c.largest, c.beyond, c.rms) for c in found.channels} == {(0.0, 0.0, 0.0)}


def test_figures_of_one_channel(pair: Pair) -> None:
    first = [1.0, 2.0, 4.0, 8.0]
    second = [1.0, 2.5, 3.0, 8.0]
    found = pair.compare(
        {"p": first},
        {"p": second},
        a={"first": 10},
        tolerance=Tolerance(absolute=0.75),
        offset=5e-3,
    )
    (channel,) = found.channels
    assert channel.verdict == "out-of-tolerance"
    assert channel.largest == -1.0
    assert channel.at is not None
    assert (channel.at.time, channel.at.candidate_time) == pytest.approx((12 * T, 2 * T))
    assert channel.beyond == 0.25
    assert channel.rms == pytest.approx(np.sqrt((0.25 + 1.0) / 4))
    assert (found.within, found.holds) == (0, False)
    relative = pair.compare({"p": first}, {"p": second}, tolerance=Tolerance(relative=0.25))
    assert relative.holds  # 0.5 of 2 and 1 of 4


@pytest.mark.parametrize(
    ("second", "how", "verdict"),
    [
        ({"p": [1, 1, 1]}, {}, "within"),
        ({"p": [1, 1, 2]}, {}, "out-of-tolerance"),
        ({"q": [1, 1, 1]}, {}, "missing"),
        ({"q": [1, 1, 1]}, {"b": {"units": {"q": ""}}}, "missing"),
        ({"p": [1, 1, 1]}, {"b": {"units": {"p": "N"}}}, "units-differ"),
        ({"p": [1, 1, 1]}, {"offset": 1.0}, "ranges-differ"),
        ({"p": [1, 1, 1]}, {"offset": 1e308}, "ranges-differ"),
        ({"p": [1, 1, 1]}, {"offset": -1e308}, "ranges-differ"),
        ({"p": [1, 1, 1]}, {"offset": T / 2, "samples": "intersection"}, "not-aligned"),
        ({"p": [1, 1, 1]}, {"align": "reference"}, "not-aligned"),
        ({"p": [NAN, NAN, NAN]}, {}, "empty"),
        ({"p": [1, 1, NAN]}, {}, "out-of-tolerance"),
    ],
)
def test_verdicts(pair: Pair, second: Any, how: dict[str, Any], verdict: str) -> None:
    everything = Tolerance(absolute=0.5, relative=0.5)
    found = pair.compare({"p": [1, 1, 1]}, second, tolerance=everything, **how)
    assert found.channels[0].verdict == verdict
    assert found.holds == (verdict == "within")
    compared = verdict in {"within", "out-of-tolerance"}
    assert (found.channels[0].largest is not None) == compared
    assert bool(found.note) == (verdict in {"ranges-differ", "not-aligned"})


def test_what_both_miss_counts_for_nothing(pair: Pair) -> None:
    found = pair.compare({"p": [1, NAN, 3]}, {"p": [1, NAN, 3]})
    assert found.holds
    assert (found.channels[0].compared, found.channels[0].single) == (2, 0)


def test_a_gap_in_the_ticks_is_missing(pair: Pair) -> None:
    whole, gap = np.arange(20.0), np.r_[0:8, 11:20]
    found = pair.compare({"p": whole}, {"p": whole[gap]}, b={"ticks": gap})
    (channel,) = found.channels
    assert (channel.compared, channel.single, channel.largest) == (17, 3, 0.0)
    assert channel.verdict == "out-of-tolerance"
    same = pair.compare({"p": whole[gap]}, {"p": whole[gap]}, a={"ticks": gap}, b={"ticks": gap})
    assert same.holds


def test_channels_are_chosen_and_ruled_by_pattern(pair: Pair) -> None:
    columns = {"A.x.p": [1.0, 1.0], "A.y.p": [1.0, 1.0], "B.x.p": [1.0, 1.0]}
    moved = {name: np.array(values) + 0.5 for name, values in columns.items()}
    rules = {"B.x.p": Rule(absolute=0.1), "A.*": Rule(absolute=1.0), "*.p": Rule(absolute=0.6)}
    found = pair.compare(columns, moved, channels=rules)
    assert [c.tolerance.absolute for c in found.channels] == [0.6, 0.6, 0.1]
    assert [c.verdict for c in found.channels] == ["within", "within", "out-of-tolerance"]
    some = pair.compare(columns, moved, only=["A.?.p"])
    assert [c.name for c in some.channels] == ["A.x.p", "A.y.p"]
    with pytest.raises(ConfigError, match=r"channels\.C\.\*: fits no channel"):
        pair.compare(columns, moved, channels={"C.*": Rule()})
    with pytest.raises(ConfigError, match="offset"):
        pair.compare(columns, moved, align="index", offset=0.1)


def test_variants_are_compared_under_other_letters(pair: Pair) -> None:
    x, e = "x.position_reference", "x.following_error"
    first = {x: [0.0, 1.0], f"A.{e}": [1.0, 2.0], f"B.{e}": [3.0, 4.0], f"C.{e}": [7.0, 7.0]}
    values = {x: [0.0, 1.0], e: [3.0, 4.5], "Temp": [20.0, 20.0]}
    own = {f"B.{e}" if name == e else name: each for name, each in values.items()}
    measured = {f"M.{e}" if name == e else name: each for name, each in values.items()}
    how: dict[str, Any] = {"channels": {f"B.{e}": Rule(absolute=0.1)}, "b": {"units": {e: "N"}}}
    expected = pair.compare(first, own, **how)
    assert [c.largest for c in expected.channels] == [0.0, None, 0.5, None, None]
    assert pair.compare(first, measured, **how, variants={"M": "B"}) == expected
    both = {f"A.{e}": first[f"B.{e}"], f"B.{e}": first[f"A.{e}"]}
    assert pair.compare(first, both, variants={"A": "B", "B": "A"}).within == 2
    for second, variants, message in (
        (measured, {"A": "B"}, r"variants\.A: is no variant of the candidate.*'A'.*M"),
        (measured, {"M": "Z"}, r"variants\.M: is no variant of the baseline.*'Z'.*A, B, C"),
        (both | measured, {"M": "B"}, r"variants\.M: another .* is B already.*'B'.* C"),
        (both, {"A": "C", "B": "C"}, r"variants\.B: another .* is C already.*'C'.*A, B"),
        ({"Temp": [1.0, 1.0]}, {"M": "B"}, "it has no variants"),
    ):
        with pytest.raises(ConfigError, match=message):
            pair.compare(first, second, variants=variants)


def test_a_range_of_time_leaves_out_the_rest(pair: Pair) -> None:
    first, stopped = np.arange(20.0), np.arange(20.0)
    stopped[15:] = 0.0
    of = {"a": {"first": 4}, "b": {"first": 4}}
    whole = pair.compare({"p": first}, {"p": stopped}, **of)
    assert (whole.holds, whole.instants) == (False, 20)
    part = pair.compare({"p": first}, {"p": stopped}, **of, start=10 * T, end=18 * T)
    assert (part.holds, part.instants) == (True, 9)
    assert part.start is not None
    assert part.end is not None
    assert (part.start.time, part.end.time) == pytest.approx((10 * T, 18 * T))
    fast = {"a": {"first": 4}, "b": {"first": 16, "period": T / 4}}
    curves = {"p": first}, {"p": np.arange(0.0, 20.0, 0.25)}
    between = pair.compare(*curves, **fast, start=10 * T, end=12 * T)
    assert (between.holds, between.instants) == (True, 9)  # those of the faster one
    moved = pair.compare({"p": first}, {"p": first}, offset=2 * T, end=5 * T)
    assert moved.instants == 4  # the times are those of the baseline
    for start in (1.0, 1e308):
        nothing = pair.compare({"p": first}, {"p": first}, start=start)
        assert nothing.channels[0].verdict == "ranges-differ"
        assert nothing.note == f"the runs share no instant from {start:g} s"
    assert pair.compare({"p": first}, {"p": first}, start=-1e308, end=1e308).instants == 20
    with pytest.raises(ConfigError, match=r"end: is before the start; got 1\.0; allowed >= 2 s"):
        pair.compare({"p": first}, {"p": first}, start=2.0, end=1.0)


def test_flags_and_commands_are_held(pair: Pair) -> None:
    names = ("A.x.force_command", "A.x.force_saturated", "A.x.force_realised")
    columns: dict[str, ArrayLike] = {name: [0.0, 1.0] for name in names}
    units = {"units": {names[1]: "1"}}
    found = pair.compare(columns, columns, a=units, b=units)
    assert [c.interpolation for c in found.channels] == ["hold", "hold", "linear"]
    rule = {"*": Rule(interpolation="linear")}
    asked = pair.compare(columns, columns, a=units, b=units, channels=rule)
    assert {c.interpolation for c in asked.channels} == {"linear"}


def test_files_that_are_no_telemetry(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="r- and 12 characters"):
        of_file_or_run("run.txt")
    with pytest.raises(StoreError, match="cannot be read"):
        of_file_or_run(str(tmp_path / "none.parquet"))
    parquet.write_table(pa.table({"p": [1.0]}), tmp_path / "other.parquet")
    with pytest.raises(StoreError, match="tick and time"):
        of_file_or_run(str(tmp_path / "other.parquet"))
    with pytest.raises(StoreError, match="do not grow"):
        file_of(tmp_path / "back.parquet", {"p": [1, 2, 3]}, ticks=[2, 1, 0])
    empty = make_recording(0, {"A": {}})
    recorder.write(empty, str(tmp_path / "empty.parquet"), metadata={})
    nothing = of_file_or_run(str(tmp_path / "empty.parquet"))
    found = compare(nothing, nothing, Comparing(exact=True))
    assert {c.verdict for c in found.channels} == {"ranges-differ"}


# -- other sample rates ---------------------------------------------------------------------------


def test_a_line_sampled_at_another_rate_is_the_same_line(pair: Pair) -> None:
    slow, fast = np.arange(0.0, 0.3, 0.003), np.arange(0.0, 0.3, 0.0005)
    curves = {"p": 2 * slow}, {"p": 2 * fast}
    of = {"a": {"period": 0.003}, "b": {"period": 0.0005}}
    near = Tolerance(absolute=1e-7)
    union = pair.compare(*curves, **of, tolerance=near)
    assert (union.holds, union.instants) == (True, 595)  # to the slow one's last sample
    common = pair.compare(*curves, **of, tolerance=near, samples="intersection")
    assert (common.holds, common.instants) == (True, 100)
    held = pair.compare(*curves, **of, channels={"p": Rule(interpolation="hold")})
    (channel,) = held.channels
    assert channel.largest == pytest.approx(2 * 0.0025, rel=1e-4)
    assert union.end is not None
    assert union.end.time == pytest.approx(0.297)


@given(
    st.integers(1, 40),
    st.integers(1, 40),
    st.sampled_from([PERIOD, PERIOD / 4, PERIOD * 1.37, PERIOD * 3]),
    st.floats(-0.1, 0.1),
    st.sampled_from(["union", "intersection"]),
)
def test_instants_by_time(
    ticks: int, others: int, period: float, offset: float, samples: Any
) -> None:
    baseline, candidate = Grid(0.3, PERIOD, ticks), Grid(0.28, period, others)
    found = by_time(baseline, candidate, offset=offset, samples=samples)
    if not found.instants:
        assert found.reason
        return
    own = places(found, found.baseline)
    other = places(found, found.candidate)
    close = 3e-3 * min(PERIOD, period)
    times = baseline.first + own * PERIOD
    np.testing.assert_allclose(candidate.first + offset + other * period, times, atol=close)
    assert (np.diff(times) > 0).all()
    assert (own >= 0).all()
    assert (own <= ticks - 1).all()
    whole = (own == np.rint(own)).astype(int) + (other == np.rint(other))
    assert (whole == 2).all() if samples == "intersection" else (whole >= 1).all()
    if samples == "union":  # every sample of the overlap is there
        ends = candidate.first + offset + np.arange(others) * period
        inside = ends[(ends >= baseline.first) & (ends <= baseline.first + (ticks - 1) * PERIOD)]
        assert all(np.abs(times - end).min() <= close for end in inside)


def places(found: Alignment, positions: Any) -> NDArray[np.float64]:
    if isinstance(positions, slice):
        return np.arange(positions.start, positions.stop, dtype=float)
    assert len(positions) == found.instants
    return positions


# -- by reference ---------------------------------------------------------------------------------


def circle(speed: float, laps: float, *, radius: float = 0.015) -> NDArray[Any]:
    """Return a circle at a speed of its own, eased in, as float32 holds it, shape (2, ticks)."""
    end = 2 * np.pi * radius * laps
    arc = np.minimum(np.cumsum(np.minimum(np.arange(1_000_000) * 2e-3, 1.0) * speed * T), end)
    arc = np.concatenate((np.zeros(200), arc[: int(np.argmax(arc >= end)) + 1]))
    angle = arc / radius
    return (radius * np.stack([np.cos(angle), np.sin(angle)])).astype(np.float32).astype(float)


def test_two_speeds_along_one_circle(tmp_path: Path) -> None:
    slow, fast = circle(0.06, 3.2), circle(0.1, 2.6)
    files: list[Columns] = []
    for name, (x, y) in (("slow", slow), ("fast", fast)):
        angle = np.arctan2(y, x)
        channels = {
            "x.position_reference": x,
            "y.position_reference": y,
            "error": np.sin(3 * angle),
        }
        files.append(file_of(tmp_path / f"{name}.parquet", channels))
    by_place = Comparing(align="reference", exact=True, tolerance=Tolerance(absolute=2e-3))
    first, second = files
    found = compare(first, second, by_place)
    assert found.holds, found
    assert found.lap_length == pytest.approx(2 * np.pi * 0.015, rel=1e-5)
    assert found.end is not None
    assert found.end.lap == 2
    assert found.end.arc == pytest.approx(0.6 * 2 * np.pi * 0.015, rel=1e-3)
    assert found.end.time > found.end.candidate_time
    lap = compare(first, second, by_place.model_copy(update={"start": 3.0, "end": 4.0}))
    assert (lap.holds, lap.lap_length) == (True, found.lap_length)
    assert 0 < lap.instants < found.instants
    assert lap.start is not None
    assert lap.start.time == pytest.approx(3.0, abs=2 * T)
    assert not compare(first, second, by_place.model_copy(update={"align": "time"})).holds


def test_laps_do_not_drift() -> None:
    """Chords of a fast motion are shorter: without laps the places would part by micrometres."""
    slow, fast = circle(0.02, 6.0), circle(0.9, 6.0)
    found = by_reference(slow, fast, samples="union")
    assert found.path is not None
    where = [
        np.stack([resampled(axis, at, hold=False) for axis in side])
        for side, at in ((slow, found.baseline), (fast, found.candidate))
    ]
    sagitta = (0.9 * T) ** 2 / (8 * 0.015)  # of the fast one's chords
    assert np.hypot(*(where[0] - where[1])).max() < 1.3 * sagitta
    assert found.path.lap.max() == 5


def test_a_reference_that_stands_still() -> None:
    line = np.concatenate((np.zeros(50), np.linspace(0, 0.01, 100), np.full(30, 0.01)))
    path = np.stack([line, np.zeros_like(line)])
    found = by_reference(path, path, samples="union")
    assert found.path is not None
    assert found.instants == 100
    assert found.path.standing == pytest.approx(80 / 180)
    assert places(found, found.baseline).tolist() == [50.0, *range(51, 149), 179.0]
    still = by_reference(path * 0.0, path, samples="union")
    assert (still.instants, still.reason) == (0, "not-aligned")


def test_another_path_is_not_aligned() -> None:
    large, small = circle(0.1, 2.0), circle(0.1, 2.0, radius=0.0149)
    found = by_reference(large, small, samples="union")
    assert found.reason == "not-aligned"
    assert "part" in found.note


def test_a_figure_of_eight_has_one_lap_a_turn() -> None:
    """It comes by its first point twice a turn, in two directions."""
    turn = np.linspace(0.0, 6 * np.pi, 30_000)
    eight = np.stack([0.02 * np.sin(turn), 0.01 * np.sin(2 * turn)])
    found = by_reference(eight, eight, samples="union")
    assert found.path is not None
    assert found.path.lap.max() in {2, 3}
    assert np.count_nonzero(np.diff(found.path.lap)) in {2, 3}


# -- kernels --------------------------------------------------------------------------------------


@given(
    st.lists(st.tuples(numbers, numbers), max_size=30),
    st.floats(0.0, 2.0),
    st.floats(0.0, 2.0),
)
def test_difference_is_what_numpy_says(
    values: list[tuple[float, float]], absolute: float, relative: float
) -> None:
    b, c = np.array(values, dtype=np.float32).reshape(-1, 2).T.copy()
    found = within(b, c, absolute, relative)
    both = np.isfinite(b) & np.isfinite(c)
    d = c.astype(float) - b
    far = np.abs(d[both]) > np.maximum(absolute, relative * np.abs(b[both].astype(float)))
    single = np.count_nonzero(np.isfinite(b) ^ np.isfinite(c))
    assert found.compared == np.count_nonzero(both)
    assert found.single == single
    assert found.beyond == np.count_nonzero(far) + single
    assert found.beyond == np.count_nonzero(beyond_in_value(b, c, absolute, relative))
    if both.any():
        assert found.where == np.nanargmax(np.abs(d))
        assert found.largest == d[found.where]
        assert found.rms == pytest.approx(np.sqrt(np.mean(d[both] ** 2)))
    else:
        assert (found.where, found.largest, found.rms) == (-1, 0.0, 0.0)


@given(
    st.lists(numbers, min_size=1, max_size=25),
    st.lists(st.tuples(st.floats(0.0, 1.0), numbers), max_size=25),
    st.floats(0.0, 6.0) | st.integers(0, 6).map(float),
    st.booleans(),
    st.floats(0.0, 1.0) | st.just(0.0),
)
def test_tolerance_in_time_is_what_a_search_finds(
    samples: list[float], instants: list[tuple[float, float]], reach: float, hold: bool, near: float
) -> None:
    c = np.array(samples, dtype=np.float32)
    ordered = sorted(share for share, _ in instants)
    p = np.array(ordered) * (len(c) - 1)
    b = np.array([value for _, value in instants], dtype=np.float32)
    found = beyond_in_time(b, c, p, Bounds(near, 0.1, reach), hold=hold)
    expected = [not passes(value, c, at, reach, hold, near) for value, at in zip(b, p, strict=True)]
    assert found.tolist() == expected


def passes(
    b: float, c: NDArray[np.float32], at: float, reach: float, hold: bool, near: float
) -> bool:
    """Return whether a candidate comes near enough in time, piece by piece."""
    last = len(c) - 1.0

    def value(place: float) -> float:
        return float(resampled(c, np.array([place]), hold=hold)[0])

    if not np.isfinite(b):
        return not np.isfinite(value(at))
    tolerance = max(near, 0.1 * abs(float(b)))
    low, high = float(b) - tolerance, float(b) + tolerance
    start, stop = max(at - reach, 0.0), min(at + reach, last)
    ends = [start, *(k for k in range(len(c)) if start < k < stop), stop]
    if any(low <= value(end) <= high for end in ends):
        return True
    pieces = [] if hold else itertools.pairwise(ends)
    return any(
        min(first, second) <= high and max(first, second) >= low
        for first, second in ((value(left), value(right)) for left, right in pieces)
        if np.isfinite(first) and np.isfinite(second)
    )


def test_a_late_edge_is_within_a_tolerance_in_time(pair: Pair) -> None:
    edge = np.repeat([0.0, 1.0], 50)
    late = np.roll(edge, 4)
    late[:4] = 0.0
    channels = {"A.x.force_saturated": edge}, {"A.x.force_saturated": late}
    assert pair.compare(*channels, tolerance=Tolerance(time=4 * T)).holds
    assert not pair.compare(*channels, tolerance=Tolerance(time=3 * T)).holds
    (channel,) = pair.compare(*channels).channels
    assert channel.beyond == 0.04
