"""The command line: exit codes, the result document, complaints, and what it leaves behind."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pyarrow.parquet as pq
import pytest

from motionlab import __version__
from motionlab.cli import main
from motionlab.config.named_configs import names

QUICK = ["--set", "trajectory.laps=1", "--set", "trajectory.lead_in=0.5"]
# A bare environment with what numba needs to find its cache, so that nothing is compiled anew.
ENVIRONMENT = {
    key: value
    for key, value in os.environ.items()
    if key in {"HOME", "PATH", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "TMPDIR"}
}
METRICS = {"max_abs_following_error", "rms_following_error", "itae", "rms_force"} | {
    "saturated_fraction",
    "rms_current",
    "settling_time",
    "overshoot",
    "steady_state_error",
}


def command(*arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run the installed command as a user does."""
    program = Path(sys.executable).with_name("motionlab")
    return subprocess.run(
        [program, *arguments],
        cwd=cwd,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


def refuse_constant(text: str) -> Any:
    raise AssertionError(f"JSON does not know {text}")


def parse(text: str) -> Any:
    """Return the one document of a text; NaN and Infinity are refused."""
    return json.loads(text, parse_constant=refuse_constant)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Stand in an empty folder far from the checkout."""
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    return folder


# -- a run ----------------------------------------------------------------------------------------


def test_circle_as_a_user_runs_it(tmp_path: Path) -> None:
    done = command("run", "circle", "--json", cwd=tmp_path)
    assert done.returncode == 0
    assert done.stderr == ""
    assert done.stdout.count("\n") == 1
    result = parse(done.stdout)
    errors = {
        variant: {axis: m["max_abs_following_error"] * 1e6 for axis, m in entry["axes"].items()}
        for variant, entry in result["variants"].items()
    }
    assert 18.5 <= errors["A"]["x"] <= 22.5
    assert 20.0 <= errors["A"]["y"] <= 25.0
    assert errors["B"]["x"] <= 3.0
    assert errors["B"]["y"] <= 4.5
    assert list(tmp_path.iterdir()) == []


def test_the_result_document(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle", "--json"]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    result = parse(printed.out)
    assert result["scenario"] == "circle"
    assert result["seed"] == 2019
    assert result["plant"] == "nominal"
    assert result["version"] == __version__
    # the last two periods, after at least one
    assert result["window"] == {"start": 4.5, "end": 10.5}
    assert list(result["variants"]) == ["A", "B"]
    assert [variant["law"] for variant in result["variants"].values()] == ["off", "lugre-observer"]
    for variant in result["variants"].values():
        assert variant["diverged"] is None
        assert variant["notes"] == []
        assert set(variant["axes"]) == {"x", "y"}
        for metrics in variant["axes"].values():
            assert set(metrics) >= METRICS
    A, B = result["variants"].values()
    for axis, ratios in result["comparison"].items():
        quotient = B["axes"][axis]["rms_force"] / A["axes"][axis]["rms_force"]
        assert ratios["rms_force_ratio"] == pytest.approx(quotient)
        assert ratios["max_abs_following_error_ratio"] < 0.2
    assert len(result["segments"]) == 1
    assert set(result["segments"][0]) == {"window", "variants", "comparison"}
    assert result["segments"][0]["variants"] == result["variants"]
    assert list(here.iterdir()) == []


def test_the_same_run_prints_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    printed = []
    for _ in range(2):
        main(["run", "circle", "--json", *QUICK])
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]


def test_fig5_has_two_segments(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "fig5", "--json"]) == 0
    result = parse(capsys.readouterr().out)
    before, after = result["segments"]
    assert before["window"]["end"] == 90.0
    assert 90.0 < after["window"]["start"] < after["window"]["end"] == 180.0
    for variant in "AB":
        for axis in "xy":
            first, second = (
                segment["variants"][variant]["axes"][axis]["max_abs_following_error"]
                for segment in (before, after)
            )
            assert second < first


def test_published_k_says_that_it_does_not_work(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle-published-k", "--json"]) == 0
    result = parse(capsys.readouterr().out)
    notes = " ".join(result["variants"]["B"]["notes"])
    assert "does not work" in notes
    for axis in "xy":
        ratio = result["comparison"][axis]["max_abs_following_error_ratio"]
        assert ratio > 1.0
        assert f"{ratio:.3g} times on {axis}" in notes
    assert result["variants"]["A"]["notes"] == []


def test_a_table_for_people(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", "circle", *QUICK]) == 0
    printed = capsys.readouterr()
    assert printed.err == ""
    for word in ("circle", "nominal", "B/A", "max abs following error", "um"):
        assert word in printed.out
    assert not printed.out.startswith("{")


@pytest.mark.parametrize(
    ("setting", "plant"),
    [
        ("plant=matched", "matched"),
        ("plant.x.mass=6.0", "nominal (changed)"),
        ("seed=2019", "nominal"),
    ],
)
def test_the_document_names_the_plant(
    setting: str, plant: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "circle", "--json", *QUICK, "--set", setting]) == 0
    assert parse(capsys.readouterr().out)["plant"] == plant


def test_settings_apply_together_in_any_order(capsys: pytest.CaptureFixture[str]) -> None:
    settings = ["plant.x.mass=6.0", "plant=as-measured", "trajectory.laps=1", "trajectory=rhombus"]
    printed = []
    for order in (settings, settings[::-1]):
        assert main(["run", "circle", "--json", *(f"--set={setting}" for setting in order)]) == 0
        printed.append(capsys.readouterr().out)
    assert printed[0] == printed[1]


def test_a_file_of_ones_own(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (here / "mine.toml").write_text(
        'base = "circle"\nseed = 7\ntrajectory = { base = "circle", laps = 1 }\n'
    )
    assert main(["run", "mine.toml", "--json"]) == 0
    result = parse(capsys.readouterr().out)
    assert (result["scenario"], result["seed"]) == ("mine", 7)


@pytest.mark.parametrize("suffix", [".parquet", ".csv"])
def test_out_writes_every_channel(
    here: Path, suffix: str, capsys: pytest.CaptureFixture[str]
) -> None:
    from motionlab.telemetry.channels import CHANNELS

    arguments = ["run", "circle", "--json", "--out", f"run{suffix}"]
    short = ["--set", 'trajectory={ kind = "dwell", duration = 0.1 }']
    assert main([*arguments, *short]) == 0
    parse(capsys.readouterr().out)
    assert [path.name for path in here.iterdir()] == [f"run{suffix}"]
    expected = {f"{v}.{a}.{c.name}" for v in "AB" for a in "xy" for c in CHANNELS}
    if suffix == ".parquet":
        table = pq.read_table(here / "run.parquet")
        assert set(table.column_names) >= expected
        assert table.num_rows == 200
    else:
        lines = (here / "run.csv").read_text().splitlines()
        assert all(any(name in cell for cell in lines[0].split(",")) for name in expected)
        assert len(lines) >= 201


def test_a_diverged_variant(here: Path, capsys: pytest.CaptureFixture[str]) -> None:
    limp = ["--set", "variants.B.controller.x.k_p=0", "--set", "variants.B.controller.x.k_d=0"]
    limp += ["--set", "variants.B.controller.compensation.law=off"]
    assert main(["run", "circle", "--json", *QUICK, *limp]) == 1
    printed = capsys.readouterr()
    result = parse(printed.out)
    B = result["variants"]["B"]
    assert B["diverged"]["channel"] == "x.following_error"
    assert 0.0 < B["diverged"]["time"] < result["window"]["end"]
    assert B["diverged"]["last_states"]
    assert set(B["axes"]) == {"x", "y"}
    assert all(value is None for metrics in B["axes"].values() for value in metrics.values())
    assert all(v is None for ratios in result["comparison"].values() for v in ratios.values())
    A = result["variants"]["A"]
    assert A["diverged"] is None
    assert A["axes"]["x"]["max_abs_following_error"] == pytest.approx(20.5e-6, rel=0.02)
    assert "variant B: diverged at t = " in printed.err
    assert "x.following_error" in printed.err
    # and for people
    assert main(["run", "circle", *QUICK, *limp]) == 1
    assert "circle" in capsys.readouterr().out
    assert list(here.iterdir()) == []


# -- help -----------------------------------------------------------------------------------------


def test_version(tmp_path: Path) -> None:
    done = command("--version", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (0, f"motionlab {__version__}\n")
    module = subprocess.run(
        [sys.executable, "-m", "motionlab", "--version"],
        cwd=tmp_path,
        env=ENVIRONMENT,
        capture_output=True,
        text=True,
        check=True,
    )
    assert module.stdout == done.stdout


def test_help_is_helpful(capsys: pytest.CaptureFixture[str]) -> None:
    for arguments in (["--help"], ["run", "--help"]):
        with pytest.raises(SystemExit) as left:
            main(arguments)
        assert left.value.code == 0
    text = " ".join(capsys.readouterr().out.split())
    for word in ("--set KEY=VALUE", "--out FILE", "--json", "motionlab run circle", "SI"):
        assert word in text
    for name in names("scenarios"):
        assert name.replace("-", "") in text.replace("-", "").replace(" ", "")


@pytest.mark.parametrize(
    ("line", "answer"),
    [
        ("rnu", "motionlab: no such COMMAND, did you mean 'run'?; got 'rnu'"),
        ("fly circle", "motionlab: no such COMMAND; got 'fly'"),
        ("--versoin", "motionlab: no option --versoin, did you mean '--version'?"),
        ("compare", "motionlab compare: A, B is missing"),
        ("run circle --fast", "motionlab run: no option --fast"),
        ("run circle --sett=a=1", "motionlab run: no option --sett, did you mean '--set'?"),
        ("run circle square", "motionlab run: nothing here takes 'square'"),
        ("run circle --set", "motionlab run: --set: expected one argument"),
        ("openapi --yaml", "motionlab openapi: no option --yaml"),
        ("runs --limit many", "motionlab runs: --limit: is not a whole number; got 'many'"),
        (
            "tune --axis z",
            "motionlab tune: no such --axis; got 'z'; allowed one of x, y, both",
        ),
        (
            "view balbar circle",
            "motionlab view: no such VIEW, did you mean 'ballbar'?; got 'balbar'; allowed one of "
            "ballbar, contouring, cost, friction, positioning",
        ),
    ],
)
def test_wrong_usage(line: str, answer: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(line.split())
    assert left.value.code == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    what, where = printed.err.splitlines()
    assert what == answer
    assert where == f"`{answer.split(':', maxsplit=1)[0]} --help` shows what there is"


@pytest.mark.parametrize("arguments", [[], ["help"], ["--help"]])
def test_help(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main(arguments)
    assert not left.value.code
    assert "usage: motionlab" in capsys.readouterr().out
