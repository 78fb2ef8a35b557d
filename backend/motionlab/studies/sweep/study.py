"""Sweeps over any fields of a scenario."""

from __future__ import annotations

import argparse
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.studies.study import Bounds, Command, Models, Progress, Source, Study, above

if TYPE_CHECKING:
    from motionlab.studies.sweep.document import SweepDocument
    from motionlab.studies.sweep.run import Sweep

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s: a few minutes of four cores."""

_FORM = "PATH=FROM:TO:COUNT[:log] or PATH=VALUE,VALUE,..."
_EXAMPLES = """\
examples:
  motionlab sweep circle --grid variants.B.controller.x.k_p=1e5:1e6:10:log
  motionlab sweep circle --grid plant=nominal,as-measured,matched
  motionlab sweep circle --grid plant.x.mass=4:8:5 --grid variants.B.compensation.gain=0.5:1.5:5
  motionlab sweep circle --list --grid seed=1,2,3 --grid trajectory.frequency=0.4,0.5,0.6 --json

Values are SI; docs/sweep.md says more. POST /api/v1/sweep takes the same.
"""


class SweepStudy(Study["Sweep", "SweepDocument"]):
    """Run a scenario over a grid or a list of values of any of its fields.

    The job ends with every metric of every variant and axis in each case, and the best cases.
    """

    kind = "sweep"
    path = "/sweep"
    operation = "sweep"
    tag = "sweep"
    report_name = "SweepJob"
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
    command = Command(
        name="sweep",
        help="run a scenario over a grid of values",
        description="Run a scenario over a grid or a list of values of any of its fields, and "
        "compare the metrics of all cases.",
        examples=_EXAMPLES,
        title="cases",
    )

    def models(self) -> Models:
        """Return the types of request and document."""
        from motionlab.studies.sweep.document import SweepDocument
        from motionlab.studies.sweep.request import SweepRequest

        return Models(SweepRequest, SweepDocument)

    def plan(self, request: Mapping[str, Any], source: Source | None = None) -> Sweep:
        """Return the cases; see `Study.plan`."""
        from motionlab.studies.sweep.request import read_request
        from motionlab.studies.sweep.run import plan

        return plan(read_request(request), source)

    def excess(self, plan: Sweep, bounds: Bounds) -> list[FieldError]:
        """Bound the simulated time of all cases."""
        message = "simulated time of all cases and variants is too large for one request"
        return above(plan.seconds, WORK_MAX, loc="grid", message=message)

    def run(self, plan: Sweep, progress: Progress) -> SweepDocument:
        """Run every case."""
        from motionlab.studies.sweep.run import run

        return run(plan, progress)

    def report(self, found: SweepDocument) -> str:
        """Return the largest following errors as a table."""
        from motionlab.studies.sweep.report import report

        return report(found)

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
        """Return the request that options make."""
        from motionlab.config.changes import split_pairs

        swept = split_pairs(options.grid, "--grid", _FORM)
        if not swept:
            raise ConfigError(FieldError("--grid", "is missing", range=_FORM))
        grid = [{"path": path} | _values(path, text) for path, text in swept.items()]
        return super().request_of(options, changes) | {"grid": grid, "combine": options.combine}

    def before(self, plan: Sweep, options: argparse.Namespace) -> str | None:
        """Refuse a file that could not be written."""
        from motionlab.studies.sweep.report import check_target

        if options.out is not None:
            check_target(options.out)

    def after(self, found: SweepDocument, options: argparse.Namespace) -> None:
        """Write one row a case."""
        from motionlab.studies.sweep.report import write

        if options.out is not None:
            write(found, options.out)


def _values(path: str, text: str) -> dict[str, Any]:
    """Return a range, or values as ``--set`` reads them."""
    from motionlab.config.changes import parse_assignments

    parts = text.split(":")
    if len(parts) == 1:
        values = [parse_assignments([f"{path}={part}"], "--grid")[path] for part in text.split(",")]
        return {"values": values}
    try:
        start, stop, count, *scale = parts
        found = {"start": float(start), "stop": float(stop), "count": int(count)}
    except ValueError:
        raise ConfigError(FieldError("--grid", f"needs {_FORM}", f"{path}={text}")) from None
    if scale not in ([], ["log"]):
        raise ConfigError(FieldError("--grid", "is no spacing", ":".join(scale), "log"))
    return found | {"scale": scale[0] if scale else "linear"}
