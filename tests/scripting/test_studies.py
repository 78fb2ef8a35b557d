"""Studies from Python: the same documents as their commands, with rows for tables."""

from __future__ import annotations

import inspect
import json
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import motionlab
from motionlab.cli import main
from motionlab.studies.table import BY_KIND

K_P = "variants.B.controller.x.k_p"
SHORT = {"trajectory.laps": 2, "window": None}


def test_a_sweep_has_a_row_for_each_case(tmp_path: Path) -> None:
    found = motionlab.sweep(
        "circle",
        {K_P: np.array([1e5, 4e5]), "plant.x.mass": {"start": 5.0, "stop": 6.0, "count": 3}},
    )
    frame: Any = found.to_pandas()
    assert list(frame[K_P]) == [1e5] * 3 + [4e5] * 3
    assert list(frame["plant.x.mass"]) == [5.0, 5.5, 6.0] * 2
    run = motionlab.run("circle", {K_P: 4e5, "plant.x.mass": 5.5})
    error = "max_abs_following_error"
    assert frame[f"B.x.{error}"][4] == pytest.approx(run.metrics["B"]["x"][error], rel=1e-5)
    assert json.loads(found.save(tmp_path / "sweep.json").read_text())["cases"] == 6
    assert found.save(tmp_path / "sweep.csv").read_text().count("\n") >= 6
    with pytest.raises(AttributeError):
        _ = found.set


def test_a_list_takes_first_values_together() -> None:
    found = motionlab.sweep(
        "circle", {K_P: [1e5, 4e5], "plant": ["nominal", "matched"]}, combine="list"
    )
    rows = found.rows()
    assert [(row[K_P], row["plant"]) for row in rows] == [(1e5, "nominal"), (4e5, "matched")]


def test_tuned_gains_go_back_into_the_scenario(capsys: pytest.CaptureFixture[str]) -> None:
    found = motionlab.tune("circle", axis="x", starts=1, evaluations=12)
    assert main(["tune", "circle", "--axis", "x", "--starts", "1", "--evaluations", "12"]) == 0
    assert capsys.readouterr().out.rstrip("\n") == str(found)
    assert found.set.keys() == {K_P, "variants.B.controller.x.k_d"}
    rms = "rms_following_error"
    before, after = motionlab.run("circle"), motionlab.run("circle", found.set)
    assert after.metrics["B"]["x"][rms] < before.metrics["B"]["x"][rms]  # type: ignore[operator]
    frame: Any = found.to_pandas()
    assert list(frame["origin"])[:2] == ["present", "paper"]
    assert frame["x.k_p"][2] == found.set[K_P]
    assert str(found) in found._repr_html_().replace("&lt;", "<").replace("&gt;", ">").replace(
        "&amp;", "&"
    )


def test_plausible_motors_are_rows() -> None:
    found = motionlab.montecarlo("circle", cases=4, spec={"x": 12e-6})
    frame: Any = found.to_pandas()
    assert len(frame) == 4
    worst = found.document.worst[0]
    assert frame[f"{worst.variant}.{worst.axis}.max_abs_following_error"][worst.case] == worst.value
    # Whoever wants to draw a metric over what was drawn has both.
    case = {path: frame[path][2] for path in frame if path.startswith("plant.x.friction.")}
    assert len(case) == 6
    alone = motionlab.run("circle", set=motions(found, 2))
    for name, variant in alone.metrics.items():
        for metric in ("rms_following_error", "rms_force", "itae"):
            expected = pytest.approx(variant["y"][metric], rel=1e-5)
            assert frame[f"{name}.y.{metric}"][2] == expected
    peaks = motionlab.montecarlo("circle", cases=4, table=False).rows()[0]
    assert len(peaks) == 1 + 4


def motions(found: Any, case: int) -> dict[str, Any]:
    """Return the changes that make a motor of a Monte Carlo study."""
    plan = found.study.plan({"scenario": "circle", "cases": found.document.cases})
    return plan.changes(case)


@pytest.mark.parametrize("kind", ["tune", "identify", "monte-carlo", "design", "sweep"])
def test_a_call_names_every_field_of_its_request(kind: str) -> None:
    """So that an editor completes them and a type checker knows them, with their defaults."""
    model = BY_KIND[kind].request_model
    call = getattr(motionlab, kind.replace("-", ""))
    parameters = inspect.signature(call).parameters
    here = set() if kind == "design" else {"scheduler"}
    assert set(parameters) == set(model.model_fields) | here
    for name, field in model.model_fields.items():
        default = parameters[name].default
        if name not in {"scenario", "set", "grid", "table"} and default not in (None, ()):
            assert default == field.default, name
        assert re.search(rf"^{name} :|^scenario, set$", inspect.cleandoc(call.__doc__), re.M), name


def test_worker_processes_do_not_run_the_script_again(tmp_path: Path) -> None:
    script = tmp_path / "script.py"
    script.write_text(
        "import motionlab\n"
        "print('begun')\n"
        "short = {'trajectory.laps': 2}\n"
        "found = motionlab.montecarlo('circle', short, cases=4, scheduler='processes:2')\n"
        "print(found.document.cases)\n"
    )
    done = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["begun", "4"]


def test_a_scheduler_that_is_none_is_refused() -> None:
    with pytest.raises(motionlab.ConfigError, match="scheduler"):
        motionlab.sweep("circle", {K_P: [1e5]}, scheduler="foo")


def test_identified_friction_has_points() -> None:
    speeds = [0.002, 0.005, 0.01, 0.02, 0.05, 0.1]
    found = motionlab.identify(
        "circle", axis="x", speeds=speeds, time_max=1.0, presliding={"enabled": False}
    )
    frame: Any = found.to_pandas()
    assert set(frame["axis"]) == {"x"}
    assert len(frame) == 2 * len(speeds)
    assert all(path.startswith("variants.B.controller.model.x.") for path in found.set)


def test_a_design_is_a_document_with_a_report() -> None:
    found = motionlab.design(requirements={"f_max": 50.0})
    assert "f_max = 50.0 N" in str(found)
    with pytest.raises(AttributeError, match="design has no rows"):
        found.rows()


def test_what_is_wrong_is_named() -> None:
    with pytest.raises(motionlab.ConfigError, match=r"variants\.B\.controller\.x\.k_q"):
        motionlab.sweep("circle", {"variants.B.controller.x.k_q": [1.0]})
    with pytest.raises(TypeError, match="objectiv"):
        motionlab.tune("circle", objectiv={"rms": 1.0})  # type: ignore[call-arg]
    with pytest.raises(motionlab.ConfigError, match="cases"):
        motionlab.montecarlo(cases=1)
