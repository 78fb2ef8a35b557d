"""What is checked of a law's file before a server takes it, in a process of its own.

A file is code: it may loop for ever, take all memory or end its process. So it is first run by a
child that has bounds of time and memory: ``python -m motionlab.own_laws.check FILE`` prints what
`Checked` holds as JSON.
"""

from __future__ import annotations

import dataclasses
import faulthandler
import importlib
import json
import os
import re
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import IO, Any

from motionlab.errors import FieldError
from motionlab.executors.progress import COMPILING, compiling, first_use
from motionlab.own_files import VARIABLE

SECONDS = 30.0
"""Time that a file may take, and its law until it has run, s; a compilation takes 1 to 3."""
_KERNEL_SECONDS = 600.0  # that the kernel takes besides, once on a machine
_POLL = 0.1  # s
_WRITTEN_MAX = 2**20  # bytes of what a child writes that are read
MEMORY = 4 * 2**30
"""Memory that a file may take, bytes."""

_TIMEOUT = "Timeout ("  # as faulthandler writes it
LINE = re.compile(r'File "([^"]+)", line (\d+)')


@dataclasses.dataclass(frozen=True)
class Checked:
    """What a check says of a file.

    Attributes
    ----------
    name : str
        Of the law; empty where there is none.
    problems : tuple of FieldError
        Why it cannot be taken; empty if it can.
    ns, share : float or None
        What a law costs in a control period, in ns and as a share of it; None where that has not
        been measured.
    """

    name: str
    problems: tuple[FieldError, ...] = ()
    ns: float | None = None
    share: float | None = None


def check_file(path: Path, *, seconds: float = SECONDS) -> Checked:
    """Check a file in a child process.

    Parameters
    ----------
    path : Path
        The file.
    seconds : float
        Time that it may take, s.

    Returns
    -------
    Checked
        With a problem, too, where the child had to be ended.
    """
    command = [sys.executable, "-m", __spec__.name, str(path), str(seconds)]
    environment = os.environ | {VARIABLE: str(path)}
    try:
        stdout, stderr = answer_of(command, environment, 2.0 * seconds + _KERNEL_SECONDS)
    except subprocess.TimeoutExpired:
        return no_answer(path, seconds, _TIMEOUT)
    try:
        return from_json(stdout)
    except ValueError:
        return no_answer(path, seconds, stderr)


def answer_of(
    command: Sequence[str], environment: Mapping[str, str], seconds: float
) -> tuple[bytes, str]:
    """Run a child, and say at once when it compiles the kernel.

    Returns
    -------
    bytes, str
        What it has written to stdout, and to stderr but for that.

    Raises
    ------
    subprocess.TimeoutExpired
        If it has not ended within some seconds; then it is ended.
    """
    nothing, end = subprocess.DEVNULL, time.monotonic() + seconds
    with (
        tempfile.TemporaryFile() as stdout,
        tempfile.TemporaryFile() as stderr,
        subprocess.Popen(
            command, env=environment, stdin=nothing, stdout=stdout, stderr=stderr
        ) as child,
    ):
        try:
            while child.poll() is None:
                try:
                    child.wait(_POLL)
                except subprocess.TimeoutExpired:
                    if COMPILING.encode() in _written(stderr):
                        compiling()
                    if time.monotonic() > end:
                        raise
        finally:
            child.kill()
        lines = _written(stderr).decode("utf-8", "replace").splitlines()
        return _written(stdout), "\n".join(line for line in lines if COMPILING not in line)


def _written(file: IO[bytes]) -> bytes:
    """Return the end of what a child has written to a file, whose offset it shares."""
    size = os.fstat(file.fileno()).st_size
    return os.pread(file.fileno(), _WRITTEN_MAX, max(0, size - _WRITTEN_MAX))


def as_json(result: Checked) -> str:
    """Return what a check says as one line of JSON."""
    answer: dict[str, Any] = dataclasses.asdict(result)
    for each in answer["problems"]:
        plain = isinstance(each["value"], (str, int, float, type(None)))
        each["value"] = each["value"] if plain else repr(each["value"])
    return json.dumps(answer)


def from_json(line: bytes) -> Checked:
    """Return what `as_json` has written.

    Raises
    ------
    ValueError
        If it is something else.
    """
    answer = json.loads(line)
    problems = tuple(FieldError(**each) for each in answer["problems"])
    return Checked(answer["name"], problems, answer["ns"], answer["share"])


def no_answer(path: Path, seconds: float, text: str) -> Checked:
    """Return why a child has ended without an answer, by what it has written to stderr."""
    lines = [line for file, line in LINE.findall(text) if file == str(path)]
    place = f"{path}:{lines[0]}" if lines else str(path)
    message = (
        f"has not ended within {seconds:g} s: an endless loop"
        if _TIMEOUT in text
        else f"ends the process that runs it: {(text.splitlines() or ['without a word'])[-1]}"
    )
    return Checked("", (FieldError(path.stem, message, place=place),))


def _main(path: Path, seconds: float) -> None:
    resource.setrlimit(resource.RLIMIT_DATA, (MEMORY, MEMORY))
    faulthandler.dump_traceback_later(seconds, exit=True)
    stdout, sys.stdout = sys.stdout, sys.stderr  # what the file prints is no answer
    # Only now: with the laws comes the file.
    laws: Any = importlib.import_module("motionlab.laws")
    problems = (each for each in laws.PROBLEMS if each.place.startswith(str(path)))
    result = Checked("", tuple(problems))  # of this file: installed packages have laws, too
    if not result.problems:
        faulthandler.cancel_dump_traceback_later()
        trial: Any = importlib.import_module("motionlab.own_laws.trial")
        with first_use():
            trial.warm_up(path)
            faulthandler.dump_traceback_later(seconds, exit=True)
            result = trial.with_cost(trial.try_file(path))
    print(as_json(result), file=stdout)


if __name__ == "__main__":
    _main(Path(sys.argv[1]), float(sys.argv[2]))
