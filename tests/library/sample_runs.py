"""Runs that were never run, for tests of the index."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import sqlalchemy as sa

from motionlab.library import index, migrations
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


def made_by(url: str, version: str, *runs: RunDetail) -> None:
    """Make an index as an earlier version of its tables had it, with runs."""
    from alembic import command
    from alembic.config import Config

    config = Config()
    config.set_main_option("script_location", str(Path(migrations.__file__).parent))
    engine = sa.create_engine(url)
    with engine.begin() as connection:
        config.attributes["connection"] = connection
        command.upgrade(config, version)
        tables = sa.MetaData()
        tables.reflect(connection)
        for number, run in enumerate(runs, 1):
            key = number if "number" in tables.tables["runs"].columns else run.id
            fields = run.model_dump(mode="json") | {"run": key, "words": run.name}
            fields["entry"] = {name: fields[name] for name in index._ENTRY}
            fields["record"] = {name: fields[name] for name in index._RECORD}
            rows = {"runs": [fields], "run_words": [fields], "run_documents": [fields]}
            rows["run_tags"] = [{"run": key, "tag": tag} for tag in run.tags]
            rows["run_metrics"] = [
                {"run": key, "metric": name, "value": value} for name, value in run.metrics.items()
            ]
            for name, some in rows.items():
                for row in some if name in tables.tables else []:
                    table = tables.tables[name]
                    values = {key: value for key, value in row.items() if key in table.columns}
                    connection.execute(sa.insert(table).values(values))  # numbers by themselves
    engine.dispose()
