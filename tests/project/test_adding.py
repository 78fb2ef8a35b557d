"""A view and a metric, each one file and one line: every surface offers them then."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

FIXTURES = Path(__file__).parent.parent / "fixtures" / "adding"

# Adds what a newcomer would, before anything else of the project is imported; then uses it.
WITH_BOTH = """
import sys
import motionlab.analysis.views as views
from motionlab.analysis import metrics
from motionlab.analysis.views import table

sys.path.append({fixtures!r})
views.__path__.append({fixtures!r})
table.VIEWS += (table.View("smoothness", "Smoothness", "Jerk of the reference", False, 4),)
table.BY_NAME.update({{view.name: view for view in table.VIEWS}})
from span_of_error import SPAN
metrics.DEFINITIONS["span_of_error"] = SPAN
"""


def run(code: str) -> str:
    """Return what code prints in a process of its own, where the fixtures are part of the lab."""
    words = [sys.executable, "-c", WITH_BOTH.format(fixtures=str(FIXTURES)) + code]
    return subprocess.run(words, capture_output=True, text=True, check=True).stdout


def test_a_view_is_one_module_and_one_line() -> None:
    out = run(
        "from motionlab.cli import main\n"
        "main(['view', 'smoothness', 'circle'])\n"
        "main(['view', 'smoothness', 'circle', '--json'])\n"
        "main(['openapi'])\n"
    )
    text, document, openapi = out.split("\n", 2)
    assert text.startswith("jerk max  ")
    assert json.loads(document)["jerk_max"] > 0
    assert "/api/v1/views/smoothness" in json.loads(openapi)["paths"]


def test_a_metric_is_one_definition() -> None:
    out = run(
        "from motionlab.cli import main\n"
        "main(['run', 'circle', '--json'])\n"
        "main(['run', 'circle'])\n"
        "main(['sweep', 'circle', '--grid', 'seed=1,2', '--json'])\n"
        "from motionlab.server.routes.fields import _scenario\n"
        "print(_scenario().decode())\n"
    )
    result, *text, sweep, served = out.splitlines()
    result, sweep, served = (json.loads(line) for line in (result, sweep, served))
    axis = result["variants"]["A"]["axes"]["x"]
    span = axis["max_following_error"] - axis["min_following_error"]
    assert axis["span_of_error"] == span
    assert "span_of_error_ratio" in result["comparison"]["x"]
    assert sum("range of the error" in line for line in text) == len("xy")
    assert "span_of_error" in json.dumps(sweep)
    assert served["metrics"]["span_of_error"]["rank"] == "other"
