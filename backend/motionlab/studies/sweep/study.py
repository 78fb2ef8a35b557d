"""Sweeps over any fields of a scenario."""

from __future__ import annotations

import argparse
import re
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.sweep.run import SweepPlan

WORK_MAX = 100_000.0
"""Simulated time summed over cases and variants, s: a few minutes of four cores."""

_FORM = "PATH=FROM:TO:COUNT[:log] or PATH=VALUE,VALUE,..."
_RANGE = "PATH=FROM:TO[:log] or PATH=VALUE,VALUE,..."
_LIMIT = "METRIC>=VALUE or METRIC<=VALUE, as in B.worst.gain_margin>=2"
_SAMPLINGS = ("random", "latin-hypercube", "sobol")
_SEARCHERS = ("cma-es", "nsga-ii", "tpe", "gp")  # as in the request, which brings pydantic
_EXAMPLES = """\
examples:
  motionlab sweep circle --grid variants.B.controller.x.k_p=1e5:1e6:10:log
  motionlab sweep circle --grid plant=nominal,as-measured,matched
  motionlab sweep circle --grid plant.x.mass=4:8:5 --grid variants.B.controller.x.k_d=900:2500:5
  motionlab sweep circle --list --grid seed=1,2,3 --grid trajectory.frequency=0.4,0.5,0.6 --json
  motionlab sweep circle --sample sobol:256 --grid plant.x.mass=5:8 --grid plant.y.mass=9:12
  motionlab sweep circle --search nsga-ii:512 --grid variants.B.controller.x.k_p=1e5:2e6:log \
    --grid variants.B.controller.x.k_d=300:4000:log --objective B.x.max_abs_following_error \
    --objective B.x.max_abs_force --limit 'B.x.gain_margin>=2'

Values are SI; `motionlab docs sweep` says more. POST /api/v1/sweep takes the same.
"""


class SweepStudy(Study):
    """Run a scenario over a grid or a list of values of any of its fields, or drawn ones.

    The job ends with every metric of every variant and axis in each case, the best cases, and the
    front between several objectives; its report carries the metrics of the cases that have run.
    """

    kind = "sweep"
    path = "/sweep"
    operation = "sweep"
    tag = "sweep"
    report_name = "SweepJob"
    request_model = lazy("studies.sweep.request:SweepRequest")
    document_model = lazy("studies.sweep.documents:SweepDocument")
    partial_model = lazy("studies.sweep.documents:PartialSweep")
    planner = lazy("studies.sweep.run:plan")
    run = lazy("studies.sweep.run:run")
    report = lazy("studies.sweep.report:report")
    suffixes = (".csv",)
    write = lazy("studies.sweep.report:write")
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
        {
            "grid": [
                {"path": "plant.x.mass", "start": 5.0, "stop": 8.0},
                {"path": "plant.y.mass", "start": 9.0, "stop": 12.0},
            ],
            "combine": "sobol",
            "samples": 64,
            "objectives": ["B.worst.max_abs_following_error"],
            "limits": [{"of": "B.worst.gain_margin", "at_least": 2.0}],
        },
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
        how = parser.add_mutually_exclusive_group()
        how.add_argument(
            "--list",
            action="store_true",
            help="take first values together, then second ones, not every combination",
        )
        how.add_argument(
            "--sample",
            metavar="METHOD:CASES",
            help=f"draw cases from all ranges, {_RANGE}: {', '.join(_SAMPLINGS)}",
        )
        how.add_argument(
            "--search",
            metavar="[METHOD:]CASES",
            help="choose cases for the least objectives, ranges as with --sample: "
            f"{', '.join(_SEARCHERS)}; needs the extra search",
        )
        parser.add_argument(
            "--sampling-seed",
            metavar="N",
            type=int,
            help="of what is drawn or searched (default: 0)",
        )
        parser.add_argument(
            "--objective",
            metavar="VARIANT.AXIS.METRIC",
            action="append",
            default=[],
            help="what is best where it is least, or largest of a margin; AXIS x, y or worst "
            "(repeatable)",
        )
        parser.add_argument(
            "--limit",
            metavar="METRIC>=VALUE",
            action="append",
            default=[],
            help=f"what a case has to meet, SI: {_LIMIT} (repeatable)",
        )
        parser.add_argument("--out", metavar="FILE", help="write every metric to FILE, .csv")

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import split_pairs

        chosen = _combined(options)
        form = _RANGE if "samples" in chosen else _FORM
        swept = split_pairs(options.grid, "--grid", form)
        if not swept:
            raise ConfigError(FieldError("--grid", "is missing", range=form))
        grid = [{"path": path} | _values(path, text, form) for path, text in swept.items()]
        request = {"grid": grid, **chosen, "sampling_seed": options.sampling_seed}
        request["objectives"] = options.objective
        request["limits"] = [_limit(text) for text in options.limit]
        return super().request_of(options, changes) | request


def _combined(options: argparse.Namespace) -> dict[str, Any]:
    """Return how values are combined, of the options."""
    for option, known in (("sample", _SAMPLINGS), ("search", _SEARCHERS)):
        text = getattr(options, option)
        if text is None:
            continue
        method, colon, cases = text.rpartition(":")
        if not cases.isdecimal() or (method not in known if colon or option == "sample" else False):
            allowed = f"METHOD:CASES, METHOD one of {', '.join(known)}"
            raise ConfigError(FieldError(f"--{option}", "is no method and number", text, allowed))
        if option == "sample":
            return {"combine": method, "samples": int(cases)}
        return {"combine": "search", "samples": int(cases)} | (
            {"searcher": method} if method else {}
        )
    return {"combine": "list" if options.list else "grid"}


def _limit(text: str) -> dict[str, Any]:
    match = re.fullmatch(r"\s*([A-Za-z_.]+)\s*(>=|<=)\s*(\S+)\s*", text)
    try:
        if match is None:
            raise ValueError(text)
        bound = "at_least" if match[2] == ">=" else "at_most"
        return {"of": match[1], bound: float(match[3])}
    except ValueError:
        raise ConfigError(FieldError("--limit", f"needs {_LIMIT}", text)) from None


def _values(path: str, text: str, form: str) -> dict[str, Any]:
    """Return a range, or values as ``--set`` reads them."""
    from motionlab.config.changes import parse_assignments

    parts = text.split(":")
    if len(parts) == 1:
        values = [parse_assignments([f"{path}={part}"], "--grid")[path] for part in text.split(",")]
        return {"values": values}
    scale = "linear"
    if parts[-1] == "log":
        scale = parts.pop()
    keys = ("start", "stop") if form == _RANGE else ("start", "stop", "count")
    try:
        numbers = dict(zip(keys, parts, strict=True))
        counted = {"count": int(numbers.pop("count"))} if "count" in numbers else {}
        ends = {key: float(number) for key, number in numbers.items()}
    except ValueError:
        raise ConfigError(FieldError("--grid", f"needs {form}", f"{path}={text}")) from None
    return ends | counted | {"scale": scale}
