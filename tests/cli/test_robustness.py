"""What a hostile user or a broken machine meets: one line and the right exit code."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from motionlab.config.changes import parse_assignments
from motionlab.config.load import load_scenario
from motionlab.errors import ConfigError, Infeasible
from motionlab.lanes import model_hash
from motionlab.lanes.compiler import cache
from motionlab.simulation.prepare import prepare
from motionlab.simulation.result import document
from motionlab.simulation.run import run
from motionlab.telemetry import recorder
from tests.recordings import noise

SHORT = 'trajectory={kind="point",duration=0.05}'
MOTIONLAB = [sys.executable, "-m", "motionlab"]


def shell(command: str, **environment: str) -> subprocess.CompletedProcess[str]:
    motionlab = " ".join(MOTIONLAB)
    return subprocess.run(
        ["bash", "-c", command.replace("motionlab", motionlab, 1)],
        capture_output=True,
        text=True,
        check=False,
        env=os.environ | environment,
    )


@pytest.mark.parametrize("buffered", ["", "1"])
def test_a_full_disk_behind_stdout_is_told(buffered: str) -> None:
    done = shell("motionlab show circle > /dev/full", PYTHONUNBUFFERED=buffered)
    assert done.returncode == 1
    assert done.stderr.startswith("motionlab: ")
    assert "No space left" in done.stderr
    assert "Traceback" not in done.stderr


@pytest.mark.parametrize("arguments", ["show circle", "run --help"])
def test_a_reader_that_leaves_early_is_no_failure(arguments: str) -> None:
    done = shell(f"motionlab {arguments} | true; exit ${{PIPESTATUS[0]}}")
    assert (done.returncode, done.stderr) == (0, "")


def test_a_closed_stdout_is_told() -> None:
    done = shell(f"motionlab run circle --set '{SHORT}' >&-")
    assert done.returncode == 1
    assert "stdout is closed" in done.stderr


def test_a_closed_stdin_is_told() -> None:
    done = shell("motionlab run - <&-")
    assert (done.returncode, done.stderr) == (2, "motionlab: stdin: is closed\n")


def test_bytes_that_are_no_text_are_no_name_and_no_folder() -> None:
    named = shell(f"motionlab run circle --set '{SHORT}' --keep --name $'\\xff'")
    kept = shell(f"MOTIONLAB_DATA=$'/tmp/\\xff' motionlab run circle --set '{SHORT}' --keep")
    for done, field in ((named, "--name"), (kept, "MOTIONLAB_DATA")):
        assert done.returncode == 2
        assert done.stderr.startswith(f"motionlab: {field}: holds half of a surrogate pair")


SWEEP = f"motionlab sweep circle --set '{SHORT}' --grid plant.x.mass=5:6:2 --json"


@pytest.mark.parametrize("stderr", ["2>&-", "2>/dev/full", "2> >(true)"])
def test_no_stderr_ends_a_study(stderr: str) -> None:
    done = shell(f"sleep 0.1; {SWEEP} {stderr}" if ">(" in stderr else f"{SWEEP} {stderr}")
    assert done.returncode == 0
    assert json.loads(done.stdout)["cases"] == 2  # and nothing else on stdout


def test_a_refusal_keeps_its_code_without_stderr() -> None:
    for stderr in ("2>&-", "2>/dev/full"):
        done = shell(f"motionlab show circle --set seed=-1 {stderr}")
        assert (done.returncode, done.stdout) == (2, "")


def test_another_broken_pipe_than_that_of_stdout_is_a_failure() -> None:
    broken = (
        "import motionlab.cli.study as study; from motionlab.cli import main\n"
        "def share_done(_): raise BrokenPipeError(32, 'Broken pipe')\n"
        "study.share_done = share_done\n"
        f"raise SystemExit(main(['sweep', 'circle', '--set', '{SHORT}', '--grid', 'seed=1,2']))"
    )
    done = subprocess.run(
        [sys.executable, "-c", broken], capture_output=True, text=True, check=False
    )
    assert done.returncode == 1
    assert "Broken pipe" in done.stderr


def test_a_letter_that_the_terminal_lacks_stops_nothing() -> None:
    command = "motionlab show circle --set variants.A.label=\u00e9"
    done = shell(command, PYTHONIOENCODING="ascii")
    assert (done.returncode, done.stderr) == (0, "")
    assert "\\xe9" in done.stdout


@pytest.mark.parametrize(
    "assignment",
    [
        "seed=" + "9" * 5000,
        "seed=0x" + "f" * 5000,
        "load.x=" + "[" * 3000,
        "a" + ".a" * 3000 + "=1",
        "plant.x.amplifiers.offset.\u00b2=0.3",
        "plant.x.amplifiers.offset.3=0.3",
        "plant.x.mass=5.9\nseed=3",
        "base=rhombus",
    ],
)
def test_odd_settings_are_refused(assignment: str) -> None:
    with pytest.raises(ConfigError) as caught:
        load_scenario("circle", parse_assignments([assignment]))
    assert len(str(caught.value)) < 8000


def test_a_file_with_a_byte_order_mark_is_read(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text('base = "circle"\nseed = 5\n', encoding="utf-8-sig")
    assert load_scenario(file).seed == 5


def test_a_file_nested_too_deeply_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("a = " + "[" * 5000)
    with pytest.raises(ConfigError, match="nested too deeply"):
        load_scenario(file)


def test_a_setting_reaches_into_a_default() -> None:
    offset = load_scenario("circle", {"plant.x.amplifiers.offset.1": 0.3}).plant.x.amplifiers.offset
    assert offset == (0.0, 0.3, 0.0)


def test_setting_a_base_swaps_the_part_whole() -> None:
    by_base = load_scenario("circle", {"plant.base": "matched"})
    assert by_base == load_scenario("circle", {"plant": "matched"})


def test_a_mass_that_one_step_would_throw_about_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"plant\.x: mass = 0\.05 kg is too small for stop_damp"):
        load_scenario("circle", {"plant.x.mass": 0.05})
    with pytest.raises(ConfigError, match=r"too small for friction\.sigma_1: .* >= 13 kg"):
        load_scenario("circle", {"plant.x.friction.sigma_1": 1.3e5})


def test_the_lightest_mass_allowed_stays_put_below_stiction() -> None:
    changes = {
        "trajectory": {"kind": "point", "duration": 0.3},
        "plant.x.mass": 0.2,
        "variants.A.controller.x": {"k_p": 0.0, "k_d": 0.0},
        "load.x": 0.1,
    }
    record = run(prepare(load_scenario("circle", changes))).variants["A"]
    rest = -0.1 / 118913.2532  # the bristle carries the load, and creeps a little
    assert record.channel("position", "x")[-1] == pytest.approx(rest, rel=0.03)


def test_a_force_command_at_its_limit_is_flagged_without_compensation() -> None:
    changes = {
        "trajectory": {"kind": "step", "height": {"x": 10e-6}, "dwell": 0.2},
        "variants.A.controller.x.k_p": 1e7,
        "plant.force": "ideal",
    }
    record = run(prepare(load_scenario("circle", changes))).variants["A"]
    at_limit = np.abs(record.channel("force_command", "x")) >= 40.0
    assert at_limit.any()
    assert np.array_equal(record.channel("force_saturated", "x") == 1.0, at_limit)


def test_a_change_that_makes_the_motion_infeasible_is_refused() -> None:
    event = {"time": 5.0, "set": {"plant.x.stroke": 0.001}}
    with pytest.raises(Infeasible) as caught:
        prepare(load_scenario("circle", {"schedule": [event]}))
    assert caught.value.time == 5.0
    assert caught.value.quantity == "position"


def test_each_segment_tells_the_law_in_effect() -> None:
    event = {"time": 5.0, "set": {"variants.B.controller": "published-k", "plant": "matched"}}
    prepared = prepare(load_scenario("circle", {"schedule": [event]}))
    result = document(prepared, run(prepared))
    assert [s["variants"]["B"]["law"] for s in result["segments"]] == [
        "lugre-observer",
        "published-k",
    ]
    assert result["plant"] == "matched"
    assert any("does not work" in note for note in result["variants"]["B"]["notes"])


def test_force_steps_after_the_end_are_refused_in_a_schedule_too() -> None:
    event = {"time": 1.0, "set": {"load.steps": [{"time": 60.0, "x": 1.0}]}}
    with pytest.raises(ConfigError, match=r"schedule\.0\.set\.load\.steps\.0\.time"):
        prepare(load_scenario("circle", {"schedule": [event]}))


def test_a_replaced_file_keeps_its_permissions_and_a_link_stays(tmp_path: Path) -> None:
    file = tmp_path / "run.csv"
    file.touch(mode=0o600)
    link = tmp_path / "link.csv"
    link.symlink_to(file)
    recorder.write(noise(3), str(link), metadata={})
    assert link.is_symlink()
    assert file.stat().st_size > 0
    assert stat.S_IMODE(file.stat().st_mode) == 0o600


def test_a_new_file_heeds_the_umask(tmp_path: Path) -> None:
    before = os.umask(0o077)
    try:
        recorder.write(noise(3), str(tmp_path / "run.csv"), metadata={})
    finally:
        os.umask(before)
    assert stat.S_IMODE((tmp_path / "run.csv").stat().st_mode) == 0o600


def test_compiled_code_is_never_taken_from_a_folder_that_others_can_write(tmp_path: Path) -> None:
    folder = tmp_path / f"kernel-{model_hash()}"
    folder.mkdir()
    folder.chmod(0o777)
    assert cache._writable(tmp_path) is None
    folder.chmod(0o755)
    assert cache._writable(tmp_path) == folder
