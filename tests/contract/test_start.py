"""A server answers before what only some calls need is imported."""

from __future__ import annotations

import subprocess
import sys

LATER = {"scipy.interpolate", "scipy.optimize", "scipy.sparse", "skfem", "pyarrow"}


def test_a_start_imports_nothing_that_only_some_calls_need() -> None:
    script = f"import sys, motionlab.service.app; print(sys.modules.keys() & {LATER})"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"
