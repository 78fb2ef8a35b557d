"""A run from Python against what it stands for: the recording, the files, the command line."""

from __future__ import annotations

import itertools
import json
import pickle
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motionlab
from motionlab.config.load import load_scenario
from motionlab.scripting.run import Run
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run as simulate
from motionlab.telemetry import recorder

GAIN = {"variants.B.controller.x.k_p": 400e3}
ERROR = "B.x.following_error"
RADIAL = "radial = hypot(B.x.following_error, B.y.following_error)"


@pytest.fixture(scope="module")
def circle() -> Run:
    return motionlab.run("circle", set=GAIN)


def test_every_channel_is_the_recorded_one_with_unit_and_meaning(circle: Run) -> None:
    recording = simulate(prepare(load_scenario("circle", GAIN)))
    expected = list(recorder.columns(recording))
    assert list(circle) == [name for name, _, _ in expected]
    for name, channel, values in expected:
        found = circle[name]
        np.testing.assert_array_equal(found, values)
        assert (found.name, found.unit) == (name, channel.unit)
        assert circle.described[name] == channel
    np.testing.assert_array_equal(circle.time, np.arange(recording.ticks) * 0.0005)
    assert circle.time.unit == "s"


def test_metrics_are_those_of_the_channels(circle: Run) -> None:
    start, end = (round(t / 0.0005) for t in circle.window)
    largest = float(np.abs(circle[ERROR][start:end]).max())
    assert circle.metrics["B"]["x"]["max_abs_following_error"] == pytest.approx(largest, rel=1e-6)
    of_a = circle.metrics["A"]["x"]["max_abs_following_error"]
    assert of_a is not None
    ratio = circle.comparison["x"]["max_abs_following_error_ratio"]
    assert ratio == pytest.approx(largest / of_a, rel=1e-6)
    assert circle.metrics["B"]["xy"].keys() == circle.document["variants"]["B"]["contour"].keys()
    assert circle.diverged == {}


def test_it_is_what_the_command_prints(circle: Run, capsys: pytest.CaptureFixture[str]) -> None:
    from motionlab.cli import main

    assert main(["run", "circle", "--set", "variants.B.controller.x.k_p=400e3", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == circle.document


def test_the_scenario_is_resolved_and_runs_again(circle: Run) -> None:
    assert circle.scenario == load_scenario("circle", GAIN)
    again = motionlab.run(circle.scenario)
    np.testing.assert_array_equal(again[ERROR], circle[ERROR])


def test_slices_keep_the_unit_and_results_have_none(circle: Run) -> None:
    error = circle[ERROR]
    parts: list[Any] = [error[10:20], error.copy()]
    assert [part.unit for part in parts] == ["m", "m"]
    assert "m  # B.x.following_error" in repr(error)
    for result in (error * 1e6, np.abs(error), error - circle["A.x.following_error"]):
        assert type(result) is np.ndarray
    assert type(error.max()) is np.float32


def test_math_channels_are_checked_and_computed(circle: Run) -> None:
    radial = circle[RADIAL]
    assert (radial.name, radial.unit) == ("radial", "m")
    expected = np.hypot(
        circle[ERROR].astype(np.float64), circle["B.y.following_error"].astype(np.float64)
    )
    np.testing.assert_array_equal(radial, expected.astype(np.float32))
    assert circle["= B.x.thrust * B.x.velocity"].unit == "W"
    with pytest.raises(motionlab.ConfigError, match=r"channel: .*N.*m"):
        circle["= B.x.thrust + B.x.position"]


def test_an_unknown_channel_is_answered_with_the_closest(circle: Run) -> None:
    with pytest.raises(KeyError, match=r"no channel 'B\.x\.folowing.*did you mean 'B\.x\.follow"):
        circle["B.x.folowing_error"]
    assert "B.x.folowing_error" not in circle


def test_tables_carry_units(circle: Run) -> None:
    frame = circle.to_pandas(ERROR, RADIAL)
    assert list(frame.columns) == [ERROR, "radial"]
    assert frame.attrs["units"] == {ERROR: "m", "radial": "m"}
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame[ERROR], circle[ERROR])
    table = circle.to_arrow(ERROR)
    assert table.column_names == ["tick", "time", ERROR]
    assert table.schema.field(ERROR).metadata[b"unit"] == b"m"
    assert len(circle.to_arrow().column_names) == len(circle) + 2


def test_files_are_those_of_the_command_line(circle: Run, tmp_path: Path) -> None:
    from motionlab.simulation.result import metadata

    saved = circle.save(tmp_path / "run.parquet")
    same = str(tmp_path / "same.parquet")
    recording = simulate(prepare(circle.scenario))
    recorder.write(recording, same, metadata=metadata(circle.scenario))
    assert saved.read_bytes() == Path(same).read_bytes()
    for name in ("some.parquet", "some.csv"):
        back = recorder.read(str(circle.save(tmp_path / name, ERROR, RADIAL)))
        assert {key: each.unit for key, each in back.items()} == {
            "tick": "1", "time": "s", ERROR: "m", "radial": "m"
        }  # fmt: skip
        np.testing.assert_array_equal(back[ERROR].values, circle[ERROR])
    with pytest.raises(motionlab.ConfigError, match=r"path: .*\.parquet"):
        circle.save(tmp_path / "run.xlsx")


def test_figures_draw_what_was_asked_for(circle: Run) -> None:
    figure = circle.plot()
    assert [[line.get_label() for line in axis.lines] for axis in figure.axes] == [
        [f"{variant}.{axis}.following_error" for variant in "AB"] for axis in "xy"
    ]
    assert [axis.get_ylabel() for axis in figure.axes] == ["µm", "µm"]
    figure = circle.plot(ERROR, "B.x.velocity", start=2.0, end=3.0)
    error, velocity = figure.axes
    assert (error.get_ylabel(), velocity.get_ylabel()) == ("µm", "mm/s")
    line: Any = error.lines[0]
    np.testing.assert_allclose(line.get_ydata(), circle[ERROR][4000:6000] * 1e6, rtol=1e-6)
    assert line.get_xdata()[[0, -1]] == pytest.approx([2.0, 2.9995])


def test_figures_are_drawn_in_axes_of_ones_own(circle: Run) -> None:
    from matplotlib.figure import Figure

    own = Figure()
    left, right = own.subplots(1, 2)
    assert circle.plot(ax=left, title="Both axes") is own
    assert [line.get_label() for line in left.lines] == circle.shown()
    assert (left.get_title(), left.get_ylabel(), len(right.lines)) == ("Both axes", "µm", 0)
    two = own.add_subfigure(own.add_gridspec(1, 2)[0]).subplots(2, 1)
    assert circle.plot(ERROR, "B.x.velocity", ax=two) is own
    assert [panel.get_ylabel() for panel in two] == ["µm", "mm/s"]
    with pytest.raises(motionlab.ConfigError, match=r"ax: must have.*got 1; .*2, of m, m/s"):
        circle.plot(ERROR, "B.x.velocity", ax=left)
    with pytest.raises(motionlab.ConfigError, match="ax: is not an Axes"):
        circle.plot(ax=own)  # pyright: ignore[reportArgumentType]
    assert circle.plot(title="Circle").get_suptitle() == "Circle"


def test_a_notebook_shows_curves_and_the_report(circle: Run) -> None:
    html = circle._repr_html_()
    assert html.count("<svg") == 2
    assert "max contouring error" in html
    assert len(html) < 100_000


def test_a_variant_that_diverged_says_when() -> None:
    with pytest.warns(motionlab.RunWarning, match="B: diverged at t = "):
        run = motionlab.run(
            "circle", set={"variants.B.controller.x.k_p": 2e7, "divergence_error": 1e-4}
        )
    assert list(run.diverged) == ["B"]
    at = np.searchsorted(run.time, run.diverged["B"])
    assert np.isfinite(run[ERROR][: at - 1]).all()
    assert np.isnan(run[ERROR][at + 1 :]).all()
    assert run.metrics["B"]["x"]["max_abs_following_error"] is None


def test_an_unstable_loop_is_warned_of_wherever_a_run_is_read() -> None:
    at_rest = {"plant": "matched", "variants.B.controller.compensation.law": "canudas-de-wit"}
    with pytest.warns(motionlab.RunWarning) as caught:
        run = motionlab.run("stair-x-500nm", set=at_rest)
    (text,) = (str(each.message) for each in caught if str(each.message).startswith("B: "))
    assert text.startswith("B: on x: its linearised loop is unstable at standstill and its ")
    assert text in run.notes
    assert text.removeprefix("B: ") in run.document["variants"]["B"]["notes"]
    for shown in (str(run), run._repr_html_()):
        assert "its linearised loop is unstable at standstill" in shown
    loop = motionlab.linearise("stair-x-500nm", "B", "x", at_rest)
    assert loop.stable and not loop.stable_at_rest
    assert not motionlab.linearise("stair-x-500nm", "B", "x", at_rest, velocity=0.0).stable


def test_an_expression_needs_no_name(circle: Run) -> None:
    unnamed, named = circle["derivative(B.x.position)"], circle["v = derivative(B.x.position)"]
    np.testing.assert_array_equal(unnamed, named)
    assert unnamed.unit == "m/s"
    with pytest.raises(KeyError, match=r"did you mean 'B\.x\.position'"):
        circle["B.x.positon"]


def test_input_is_refused_as_everywhere(tmp_path: Path) -> None:
    with pytest.raises(motionlab.ConfigError, match=r"plant\.x\.mass: .* kg"):
        motionlab.run("circle", set={"plant.x.mass": 0})
    with pytest.raises(motionlab.Infeasible, match=r"thrust on y is .* N at t = "):
        motionlab.run("circle", set={"trajectory.frequency": 5.0})
    with pytest.raises(motionlab.ConfigError, match=r"did you mean 'circle'"):
        motionlab.run("circel")
    own = tmp_path / "own.toml"
    own.write_text('base = "circle"\ntrajectory = { base = "circle", laps = 1 }\n')
    assert motionlab.run(str(own)).scenario == motionlab.run(own).scenario


def test_a_part_of_a_file_is_named_by_its_path(tmp_path: Path) -> None:
    stage = tmp_path / "stage.toml"
    stage.write_text('base = "nominal"\nx.mass = 6.5\n')
    run = motionlab.run("circle", {"plant": stage, "trajectory.laps": 1})
    assert run.scenario.plant.x.mass == 6.5


def test_importing_the_package_imports_nothing_heavy() -> None:
    code = (
        "import sys, motionlab\n"
        "print(sorted({m.split('.')[0] for m in sys.modules}"
        " & {'numpy', 'numba', 'pydantic', 'pyarrow', 'pandas'}))\n"
        "print(sorted(set(motionlab.__all__) - set(dir(motionlab))))"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.split() == ["[]", "[]"]


@pytest.mark.parametrize("name", motionlab.__all__)
def test_every_name_is_there_and_described(name: str) -> None:
    found = getattr(motionlab, name)
    assert callable(found)
    assert (found.__doc__ or "").strip()


NESTED: dict[str, Any] = {}
NESTED["base"] = NESTED


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: motionlab.run(None), "scenario: must be a name, a .toml file"),  # pyright: ignore
        (lambda: motionlab.run(3), r"scenario: must be a name, .*; got 3$"),  # pyright: ignore
        (lambda: motionlab.run("a\0.toml"), "scenario: holds a zero byte"),
        (lambda: motionlab.run(name="a"), "name: needs keep=True"),
        (lambda: motionlab.run(keep=True, name="a\nb"), "name: has a control character"),
        (lambda: motionlab.run(NESTED), "scenario: is nested too deeply"),
        (lambda: motionlab.run("circle", [("a", 1)]), "set: is no mapping"),  # pyright: ignore
        (lambda: motionlab.run("circle", {3: 5}), "set: is no mapping"),  # pyright: ignore
        (lambda: motionlab.sweep("circle", None), "grid: is no mapping"),  # pyright: ignore
        (lambda: motionlab.sweep("circle", {"seed": 3}), r"grid\.seed: is no list"),  # pyright: ignore
        (lambda: motionlab.sweep("circle", {"seed": itertools.count()}), "10000"),  # pyright: ignore
        (lambda: motionlab.trajectory(None), "motion: must be a name, a file"),  # pyright: ignore
        (lambda: motionlab.linearise(velocity=float("nan")), r"velocity: .*got nan; .* m/s"),
        (lambda: motionlab.trajectory([[0, 0]]), r"motion: must be a name, .*; got \[\[0, 0\]\]"),  # pyright: ignore
        (lambda: motionlab.linearise(velocity="slow"), "velocity: must be a number"),  # pyright: ignore
        (lambda: motionlab.linearise(velocity=11.0), r"velocity: is out .*; .*<= 10 m/s"),
        (lambda: motionlab.kept(3), "run: must be text; got 3"),  # pyright: ignore
        (lambda: motionlab.kept_runs(3), "search: must be text; got 3"),  # pyright: ignore
        (lambda: motionlab.kept_runs(limit=-1), r"limit: is out .*>= 1 and <= 200"),
        (lambda: motionlab.kept_runs(limit=1.5), r"limit: must be a whole number; got 1\.5"),  # pyright: ignore
        (lambda: motionlab.sweep("circle", {"seed": [1]}, scheduler=3), "scheduler: must"),  # pyright: ignore
        (lambda: motionlab.Client(token=3), "^token: must be text$"),  # pyright: ignore
        (lambda: motionlab.Client(8000), "url: is no address"),  # pyright: ignore
        (lambda: motionlab.Client("http://[::1"), "url: is no address"),
        (
            lambda: motionlab.Client(token="a\nb"),
            "^token: has a character .* blanks and line ends$",
        ),
    ],
)
def test_odd_arguments_are_named(call: Callable[[], object], message: str) -> None:
    with pytest.raises(motionlab.ConfigError, match=message):
        call()


def test_a_run_outlives_a_pickle_and_draws_what_there_is(circle: Run) -> None:
    again = pickle.loads(pickle.dumps(circle))
    np.testing.assert_array_equal(again[ERROR], circle[ERROR])
    assert again.document == circle.document
    assert again.scenario == circle.scenario
    assert 3 not in circle
    with pytest.raises(motionlab.ConfigError, match="leaves nothing to draw"):
        circle.plot(start=5.0, end=1.0)
    panel = circle.plot("B.x.friction", "B.x.friction_estimate", "B.x.thrust").axes[0]
    assert len({line.get_color() for line in panel.lines}) == 3
    with pytest.raises(motionlab.MotionLabError):
        motionlab.design().save("/proc/design.json")


def test_a_kept_run_is_read_back_here(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, circle: Run
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    made = motionlab.run("circle", set=GAIN, keep=True, name="stiff")
    (listed,) = motionlab.kept_runs("stiff B.x.max<3um")
    assert listed["id"] == made.id
    assert motionlab.kept_runs("tag:none") == []
    for name in (made.id, "stiff"):
        assert name is not None
        again = motionlab.kept(name)
        np.testing.assert_array_equal(again[ERROR], circle[ERROR])
        np.testing.assert_array_equal(again[RADIAL], circle[RADIAL])
    largest = circle.metrics["B"]["x"]["max_abs_following_error"]
    assert again.metrics["B.x.max_abs_following_error"] == largest
    assert again.scenario == circle.scenario
    assert "stiff" in repr(again)
    assert again.id == made.id and again.name == "stiff"
    with pytest.raises(motionlab.ConfigError, match="no kept run of that name"):
        motionlab.kept("soft")
