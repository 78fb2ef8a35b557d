"""C compilers of this machine, and exported controllers built with them."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path

import pytest

STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
SOURCES = ("check.c", "psrm_controller.c", "psrm_parameters.c")
"""Of an export."""


def compiler(name: str) -> str:
    """Return a compiler's path; skip the test without it, or fail where CI has to have it."""
    found = shutil.which(name)
    if found is None:
        reason = f"there is no {name}"
        if os.environ.get("CI") == "true":
            pytest.fail(reason, pytrace=False)
        pytest.skip(reason)
    return found


def call(*command: str | Path, cwd: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run a command and return what it printed."""
    words = [str(word) for word in command]
    return subprocess.run(words, cwd=cwd, capture_output=True, text=True, check=False, timeout=600)


def built(*command: str | Path, cwd: Path | None = None) -> None:
    """Run a compiler, which has to succeed without a word."""
    done = call(*command, cwd=cwd)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", ""), done.stderr
