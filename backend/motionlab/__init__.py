"""A motion lab for planar switched reluctance motors.

::

    import motionlab

    run = motionlab.run("circle", set={"variants.B.controller.x.k_p": 400e3})
    run.metrics["B"]["x"]["max_abs_following_error"]  # m
    run["B.x.following_error"]  # an array, m, over run.time, s
"""

import importlib
import os
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from motionlab.errors import ConfigError, Infeasible, MotionLabError, RunWarning
    from motionlab.scripting.client import Client
    from motionlab.scripting.here import (
        design,
        identify,
        kept,
        kept_runs,
        montecarlo,
        run,
        sensitivity,
        study,
        sweep,
        tune,
    )
    from motionlab.scripting.http_client import ServerRefused
    from motionlab.scripting.kept import KeptRun
    from motionlab.scripting.linear import linearise
    from motionlab.scripting.motion import trajectory
    from motionlab.scripting.run import Run
    from motionlab.scripting.session import Session
    from motionlab.scripting.study_result import StudyResult

try:
    from motionlab._version import __version__
except ModuleNotFoundError:  # sources that were never built
    __version__ = "0+unknown"

__all__ = [
    "Client",
    "ConfigError",
    "Infeasible",
    "KeptRun",
    "MotionLabError",
    "Run",
    "RunWarning",
    "ServerRefused",
    "Session",
    "StudyResult",
    "design",
    "identify",
    "kept",
    "kept_runs",
    "linearise",
    "montecarlo",
    "run",
    "sensitivity",
    "study",
    "sweep",
    "trajectory",
    "tune",
]

# Before numpy is loaded: matrices are small here, and simulations fill the cores with threads of
# their own, between which those of OpenBLAS only spin.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

_HOMES = {
    "Client": "scripting.client",
    "ConfigError": "errors",
    "Infeasible": "errors",
    "KeptRun": "scripting.kept",
    "MotionLabError": "errors",
    "Run": "scripting.run",
    "RunWarning": "errors",
    "ServerRefused": "scripting.http_client",
    "Session": "scripting.session",
    "StudyResult": "scripting.study_result",
    "linearise": "scripting.linear",
    "trajectory": "scripting.motion",
}


def __getattr__(name: str) -> Any:
    """Return a name of `__all__`, imported when it is first used: the package itself is light."""
    if name not in __all__:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    module = importlib.import_module(f"{__name__}.{_HOMES.get(name, 'scripting.here')}")
    globals()[name] = getattr(module, name)
    return globals()[name]


def __dir__() -> list[str]:
    return sorted({*__all__, "__version__", "__doc__"})
