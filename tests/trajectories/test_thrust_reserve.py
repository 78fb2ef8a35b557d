"""Feasible motions leave feedback some of the thrust."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tomli_w

import motionlab
from motionlab.cli.main import main
from motionlab.config.load import epochs, load_scenario
from motionlab.config.planar import AXES
from motionlab.errors import Infeasible
from motionlab.force_sharing.ripple import reachable_over
from motionlab.kernel.force_maps import force_model
from motionlab.lanes.bank import TABLES
from motionlab.simulation.loop_check import Loops, run_loops
from motionlab.simulation.prepare import limit_sets, planned_for, prepare
from motionlab.trajectories.trajectory_check import examine
from tests.trajectories.random_splines import random_splines

FAST = {"kind": "path", "law": "time_optimal", "v_max": 1.0, "a_max": 10.0, "j_max": 2000.0}


@pytest.mark.parametrize("law", ["least-norm", "least-normal-force", "force-per-ampere", "sine"])
@pytest.mark.parametrize("force_map", [None, "new-design"])
def test_the_available_thrust_is_realised_in_full(law: str, force_map: str | None) -> None:
    changes: dict[str, Any] = {"thrust_reserve": 0.2, "variants.B.controller.sharing.law": law}
    if force_map is not None:
        changes |= {
            "plant.force_map": force_map,
            "variants.B.controller.model.force_map": force_map,
        }
    scenario = load_scenario("circle", changes)
    limits = limit_sets(tuple(epochs(scenario)))[-1][1]
    controller = scenario.variants["B"].controller
    with TABLES.lease():
        config = controller.model.y.force_map
        model = force_model(config, controller.sharing, controller.current_limit)
        place = np.random.default_rng(1).uniform(-0.1, 0.1, 50)
        for sign in (-1.0, 1.0):
            whole = reachable_over(model, position=place, forward=sign > 0.0)
            available = limits.available_thrust(1, place, np.full(50, sign))
            expected = 0.8 * np.minimum(whole, controller.force_limit)
            assert available == pytest.approx(expected, rel=2e-3)
            assert (available >= limits.sure_thrust[1]).all()


def test_planning_leaves_the_reserve() -> None:
    least = [
        min(planned_for(load_scenario("circle", {"thrust_reserve": reserve})).y.forward)
        for reserve in (0.0, 0.12)
    ]
    assert least[0] == pytest.approx(27.30, abs=0.05)
    assert least[1] == pytest.approx(0.88 * least[0], rel=1e-4)


@pytest.mark.filterwarnings("ignore::motionlab.RunWarning")  # A diverges, and B is at its limits
def test_feedback_keeps_motions_at_the_limit_of_thrust() -> None:
    for path in random_splines(seed=902, count=3):
        limited = []
        for reserve in (0.0, 0.12):
            changes = {"trajectory": path | FAST, "thrust_reserve": reserve}
            run = motionlab.run("circle", set=changes | {"variants.B.controller": "lugre-full"})
            free = [run[f"B.{axis}.current_saturated"] == 0.0 for axis in AXES]
            limited.append(1.0 - float(np.mean(np.min(free, axis=0))))
            errors = [np.abs(run[f"B.{axis}.following_error"]).max() for axis in AXES]
        assert limited[0] > 0.3  # planned for all that the sharing realises
        assert limited[1] < 0.08  # at reversals, where friction changes its sign
        assert max(errors) < 30e-6


@pytest.mark.filterwarnings("ignore::motionlab.RunWarning")  # both are at their limits
def test_the_check_tells_which_loops_reach_their_limits(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    path = next(random_splines(seed=902, count=1)) | FAST
    file = tmp_path / "path.toml"
    file.write_text(tomli_w.dumps(path))
    assert main(["check", str(file), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert main(["check", str(file)]) == 0
    printed = capsys.readouterr().out
    assert "can be followed, but A and B reach their limits;" in printed
    result = motionlab.run("circle", set={"trajectory": path}).document
    assert document["loops_window"] == [result["window"]["start"], result["window"]["end"]]
    assert document["loops_not_run"] is None
    for each in document["loops"]:
        axes = result["variants"][each["variant"]]["axes"]
        for key in ("saturated_fraction", "max_abs_following_error"):
            assert each[key] == {axis: axes[axis][key] for axis in AXES}
        assert each["saturated_fraction"]["y"] > 0.1
        assert f"{100 * each['saturated_fraction']['y']:.3g} %" in printed
    assert not document["loops"][1]["feedforward"]


def test_the_check_tells_that_no_loop_reaches_its_limits(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["check", "circle", "--json"]) == 0
    loops = json.loads(capsys.readouterr().out)["loops"]
    assert [each["variant"] for each in loops] == ["A", "B"]
    assert all(each["saturated_fraction"] == {"x": 0.0, "y": 0.0} for each in loops)
    assert main(["check", "circle"]) == 0
    assert capsys.readouterr().out.startswith("circle: can be followed; ")


def test_a_loop_that_diverges_is_at_its_limits(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["check", "circle", "--set", "divergence_error=1e-5"]
    assert main([*arguments, "--json"]) == 0
    loops = json.loads(capsys.readouterr().out)["loops"]
    assert [each["diverged"] for each in loops] == [True, False]
    assert main(arguments) == 0
    first, *_, row, _other, _about = capsys.readouterr().out.splitlines()
    assert first.startswith("circle: can be followed, but A reaches its limits; ")
    assert row.split()[-5:] == ["-", "-", "-", "-", "diverged"]


@pytest.mark.parametrize(
    ("change", "code", "reason"),
    [
        ("trajectory.laps=60", 0, "the motion takes 181.5 s, more than 120 s"),
        ("trajectory.frequency=3.0", 1, "the motor cannot follow the motion"),
        ("window={start=1.0,end=99.0}", 0, "window.end: lies after the end of the trajectory"),
    ],
)
def test_the_check_tells_why_no_loop_was_run(
    change: str, code: int, reason: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "circle", "--set", change, "--json"]) == code
    document = json.loads(capsys.readouterr().out)
    assert document["loops"] is None
    assert document["loops_window"] is None
    assert document["loops_not_run"].startswith(reason)
    assert main(["check", "circle", "--set", change]) == code
    assert f"The loops of the variants were not run: {reason}" in capsys.readouterr().out


def test_many_variants_are_not_run_by_the_check() -> None:
    scenario = load_scenario("circle", {"trajectory.laps": 35})
    variants = dict.fromkeys("ABCDEF", scenario.variants["B"])
    scenario = scenario.model_copy(update={"variants": variants})
    found = examine(scenario.trajectory, limit_sets(tuple(epochs(scenario))), bins=10)
    assert run_loops(scenario, found) == Loops(
        loops_not_run="6 variants of 106.5 s each are more than 600 s of simulated time"
    )


def test_the_refusal_and_the_check_say_the_reserve(capsys: pytest.CaptureFixture[str]) -> None:
    changes = {"trajectory": "trapezoid-y", "trajectory.thrust_reserve": 0.12}
    with pytest.raises(Infeasible, match=r"12 % are left to feedback \(thrust_reserve\)"):
        prepare(load_scenario("circle", changes))
    assert main(["check", "circle"]) == 0
    assert "The limit of thrust leaves 12 % to feedback" in capsys.readouterr().out


def test_the_motion_may_have_a_reserve_of_its_own() -> None:
    motion = motionlab.trajectory("trapezoid-y")
    assert motion.feasible
    assert motion.check.reserve == 0.01
    assert motionlab.trajectory("circle").check.reserve == 0.12
