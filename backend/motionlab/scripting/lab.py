"""What scripts ask of a lab: `Local` computes in this process, `Client` asks a server."""

from __future__ import annotations

import contextlib
import itertools
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from motionlab.config.load import load_scenario
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, RunWarning
from motionlab.executors.executor import executing
from motionlab.progress import first_use, has_bars, is_told, share_done, tick_bar, told
from motionlab.runs.run import check_name
from motionlab.scripting.run import Run, record_of
from motionlab.scripting.study_result import StudyResult
from motionlab.studies.sweep.request import CASES_MAX
from motionlab.studies.table import BY_KIND

if TYPE_CHECKING:
    from motionlab.motor_design.document import DesignDocument
    from motionlab.studies.identify.document import IdentificationDocument
    from motionlab.studies.montecarlo.document import MonteCarloDocument
    from motionlab.studies.sweep.document import SweepDocument
    from motionlab.studies.tune.document import TuneDocument

Source = str | Path | Mapping[str, Any] | Scenario
"""A scenario: name of a shipped one, a ``.toml`` file, its tables, or one that was loaded."""

Changes = Mapping[str, Any] | None
"""Dotted path to value, SI, such as ``{"variants.B.controller.x.k_p": 312e3}``."""

Values = Sequence[Any] | NDArray[Any] | Mapping[str, Any]
"""Values of a swept field, or ``{"start": ..., "stop": ..., "count": ..., "scale": "log"}``."""


class Lab(ABC):
    """The calls that a script makes. Each checks its input before anything runs.

    A field that is wrong raises `motionlab.ConfigError` with its value, range and unit; a motion
    that the motor cannot follow raises `motionlab.Infeasible` with time, place, value and limit.
    """

    def run(
        self,
        scenario: Source = "circle",
        set: Changes = None,
        *,
        keep: bool = False,
        name: str = "",
    ) -> Run:
        """Run a scenario, all variants on the same noise.

        Parameters
        ----------
        scenario : str, Path, mapping or Scenario
            Name of a shipped one, a ``.toml`` file, tables, or one loaded before.
        set : mapping of str to value, optional
            Changes by dotted path, SI; a part is swapped by its name, as in
            ``{"plant": "matched"}``.
        keep : bool
            Whether to keep it among the runs (docs/runs.md).
        name : str
            What the kept run is called.

        Returns
        -------
        Run
            Metrics, comparison, and every channel; a variant that diverged is NaN from there on.

        Warns
        -----
        RunWarning
            For each of its notes: a loop that is unstable, a command at its limits, a divergence.
        """
        if keep:
            check_name(name)
        elif name:
            raise ConfigError(FieldError("name", "needs keep=True: it names a kept run", name))
        run = self._run(scenario, tables(set, "set"), keep=keep, name=name)
        for note in run.notes:
            warnings.warn(note, RunWarning, stacklevel=2)
        return run

    def sweep(
        self,
        scenario: Source,
        grid: Mapping[str, Values],
        set: Changes = None,
        *,
        combine: Literal["grid", "list"] = "grid",
    ) -> StudyResult[SweepDocument]:
        """Run a scenario over a grid, or a list, of values of any fields (docs/sweep.md).

        Parameters
        ----------
        scenario, set
            As of `run`.
        grid : mapping of str to values
            Dotted path to a sequence of values, SI or names, or to a range such as
            ``{"start": 1e5, "stop": 1e6, "count": 10, "scale": "log"}``.
        combine : str
            ``grid``: every combination; ``list``: first values together, then second ones.
        """
        if not isinstance(grid, Mapping):
            raise ConfigError(FieldError("grid", "is no mapping of paths to values", grid))
        fields = [{"path": path} | _dimension(path, values) for path, values in grid.items()]
        return self._study("sweep", scenario, set, grid=fields, combine=combine)

    def tune(
        self, scenario: Source = "circle", set: Changes = None, **request: Any
    ) -> StudyResult[TuneDocument]:
        """Search gains of one variant by the simplex, under constraints (docs/tune.md).

        Parameters
        ----------
        scenario, set
            As of `run`.
        **request
            ``variant``, ``axis`` (x, y, both), ``objective`` (metric to weight), ``constraints``,
            ``bounds`` (gain to low and high), ``also``, ``starts``, ``evaluations``, ``plants``,
            ``window``: the fields of ``POST /tune``.

        Returns
        -------
        StudyResult
            ``result.set`` puts the best gains into the scenario.
        """
        return self._study("tune", scenario, set, **request)

    def identify(
        self, scenario: Source = "circle", set: Changes = None, **request: Any
    ) -> StudyResult[IdentificationDocument]:
        """Identify friction by an experiment on the motor, or from a run (docs/identify.md).

        Parameters
        ----------
        scenario, set
            As of `run`.
        **request
            ``axis``, ``speeds`` (m/s), ``time_max`` (s), ``pitches_max``, ``presliding``,
            ``variant``, ``apply_to``, ``compare``; of a run ``run`` and ``record``: the fields of
            ``POST /identify``.

        Returns
        -------
        StudyResult
            ``result.set`` puts what was identified into the controller's model.
        """
        return self._study("identify", scenario, set, **request)

    def montecarlo(
        self, scenario: Source = "circle", set: Changes = None, **request: Any
    ) -> StudyResult[MonteCarloDocument]:
        """Run a scenario on many plausible motors (docs/montecarlo.md).

        Parameters
        ----------
        scenario, set
            As of `run`.
        **request
            ``cases`` (300), ``seed``, ``spec`` (axis to largest following error, m), ``vary``: the
            fields of ``POST /montecarlo``.
        """
        return self._study("monte-carlo", scenario, set, **request)

    def design(self, **request: Any) -> StudyResult[DesignDocument]:
        """Size a motor by equations (1) to (14), as printed beside corrected (docs/design.md).

        Parameters
        ----------
        **request
            ``preset`` (paper, previous), ``requirements``, ``dimensions``: tables, SI. Nothing is
            the paper's example.
        """
        return self._study("design", None, None, **request)

    @abstractmethod
    def _run(self, scenario: Source, changes: dict[str, Any], *, keep: bool, name: str) -> Run:
        """Return a run."""

    @abstractmethod
    def _study(self, kind: str, scenario: Source | None, set: Changes, **request: Any) -> Any:
        """Return the result of a study."""


class Local(Lab):
    """A lab in this process."""

    @first_use()
    def _run(self, scenario: Source, changes: dict[str, Any], *, keep: bool, name: str) -> Run:
        from motionlab.simulation.prepare import prepare
        from motionlab.simulation.result import document
        from motionlab.simulation.run import run

        prepared = prepare(load_scenario(readable(scenario), changes))
        with tick_bar(prepared.reference.ticks) as progress:
            recording = run(prepared, progress)
        found = document(prepared, recording)
        if keep:
            from motionlab.runs.library import library

            found["run"] = library().keep(prepared, recording, found, name=name).id
        return Run(found, lambda: record_of(recording, prepared.scenario))

    @first_use()
    def _study(self, kind: str, scenario: Source | None, set: Changes, **request: Any) -> Any:
        study = BY_KIND[kind]
        source = None if scenario is None else readable(scenario)
        if scenario is not None:
            request |= {"set": tables(set, "set")}
        plan = study.plan(tables(request, kind), source)
        if study.direct:
            return StudyResult(study, study.document(study.run(plan, lambda *_: None)))
        with executing(None), shown_share(kind) as progress:
            found = study.run(plan, lambda share, _partial=None: progress(share))
        return StudyResult(study, study.document(found))


def readable(scenario: Source) -> str | Path | dict[str, Any]:
    """Return a scenario as `load_scenario` takes it; text that ends with ``.toml`` is a path."""
    match scenario:
        case Scenario():
            return scenario.model_dump(mode="json")
        case Mapping():
            return tables(scenario, "scenario")
        case str() | Path():
            return path_of(scenario, "scenario")
    kinds = "a name, a .toml file, tables or a Scenario"
    raise ConfigError(FieldError("scenario", f"is a {type(scenario).__name__}", range=kinds))


def path_of(text: str | Path, loc: str) -> str | Path:
    """Return text that ends with ``.toml`` as a path."""
    if "\0" in str(text):
        raise ConfigError(FieldError(loc, "holds a zero byte", str(text)))
    return Path(text) if str(text).endswith(".toml") else text


def tables(value: object, loc: str) -> dict[str, Any]:
    """Return a mapping in types of JSON; None is an empty one.

    Raises
    ------
    ConfigError
        If it is no mapping of names, or nested too deeply.
    """
    if value is None:
        return {}
    if not isinstance(value, Mapping) or not all(isinstance(key, str) for key in value):
        raise ConfigError(FieldError(loc, "is no mapping of names to values", value))
    try:
        return plain(value)
    except RecursionError:
        raise ConfigError(FieldError(loc, "is nested too deeply")) from None


def plain(value: Any) -> Any:
    """Return a value in types of JSON: arrays and numbers of numpy become Python's."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple | range):
        return [plain(item) for item in value]
    return value


@contextlib.contextmanager
def shown_share(title: str) -> Iterator[Callable[[float], None]]:
    """Show the share of long work that is done in a terminal or a notebook, nowhere else."""
    with told(is_told() and has_bars()), share_done(title) as progress:
        yield progress


def _dimension(path: str, values: Values) -> dict[str, Any]:
    if isinstance(values, Mapping):
        return tables(values, f"grid.{path}")
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ConfigError(FieldError(f"grid.{path}", "is no list of values", values))
    # One more than is allowed, so that an endless one is refused.
    return {"values": plain(list(itertools.islice(values, CASES_MAX + 1)))}
