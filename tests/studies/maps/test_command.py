"""``motionlab map`` and its page: the file, what is kept, what is refused, and cancelling."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from typing import Any

import numpy as np
import pytest

from motionlab.cli import main
from motionlab.errors import ConfigError, StoreError
from motionlab.motor_design.computed_maps import computed_or_kept
from motionlab.motor_design.fem import compute as computing
from motionlab.motor_design.fem.compute import compute
from motionlab.motor_design.fem.force_map import ForceMapDocument, content_hash
from motionlab.motor_design.fem.geometry import Geometry, geometry
from motionlab.motor_design.fem.mesh import Resolution
from motionlab.motor_design.fem.workers import FieldTask, fields
from motionlab.motor_design.kept_maps import MapStore, map_in
from tests.paths import DOCS
from tests.processes import runs, workers_of
from tests.server.live import until
from tests.server.servers import PATIENCE
from tests.studies.maps.noted_current import NotedCurrent

PAGE = (DOCS / "maps.md").read_text()
PREVIEW = ["map", "--preset", "preview"]
VERY_COARSE = Resolution(12, 1)
SMALL = geometry({"n": 1, "limb": 3e-3, "coil": 2e-3})

# what is set, and what the complaint must say
BAD = {
    "a wrong key": (["gap=1e-4"], ["gap", "unknown key", "0.0001"]),
    "no gap": (["g=0"], ["g:", "is out of range", "0", ">= 2e-05 and <= 0.005 m"]),
    "teeth as wide as the pitch": (
        ["p=7.2e-3"],
        ["geometry", "teeth overlap", "p = 0.0072 m", "tau = 0.0072 m"],
    ),
    "teeth wider than the pitch": (["p=8e-3"], ["teeth overlap", "p = 0.008 m"]),
    "hardly a slot": (["p=7e-3"], ["p/tau = 0.972", ">= 0.1 and <= 0.9"]),
    "a gap like a slot": (["g=3e-3"], ["g = 0.003 m", "half of a slot, 0.0018 m"]),
    "a limb wider than its shoe": (["limb=19e-3"], ["limb = 0.019 m", "0.018 m"]),
    "coils in each other": (["coil=11e-3"], ["coils overlap", "0.011 m", "0.0108 m"]),
    "negative depth": (["l_m=-1.0"], ["l_m", "-1.0", ">= 0.001 and <= 1 m"]),
    "half a tooth": (["n=2.5"], ["n:", "must be a whole number", "2.5"]),
    "infinity": (["i=inf"], ["i:", "must be a finite number"]),
    "text": (["tau=wide"], ["tau", "must be a number", "'wide'"]),
    "two things": (["g=0", "N=0"], ["g:", "N:"]),
}


@pytest.fixture(autouse=True)
def _data(tmp_path, monkeypatch):
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path / "data"))


@pytest.fixture(scope="module")
def preview():
    return compute(Geometry(), "preview")


@pytest.mark.parametrize("case", BAD)
def test_bad_geometry_is_refused_with_the_wrong_number(case, capsys):
    assignments, expected = BAD[case]
    arguments = [word for text in assignments for word in ("--set", text)]
    assert main([*PREVIEW, *arguments]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    for text in expected:
        assert text in err


def test_the_command_prints_tables_and_keeps_the_map(capsys, tmp_path):
    assert main(PREVIEW) == 0
    first, err = capsys.readouterr()
    assert "thrust dW'/dx, N" in first
    assert "computed before" not in err
    kept = list((tmp_path / "data" / "maps").iterdir())
    assert [path.name for path in kept] == [f"{content_hash(Geometry(), 'preview')}.json"]
    assert main(PREVIEW) == 0
    again, err = capsys.readouterr()
    assert again == first
    assert "computed before" in err


def test_json_and_the_file_are_the_same_document(capsys, tmp_path):
    out = tmp_path / "map.json"
    assert main([*PREVIEW, "--json", "--out", str(out), "--set", "g=0.4e-3"]) == 0
    printed = capsys.readouterr().out
    assert out.read_text() == printed
    assert json.loads(printed)["geometry"]["g"] == 0.4e-3
    assert out.stat().st_mode & 0o777 == 0o644


@pytest.mark.parametrize(
    ("target", "message"),
    [("map.npz", "names ending in .json"), ("nowhere/map.json", "folder does not exist")],
)
def test_a_target_that_cannot_be_is_refused_first(target, message, capsys, tmp_path):
    assert main([*PREVIEW, "--out", str(tmp_path / target)]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "data").exists()


def test_a_folder_that_cannot_be_written_fails(capsys, tmp_path):
    (tmp_path / "data").write_text("")
    assert main(PREVIEW) == 1
    assert "cannot be written" in capsys.readouterr().err


def test_a_map_survives_its_file(preview, tmp_path):
    path = tmp_path / "map.json"
    path.write_text(preview.text())
    found = map_in(path, str(path))
    assert found.document == preview.document
    x, i = np.linspace(-9e-3, 9e-3, 50), np.linspace(0, 10, 50)
    assert np.array_equal(found.thrust(x, i), preview.thrust(x, i))


def test_a_file_that_is_no_map_is_refused(preview, tmp_path):
    tables = preview.document.model_dump(mode="json")
    wrong = {
        "not JSON": "{",
        "unknown key": {**tables, "extra": 1},
        "format": {**tables, "format": "other"},
        "coenergy must have 25 rows": {**tables, "coenergy": tables["coenergy"][1:]},
        "positions must run evenly": {**tables, "positions": tables["positions"][::-1]},
        "currents must rise evenly": {**tables, "currents": tables["currents"][::-1]},
    }
    path = tmp_path / "map.json"
    for message, content in wrong.items():
        path.write_text(content if isinstance(content, str) else json.dumps(content))
        with pytest.raises(ConfigError, match=message) as caught:
            map_in(path, str(path))
        assert str(path) in str(caught.value)
    with pytest.raises(ConfigError, match="No such file"):
        map_in(tmp_path / "none.json", "none")


def test_a_map_is_found_by_what_it_depends_on(preview, tmp_path):
    store = MapStore(tmp_path / "maps")
    assert store.find(Geometry(), "preview") is None
    path = store.keep(preview)
    found = store.find(Geometry(), "preview")
    assert found is not None
    assert found.document == preview.document
    shipped = store.find(Geometry(), "default")  # of the same geometry as new-design
    assert shipped is not None
    assert store.find(Geometry(g=0.31e-3), "preview") is None
    path.write_text("damaged")
    assert store.find(Geometry(), "preview") is None
    assert computed_or_kept(store, Geometry(), "preview")[1] is False
    assert computed_or_kept(store, Geometry(), "preview")[1] is True


def test_a_kept_map_is_not_computed_again(preview, tmp_path, monkeypatch):
    store = MapStore(tmp_path / "maps")
    store.keep(preview)
    monkeypatch.setattr("motionlab.motor_design.computed_maps.compute", pytest.fail)
    assert computed_or_kept(store, Geometry(), "preview")[1] is True


def test_a_full_disk_is_told(preview, tmp_path, monkeypatch):
    def full(*_args, **_options):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("tempfile.mkstemp", full)
    with pytest.raises(StoreError, match="No space left"):
        MapStore(tmp_path).keep(preview)
    assert list(tmp_path.iterdir()) == []


def test_the_map_repeats_and_is_symmetric(preview):
    x, i = np.linspace(-3.5e-3, 3.5e-3, 41), 7.0
    assert preview.thrust(x + 3 * 7.2e-3, i) == pytest.approx(preview.thrust(x, i), abs=1e-9)
    assert preview.thrust(-x, i) == pytest.approx(-preview.thrust(x, i), abs=1e-6)
    assert preview.coenergy(-x, i) == pytest.approx(preview.coenergy(x, i), abs=1e-9)


@pytest.mark.parametrize("current", [-0.1, 10.1, float("nan")])
def test_a_current_outside_of_the_map_is_refused(current, preview):
    with pytest.raises(ValueError, match="currents must be 0 to 10 A"):
        preview.thrust(0.0, current)


def test_the_corners_of_a_cell_give_its_bicubic(preview):
    w, w_x, w_i, w_xi = preview.hermite()
    d = preview.document
    a, b = 15, 4
    x_0, x_1, i_0, i_1 = *d.positions[a : a + 2], *d.currents[b : b + 2]
    h, k = x_1 - x_0, i_1 - i_0
    corners = np.block(
        [
            [w[a : a + 2, b : b + 2], k * w_i[a : a + 2, b : b + 2]],
            [h * w_x[a : a + 2, b : b + 2], h * k * w_xi[a : a + 2, b : b + 2]],
        ]
    )

    def basis(t):
        return np.array(
            [2 * t**3 - 3 * t**2 + 1, 3 * t**2 - 2 * t**3, t**3 - 2 * t**2 + t, t**3 - t**2]
        )

    s, t = 0.3, 0.8
    value = basis(s) @ corners @ basis(t)
    assert value == pytest.approx(float(preview.coenergy(x_0 + s * h, i_0 + t * k)), rel=1e-9)


def test_workers_find_what_one_process_finds(monkeypatch):
    monkeypatch.setattr(computing, "CURRENTS", 3)
    shares = []
    many = compute(SMALL, resolution=VERY_COARSE, workers=2, progress=shares.append)
    one = compute(SMALL, resolution=VERY_COARSE, workers=1)
    assert many.document == one.document
    assert shares == sorted(shares)
    assert shares[-1] == 1


class Enough(Exception):
    """Raised by a progress function."""


def test_progress_can_cancel():
    def cancel(share):
        if share > 0:
            raise Enough

    with pytest.raises(Enough):
        compute(SMALL, resolution=VERY_COARSE, workers=1, progress=cancel)


def test_cancelling_ends_the_fields_that_are_sought(tmp_path):
    sought = tmp_path / "sought"
    sought.touch()
    currents: Any = [0.0, *(NotedCurrent(0.5, sought) for _ in range(50))]
    work = FieldTask(SMALL, VERY_COARSE, currents, list(range(7)))
    done = 0

    def cancel(_share):
        nonlocal done
        done = sought.stat().st_size
        if done:
            raise Enough

    with pytest.raises(Enough):
        fields(work, workers=2, progress=cancel)
    assert workers_of(os.getpid()) == []
    # Each of both workers ends what it has begun; of 350 fields hardly another is begun.
    begun = sought.stat().st_size
    assert done <= begun < 100
    time.sleep(0.3)
    assert sought.stat().st_size == begun


def test_an_interrupt_ends_the_command_and_its_workers(tmp_path):
    own = tmp_path / "own"
    own.mkdir()
    process = subprocess.Popen(
        [sys.executable, "-m", "motionlab", "map", "--set", "g=0.31e-3"],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        env={**os.environ, "MOTIONLAB_DATA": str(own)},
    )
    try:
        assert process.stderr is not None
        assert "force map 0 %" in process.stderr.readline()
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=PATIENCE)
    finally:
        process.kill()
    assert process.returncode == 130
    assert out == ""
    assert "interrupted" in err
    assert "Traceback" not in err
    assert list(own.iterdir()) == []


@pytest.mark.skipif(len(os.sched_getaffinity(0)) < 2, reason="one core has no workers")
def test_workers_end_when_the_command_is_killed(tmp_path):
    process = subprocess.Popen(
        [sys.executable, "-m", "motionlab", "map", "--set", "g=0.31e-3"],
        stderr=subprocess.DEVNULL,
        env={**os.environ, "MOTIONLAB_DATA": str(tmp_path)},
    )
    try:
        until(lambda: len(workers_of(process.pid)) > 1)
        workers = workers_of(process.pid)
    finally:
        process.kill()
        process.wait()
    until(lambda: not any(runs(worker) for worker in workers))


def test_the_page_lists_every_field_and_key():
    for name in [*Geometry.model_fields, *ForceMapDocument.model_fields]:
        assert re.search(rf"`{name}`", PAGE), name
    for name, preset in computing.PRESETS.items():
        assert f"`{name}`" in PAGE
        assert preset.method in PAGE
