"""Runs that were never run, for tests of the index."""

from __future__ import annotations

from typing import Any

from motionlab.library.run import Difference, RunDetail, new_id


def sample(**changed: Any) -> RunDetail:
    """Return a kept simulation, some of its fields changed."""
    fields: dict[str, Any] = {
        "id": new_id(),
        "kind": "simulation",
        "state": "complete",
        "name": "circle",
        "scenario": "circle",
        "note": "",
        "tags": [],
        "pinned": False,
        "created": 1_800_000_000.0,
        "duration": 10.0,
        "ticks": 20_000,
        "period": 0.0005,
        "size": 1000,
        "variants": ["A", "B"],
        "labels": {"A": "off", "B": "lugre-observer"},
        "differences": [Difference(path="plant.x.mass", shipped=5.0, value=6.0)],
        "metrics": {},
        "thumbnail": {"reference": [0, 0, 1000, 1000]},
        "seed": 2019,
        "version": "0",
        "model": "0" * 16,
        "processor": "generic",
        "maps": {},
        "scenario_document": {"name": "circle"},
        "events": [],
        "result": {},
        "columns": [],
    }
    return RunDetail(**fields | changed)
