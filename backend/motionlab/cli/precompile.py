"""The command ``motionlab precompile``: compile everything once, rather than on first use."""

from __future__ import annotations

import argparse
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from typing import Any

from motionlab.cli.messages import say
from motionlab.errors import DONE, MotionLabError
from motionlab.executors.progress import share_done

EXAMPLES = """\
examples:
  motionlab precompile
"""

_PARTS = "motionlab.simulation.precompile", "motionlab.drive.precompile"
"""Modules that compile, each in a process of its own."""


def add(commands: Any) -> None:
    """Add ``motionlab precompile``."""
    parser = commands.add_parser(
        "precompile",
        help="compile the model once, so that no first use has to",
        description="Compile the model and everything else that is compiled on first use: "
        "simulations, studies, trajectories, drives. What is compiled already is left as it is.",
        epilog=EXAMPLES,
    )
    parser.set_defaults(command=_precompile)


def _precompile(_: argparse.Namespace) -> int:
    from motionlab.lanes.compiler.cache import cache_folder

    with share_done("compile") as progress, ThreadPoolExecutor(len(_PARTS)) as threads:
        progress(0.0)
        for count, done in enumerate(as_completed(threads.submit(_compile, m) for m in _PARTS), 1):
            done.result()
            progress(count / len(_PARTS))
    say(f"everything is compiled, in {cache_folder()}")
    return DONE


def _compile(module: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", module],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    if done.returncode != 0:
        last = (done.stderr.strip().splitlines() or [f"exit code {done.returncode}"])[-1]
        raise MotionLabError(f"{module} could not compile: {last}")
