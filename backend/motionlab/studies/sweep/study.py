"""Sweeps over any fields of a scenario."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.sweep.run import SweepPlan

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s: a few minutes of four cores."""

_FORM = "PATH=FROM:TO:COUNT[:log] or PATH=VALUE,VALUE,..."
_EXAMPLES = """\
examples:
  motionlab sweep circle --grid variants.B.controller.x.k_p=1e5:1e6:10:log
  motionlab sweep circle --grid plant=nominal,as-measured,matched
  motionlab sweep circle --grid plant.x.mass=4:8:5 --grid variants.B.compensation.gain=0.5:1.5:5
  motionlab sweep circle --list --grid seed=1,2,3 --grid trajectory.frequency=0.4,0.5,0.6 --json

Values are SI; `motionlab docs sweep` says more. POST /api/v1/sweep takes the same.
"""


class SweepStudy(Study):
    """Run a scenario over a grid or a list of values of any of its fields.

    The job ends with every metric of every variant and axis in each case, and the best cases; its
    report carries the metrics of the cases that have run.
    """

    kind = "sweep"
    path = "/sweep"
    operation = "sweep"
    tag = "sweep"
    report_name = "SweepJob"
    request_model = lazy("studies.sweep.documents:SweepRequest")
    document_model = lazy("studies.sweep.documents:SweepDocument")
    partial_model = lazy("studies.sweep.documents:PartialSweep")
    planner = lazy("studies.sweep.run:plan")
    run = lazy("studies.sweep.run:run")
    report = lazy("studies.sweep.documents:report")
    suffixes = (".csv",)
    write = lazy("studies.sweep.documents:write")
    bodies = (
        {
            "scenario": "circle",
            "grid": [
                {
                    "path": "variants.B.controller.x.k_p",
                    "start": 1e5,
                    "stop": 1e6,
                    "count": 10,
                    "scale": "log",
                }
            ],
        },
        {"grid": [{"path": "plant", "values": ["nominal", "as-measured", "matched"]}]},
    )
    batches = True
    scatters = True
    command = StudyCommand(
        name="sweep",
        help="run a scenario over a grid of values",
        description="Run a scenario over a grid or a list of values of any of its fields, and "
        "compare the metrics of all cases.",
        examples=_EXAMPLES,
        title="cases",
    )

    def excess(self, plan: SweepPlan, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of all cases."""
        message = "simulated time of all cases and variants is too large for one request"
        return above(plan.seconds, WORK_MAX, loc="grid", message=message)

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add the swept fields and the file to write."""
        parser.add_argument(
            "--grid",
            metavar="PATH=VALUES",
            action="append",
            default=[],
            help=f"a swept field, {_FORM} (repeatable)",
        )
        parser.add_argument(
            "--list",
            dest="combine",
            action="store_const",
            const="list",
            default="grid",
            help="take first values together, then second ones, not every combination",
        )
        parser.add_argument("--out", metavar="FILE", help="write every metric to FILE, .csv")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import split_pairs

        swept = split_pairs(options.grid, "--grid", _FORM)
        if not swept:
            raise ConfigError(FieldError("--grid", "is missing", range=_FORM))
        grid = [{"path": path} | _values(path, text) for path, text in swept.items()]
        return super().request_of(options, changes) | {"grid": grid, "combine": options.combine}


def _values(path: str, text: str) -> dict[str, Any]:
    """Return a range, or values as ``--set`` reads them."""
    from motionlab.config.changes import parse_assignments

    parts = text.split(":")
    if len(parts) == 1:
        values = [parse_assignments([f"{path}={part}"], "--grid")[path] for part in text.split(",")]
        return {"values": values}
    try:
        start, stop, count, *scale = parts
        spec = {"start": float(start), "stop": float(stop), "count": int(count)}
    except ValueError:
        raise ConfigError(FieldError("--grid", f"needs {_FORM}", f"{path}={text}")) from None
    if scale not in ([], ["log"]):
        raise ConfigError(FieldError("--grid", "is no spacing", ":".join(scale), "log"))
    return spec | {"scale": scale[0] if scale else "linear"}
