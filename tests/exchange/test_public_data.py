"""Commands of docs/public-data.md, on files of the layouts that it describes."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io
from numpy.typing import NDArray

from motionlab.cli.main import main
from tests.paths import ROOT

Array = NDArray[Any]

PAGE = (ROOT / "docs" / "public-data.md").read_text()
EMPS = {"M": 95.1089, "sigma_2": 203.5034, "F_c": 20.3935, "f_0": -3.1648}
GTAU = 35.150651882485469


def commands(section: str) -> list[str]:
    """Return the commands of a section, its variables filled in."""
    part = PAGE.split(f"\n## {section}\n")[1].split("\n## ")[0]
    lines = re.findall(r"^    (.*)$", part, re.MULTILINE)
    variables = dict(line.split("=") for line in lines if re.match(r"[A-Z]+=", line))
    for name, value in variables.items():
        lines = [line.replace(f"${name}", value) for line in lines]
    return [line for line in lines if line.startswith("motionlab ")]


def run(command: str, capsys: pytest.CaptureFixture[str], *more: str) -> str:
    assert main([*shlex.split(command)[1:], *more]) == 0
    return capsys.readouterr().out


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))
    return tmp_path


def identified(document: str) -> dict[str, dict[str, Any]]:
    """Return value and interval of each parameter of sliding."""
    return json.loads(document)["axes"]["x"]["sliding"]["parameters"]


def contains(parameter: dict[str, Any], truth: float, *, times: float = 2.0) -> None:
    """Assert that an interval, made `times` as wide, has the truth in it."""
    value, low, high = (parameter[name] for name in ("value", "low", "high"))
    assert value - times * (value - low) <= truth <= value + times * (high - value), parameter


def moved(force: Any, friction: Any, mass: float, steps: int, period: float) -> tuple[Array, ...]:
    """Return position, velocity and force of a mass, by small explicit steps.

    `force` is of step, position and velocity, as a controller has it.
    """
    x = v = 0.0
    rows = np.empty((3, steps))
    for k in range(steps):
        f = force(k, x, v)
        rows[:, k] = x, v, f
        for _ in range(10):
            v += period / 10 * (f - friction(v)) / mass
            x += period / 10 * v
    return tuple(rows)


def emps(path: Path) -> None:
    """Back and forth at four speeds under a cascade of P and P, as the authors' controller."""
    rng, period, steps = np.random.default_rng(2), 9.999839611217580e-04, 12_000
    acceleration = np.zeros(steps + 2000)
    k = 0
    for stroke in range(40):
        speed, sign = (0.12, 0.03, 0.09, 0.06)[stroke % 4], 1 - 2 * (stroke % 2)
        ramp, slide = int(speed / 0.83 / period), int(0.035 / speed / period)
        for share, count in ((sign, ramp), (0, slide), (-sign, ramp), (0, 60)):
            acceleration[k : k + count] = 0.83 * share
            k += count
        if k > steps:
            break
    reference = np.cumsum(np.cumsum(acceleration) * period) * period
    volts = np.zeros(steps)

    def force(k: int, x: float, v: float) -> float:
        measured = round(x / 5e-8) * 5e-8
        volts[k] = np.clip(
            243.45 * (160.18 * (reference[k] - measured) - v) + rng.normal(0, 0.02), -10, 10
        )
        return GTAU * volts[k]

    def friction(v: float) -> float:
        return EMPS["f_0"] + EMPS["sigma_2"] * v + EMPS["F_c"] * np.tanh(v / 1e-4)

    position, _, _ = moved(force, friction, EMPS["M"], steps, period)
    columns = {
        "t": np.arange(steps) * period,
        "qm": np.round(position / 5e-8) * 5e-8,
        "qg": reference[:steps],
        "vir": volts,
    }
    vectors = {name: values[:, None] for name, values in columns.items()}
    scipy.io.savemat(path, {**vectors, "gtau": GTAU, "kp": 160.18, "kv": 243.45, "tec": period})


def test_emps(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    emps(folder / "DATA_EMPS.mat")
    importing, identifying, comparing = commands("EMPS")
    out = run(importing, capsys)
    assert "gtau: not read, is a single number, 35.1506519" in out
    assert "M.x.following_error: computed" in out
    parameters = identified(run(identifying, capsys, "--json"))
    for name in ("M", "sigma_2", "f_0"):
        contains(parameters[name], EMPS[name])
        assert parameters[name]["value"] == pytest.approx(EMPS[name], rel=0.02)
    F_c, F_s, v_s, sigma_2 = (parameters[n]["value"] for n in ("F_c", "F_s", "v_s", "sigma_2"))
    for v in (0.03, 0.06, 0.09, 0.12):
        fitted = F_c + (F_s - F_c) * np.exp(-((v / v_s) ** 2)) + sigma_2 * v
        assert fitted == pytest.approx(EMPS["F_c"] + EMPS["sigma_2"] * v, rel=0.02)
    compared = json.loads(run(comparing, capsys, "--json"))
    assert compared["selected"] == "coulomb"
    (coulomb,) = (each for each in compared["models"] if each["name"] == "coulomb")
    for name, value in EMPS.items():
        assert coulomb["parameters"][name]["value"] == pytest.approx(value, rel=2e-3)


def test_hsm150(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng, period, steps = np.random.default_rng(4), 1e-3, 20_000
    inertia, viscous, coulomb = 1.2153e-4, 6.9498e-5, 0.012
    torque = np.where(np.arange(steps) < steps // 2, -0.03, -0.04)
    angle, velocity, _ = moved(
        lambda k, *_: torque[k],
        lambda w: viscous * w + coulomb * np.tanh(w / 0.05),
        inertia,
        steps,
        period,
    )
    counts = np.round(angle / (2 * np.pi / 10_000)) * (2 * np.pi / 10_000)
    noisy = torque + rng.normal(0, 2e-4, steps)
    time = np.arange(steps) * period
    data = np.c_[time, 0 * time, counts, velocity, noisy, noisy, noisy / 0.0458]
    scipy.io.savemat(folder / "idf_neg_0.04_1.mat", {"data": data})
    importing, identifying = commands("HSM150")
    run(importing, capsys)
    document = run(identifying, capsys, "--json")
    contains(identified(document)["sigma_2"], 1e6 * viscous)
    assert "it moves one way only" in document
    for letters in ("J = 1.2153e-4", "B = 6.9498e-5", "--mass 121.53"):
        assert letters in PAGE


def test_openarm(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rng, steps = np.random.default_rng(8), 10_365
    time = np.cumsum(rng.uniform(0.0015, 0.0025, steps))
    arrays = {name: np.zeros((steps, 7)) for name in ("q", "qd", "tau_friction")}
    for joint in range(7):
        for amplitude, rate, phase in ((0.5, 0.9, joint), (0.2, 2.3, 2), (0.08, 5.1, joint + 1)):
            arrays["q"][:, joint] += amplitude * np.sin(rate * time + phase)
            arrays["qd"][:, joint] += amplitude * rate * np.cos(rate * time + phase)
    speed = arrays["qd"]
    friction = 0.168 * np.tanh(speed / 0.03) + 0.02 * speed - 0.05
    arrays["tau_friction"] = friction + rng.normal(0, 0.02, speed.shape)
    arrays["tau_rigid"] = 1.5 * np.cos(arrays["q"])
    arrays["tau_measured"] = arrays["tau_rigid"] + friction
    np.savez(
        folder / "real_friction_identification_joint_6.npz",
        time=time,
        clean_mask=np.ones(steps, bool),
        **arrays,  # pyright: ignore[reportArgumentType]
    )
    looking, importing, identifying = commands("OpenArm")
    run(looking, capsys)
    assert "resampled from" in run(importing, capsys)
    parameters = identified(run(identifying, capsys, "--json"))
    assert parameters["F_c"]["value"] == pytest.approx(1.68, rel=0.05)
    assert parameters["f_0"]["value"] == pytest.approx(-0.5, rel=0.05)
    contains(parameters["M"], 0.0)


def rack(folder: Path) -> float:
    """Write both files; return what is to be added to the cell's time."""
    late, rng = 0.004, np.random.default_rng(6)

    def speed(t: Array) -> Array:
        stroke = np.clip((t - 0.05) / 0.45, 0, 1)
        return 0.35 * np.sin(np.pi * stroke) ** 2 * (1 + 0.1 * np.sin(60 * t))

    def force(t: Array) -> Array:
        slope = (speed(t + 1e-4) - speed(t - 1e-4)) / 2e-4
        return 24.7 * slope + 60 * np.tanh(speed(t) / 0.02) + 40 * speed(t)

    drive = np.arange(1024) * 0.666666e-3
    rows = [f"{1e3 * t:f},{-v / (20 / 1000 / 60):.0f},{-1 - f / 16:.1f}" for t, v, f in zip(
        drive, speed(drive), force(drive), strict=True)]  # fmt: skip
    rest = ",0.000000" * 5 + ",2.500000" + ",0.000000" * 7
    signals = ",".join(f"Analog {k}" for k in range(1, 8))
    digital = ",".join(f"Digital {k}" for k in range(1, 9))
    (folder / "a3MR.csv").write_text(
        "Axis1\nNumber of sampling data,1024\nSampling time interval(ms),0.667\n"
        f"Time,{signals},{digital}\nms,Servo motor speed,Torque,Droop pulses (by 1 pls.)"
        f"{',Not selected' * 4},INP{',Not selected' * 7}\n"
        + "".join(f"{row}{rest}\n" for row in rows)
    )
    cell = np.arange(1078) * 0.0005
    volts = -0.129 - force(cell + late) / 200 + rng.normal(0, 2e-3, cell.size)
    (folder / "a3NI.csv").write_text(
        "Timestamp,2020-03-16 17:04:51,Timestamp,2020-03-16 17:04:51\n"
        'Interval,0.0005,Interval,0.0005\nChannel name,"Force",Channel name,"Input 1"\n'
        'Unit,"V",Unit,"V"\n'
        + "".join(f"{t:.10g},{f!r},{t:.10g},{8 * t - 3.2!r}\n" for t, f in zip(
            cell.tolist(), volts.tolist(), strict=True))
    )  # fmt: skip
    return late


def test_two_clocks(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    late = rack(folder)
    (importing,) = commands("Rack and pinion, two clocks")
    (speed,) = re.findall(r"`(--map 'Servo motor speed=[^`]*)`", PAGE)
    document = json.loads(run(importing, capsys, *shlex.split(speed), "--json"))
    merged = document["merged"]
    assert merged["offset"] == pytest.approx(late, abs=2 * merged["offset_half_width"])
    assert merged["offset"] == pytest.approx(late, abs=0.5e-3)
    columns = {column["column"]: column["name"] for column in document["columns"]}
    assert columns["Force"] == "M.x.thrust"
    assert columns["Servo motor speed"] == "M.x.velocity_measured"
    assert main(["identify", "--run", document["run"], "--axis", "x"]) == 2
    assert "position" in capsys.readouterr().err
