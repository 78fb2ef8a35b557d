"""Motor sizing by equations (1) to (14), and the rating of dimensions."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from motionlab.studies.study import Command, Models, Progress, Source, Study

if TYPE_CHECKING:
    from motionlab.design.document import DesignDocument

_EXAMPLES = """\
examples:
  motionlab design
  motionlab design --json --set requirements.f_max=50
  motionlab design --set dimensions.single_phase_force=38.4
  motionlab design --set preset=previous
"""


class Sizing(Study["DesignDocument", "DesignDocument"]):
    """Size a motor by the paper's equations (1) to (14), as printed beside corrected.

    An empty table is the paper's example.
    """

    kind = "design"
    path = "/design"
    operation = "design"
    tag = "design"
    bodies = (
        {"requirements": {"f_max": 50.0}},
        {"preset": "previous"},
    )
    direct = True
    light = True
    command = Command(
        name="design",
        help="size a motor, and rate its dimensions",
        description="Size a motor by the paper's equations (1) to (14): from requirements to "
        "dimensions and from dimensions to limits, as printed beside corrected. The paper's "
        "example is the default; docs/design.md lists the fields.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of requirements or dimensions, SI (repeatable, all applied together)",
    )

    def models(self) -> Models:
        """Return the types of request and document."""
        from motionlab.design.document import DesignDocument
        from motionlab.design.inputs import DesignRequest

        return Models(DesignRequest, DesignDocument)

    def plan(self, request: Mapping[str, Any], source: Source | None = None) -> DesignDocument:
        """Return the design, which takes no longer than checking it; see `Study.plan`."""
        from motionlab.design.design import design

        return design(request)

    def run(self, plan: DesignDocument, progress: Progress) -> DesignDocument:
        """Return the design."""
        return plan

    def report(self, found: DesignDocument) -> str:
        """Return printed and corrected values as tables."""
        from motionlab.design.report import report

        return report(found)

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request that ``--set`` makes."""
        from motionlab.config.changes import as_tables

        return as_tables(changes)
