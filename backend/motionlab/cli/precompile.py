"""The command ``motionlab precompile``: compile everything once, rather than on first use."""

from __future__ import annotations

import argparse
import contextlib
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from typing import Any

from motionlab.cli.messages import say
from motionlab.errors import DONE, MotionLabError
from motionlab.executors.progress import share_done

EXAMPLES = """\
examples:
  motionlab precompile
"""


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
    from motionlab.simulation.precompile import LAST_OF_KERNEL

    with share_done("compile") as progress, contextlib.ExitStack() as processes:
        progress(0.0)
        compilers = [processes.enter_context(_Compiler("motionlab.simulation.precompile"))]
        for line in compilers[0].lines():
            share, step = line.split(maxsplit=1)
            progress(float(share))
            if step.strip() == LAST_OF_KERNEL:  # which drives call: they find it compiled
                compilers.append(processes.enter_context(_Compiler("motionlab.drive.precompile")))
        for compiler in compilers:
            compiler.wait()
    say(f"everything is compiled, in {cache_folder()}")
    return DONE


class _Compiler(contextlib.AbstractContextManager["_Compiler"]):
    """A process that compiles, which ends with its block."""

    def __init__(self, module: str) -> None:
        self._module = module
        self._errors = tempfile.TemporaryFile("w+")
        self._process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=self._errors,
            text=True,
        )

    def lines(self) -> Iterator[str]:
        """Yield what it prints."""
        assert self._process.stdout is not None
        yield from self._process.stdout

    def wait(self) -> None:
        """Wait for its end."""
        if (code := self._process.wait()) != 0:
            self._errors.seek(0)
            last = (self._errors.read().strip().splitlines() or [f"exit code {code}"])[-1]
            raise MotionLabError(f"{self._module} could not compile: {last}")

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.communicate()
        self._errors.close()
