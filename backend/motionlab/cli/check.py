"""The command ``motionlab check``: whether the motor can follow a trajectory."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import show
from motionlab.errors import DONE, FAILED
from motionlab.studies.options import add_json, add_set, source

if TYPE_CHECKING:
    from motionlab.config.scenario import Scenario
    from motionlab.config.trajectory import TrajectoryConfig
    from motionlab.simulation.loop_check import Loops
    from motionlab.trajectories.trajectory_check import Examination

EXAMPLES = """\
examples:
  motionlab check circle
  motionlab check circle --set trajectory.frequency=0.6
  motionlab check square.toml --motor circle-matched

`motionlab docs trajectories` says what is checked.
"""
_BINS = 10
_SHOWN = 5  # violations
_MORE = 1.005
_NOTHING = 1e-6  # share of a limit


def add(commands: Any) -> None:
    """Add ``motionlab check``."""
    parser = commands.add_parser(
        "check",
        help="check whether the motor can follow a trajectory",
        description="Check a scenario, and whether its motor can follow its trajectory: every "
        "place where it cannot, and how much slower it could. Where it can, every variant is run "
        "along it (up to 120 s): a loop may ask for more than the currents give. The exit code is "
        "1 if the motor cannot follow.",
        epilog=EXAMPLES,
    )
    parser.add_argument(
        "scenario",
        metavar="SCENARIO|FILE",
        nargs="?",
        default="circle",
        help="shipped scenario, or a .toml file of a scenario or of a trajectory, - for stdin "
        "(default: %(default)s)",
    )
    parser.add_argument(
        "--motor",
        metavar="SCENARIO",
        default="circle",
        help="of a trajectory's file: scenario whose motor and controllers are to follow it "
        "(default: %(default)s)",
    )
    add_set(parser, "change a field of the scenario (repeatable, all applied together)")
    add_json(parser)
    parser.set_defaults(command=_check)


def _check(options: argparse.Namespace) -> int:
    from motionlab.config.load import epochs
    from motionlab.simulation.loop_check import run_loops
    from motionlab.simulation.prepare import limit_sets, planned
    from motionlab.trajectories.trajectory_check import examine

    scenario = planned(_scenario(options))
    limits = limit_sets(epochs(scenario))
    examination = examine(scenario.trajectory, limits, bins=_BINS)
    remedy = None if examination.feasible else slower(scenario)
    loops = run_loops(scenario, examination)
    if options.json:
        print(json.dumps(_document(examination, remedy, loops), allow_nan=False))
    else:
        show("\n".join(_report(options.scenario, examination, remedy, loops)))
    return DONE if examination.feasible else FAILED


def _scenario(options: argparse.Namespace) -> Scenario:
    """Return the scenario: its own, or another's with the trajectory of a file."""
    from motionlab.config.changes import parse_assignments
    from motionlab.config.load import load_scenario
    from motionlab.config.named_configs import parse

    changes = parse_assignments(options.assignments)
    chosen = source(options)
    tables = parse(chosen) if isinstance(chosen, Path) else chosen
    if isinstance(tables, dict) and "kind" in tables:
        return load_scenario(options.motor, {"trajectory": tables} | changes)
    return load_scenario(chosen, changes)


class Slower(dict[str, Any]):
    """Changes of a trajectory by dotted path, with which it can be followed."""

    stretch = 1.0

    def __str__(self) -> str:
        """Return what to do, in words."""
        if "trajectory.time" in self:  # of samples, too many to be typed
            return f"{self.stretch:.4g} times slower it can be followed: multiply its times by that"
        changes = " ".join(f"--set {path}={value!r}" for path, value in self.items())
        return f"{self.stretch:.4g} times slower it can be followed: {changes}"


def slower(scenario: Scenario) -> Slower | None:
    """Return the changes that slow a trajectory until it can be followed; None if none does."""
    from motionlab.config.changes import set_path
    from motionlab.config.load import epochs, validate_trajectory
    from motionlab.errors import ConfigError, Infeasible
    from motionlab.simulation.prepare import limit_sets, planned
    from motionlab.trajectories.retiming import slow_down, stretched
    from motionlab.trajectories.trajectory_check import examine

    try:
        scenario = planned(scenario)
        limits = limit_sets(epochs(scenario))
        slow, stretch = slow_down(scenario.trajectory, limits)
        remedy = _changes(scenario.trajectory, slow)
        # Numbers that can be typed, if they will do.
        more = _changes(scenario.trajectory, stretched(scenario.trajectory, _MORE * stretch))
        short = Slower({path: _short(value) for path, value in more.items()})
        tables = {"trajectory": scenario.trajectory.model_dump(mode="json")}
        for path, value in short.items():
            set_path(tables, path, value)
        if examine(validate_trajectory(tables["trajectory"]), limits, bins=_BINS).feasible:
            remedy = short
    except (ConfigError, Infeasible):
        return None
    remedy.stretch = stretch
    return remedy


def _changes(before: TrajectoryConfig, after: TrajectoryConfig) -> Slower:
    from motionlab.config.fields import values_of

    old = {each.path: each.value for each in values_of(before)}
    return Slower(
        {
            f"trajectory.{each.path}": each.value
            for each in values_of(after)
            if each.value != old.get(each.path)
        }
    )


def _short(value: Any) -> Any:
    return float(f"{value:.4g}") if isinstance(value, float) else value


def _document(examination: Examination, remedy: Slower | None, loops: Loops) -> dict[str, Any]:
    return {
        "feasible": examination.feasible,
        "duration": examination.duration,
        "length": examination.length,
        "peaks": [vars(peak) for peak in examination.peaks],
        "violations": [vars(each) for each in examination.violations],
        "violation_count": examination.violation_count,
        "thrust_reserve": examination.reserve,
        "notes": examination.notes,
        **loops.document(),
        "slower": None if remedy is None else {"stretch": remedy.stretch, "set": dict(remedy)},
    }


def _report(name: str, examination: Examination, remedy: Slower | None, loops: Loops) -> list[str]:
    from motionlab.reports.tables import table

    verdict = "can be followed" if examination.feasible else "cannot be followed"
    if limited := [each.variant for each in loops.loops or () if each.limited]:
        reach = "reach their limits" if len(limited) > 1 else "reaches its limits"
        verdict += f", but {' and '.join(limited)} {reach}"
    lines = [
        f"{name}: {verdict}; {examination.duration:.6g} s, {examination.length:.4g} m in "
        f"{examination.examined:.6g} s",
        "",
    ]
    rows = [
        (
            f"{peak.axis}  {peak.quantity}",
            "0" if peak.share is not None and peak.share < _NOTHING else f"{peak.value:.4g}",
            "-" if peak.limit is None else f"{peak.limit:.4g}",
            peak.unit,
            "-" if peak.share is None else f"{100 * peak.share:.1f} %",
        )
        for peak in examination.peaks
    ]
    heads = ("largest", "value", "limit", "unit", "of limit")
    lines.append(table(heads, rows, right={1, 2, 4}))
    if examination.reserve > 0.0:
        kept = f"{100 * examination.reserve:.3g} %"
        lines += ["", f"The limit of thrust leaves {kept} to feedback (thrust_reserve)."]
    if examination.violations:
        lines.append("")
    lines += [
        f"{each.quantity} on {each.axis} from {each.start:.4f} s to {each.end:.4f} s: "
        f"{abs(each.value):.6g} {each.unit} at x = {each.place[0]:.4g} m, "
        f"y = {each.place[1]:.4g} m; allowed {each.limit:.6g} {each.unit}"
        for each in examination.violations[:_SHOWN]
    ]
    if examination.violation_count > _SHOWN:
        lines.append(f"and {examination.violation_count - _SHOWN} more; --json lists the worst")
    if examination.notes:
        lines += ["", *examination.notes]
    lines += ["", *_loops(loops)]
    if not examination.feasible:
        lines += ["", str(remedy or "no slower one can be: move or shrink it, or smooth its jumps")]
    return lines


def _loops(checks: Loops) -> list[str]:
    """Return a table of how each variant follows the motion, or why none was run."""
    from motionlab.config.planar import AXES
    from motionlab.reports.tables import table

    if checks.loops is None or checks.loops_window is None:
        return [f"The loops of the variants were not run: {checks.loops_not_run}."]
    rows = []
    for each in checks.loops:
        shares = [each.saturated_fraction.get(axis) for axis in AXES]
        errors = [each.max_abs_following_error.get(axis) for axis in AXES]
        rows.append(
            (
                each.variant,
                each.label,
                *("-" if share is None else f"{100 * share:.3g} %" for share in shares),
                *("-" if error is None else f"{1e6 * error:.4g} um" for error in errors),
                "diverged" if each.diverged else "",
            )
        )
    heads = ("", "variant", "limited x", "y", "max |e| x", "y", "")
    start, end = checks.loops_window
    return [
        table(heads, rows, right={2, 3, 4, 5}),
        f"limited: share of {start:.6g} to {end:.6g} s with the command or a current at its limit",
    ]
