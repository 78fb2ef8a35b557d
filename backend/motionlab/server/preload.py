"""Imports and compiled code in advance of the first request."""

from __future__ import annotations

import importlib
import pkgutil
from collections.abc import Callable

from motionlab import studies
from motionlab.simulation.precompile import first_use, rare_use


def warm_up(done: Callable[[float], None] = lambda _: None) -> None:
    """Load simulations and path checks; compile them on the first start.

    Parameters
    ----------
    done : callable, optional
        Takes the share of compiling that is done, 0 to 1.
    """
    first_use(done)
    importlib.import_module("motionlab.server.routes.trajectories")
    importlib.import_module("motionlab.library.spool")  # which the first Play needs


def load_the_rest() -> None:
    """Load rarely used modules: studies, runs, scipy, and skfem by a force-map preview."""
    rare_use()
    for module in pkgutil.walk_packages(studies.__path__, "motionlab.studies."):
        importlib.import_module(module.name)
    importlib.import_module("motionlab.library.index")
    importlib.import_module("pyarrow.parquet")
