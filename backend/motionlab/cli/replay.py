"""The command ``motionlab replay``."""

from __future__ import annotations

import argparse
import json
import math
from typing import TYPE_CHECKING, Any, Literal

from motionlab.cli.output import show
from motionlab.errors import DONE, FAILED, INTERRUPTED
from motionlab.executors.progress import share_done
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.library.replay import Replay
    from motionlab.library.replayed_errors import ErrorChange
    from motionlab.library.replays import Replays, RunReplay

_NAMED = 6  # channels that are listed


EXAMPLES = """\
examples:
  motionlab replay r-gpd6hecc7x3n
  motionlab replay --all
  motionlab replay --all tag:rig after:2026-11-01 --json

With --all the exit code is 1 if a run has moved; runs that cannot be simulated again, such as
measurements, are listed and do not count. `motionlab docs runs` has the language of searches.
"""


def add(commands: Any) -> None:
    """Add ``motionlab replay``."""
    parser = commands.add_parser(
        "replay",
        help="simulate kept runs again and compare every bit",
        description="Simulate a kept run again from its record and compare every channel, bit for "
        "bit. The exit code is 1 unless all are the same.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        "runs",
        metavar="RUN",
        nargs="*",
        help="identifier or name of a run; motionlab runs lists them. With --all, terms of a "
        "search, all of which the runs must meet",
    )
    parser.add_argument(
        "--all",
        action="store_true",
        help="all runs, or those that a search finds: which have moved, by how much, and why",
    )
    add_json(parser)
    parser.set_defaults(command=_replay)


def _replay(options: argparse.Namespace) -> int:
    if options.all:
        return _replay_all(options)
    from motionlab.errors import ConfigError, FieldError
    from motionlab.library.library import library
    from motionlab.library.replay import again, replay

    if len(options.runs) != 1:
        message, allowed = "names no single run", "one run; or --all, and terms of a search"
        raise ConfigError(FieldError("RUN", message, " ".join(options.runs), allowed))
    kept = library()
    run = kept.named(options.runs[0])
    recorded = again(kept.complete(run))
    with kept.files.open(run) as file, share_done("replay") as progress:
        comparison = replay(recorded, file, progress)
    if options.json:
        print(json.dumps(comparison.model_dump(mode="json"), allow_nan=False))
    else:
        show(_report(comparison))
    return DONE if comparison.identical else FAILED


def _replay_all(options: argparse.Namespace) -> int:
    from motionlab.cli.runs import search_of
    from motionlab.library.library import library
    from motionlab.library.replays import replay_all

    search = search_of(options.runs)
    kept = library()
    kept.recover()  # what a killed server left
    with share_done("replay") as progress:
        replays = replay_all(kept, search, progress)
    if options.json:
        print(json.dumps(replays.model_dump(mode="json"), allow_nan=False))
    else:
        show(_report_all(replays))
    if replays.interrupted:
        return INTERRUPTED
    return FAILED if replays.moved else DONE


def _report_all(replays: Replays) -> str:
    from motionlab.reports.tables import table

    moved = [_moved_row(run) for run in replays.runs if run.outcome == "moved"]
    refused = [
        (run.run, run.name, "; ".join(run.reasons))
        for run in replays.runs
        if run.outcome == "not replayable"
    ]
    lines = []
    if moved:
        heads = ("moved", "name", "largest error", "RMS error", "first difference", "why")
        lines += [table(heads, moved), ""]
    if refused:
        lines += [table(("not simulated again", "name", "why"), refused), ""]
    count = len(replays.runs)
    extent = f"{count} of {replays.total} runs" if replays.interrupted else _counted(count)
    lines.append(
        f"{'interrupted: ' if replays.interrupted else ''}{extent}, {replays.identical} identical, "
        f"{replays.moved} moved, {replays.not_replayable} cannot be simulated again"
    )
    return "\n".join(lines)


def _counted(count: int) -> str:
    return "1 run" if count == 1 else f"{count} runs"


def _moved_row(run: RunReplay) -> tuple[str, ...]:
    first = run.first
    begins = "" if first is None else f"{first.channel} at {first.time:.4f} s"
    why = "; ".join(run.reasons)
    return run.run, run.name, _most(run, "max"), _most(run, "rms"), begins, why


def _most(run: RunReplay, kind: Literal["max", "rms"]) -> str:
    """Return the axis whose following error changed most: by how much, from what to what."""

    def sides(error: ErrorChange) -> tuple[float | None, ...]:
        if kind == "max":
            return error.max_recorded, error.max_simulated, error.max_change
        return error.rms_recorded, error.rms_simulated, error.rms_change

    def size(error: ErrorChange) -> float:
        before, after, change = sides(error)
        return abs(change) if change is not None else math.inf * (before is not after)

    if not run.errors:
        return ""
    error = max(run.errors, key=size)
    before, after, change = sides(error)
    name = f"{error.variant}.{error.axis}"
    if change is None:
        return f"{name} {_microns(before)} to {_microns(after)}"
    return f"{name} {1e6 * change:+.3g} um, {_microns(before)} to {_microns(after)}"


def _microns(value: float | None) -> str:
    return "diverged" if value is None else f"{1e6 * value:.4g} um"


def _report(comparison: Replay) -> str:
    extent = f"{comparison.channels} channels, {comparison.ticks} ticks"
    if comparison.missing:
        extent += f", {comparison.missing} not recorded"
    if comparison.identical:
        return f"identical: {extent}"
    lines = [f"not identical: {extent}"]
    if comparison.first is not None:
        first = comparison.first
        size = (
            "" if first.difference is None else f", difference {first.difference:.6g} {first.unit}"
        )
        lines += [
            f"first at tick {first.tick}, t = {first.time:.4f} s: {first.channel} was "
            f"{_value(first.recorded)}, is {_value(first.simulated)}{size}",
            f"{comparison.samples} samples differ, of {', '.join(comparison.differing[:_NAMED])}"
            + (
                f" and {len(comparison.differing) - _NAMED} more"
                if comparison.differing[_NAMED:]
                else ""
            ),
        ]
    return "\n".join([*lines, *comparison.reasons])


def _value(value: float | str | None) -> str:
    return "missing" if value is None else f"{float(value):.9g}"
