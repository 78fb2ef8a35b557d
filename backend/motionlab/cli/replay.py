"""The command ``motionlab replay``."""

from __future__ import annotations

import argparse
import json
from typing import TYPE_CHECKING, Any

from motionlab.cli.output import show
from motionlab.errors import DONE, FAILED
from motionlab.executors.progress import share_done
from motionlab.studies.options import add_json

if TYPE_CHECKING:
    from motionlab.library.replay import Replay

_NAMED = 6  # channels that are listed


def add(commands: Any) -> None:
    """Add ``motionlab replay``."""
    parser = commands.add_parser(
        "replay",
        help="simulate a kept run again and compare every bit",
        description="Simulate a kept run again from its record and compare every channel, bit for "
        "bit. The exit code is 1 unless all are the same.",
    )
    parser.add_argument(
        "run", metavar="RUN", help="identifier or name of a run; motionlab runs lists them"
    )
    add_json(parser)
    parser.set_defaults(command=_replay)


def _replay(options: argparse.Namespace) -> int:
    from motionlab.library.library import library
    from motionlab.library.replay import again, replay

    kept = library()
    run = kept.named(options.run)
    recorded = again(kept.complete(run))
    with kept.files.open(run) as file, share_done("replay") as progress:
        comparison = replay(recorded, file, progress)
    if options.json:
        print(json.dumps(comparison.model_dump(mode="json"), allow_nan=False))
    else:
        show(_report(comparison))
    return DONE if comparison.identical else FAILED


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
