"""The kernel as a WebAssembly module, for the page: ``python -m motionlab.targets.wasm FILE``.

numba must compile for a processor without extensions while the module is made, or intrinsics of
this machine's would appear in it: a process of its own does that, whose compiled code is discarded.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

_GENERIC = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}


def build(file: Path) -> None:
    """Write the module to a file.

    Raises
    ------
    subprocess.CalledProcessError
        If it cannot be compiled; the compiler's message has been printed.
    """
    file.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="motionlab-") as folder:
        subprocess.run(
            [sys.executable, "-m", "motionlab.targets.wasm_compile", str(file)],
            env={**os.environ, **_GENERIC, "NUMBA_CACHE_DIR": folder},
            check=True,
        )


if __name__ == "__main__":
    build(Path(sys.argv[1]))
