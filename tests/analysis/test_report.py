"""The table that the command line prints."""

from __future__ import annotations

import pytest

from motionlab.reports.result_text import report
from motionlab.simulation.result import document
from tests.simulated import SHORT, play


def test_every_metric_is_compared() -> None:
    played = play("circle", SHORT)
    result = document(played.prepared, played.recording)
    row = next(line for line in report(result).splitlines() if "max contouring error" in line)
    a, b, ratio = map(float, row.split()[-3:])
    assert ratio == pytest.approx(b / a, rel=0.01)
