"""Force sharing over one pole pitch."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.studies.study import Progress, Study, StudyCommand, lazy

if TYPE_CHECKING:
    from motionlab.studies.sharing.sharing import SharingDocument, SharingRequest

_EXAMPLES = """\
examples:
  motionlab sharing
  motionlab sharing --set force=5 --set resistance=1.5
  motionlab sharing --set controller=new-design --set law=force-per-ampere --json
  motionlab sharing --set controller=nominal --set plant=new-design

Values are SI; `motionlab docs sharing` lists the fields.
"""


class SharingStudy(Study):
    """Share a force among the phases over one pole pitch: currents, forces, ripple, copper loss.

    An empty table is 20 N on the nominal motor.
    """

    kind = "sharing"
    path = "/design/sharing"
    operation = "shareForce"
    tag = "design"
    request_model = lazy("studies.sharing.sharing:SharingRequest")
    document_model = lazy("studies.sharing.sharing:SharingDocument")
    bodies = (
        {"force": 20.0},
        {"controller": "nominal", "plant": "new-design", "law": "force-per-ampere"},
    )
    direct = True
    light = True
    command = StudyCommand(
        name="sharing",
        help="share a force among the phases over one pole pitch",
        description="Share a force among the phases over one pole pitch by each law: ripple, "
        "copper loss, normal force, reachable force. The controller's map and the plant's may "
        "differ. With --json, of one law.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of the request (repeatable, all applied together)",
    )

    def run(self, plan: SharingRequest, progress: Progress) -> SharingDocument:
        """Share the force at every position."""
        from motionlab.studies.sharing.sharing import sharing

        return sharing(plan)

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request that ``--set`` makes."""
        return changes

    def before(self, plan: SharingRequest, options: argparse.Namespace) -> str | None:
        """Return the comparison of all sharing functions, unless one or a document is requested."""
        from motionlab.force_sharing.functions import FUNCTIONS
        from motionlab.reports.document_text import document_text
        from motionlab.studies.sharing.sharing import sharing

        if options.json or "law" in plan.model_fields_set:
            return None
        return document_text(
            {law: sharing(plan.model_copy(update={"law": law})) for law in FUNCTIONS}
        )
