"""Motor sizing by equations (1) to (14), and the rating of dimensions."""

from __future__ import annotations

import argparse
from typing import Any

from motionlab.studies.study import Study, StudyCommand, lazy

_EXAMPLES = """\
examples:
  motionlab design
  motionlab design --json --set requirements.f_max=50
  motionlab design --set dimensions.single_phase_force=38.4
  motionlab design --set preset=previous
"""


class SizingStudy(Study):
    """Size a motor by the paper's equations (1) to (14), as printed beside corrected.

    An empty table is the paper's example.
    """

    kind = "design"
    path = "/design"
    operation = "design"
    tag = "design"
    request_model = lazy("motor_design.inputs:DesignRequest")
    document_model = lazy("motor_design.document:DesignDocument")
    read = lazy("motor_design.design:design")
    report = lazy("studies.design_text:report")
    bodies = (
        {"requirements": {"f_max": 50.0}},
        {"preset": "previous"},
    )
    direct = True
    light = True
    command = StudyCommand(
        name="design",
        help="size a motor, and rate its dimensions",
        description="Size a motor by the paper's equations (1) to (14): from requirements to "
        "dimensions and from dimensions to limits, as printed beside corrected. The paper's "
        "example is the default; `motionlab docs design` lists the fields.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of requirements or dimensions, SI (repeatable, all applied together)",
    )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request that ``--set`` makes."""
        from motionlab.config.changes import as_tables

        return as_tables(changes)
