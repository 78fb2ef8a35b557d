"""A frequency response that is measured: its lines, its estimate, and what it finds on motors."""

from __future__ import annotations

import csv
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from motionlab.cli.main import main
from motionlab.config.load import load_scenario
from motionlab.config.multisine import Multisine, Signal
from motionlab.errors import ConfigError
from motionlab.library.library import library
from motionlab.simulation.prepare import prepare
from motionlab.simulation.run import run
from motionlab.studies.loop.frequency_sweep import ResponseDocument, loop_curve
from motionlab.studies.response import recorded
from motionlab.studies.response.controller_check import OTHER
from motionlab.studies.response.documents import (
    FittedMode,
    FittedPlant,
    MeasuredResponse,
    PlantValue,
    ResponseRequest,
)
from motionlab.studies.response.estimate import Slides, Smaller, estimate
from motionlab.studies.response.margins import intervals, measured_margins, refined
from motionlab.studies.response.measure import ResponsePlan, measure, plan
from motionlab.trajectories.multisine import Lines, excitation

SHORT = {"seconds": 30.0, "lines": 40}
SHAKEN = {"kind": "multisine", "axis": "y", "velocity": 0.0432}


def found(**request: Any) -> MeasuredResponse:
    return measure(plan(ResponseRequest.model_validate(SHORT | request)))


@pytest.fixture(scope="module")
def x_of_circle() -> MeasuredResponse:
    return found(scenario="circle", axis="x", seconds=60.0)


def complex_of(curve: Any) -> np.ndarray[Any, Any]:
    return np.array(curve.magnitude) * np.exp(1j * np.array(curve.phase))


def test_amplitudes_of_a_motion_are_those_that_made_it() -> None:
    lines = Lines.between(2.0, 400.0, 12, 1000)
    sizes = np.exp(1j * np.arange(len(lines.cycles)))
    value, rate, _ = lines.motion(sizes)
    np.testing.assert_allclose(lines.amplitudes(np.tile(value, 3)), np.tile(sizes, (3, 1)))
    w = 2.0 * np.pi * lines.frequency
    np.testing.assert_allclose(lines.amplitudes(rate)[0], 1j * w * sizes, rtol=1e-9)


@pytest.mark.parametrize("signal", ["multisine", "noise", "chirp", "stepped-sine"])
def test_a_signal_has_the_power_of_its_lines(signal: Signal) -> None:
    """Over slides; a chirp has the smallest peaks, a stepped sine one line in each slide."""
    lines = Lines.of(signal, 2.0, 400.0, 20, 1000)
    size, rng = lines.share / lines.cycles**2, np.random.default_rng(0)
    slides = [excitation(signal, lines, size, n, rng) for n in range(6 * len(lines.cycles))]
    power = np.mean([np.abs(each) ** 2 for each in slides], axis=0)
    np.testing.assert_allclose(power, size**2, rtol=0.3)
    accelerations = lines.motion(slides[-1])[2]
    crest = np.abs(accelerations).max() / accelerations.std()
    least, most = {"chirp": (1.4, 2.5), "stepped-sine": (1.3, 1.5)}.get(signal, (2.5, 5.0))
    assert least < crest < most
    assert (np.count_nonzero(slides[0]) == 1) == (signal == "stepped-sine")


@pytest.mark.parametrize("turn", [7.2e-3, 20e-6])
def test_a_turn_is_whole_in_all_periods_and_in_no_fewer(turn: float) -> None:
    planned = plan(ResponseRequest(scenario="circle", axis="y"))
    assert isinstance(planned, ResponsePlan)
    turns = planned.velocity / planned.lines.frequency[0] / turn * np.arange(1, planned.periods + 1)
    off = np.abs(turns - np.round(turns))
    assert off[-1] < 0.02
    assert off[:-1].min() > 0.15


@pytest.mark.parametrize("signal", ["noise", "chirp", "stepped-sine"])
def test_other_signals_measure_the_same(signal: str) -> None:
    of_stepped = {"lines": 8, "seconds": 120.0} if signal == "stepped-sine" else {"seconds": 60.0}
    made = found(scenario="circle", axis="x", signal=signal, **of_stepped)
    ratio = complex_of(made.plant) / complex_of(made.linearised_plant)
    sure = np.array(made.plant.coherence) > 0.9
    assert sure.mean() > 0.75
    assert np.quantile(np.abs(20.0 * np.log10(np.abs(ratio[sure]))), 0.9) < 0.5
    assert np.quantile(np.degrees(np.abs(np.angle(ratio[sure]))), 0.9) < 3.0


def test_a_stepped_sine_takes_two_slides_for_each_line() -> None:
    with pytest.raises(ConfigError, match=r"seconds: is too short: 68 slides of .* are needed"):
        plan(ResponseRequest.model_validate(SHORT | {"signal": "stepped-sine"}))
    with pytest.raises(ValidationError, match="slides must be at least 120, two for each of 60"):
        Multisine(signal="stepped-sine")


def test_lines_that_nothing_has_shaken_yet_are_not_in_a_partial_result() -> None:
    """Those of a stepped sine come one after another; warnings of NumPy fail the test."""
    request = {"scenario": "circle", "axis": "x", "signal": "stepped-sine", "lines": 8}
    planned = plan(ResponseRequest.model_validate(request | {"seconds": 60.0}))
    lines: list[int] = []

    def progress(_: float, partial: MeasuredResponse | None) -> None:
        if partial is not None:
            lines.append(len(partial.frequency))
            assert np.isfinite(partial.plant.magnitude).all()

    document = measure(planned, progress)
    assert lines[0] == 3
    assert lines[-1] == len(document.frequency) == 8


@pytest.mark.parametrize("force", [0.005, 0.02])
def test_lines_that_are_not_coherent_are_left_out(force: float) -> None:
    """Feedback makes the command of noise there: L seems -1, and margins nothing."""
    small = found(scenario="circle", axis="x", force=force, seconds=60.0, lines=60)
    count = len(small.frequency)
    assert 8 <= count < 48
    assert min(small.plant.coherence) >= recorded.COHERENT
    assert len(small.plant.magnitude) == len(small.open.phase) == count
    assert len(small.linearised_plant.phase) == count
    if small.fitted is not None:
        assert len(small.fitted.residual) == count
    margin = small.margins["phase_margin"].value
    assert margin is not None
    assert math.degrees(margin) == pytest.approx(60.0, abs=4.0)


def test_a_force_of_which_too_little_is_coherent_is_refused() -> None:
    with pytest.raises(ConfigError, match="is too small: the coherence") as refused:
        found(scenario="circle", axis="x", force=1e-4)
    (error,) = refused.value.errors
    assert (error.loc, error.value, error.unit) == ("force", 1e-4, "N")


def test_a_force_beyond_the_friction_is_noted(x_of_circle: MeasuredResponse) -> None:
    assert x_of_circle.warnings == []
    free = {"plant.x.friction.enabled": False}
    (note, *_) = found(scenario="circle", axis="x", set=free).warnings
    assert "a force of 0.5 N RMS is more than the friction of 0 N" in note
    assert found(scenario="circle", axis="x", set=free | {"plant.force": "ideal"}).warnings == []


def test_the_force_that_is_left_out_is_shown_as_a_number() -> None:
    planned = plan(ResponseRequest(scenario="circle", axis="x"))
    assert isinstance(planned, ResponsePlan)
    assert type(planned.force) is float


def test_an_interval_holds_the_response_as_often_as_it_says() -> None:
    """Of a plant in a loop, with noise at its output that feedback brings to the command."""
    rng = np.random.default_rng(1)
    count, periods, lines = 12, 3, 4000
    P, C = 0.5 - 1.0j, 2.0 + 1.0j
    R = np.exp(2j * np.pi * rng.random((count, lines)))

    def noise(*shape: int) -> np.ndarray[Any, Any]:
        return 0.2 * (rng.standard_normal(shape) + 1j * rng.standard_normal(shape))

    ripple = np.where(np.arange(count) % 2 == 0, 3.0, 1.0j)[:, None, None]
    disturbance = noise(count, periods, lines) + noise(count, 1, lines) + ripple
    U = C * (R[:, None] - disturbance) / (1.0 + C * P)
    Y = P * U + disturbance
    made = estimate(Slides(R, U, Y, np.arange(count) % 2 == 0))
    error = np.abs(np.abs(made.response) - np.abs(P))
    assert np.mean(error < made.half_width) == pytest.approx(0.95, abs=0.01)
    turned = np.abs(np.angle(made.response / P))
    assert np.mean(turned < made.half_width / np.abs(P)) == pytest.approx(0.95, abs=0.01)
    # Of both noises, of equal size, only one differs from period to period.
    assert np.median(made.noise / made.deviation) == pytest.approx(0.5, abs=0.05)


def test_slides_of_a_smaller_excitation_tell_what_that_changes() -> None:
    rng = np.random.default_rng(2)
    count, lines = 14, 60
    smaller = np.arange(count) >= count - 2
    R = np.exp(2j * np.pi * rng.random((count, lines))) * np.where(smaller, 0.5, 1.0)[:, None]
    P = (2.0 - 1.0j) * np.where(smaller, 1.1 * np.exp(0.05j), 1.0)[:, None]
    forward = np.arange(count) % 2 == 0
    U = R + np.where(forward, 3.0, 1.0j)[:, None]
    noise = rng.standard_normal((count, lines)) + 1j * rng.standard_normal((count, lines))
    Y = P * R + np.where(forward, 1.0j, 2.0)[:, None] + 0.02 * noise
    made = estimate(Slides(R, U[:, None], Y[:, None].repeat(2, 1), forward, None, smaller))
    assert made.response == pytest.approx(np.full(lines, 2.0 - 1.0j), rel=0.03)
    assert made.smaller is not None
    assert abs(made.smaller.ratio - 1.1 * np.exp(0.05j)) < 3.0 * made.smaller.error < 0.03


@pytest.mark.parametrize("axis", ["x", "y"])
def test_half_of_the_force_widens_the_intervals_of_margins(axis: str) -> None:
    """The linearised loop, for a vanishing force, has its margins within."""
    result = found(scenario="circle-matched", axis=axis, seconds=60.0)
    assert result.half_force is not None
    assert result.half_force.gain - 1.0 > 2.0 * result.half_force.interval > 0.0
    for name, each in result.margins.items():
        if each.model is not None:
            assert each.interval is not None
            low, high = each.interval
            assert low < each.model < high, name


def test_between_lines_a_plant_follows_the_mode_of_its_model() -> None:
    """A notch at the mode: a straight line between lines is off by degrees."""
    mode, ratio, mass = 118.0, 0.018, 3.1

    def plant(f: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
        s, w = 2j * np.pi * f, 2.0 * np.pi * mode
        return (1.0 / s**2 + 0.95 / (s**2 + 2.0 * ratio * w * s + w**2)) / mass

    f = np.geomspace(10.0, 700.0, 180)
    grid = np.unique(np.concatenate([f, np.geomspace(90.0, 150.0, 200)]))
    nearly = FittedPlant.model_construct(  # 3 % too stiff, as a model may be
        loop=ResponseDocument.model_construct(frequency=grid.tolist()),
        plant=loop_curve(np.asarray(0.97 * plant(grid), dtype=np.complex128)),
        modes=[FittedMode.model_construct(frequency=PlantValue(value=mode, error=0.1, model=None))],
    )
    fine, P, deviation = refined(f, plant(f), 0.01 * np.abs(plant(f)), nearly)
    assert np.isin(f, fine).all() and len(fine) > len(f) + 100
    np.testing.assert_allclose(P, plant(fine), rtol=1e-4)
    np.testing.assert_allclose(deviation, 0.01 * np.abs(P))
    assert refined(f, plant(f), np.abs(plant(f)), None)[0] is f


def test_a_margin_between_lines_far_apart_is_noted() -> None:
    many, few = (found(scenario="circle", axis="x", lines=lines).warnings for lines in (40, 9))
    assert not any("far apart" in each for each in many)
    assert any("far apart" in each for each in few), few


def test_the_plant_of_a_motor_is_its_linearisation(x_of_circle: MeasuredResponse) -> None:
    ratio = complex_of(x_of_circle.plant) / complex_of(x_of_circle.linearised_plant)
    sure = np.array(x_of_circle.plant.coherence) > 0.9
    assert sure.mean() > 0.9
    assert np.abs(20.0 * np.log10(np.abs(ratio[sure]))).max() < 0.5
    assert np.degrees(np.abs(np.angle(ratio[sure]))).max() < 3.0


def test_margins_are_those_of_the_linearised_loop_within_intervals(
    x_of_circle: MeasuredResponse,
) -> None:
    for name, each in x_of_circle.margins.items():
        assert each.value is not None and each.interval is not None and each.model is not None
        low, high = each.interval
        assert low <= each.value <= high, name
        assert each.value == pytest.approx(each.model, rel=0.03), name


def test_a_late_command_counts_once() -> None:
    """The delay of the controller is in its response, and not in that of the plant as well."""
    late = found(scenario="circle", axis="x", set={"variants.B.controller.delay": 1})
    ratio = complex_of(late.plant) / complex_of(late.linearised_plant)
    assert np.degrees(np.abs(np.angle(ratio[np.array(late.plant.coherence) > 0.95]))).max() < 4.0
    margin = late.margins["phase_margin"]
    assert margin.value == pytest.approx(margin.model, rel=0.04)
    assert late.fitted is not None
    assert late.fitted.delay.value == pytest.approx(0.0, abs=5e-5)


def test_a_mode_of_the_machine_is_seen() -> None:
    result = found(scenario="circle-resonant", axis="y", lines=120)
    f, plant = np.array(result.frequency), complex_of(result.plant)
    peak = f[np.argmax(np.where(f > 50.0, f**2 * np.abs(plant), 0.0))]
    mode = load_scenario("circle-resonant").plant.y.resonance.frequency
    assert peak == pytest.approx(mode, rel=0.05)


def test_the_same_seed_measures_the_same() -> None:
    request = {"scenario": "circle", "axis": "y", "seconds": 30.0, "lines": 8}
    assert found(**request) == found(**request)
    assert found(**request) != found(**request, seed=1)


def test_margins_of_a_loop_that_is_known() -> None:
    """Of ``k/(s (s + a)^2)``: gain margin ``2 a^3/k`` at a, in closed form."""
    f = np.geomspace(1.0, 300.0, 60)
    a, k = 2.0 * np.pi * 40.0, 2.0 * np.pi * 10.0 * (2.0 * np.pi * 40.0) ** 2
    s = 2j * np.pi * f
    L = k / (s * (s + a) ** 2)
    margins = measured_margins(f, L)
    assert margins["gain_margin"] == pytest.approx(2.0 * a**3 / k, rel=2e-3)
    crossover = margins["crossover"]
    assert crossover is not None
    w = 2.0 * np.pi * crossover
    assert abs(k / (1j * w * (1j * w + a) ** 2)) == pytest.approx(1.0, rel=2e-3)
    assert margins["phase_margin"] == pytest.approx(np.pi / 2.0 - 2.0 * np.arctan(w / a), abs=2e-3)
    spread = intervals(f, L, np.abs(L) * 0.01, seed=0)["gain_margin"]
    assert spread is not None and spread[0] < 2.0 * a**3 / k < spread[1]
    stiffer = Smaller(1.1, 0.001)
    wider = intervals(f, L, np.abs(L) * 0.01, seed=0, smaller=stiffer)["gain_margin"]
    assert wider is not None
    assert wider == pytest.approx((spread[0] / 1.1, spread[1]), rel=0.01)


@pytest.mark.parametrize(
    ("request_", "complaint"),
    [
        ({"velocity": 0.2, "low": 0.5}, "velocity: leaves the stroke within 2 periods of 2 s"),
        ({"velocity": 1e-6}, r"velocity: is too slow.*allowed >= 0\.00072[0-9] m/s"),
        ({"seconds": 5.0}, "seconds: is too short: 5 slides of"),
        ({"force": 60.0}, "force: is too much"),
        ({"force": 1e-300}, "force: is too small: nothing is shaken"),
        ({"low": 50.0, "high": 60.0}, "high must be at least twice low"),
        ({"variant": "Z"}, "variant: is no variant of the scenario"),
        ({"high": 999.0}, "high"),
    ],
)
def test_what_cannot_be_measured_is_refused(request_: dict[str, Any], complaint: str) -> None:
    study = {"scenario": "circle", "axis": "x"} | request_
    with pytest.raises((ConfigError, ValidationError), match=complaint):
        measure(plan(ResponseRequest.model_validate(SHORT | study)))


def test_the_command_prints_margins_and_writes_curves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "plant.csv"
    words = ["response", "circle", "--seconds", "30", "--lines", "30", "--out", str(out)]
    assert main(words) == 0
    text = capsys.readouterr().out
    assert "phase margin, deg" in text and "linearised" in text
    rows = list(csv.reader(out.read_text(encoding="utf-8").splitlines()))
    assert rows[0][:3] == ["frequency [Hz]", "plant.magnitude [m/N]", "plant.phase [rad]"]
    assert len(rows) > 20 and all(map(float, rows[1]))
    assert main([*words[:-2], "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["slides"] >= 5
    with pytest.raises(ConfigError):
        plan(ResponseRequest(scenario="circle", set={"plant.x.mass": -1.0}))


def kept(changes: dict[str, Any], name: str = "circle-resonant") -> str:
    prepared = prepare(load_scenario(name, changes))
    return library().keep(prepared, run(prepared), {}, name="shaken").id


@pytest.fixture(scope="module")
def shaken() -> str:
    """A run that followed a multisine on y."""
    return kept({"trajectory": SHAKEN})


def test_a_run_of_a_multisine_tells_what_an_experiment_does(shaken: str) -> None:
    of_run = found(run=shaken, axis="y", variant="B", seconds=60.0)
    of_experiment = found(scenario="circle-resonant", axis="y", variant="B", seconds=60.0)
    assert of_run.run == shaken
    assert of_run.slides == 14
    for name in ("crossover", "phase_margin", "gain_margin"):
        here, there = of_run.margins[name].value, of_experiment.margins[name].value
        assert here == pytest.approx(there, rel=0.06)
    assert min(of_run.plant.coherence[10:]) > 0.95


def test_slides_of_a_run_lose_lines_that_are_not_coherent() -> None:
    weak = kept({"trajectory": SHAKEN | {"acceleration": 2e-3}})
    document = found(run=weak, axis="y", variant="B")
    assert 8 <= len(document.frequency) < 40
    assert min(document.plant.coherence) >= recorded.COHERENT
    assert len(document.plant.interval) == len(document.open.phase) == len(document.frequency)
    nothing = kept({"trajectory": SHAKEN | {"acceleration": 1e-7}})
    with pytest.raises(ConfigError, match="not exciting enough"):
        found(run=nothing, axis="y", variant="B")


def test_without_its_slides_a_record_tells_the_same(
    shaken: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    of_slides = found(run=shaken, axis="y", variant="B")
    monkeypatch.setattr(recorded, "_slides_within", lambda *_: ())
    of_any = found(run=shaken, axis="y", variant="B", lines=60)
    assert of_any.slides == 1
    f = np.log(of_any.frequency)
    there = np.interp(f, np.log(of_slides.frequency), np.log(of_slides.plant.magnitude))
    sure = (np.array(of_any.plant.interval) < 0.1) & (np.abs(f - np.log(160.0)) > 0.3)
    assert sure.sum() > 15
    off = np.abs(np.log(of_any.plant.magnitude) - there)[sure]
    assert np.median(off) < 0.02
    assert np.quantile(off, 0.8) < 0.1


def test_a_part_of_a_run_has_fewer_slides(shaken: str) -> None:
    part = found(run=shaken, axis="y", start=5.0, end=30.0)
    assert part.slides == 8
    assert part.seconds == pytest.approx(25.0)


def rig(path: Path) -> tuple[np.ndarray[Any, Any], ...]:
    """Write a second of nothing and 19 of a mass of 8 kg with friction, at 1 kHz, under PD."""
    rng = np.random.default_rng(3)
    T, n, M, c = 1e-3, 20_000, 8.0, 30.0
    t = np.arange(n) * T
    r = 0.02 * np.sin(2.0 * np.pi * 0.2 * t) + 3e-6 * rng.standard_normal(n)
    position, force = np.empty(n), np.empty(n)
    p = v = last = 0.0
    for k in range(n):
        position[k] = round(p / 5e-8) * 5e-8
        e = r[k] - position[k]
        force[k] = 3e5 * e + 1.2e3 * (e - last) / T
        last = e
        for _ in range(5):
            v += 0.2 * T * (force[k] - c * v - 2.0 * np.tanh(v / 1e-4)) / M
            p += 0.2 * T * v
    rows = np.column_stack([t, 1e3 * r, 1e3 * position, force])
    head = "time [s],setpoint [mm],position [mm],force [N]"
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.10g")
    f = np.geomspace(20.0, 300.0, 40)
    z = np.exp(2j * np.pi * f * T)
    a = np.exp(-c * T / M)  # a mass with viscous friction, held over a period
    b_1, b_2 = M / c**2 * (c * T / M - 1 + a), M / c**2 * (1 - a - c * T / M * a)
    return f, (b_1 * z + b_2) / ((z - 1.0) * (z - a))


def test_a_measurement_of_a_machine_tells_its_response(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    f, true = rig(tmp_path / "rig.csv")
    assert main(["import", str(tmp_path / "rig.csv"), "--name", "rig of a response"]) == 0
    command = ["response", "--run", "rig of a response", "--axis", "x", "--json"]
    capsys.readouterr()
    assert main(command) == 0  # the set-point has become the reference
    document = MeasuredResponse.model_validate_json(capsys.readouterr().out)
    here = (np.array(document.frequency) > 20.0) & (np.array(document.frequency) < 300.0)
    at = np.log(np.array(document.frequency)[here])
    magnitude = np.exp(np.interp(at, np.log(f), np.log(np.abs(true))))
    ratio = np.array(document.plant.magnitude)[here] / magnitude
    assert here.sum() > 15
    assert np.abs(20.0 * np.log10(ratio)).max() < 0.6
    reverses, other, controller, rate = document.warnings
    assert reverses.startswith("it reverses 8 times")
    assert reverses.endswith("without a reversal is from 8.782 s to 11.218 s")
    assert other.startswith(OTHER)
    assert "no controller" in controller
    assert "1000 Hz" in rate
    of_run = {"run": document.run, "axis": "x"}
    for column in ("M.x.thrust", "M.x.position_measured", "M.x.following_error"):
        with pytest.raises(ConfigError, match="depend on the loop") as refused:
            plan(ResponseRequest.model_validate(of_run | {"excitation_column": column}))
        assert refused.value.errors[0].loc == "excitation_column"
    mapped = ["--map", "setpoint [mm]=-", "--name", "rig without"]
    assert main(["import", str(tmp_path / "rig.csv"), *mapped]) == 0
    capsys.readouterr()
    assert main(["response", "--run", "rig without", "--axis", "x", "--json"]) == 0
    direct = MeasuredResponse.model_validate_json(capsys.readouterr().out)
    assert "feedback" in direct.warnings[1]


@pytest.mark.parametrize(
    ("request_", "word"),
    [
        ({"run": "r-aaaaaaaaaaaa"}, "run"),
        ({"variant": "C"}, "no variant of the run"),
        ({"start": 100.0}, "start: lies after the end"),
        ({"end": 10.0}, "too few whole slides"),
    ],
)
def test_a_run_that_cannot_tell_is_refused(
    shaken: str, request_: dict[str, Any], word: str
) -> None:
    with pytest.raises(ConfigError, match=word):
        found(**({"run": shaken, "axis": "y"} | request_))


def test_a_circle_does_not_excite_enough() -> None:
    plain = kept({}, "circle-matched")
    with pytest.raises(ConfigError, match="not exciting enough"):
        found(run=plain, axis="y", variant="B")


def test_an_axis_that_does_not_move_is_not_exciting(shaken: str) -> None:
    with pytest.raises(ConfigError, match="not exciting enough"):
        found(run=shaken, axis="x", variant="B")


def test_columns_are_of_a_run() -> None:
    with pytest.raises(ValidationError, match="name that as run"):
        ResponseRequest.model_validate({"force_column": "F"})
