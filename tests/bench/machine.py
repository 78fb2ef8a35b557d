"""What the machine is: processor, vector unit of compiled code, cores."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any

import numba
from llvmlite import binding
from numba.core.registry import cpu_target

AVX2_ENVIRONMENT = {
    "NUMBA_CPU_NAME": "haswell",
    "NUMBA_CPU_FEATURES": "+avx,+avx2,+fma,+f16c,+bmi,+bmi2,+lzcnt,+popcnt,+sse4.2",
}
"""Variables that make numba compile for a processor with AVX2 and no AVX-512."""


def processor() -> str:
    """Return the name of the processor."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or platform.machine()


def _target() -> tuple[str, str]:
    """Return name and features of the processor that numba compiles for."""
    context: Any = cpu_target.target_context
    _, name, features = context.codegen().magic_tuple()
    return name, features


def vector_unit() -> str:
    """Return the vector unit that numba compiles for: AVX-512, AVX2 or other."""
    have = set(_target()[1].split(","))
    if "+avx512f" in have:
        return "AVX-512"
    return "AVX2" if "+avx2" in have else "other"


def load() -> str:
    """Return how many processes wanted a core at once, on average over the last minute."""
    return f"{os.getloadavg()[0]:.1f}" if hasattr(os, "getloadavg") else "unknown"


def description() -> str:
    """Return the lines that head the table."""
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return (
        f"{processor()}, {cores} cores, load of the machine before this {load()}\n"
        f"numba {numba.__version__}, LLVM {'.'.join(map(str, binding.llvm_version_info))},"
        f" compiling for {_target()[0]}: {vector_unit()}"
    )
