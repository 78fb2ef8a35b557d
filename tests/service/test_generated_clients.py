"""Clients that generators make from the OpenAPI document, without a warning."""

from __future__ import annotations

import compileall
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

GENERATE = (sys.executable, "-m", "openapi_python_client", "generate", "--fail-on-warning")


def test_a_python_client_of_every_operation(tmp_path: Path, document: dict[str, Any]) -> None:
    path, config, client = (tmp_path / name for name in ("api.json", "config.json", "client"))
    path.write_text(json.dumps(document), encoding="utf-8")
    config.write_text(json.dumps({"post_hooks": []}), encoding="utf-8")  # which only format
    asked = ("--path", str(path), "--config", str(config), "--output-path", str(client))
    done = subprocess.run((*GENERATE, *asked), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stdout + done.stderr
    assert compileall.compile_dir(client, quiet=1)

    (package,) = client.glob("*/client.py")
    made = [m for m in (package.parent / "api").rglob("*.py") if m.name != "__init__.py"]
    operations = [o for methods in document["paths"].values() for o in methods.values()]
    assert len(made) == len(operations)
    for module in made:  # typed, and not merely called
        assert "sync_detailed(" in module.read_text(encoding="utf-8"), module


def test_every_accepted_job_is_of_one_kind(document: dict[str, Any]) -> None:
    kinds: dict[str, str] = {}
    for path, methods in document["paths"].items():
        for operation in methods.values():
            if "202" not in operation["responses"]:
                continue
            (content,) = operation["responses"]["202"]["content"].values()
            assert content["schema"].keys() == {"$ref"}, path
            report = document["components"]["schemas"][content["schema"]["$ref"].split("/")[-1]]
            kinds[path.rpartition("/")[2]] = report["properties"]["kind"]["const"]
    assert kinds == {
        "simulate": "simulate",
        "sweep": "frequency-sweep",
        "maps": "map",
        "identify": "identify",
        "montecarlo": "monte-carlo",
        "reproduce": "reproduce",
        "tune": "tune",
        "landscape": "landscape",
        "replay": "replay",
    }
