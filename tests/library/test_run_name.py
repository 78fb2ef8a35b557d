"""Names of runs that nobody has named."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from motionlab.config.load import load_scenario
from motionlab.library.library import Library
from motionlab.library.new_run import live_run
from motionlab.library.run import Event, RunDetail
from motionlab.library.run_name import run_name
from motionlab.library.trajectories import Trajectories

STAR = {"kind": "star", "circumradius": 0.02, "frequency": 0.25}
LAW = "variants.B.controller.compensation.law"


def gain(name: str, x: float, y: float, letters: str = "AB") -> dict[str, float]:
    values = {"x": x, "y": y}
    return {f"variants.{v}.controller.{a}.{name}": values[a] for v in letters for a in "xy"}


def begun(changes: dict[str, Any], *, drive: str = "") -> RunDetail:
    return live_run(load_scenario("circle", changes), "r-aaaaaaaaaaaa", 0.0, drive=drive)


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({}, "circle"),
        ({"variants.B.controller.x.k_p": 4e5}, "circle, B k_p x 400 N/mm"),
        (gain("k_p", 4e5, 4e5), "circle, k_p 400 N/mm"),
        (gain("k_p", 400.6e3, 561e3), "circle, k_p \u00d7 2"),
        (gain("k_p", 400.6e3, 561e3, "B"), "circle, B k_p \u00d7 2"),
        (gain("k_p", 4e5, 5e5), "circle, k_p x 400 N/mm, k_p y 500 N/mm"),
        (
            {"seed": 7, "load.x": 3.0, "plant.x.friction.F_s": 5.0, LAW: "published-k"},
            "circle, B K as published, plant F_s x 5 N and 2 more",
        ),
        ({"variants.B.controller.compensation.enabled": False}, "circle, B compensation off"),
        ({"variants.B.controller": "lugre-full"}, "circle, B lugre-full"),
        ({"trajectory.radius": 0.02}, "circle, radius 20 mm"),
        ({"trajectory.center.x": -0.01}, "circle, centre x \u221210 mm"),
        ({"trajectory": "pentagram"}, "pentagram"),
        ({"trajectory": "pentagram", "seed": 7}, "pentagram, seed 7"),
        ({"trajectory": STAR}, "star"),
        ({"load.steps": [{"time": 1.0, "x": 2.0}]}, "circle, load steps changed"),
    ],
)
def test_a_name_says_what_differs(
    changes: dict[str, Any], name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    assert begun(changes).name == name


def test_a_path_of_ones_own_names_the_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    Trajectories().put("my-star", STAR)
    run = begun({"trajectory": STAR, "variants.B.controller.x.k_p": 4e5})
    assert run.name == "my-star, B k_p x 400 N/mm"
    path, gain = run.differences
    assert (path.path, path.shipped, path.value) == ("trajectory", "circle", "my-star")
    assert gain.path == "variants.B.controller.x.k_p"


def test_a_drive_names_its_variant_and_what_was_set() -> None:
    tables = load_scenario("circle").model_dump(mode="json")
    tables["variants"] = {"B": tables["variants"]["B"]}
    changes = {"variants.B.controller.delay": 1, "variants.B.controller.x.k_p": 4e5}
    run = live_run(load_scenario(tables, changes), "r-aaaaaaaaaaaa", 0.0, drive="Virtual drive")
    assert run.name == "circle B on Virtual drive, k_p x 400 N/mm"
    assert [each.path for each in run.differences] == [
        "variants.A",
        "variants.B.controller.x.k_p",
        "variants.B.controller.delay",
    ]


@pytest.mark.parametrize(
    ("stopped", "words"), [("STOP", "stopped at 4.2 s"), ("link lost", "fault at 4.2 s")]
)
def test_a_name_says_how_a_run_ended(stopped: str, words: str) -> None:
    run = begun({}).model_copy(update={"stopped": stopped, "stopped_at": 4.2})
    assert run_name(run) == f"circle, {words}"


def test_a_live_run_is_named_by_its_changes_unless_a_person_did(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    library = Library(tmp_path)
    run = begun({})
    event = Event(tick=10, kind="change", set={"variants.B.controller.x.k_p": 4e5})
    monkeypatch.setattr("motionlab.library.spool.begun", lambda *_: (run, [event]))
    library.index.put(run)
    library.list_changes(run.id)
    assert library.get(run.id).name == "circle, B k_p x 400 N/mm"
    library.change(run.id, {"name": "mine"})
    library.list_changes(run.id)
    assert library.get(run.id).name == "mine"
    ended = run.model_copy(update={"name": "circle, stopped at 1 s"})
    assert library.index.finish(ended).name == "mine"
