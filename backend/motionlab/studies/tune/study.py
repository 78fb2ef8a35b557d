"""The search for gains, and the cost over the plane of gains."""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from motionlab.errors import ConfigError, FieldError
from motionlab.studies.study import RequestLimits, Study, StudyCommand, above, lazy

if TYPE_CHECKING:
    from motionlab.studies.tune.problem import TuningProblem

_EXAMPLES = """\
examples:
  motionlab tune circle
  motionlab tune circle --variant B --axis x --objective peak --json
  motionlab tune circle --plants as-measured matched --objective rms,effort=0.1
  motionlab tune circle --constraint phase_margin=0.7 --constraint gain_margin=3
  motionlab tune stair-y-50mm --objective settling --bounds k_p=1e5:1e7
  motionlab tune --set variants.B.controller=lugre-full --also disturbance_observer.bandwidth=10:200
  motionlab tune --laws laws --set variants.B.controller.compensation.law=mine \
    --also compensation.mine_share=0.1:2

Gains are SI: k_p in N/m, k_d in N s/m. `motionlab docs tune` explains objectives and constraints.
"""


class _TuningStudy(Study):
    """Trials of gains of one variant."""

    tag = "tune"
    batches = True
    planner = lazy("studies.tune.problem:plan")

    def read(self, request: Mapping[str, Any]) -> Any:
        """Return a request, checked."""
        from motionlab.studies.tune.documents import read_request

        return read_request(self.request_model, request)  # pyright: ignore[reportArgumentType]

    def excess(self, plan: TuningProblem, bounds: RequestLimits) -> list[FieldError]:
        """Bound the simulated time of one trial and of all."""
        one = "one trial takes too long a simulated time"
        every = "simulated time of all trials is too large for one request"
        return [
            *above(plan.own.seconds, bounds.direct_max, loc="window", message=one),
            *above(plan.seconds, bounds.trials_max, loc="scenario", message=every),
        ]


class TuneStudy(_TuningStudy):
    """Search gains by the simplex of Nelder and Mead, from several starts.

    The job's report carries what each start has evaluated, and at the end the candidates.
    """

    kind = "tune"
    path = "/tune"
    operation = "tune"
    report_name = "TuningJob"
    request_model = lazy("studies.tune.documents:TuneRequest")
    document_model = lazy("studies.tune.documents:TuneDocument")
    partial_model = lazy("studies.tune.documents:PartialTuning")
    run = lazy("studies.tune.search:tune")
    bodies = ({"scenario": "circle", "axis": "x", "objective": {"rms": 1.0}},)
    command = StudyCommand(
        name="tune",
        help="search a controller's gains by the simplex",
        description="Search k_p and k_d of a variant by the simplex of Nelder and Mead, in their "
        "logarithms, from several starts, under constraints on margins and limits.",
        examples=_EXAMPLES,
        title="tuning",
    )

    def add_options(self, parser: argparse.ArgumentParser) -> None:
        """Add objective, constraints, bounds and the effort of the search."""
        repeatable: dict[str, Any] = {"action": "append", "default": []}
        parser.add_argument(
            "--variant", help="whose gains (default: the second variant, or the only one)"
        )
        parser.add_argument(
            "--axis",
            choices=("x", "y", "both"),
            default="both",
            help="which axis (default: %(default)s)",
        )
        parser.add_argument(
            "--objective",
            metavar="METRIC[=WEIGHT],...",
            default="rms",
            help="what is to be small: peak, rms, itae, settling, effort, or a weighted sum of "
            "them (default: %(default)s)",
        )
        parser.add_argument(
            "--constraint",
            dest="constraints",
            metavar="NAME=LIMIT",
            help="gain_margin, phase_margin in rad, Ms, saturated, force in N; off leaves one "
            "out (repeatable; default: gain_margin=2 phase_margin=0.5236 saturated=0)",
            **repeatable,
        )
        parser.add_argument(
            "--bounds",
            metavar="GAIN=LOW:HIGH",
            help="between which gains is searched (repeatable; default: "
            "k_p=1e4:3e7 and k_d=1e2:1e5)",
            **repeatable,
        )
        parser.add_argument(
            "--also",
            metavar="PATH=LOW:HIGH",
            help="search a further number of the controller: compensation.NAME of a number of its "
            "law, one of your own too, or disturbance_observer.bandwidth (repeatable)",
            **repeatable,
        )
        parser.add_argument("--starts", type=int, default=4, help="starts (default: %(default)s)")
        parser.add_argument(
            "--evaluations", type=int, default=200, help="of a start at most (default: %(default)s)"
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

    def request_of(self, options: argparse.Namespace, changes: dict[str, Any]) -> dict[str, Any]:
        """Return the request of the options."""
        from motionlab.config.changes import split_pairs

        constraints = split_pairs(options.constraints, "--constraint", "NAME=LIMIT")
        bounds = split_pairs(options.bounds, "--bounds", "GAIN=LOW:HIGH")
        also = split_pairs(options.also, "--also", "PATH=LOW:HIGH")
        request = super().request_of(options, changes) | {
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


class LandscapeStudy(_TuningStudy):
    """Map the cost over k_p and k_d, with the stability boundary of the linearised loop.

    The job's report carries a coarse map first, then finer ones.
    """

    kind = "landscape"
    path = "/landscape"
    operation = "landscape"
    report_name = "LandscapeJob"
    request_model = lazy("studies.tune.documents:LandscapeRequest")
    document_model = lazy("studies.tune.documents:LandscapeDocument")
    partial_model = lazy("studies.tune.documents:PartialLandscape")
    run = lazy("studies.tune.landscape:landscape")
    bodies = ({"scenario": "circle", "points": 32},)


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
