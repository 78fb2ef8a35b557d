"""A search for the least objectives, with Optuna's ask and tell: whole batches are tried at once.

Searchers: CMA-ES (Hansen, The CMA evolution strategy: a tutorial, 2016), NSGA-II (Deb et al., IEEE
Trans. Evolutionary Computation 6(2), 2002), the tree-structured Parzen estimator (Bergstra et al.,
NIPS 2011) and Gaussian processes.
"""

from __future__ import annotations

import importlib
import warnings
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError, needs
from motionlab.studies.sweep.request import Dimension, SweepRequest
from motionlab.studies.sweep.run import Case, Results, SweepPlan

AT_ONCE = {"cma-es": 16, "nsga-ii": 32, "tpe": 8, "gp": 2}
"""Cases that are tried at once: a generation, or as many as a searcher chooses well together."""
_PENALTY = 2.0  # times the worst value so far, of a case without one
_FAR = 1e9  # beyond a limit, in shares of it
_MODULES = {"cma-es": ("cmaes",), "gp": ("torch",)}
"""What searchers need besides Optuna."""


def searcher_of(request: SweepRequest) -> str:
    """Return the searcher of a request, chosen for it where none is named."""
    if request.searcher is not None:
        return request.searcher
    if len(request.objectives) > 1:
        return "nsga-ii"
    listed = any(each.values is not None for each in request.grid)
    return "tpe" if listed or len(request.grid) == 1 else "cma-es"


def check_searcher(request: SweepRequest) -> None:
    """Refuse a searcher that cannot be used.

    Raises
    ------
    ConfigError
        If packages are missing, naming the extra, or cma-es, which learns how fields go together,
        has a single one.
    """
    searcher = searcher_of(request)
    if searcher == "cma-es" and len(request.grid) == 1:
        raise ConfigError(FieldError("searcher", "takes two fields or more", searcher))
    for module in ("optuna", *_MODULES.get(searcher, ())):
        try:
            importlib.import_module(module)
        except ImportError:
            why = "needs the package torch" if module == "torch" else needs(module)
            raise ConfigError(FieldError("searcher", why, searcher)) from None


def search(planned: SweepPlan, results: Results, tell: Callable[[float], None]) -> Iterator[None]:
    """Try cases, each batch chosen after the ones before; yield after each part.

    Parameters
    ----------
    planned : SweepPlan
        Whose request has `combine` search.
    results : Results
        Of the request's number of cases; receives them.
    tell : callable
        Takes the share done; what it raises ends the search.
    """
    import optuna  # noqa: PLC0415 - an extra

    optuna.logging.set_verbosity(optuna.logging.ERROR)
    request, total = planned.request, planned.request.samples or 0
    searcher = searcher_of(request)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        least: Any = ["minimize"] * len(request.objectives)
        study = optuna.create_study(sampler=_sampler(searcher, request), directions=least)
        while (done := len(results.cases)) < total:
            count = min(AT_ONCE[searcher], total - done)
            trials = [study.ask() for _ in range(count)]
            cases = [_case(trial, request, planned.whole) for trial in trials]

            def share(now: float, done: int = done, count: int = count) -> None:
                tell((done + now * count) / total)

            yield from results.run(cases, share)
            here = slice(done, done + count)
            over = results.excess()[: len(results.cases)]
            costs = _finite(results.costs()[: len(results.cases)])[here]
            limited = searcher != "cma-es"  # which knows no limits
            if not limited:
                costs = costs + _surcharge(costs, over[here])
            for trial, values, exceeded in zip(trials, costs, over[here], strict=True):
                for number, by in enumerate(exceeded.tolist() if limited else ()):
                    trial.set_constraint(str(number), min(by, _FAR))
                study.tell(trial, values.tolist())


def _sampler(searcher: str, request: SweepRequest) -> Any:
    """Return Optuna's sampler."""
    from optuna import samplers  # noqa: PLC0415 - an extra

    seed, size = request.seed, AT_ONCE[searcher]
    if searcher == "cma-es":
        return samplers.CmaEsSampler(seed=seed, popsize=size)
    if searcher == "nsga-ii":
        return samplers.NSGAIISampler(seed=seed, population_size=size)
    if searcher == "tpe":
        return samplers.TPESampler(seed=seed, multivariate=True, constant_liar=True)
    return samplers.GPSampler(seed=seed, deterministic_objective=True)


def _case(trial: Any, request: SweepRequest, whole: list[bool]) -> Case:
    return {
        dimension.path: _value(trial, dimension, of)
        for dimension, of in zip(request.grid, whole, strict=True)
    }


def _value(trial: Any, dimension: Dimension, whole: bool) -> Any:
    if dimension.values is not None:
        return trial.suggest_categorical(dimension.path, dimension.values)
    ends = dimension.at(0.0, whole=whole), dimension.at(1.0, whole=whole)
    suggest = trial.suggest_int if whole else trial.suggest_float
    return suggest(dimension.path, min(ends), max(ends), log=dimension.scale == "log")


def _finite(costs: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return costs with something worse than all others where a case has none."""
    able = np.where(np.isfinite(costs), costs, np.nan)
    if np.isnan(able).all():
        return np.zeros_like(costs)
    most = np.nanmax(able, axis=0)
    spread = np.nanmax(np.abs(able), axis=0)
    return np.where(np.isnan(able), most + (_PENALTY - 1.0) * spread, able)


def _surcharge(costs: NDArray[np.float64], over: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return what is added for exceeded limits: more than all objectives differ."""
    exceeded = np.minimum(np.maximum(over, 0.0), 1e3).sum(axis=1, keepdims=True)
    scale = np.abs(costs).max(initial=0.0)
    return np.where(exceeded > 0.0, scale * (1.0 + exceeded), 0.0)
