"""The command ``motionlab precompile``: compile everything once, rather than on first use."""

from __future__ import annotations

import argparse
import subprocess
import sys
import threading
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from typing import Any

from motionlab.cli.messages import say
from motionlab.errors import DONE, MotionLabError
from motionlab.executors.progress import share_done

EXAMPLES = """\
examples:
  motionlab precompile
"""

_PARTS = (
    ("motionlab.simulation.precompile", "motionlab.server.preload"),
    ("motionlab.drive.precompile",),
)
"""Modules that compile, in processes of their own: those of a line one after the other."""


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
    from motionlab.lanes.compile_cache import cache_folder

    modules, lock, share = sum(map(len, _PARTS)), threading.Lock(), 0.0
    with share_done("compile") as progress, ThreadPoolExecutor(len(_PARTS)) as threads:

        def compile_in_turn(parts: tuple[str, ...]) -> None:
            nonlocal share
            for module in parts:
                _compile(module)
                with lock:
                    share += 1.0 / modules
                    progress(share)

        progress(0.0)
        list(threads.map(compile_in_turn, _PARTS))
    say(f"everything is compiled, in {cache_folder()}")
    return DONE


def _compile(module: str) -> None:
    if module.startswith("motionlab.server.") and find_spec("fastapi") is None:
        return  # the extra lab is not installed
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
