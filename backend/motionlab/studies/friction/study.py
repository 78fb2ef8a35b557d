"""Which friction model a run supports, as a study."""

from __future__ import annotations

import argparse
from typing import Any

from motionlab.studies.options import add_fields, set_options
from motionlab.studies.study import Study, StudyCommand, lazy

_EXAMPLES = """\
examples:
  motionlab friction-models r-abcdefghijkl
  motionlab friction-models "morning" --axis y --variant A
  motionlab friction-models robot --position angle --force torque --normal-force preload
  motionlab friction-models "morning" --effect dahl --effect my-friction --laws laws

`motionlab docs identify` has the method, and how often it is right.
"""
_APART = {"run", "set", "scenario", "start", "end", "normal_force", "effects"}


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
        parser.add_argument("--from", dest="start", type=float, metavar="S", help="begin, s")
        parser.add_argument("--to", dest="end", type=float, metavar="S", help="end, s")
        parser.add_argument(
            "--normal-force", metavar="COLUMN", help="column of the normal force (default: known)"
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
