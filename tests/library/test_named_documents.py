"""Named documents: rows on SQLite and PostgreSQL alike, bounded, and what earlier versions left."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import sqlalchemy as sa

from motionlab.config.named_configs import config_root
from motionlab.errors import ConfigError, StoreFull, Unknown
from motionlab.library.gain_sets import GainSet, gain_sets
from motionlab.library.index import Index
from motionlab.library.job_records import RecordStore
from motionlab.library.layouts import ScopeLayout, layouts
from motionlab.library.maps import ForceMaps
from motionlab.library.motors import Motors
from motionlab.library.table_documents import TableDocuments
from motionlab.library.tables import GAIN_SETS, LAYOUTS
from motionlab.library.trajectories import Trajectories
from tests.library.sample_runs import made_by

K_P = "variants.B.controller.x.k_p"
STIFF: dict[str, Any] = {
    "name": "stiff",
    "created": 1000.0,
    "note": "rig",
    "scenario": "circle",
    "values": {K_P: 312000.0},
    "metrics": {"B.x.max_abs_following_error": 2e-6},
    "margins": {"B.x": {"gain_margin": None, "phase_margin": 1.1}},
}


def gain_set(name: str, created: float) -> GainSet:
    return GainSet.model_validate(STIFF | {"name": name, "created": created})


def test_rows_are_replaced_listed_newest_first_and_deleted(index: Index) -> None:
    store = TableDocuments(index, GAIN_SETS, GainSet, "gain set")
    old, new = gain_set("a", 1000.0), gain_set("b", 2000.0)
    for each in (new, old, old):
        assert store.put(each) == each
    assert store.all() == [new, old]
    store.put(newest := gain_set("a", 3000.0))
    assert store.all() == [newest, new]
    assert store.get("a") == newest
    store.delete("a")
    for call in (store.get, store.delete):
        with pytest.raises(Unknown, match="no gain set 'a'"):
            call("a")
    assert store.all() == [new]


def test_rows_are_bounded(index: Index) -> None:
    store = TableDocuments(index, LAYOUTS, ScopeLayout, "layout", count_max=2)
    for name in ("b", "a"):
        store.put(ScopeLayout(name=name, scopes=["A.x.thrust"]))
    with pytest.raises(StoreFull, match="2 layouts are saved already; delete one"):
        store.put(ScopeLayout(name="c", scopes=["A.x.thrust"]))
    store.put(ScopeLayout(name="b", scopes=["B.x.thrust"]))
    assert [(each.name, each.scopes[0][0]) for each in store.all()] == [("a", "A"), ("b", "B")]


MOTOR = """\
description = "Fitted"
base = "nominal"

[x]
mass = 6.1

[origin]
run = "r-abcdefghijkl"
run_name = "circle A"
recorded = "2026-11-23T14:44:16+00:00"
notes = []

[origin.fits."x.mass"]
value = 6.1
low = 6.0
high = 6.2
before = 5.9
unit = "kg"
"""
TRAJECTORY = """\
kind = "path"
points = [
    [0.0, 0.0],
    [0.01, 0.02],
]
v_max = 0.1
a_max = 1.0
"""


@pytest.fixture
def data(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder of data as version 0006 of the index has left it."""
    monkeypatch.setenv("MOTIONLAB_DATA", str(tmp_path))
    monkeypatch.delenv("MOTIONLAB_DATABASE_URL", raising=False)
    shipped_map = (config_root() / "maps" / "new-design.json").read_text()
    for place, text in {
        "motors/rig-7.toml": MOTOR,
        "trajectories/mine.toml": TRAJECTORY,
        "maps/0123456789abcdef.json": shipped_map,
        "jobs/abcdefghijkl.jsonl": '{"id":"abcdefghijkl"}\n{"result":1}\n',
    }.items():
        path = tmp_path / place
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    address = f"sqlite:///{tmp_path / 'runs.sqlite'}"
    made_by(address, "0006")
    engine = sa.create_engine(address)
    with engine.begin() as connection:
        for statement, values in {
            "INSERT INTO gain_sets VALUES (:n, 1000.0, :d)": {"n": "stiff", "d": json.dumps(STIFF)},
            "INSERT INTO layouts VALUES (:n, :d)": {"n": "errors", "d": '["A.x.thrust@0.5"]'},
        }.items():
            connection.execute(sa.text(statement), values)
    engine.dispose()
    return tmp_path


def test_what_earlier_versions_kept_is_read(data: Path) -> None:
    assert gain_sets().all() == [GainSet.model_validate(STIFF)] == [gain_sets().get("stiff")]
    assert layouts().all() == [ScopeLayout(name="errors", scopes=["A.x.thrust@0.5"])]
    motor = Motors().get("rig-7")
    assert (motor.description, motor.plant["x"]["mass"], motor.shipped) == ("Fitted", 6.1, False)
    assert motor.origin is not None
    assert motor.origin.fits["x.mass"].before == 5.9
    trajectory = Trajectories().get("mine")
    assert (trajectory.kind, trajectory.trajectory["v_max"]) == ("path", 0.1)
    kept = ForceMaps().get("0123456789abcdef")
    assert (kept.shipped, len(ForceMaps().all())) == (False, 3)
    records = RecordStore(data / "jobs")
    assert records.summaries() == [b'{"id":"abcdefghijkl"}\n']
    assert records.read("abcdefghijkl") == b'{"result":1}\n'


def test_a_damaged_file_is_an_error_of_its_own(data: Path) -> None:
    (data / "motors" / "rig-7.toml").write_text("x = [")
    (data / "trajectories" / "mine.toml").write_text('kind = "none"')
    (data / "maps" / "0123456789abcdef.json").write_text("{}")
    for store, name in (
        (Motors(), "rig-7"),
        (Trajectories(), "mine"),
        (ForceMaps(), "0123456789abcdef"),
    ):
        with pytest.raises(ConfigError):
            store.get(name)
        store.delete(name)
        with pytest.raises(Unknown, match=f"no {store.noun} '{name}'"):
            store.get(name)
