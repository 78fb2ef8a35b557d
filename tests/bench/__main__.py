"""``python -m tests.bench``: every figure beside its target and its reference of the same run."""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile

from tests.bench.accuracy import accuracy
from tests.bench.command import command
from tests.bench.machine import AVX2_ENVIRONMENT, description
from tests.bench.speed import speed
from tests.bench.table import Table


def main() -> int:
    """Measure and print; return 1 only if something could not be run."""
    parser = argparse.ArgumentParser(prog="python -m tests.bench", description=__doc__)
    parser.add_argument(
        "--target",
        choices=("native", "avx2"),
        default="native",
        help="avx2: compile kernel and C for a processor without AVX-512 (haswell)",
    )
    avx2 = parser.parse_args().target == "avx2"
    if avx2 and os.environ.get("NUMBA_CPU_NAME") != AVX2_ENVIRONMENT["NUMBA_CPU_NAME"]:
        return _again_for_avx2()

    print(description())
    table = Table()
    table.add("speed", lambda: speed("haswell" if avx2 else "native"))
    table.add("accuracy", accuracy)
    table.add("command", command)
    print(f"{table.missed} of the targets missed" if table.missed else "every target met")
    return 0 if table.complete else 1


def _again_for_avx2() -> int:
    """Run this again where numba compiles for AVX2, with a cache of its own."""
    with tempfile.TemporaryDirectory() as cache:
        environment = os.environ | AVX2_ENVIRONMENT | {"NUMBA_CACHE_DIR": cache}
        again = (sys.executable, "-m", "tests.bench", "--target", "avx2")
        return subprocess.run(again, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
