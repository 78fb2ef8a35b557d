"""Bending of a moving platform under the movers' normal forces."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.studies.study import Progress, Study, StudyCommand, lazy

if TYPE_CHECKING:
    from motionlab.motor_design.platform.document import PlatformDocument
    from motionlab.motor_design.platform.inputs import PlatformRequest

_EXAMPLES = """\
examples:
  motionlab platform
  motionlab platform --axis x --json
  motionlab platform --set new.rib_height=0.04 --set new.support=guides
  motionlab platform --map new-design

Lengths are in m, forces in N; `motionlab docs platform` lists the fields.
"""


class PlatformStudy(Study):
    """Bend two designs of a moving platform under four movers' normal forces.

    An empty table is the y platform with this project's shapes; the paper prints none.
    """

    kind = "platform"
    path = "/design/platform"
    operation = "bendPlatform"
    tag = "design"
    request_model = lazy("motor_design.platform.inputs:PlatformRequest")
    document_model = lazy("motor_design.platform.document:PlatformDocument")
    read = lazy("motor_design.platform.inputs:read_platform_request")
    bodies = (
        {"axis": "x"},
        {"axis": "y", "new": {"rib_height": 0.04}},
    )
    direct = True
    command = StudyCommand(
        name="platform",
        help="bend a moving platform under normal forces",
        description="Bend two designs of a ribbed platform under four movers' normal forces, by "
        "plate elements, and tell what is left of the air gap.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of previous, new or load, or cells, SI (repeatable, all applied "
        "together)",
    )

    def run(self, plan: PlatformRequest, progress: Progress) -> PlatformDocument:
        """Bend both platforms."""
        from motionlab.motor_design.kept_maps import named_map
        from motionlab.motor_design.platform.document import platform

        return platform(plan, None if plan.map is None else named_map(plan.map.name, "map"))

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add axis and force map."""
        parser.add_argument(
            "--axis",
            choices=("x", "y"),
            default="y",
            help="whose default shapes (default: %(default)s)",
        )
        parser.add_argument(
            "--map",
            metavar="NAME",
            help="take the forces from a force map, shipped or computed: they grow as the gap "
            "closes",
        )

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import as_tables

        request = {"axis": options.axis} | ({"map.name": options.map} if options.map else {})
        return as_tables(request | changes)
