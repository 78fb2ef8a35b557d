"""Which friction model a run supports, as a study."""

from __future__ import annotations

import argparse
from typing import Any

from motionlab.studies.options import add_fields, set_options
from motionlab.studies.record.options import add_columns, add_part
from motionlab.studies.study import Study, StudyCommand, lazy

_EXAMPLES = """\
examples:
  motionlab friction-models r-abcdefghijkl
  motionlab friction-models "morning" --axis y --variant A
  motionlab friction-models robot --position-column angle --force-column torque
  motionlab friction-models "morning" --effect dahl --effect my-friction --laws laws

`motionlab docs identify` has the method, and how often it is right.
"""
_COLUMNS = {kind: f"{kind}_column" for kind in ("position", "force", "normal_force")}
_APART = {"run", "set", "scenario", "start", "end", "effects", *_COLUMNS.values()}


class FrictionModelsStudy(Study):
    """Select among friction models by their held-out error on a run, or say why it cannot.

    Coulomb-viscous, Stribeck, LuGre, GMS, LuGre with friction that grows with the normal force, and
    effects of friction of one's own, each with intervals. The run may be of any machine of one
    axis: position, and force, torque or current.
    """

    kind = "friction-models"
    path = "/friction-models"
    operation = "selectFrictionModel"
    tag = "identify"
    report_name = "FrictionModelsJob"
    request_model = lazy("studies.friction.documents:FrictionModelsRequest")
    document_model = lazy("studies.friction.documents:FrictionModelsDocument")
    planner = lazy("studies.friction.record:plan")
    run = lazy("studies.friction.select:select")
    report = lazy("studies.friction.report:report")
    bodies = ({"run": "r-abcdefghijkl", "axis": "x"},)
    command = StudyCommand(
        name="friction-models",
        help="which friction model a run supports",
        description="Compare friction models by their held-out error on a run, and select one or "
        "say why the run cannot tell. Nothing moves.",
        examples=_EXAMPLES,
        scenario=None,
        set="change a field of the scenario whose force map is used (repeatable)",
        title="models",
    )

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the run, its columns, and the stretch."""
        parser.add_argument("run", metavar="RUN", help="identifier or name of a kept run")
        parser.add_argument(
            "--scenario", metavar="NAME", help="whose force map is used (default: circle)"
        )
        add_part(parser)
        add_columns(parser, **_COLUMNS)
        parser.add_argument(
            "--normal-force-magnitude",
            action="store_true",
            default=None,
            help="the normal force is the magnitude of its column",
        )
        parser.add_argument(
            "--effect",
            dest="effects",
            metavar="NAME",
            action="append",
            help="an effect of friction, such as one's own, that is compared too (repeatable)",
        )
        add_fields(parser, self.request_model, set(_APART))

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.library.library import library

        names = [name for name in self.request_model.model_fields if name not in {"run", "set"}]
        run = library().named(options.run)
        return {"run": run, "set": changes} | set_options(options, *names)
