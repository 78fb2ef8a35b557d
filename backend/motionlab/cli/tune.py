"""The command ``motionlab tune``."""

from __future__ import annotations

import argparse
import json
import math
from typing import Any

from motionlab.cli.exit_codes import DONE
from motionlab.cli.options import add_json, add_scenario, add_set, source
from motionlab.cli.progress import share_done
from motionlab.errors import ConfigError, FieldError

EXAMPLES = """\
examples:
  motionlab tune circle
  motionlab tune circle --variant B --axis x --objective peak --json
  motionlab tune circle --plants as-measured matched --objective rms,effort=0.1
  motionlab tune circle --constraint phase_margin=0.7 --constraint gain_margin=3
  motionlab tune stair-y-50mm --objective settling --bounds k_p=1e5:1e7
  motionlab tune --set variants.B.controller=lugre-full --also disturbance_observer.bandwidth=10:200

Gains are SI: k_p in N/m, k_d in N s/m. docs/tune.md says what each objective and constraint is.
"""


def add(commands: Any) -> None:
    """Add ``motionlab tune``."""
    parser = commands.add_parser(
        "tune",
        help="search a controller's gains by the simplex",
        description="Search k_p and k_d of a variant by the simplex of Nelder and Mead, in their "
        "logarithms, from several starts, under constraints on margins and limits.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add_scenario(parser)
    repeatable: dict[str, Any] = {"action": "append", "default": []}
    add_set(parser, "change a field of the scenario (repeatable, all applied together)")
    parser.add_argument("--variant", help="whose gains (the second variant, or the only one)")
    parser.add_argument(
        "--axis", choices=("x", "y", "both"), default="both", help="which axis (%(default)s)"
    )
    parser.add_argument(
        "--objective",
        metavar="METRIC[=WEIGHT],...",
        default="rms",
        help="what is to be small: peak, rms, itae, settling, effort, or a weighted sum of them "
        "(%(default)s)",
    )
    parser.add_argument(
        "--constraint",
        dest="constraints",
        metavar="NAME=LIMIT",
        help="gain_margin (2), phase_margin (0.5236 rad), Ms, saturated (0), force (N); off leaves "
        "one out (repeatable)",
        **repeatable,
    )
    parser.add_argument(
        "--bounds",
        metavar="GAIN=LOW:HIGH",
        help="between which gains is searched: k_p (1e4:3e7), k_d (1e2:1e5) (repeatable)",
        **repeatable,
    )
    parser.add_argument(
        "--also",
        metavar="PATH=LOW:HIGH",
        help="search a further number of the controller, such as disturbance_observer.bandwidth "
        "(repeatable)",
        **repeatable,
    )
    parser.add_argument("--starts", type=int, default=4, help="starts (%(default)s)")
    parser.add_argument(
        "--evaluations", type=int, default=200, help="of a start at most (%(default)s)"
    )
    parser.add_argument(
        "--plants",
        metavar="MOTOR",
        nargs="+",
        default=[],
        help="shipped motors on which the gains must do as well; the worst one counts",
    )
    parser.add_argument(
        "--window",
        metavar=("START", "END"),
        type=float,
        nargs=2,
        help="part of the run that is judged, s; a run ends with it",
    )
    add_json(parser)
    parser.set_defaults(command=_tune)


def _tune(options: argparse.Namespace) -> int:
    """Carry out ``motionlab tune``."""
    from motionlab.studies.tune.problem import plan
    from motionlab.studies.tune.report import report
    from motionlab.studies.tune.request import TuneRequest, read_request
    from motionlab.studies.tune.search import tune

    problem = plan(read_request(TuneRequest, _request(options)), source(options))
    with share_done("tuning") as progress:
        found = tune(problem, lambda share, _partial: progress(share))
    if options.json:
        print(json.dumps(found.model_dump(), allow_nan=False))
    else:
        print(report(found))
    return DONE


def _request(options: argparse.Namespace) -> dict[str, Any]:
    from motionlab.config.changes import parse_assignments, split_pairs

    constraints = split_pairs(options.constraints, "--constraint", "NAME=LIMIT")
    bounds = split_pairs(options.bounds, "--bounds", "GAIN=LOW:HIGH")
    also = split_pairs(options.also, "--also", "PATH=LOW:HIGH")
    request: dict[str, Any] = {
        "scenario": options.scenario,
        "set": parse_assignments(options.assignments),
        "variant": options.variant,
        "axis": options.axis,
        "objective": _weights(options.objective),
        "constraints": {
            name: None if text == "off" else _number(text, f"constraints.{name}")
            for name, text in constraints.items()
        },
        "bounds": {name: _range(text, f"bounds.{name}") for name, text in bounds.items()},
        "also": {path: _range(text, f"also.{path}") for path, text in also.items()},
        "starts": options.starts,
        "evaluations": options.evaluations,
        "plants": options.plants,
    }
    if options.window is not None:
        request["window"] = dict(zip(("start", "end"), options.window, strict=True))
    return request


def _weights(text: str) -> dict[str, float]:
    weights: dict[str, float] = {}
    for part in text.split(","):
        metric, equals, weight = (word.strip() for word in part.partition("="))
        if metric in weights:
            raise ConfigError(FieldError("--objective", f"names {metric} twice", text))
        weights[metric] = _number(weight, f"objective.{metric}") if equals else 1.0
    return weights


def _range(text: str, loc: str) -> list[float]:
    ends = text.split(":")
    if len(ends) != 2:
        raise ConfigError(FieldError(loc=loc, message="needs LOW:HIGH", value=text))
    return [_number(end, loc) for end in ends]


def _number(text: str, loc: str) -> float:
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ConfigError(FieldError(loc=loc, message="must be a finite number", value=text))
    return number
