"""The command ``motionlab view``."""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from motionlab.cli.exit_codes import DONE
from motionlab.studies.options import add_json, add_set, source

if TYPE_CHECKING:
    from motionlab.runs.views.ballbar import Ballbar
    from motionlab.runs.views.recorded import Recorded

EXAMPLES = """\
examples:
  motionlab view ballbar circle
  motionlab view ballbar circle-matched --set variants.B.controller.x.k_p=312000 --json
  motionlab view ballbar r-gpd6hecc7x3n --from 0 --to 10.5

docs/views.md defines every figure.
"""
_MICRO = 1e6
_RUN = "r-"


def add(commands: Any) -> None:
    """Add ``motionlab view``."""
    parser = commands.add_parser(
        "view",
        help="circular test and other views of a run or a scenario",
        description="Compute a view of a kept run, or of a scenario that is simulated for it.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("view", choices=list(_VIEWS), help="which view")
    parser.add_argument(
        "scenario",
        metavar="RUN|SCENARIO",
        help="identifier of a kept run, path of a .toml file, or a shipped scenario",
    )
    parser.add_argument("--from", dest="start", metavar="S", type=float, help="begin, s")
    parser.add_argument("--to", dest="end", metavar="S", type=float, help="end, s")
    add_set(parser, "change a field of the scenario (repeatable)")
    add_json(parser)
    parser.set_defaults(command=_view)


def _view(options: argparse.Namespace) -> int:
    compute, table, window = _VIEWS[options.view]
    found = compute(_recorded(options, window=window))
    print(json.dumps(found.model_dump(mode="json")) if options.json else "\n".join(table(found)))
    return DONE


def _recorded(options: argparse.Namespace, *, window: bool) -> Recorded:
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.errors import ConfigError, FieldError
    from motionlab.runs.views.recorded import of_run, of_scenario
    from motionlab.simulation.prepare import prepare

    if options.scenario.startswith(_RUN):
        if options.assignments:
            told = "changes a scenario; a kept run is as it was"
            raise ConfigError(FieldError("--set", told, options.assignments[0]))
        return of_run(options.scenario, options.start, options.end, window=window)
    scenario = load_scenario(source(options), parse_assignments(options.assignments))
    return of_scenario(prepare(scenario), options.start, options.end, window=window)


def _ballbar(recorded: Recorded) -> Ballbar:
    from motionlab.runs.views.ballbar import ballbar

    return ballbar(recorded)


def _ballbar_table(found: Ballbar) -> list[str]:
    lines = [
        f"circle of {1e3 * found.radius:.4g} mm at {1e3 * found.feed:.4g} mm/s; deviations in um",
        "                 G    F max    F min    0 deg   90 deg  180 deg  270 deg",
    ]
    for name, variant in found.variants.items():
        for way, one in variant.directions.items():
            values = [one.G, one.F_max, one.F_min, *one.quadrants]
            cells = "".join(f"{_um(value):>9}" for value in values)
            lines.append(f"  {name} {way:4}{cells}{'  simulated' if one.simulated else ''}")
        both = variant.both
        if both is not None:
            lines += [
                f"  {name} both{_um(both.G):>9}  G(b); H {_um(both.H)}, mean radius "
                f"{_um(both.radius_error)}, centre {_um(both.offset_x)}, {_um(both.offset_y)}",
                f"         squareness {1e6 * both.squareness:.3f} urad "
                f"({math.degrees(both.squareness) * 3600:.3f} arcsec), scale x - y "
                f"{1e6 * both.scale_mismatch:.2f} ppm, x lags y by "
                f"{1e6 * both.servo_mismatch:.3f} us",
            ]
    return [*lines, *([found.note] if found.note else [])]


def _um(value: float | None) -> str:
    return "-" if value is None else f"{_MICRO * value:.3f}"


_VIEWS: dict[str, tuple[Callable[[Recorded], Any], Callable[[Any], list[str]], bool]] = {
    "ballbar": (_ballbar, _ballbar_table, False),
}
"""Of each view what computes it, what prints it, and whether its stretch is that of metrics."""
