"""The calls of a lab: `local.Local` computes in this process, `client.Client` asks a server."""

from __future__ import annotations

import contextlib
import itertools
import operator
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from motionlab.config.changes import with_files
from motionlab.config.scenario import Scenario
from motionlab.errors import ConfigError, FieldError, RunWarning, naming_extras
from motionlab.executors.progress import has_bars, progress_shown, share_done, shows_progress
from motionlab.library.run import check_name
from motionlab.scripting.run import Run
from motionlab.scripting.study_result import StudyResult
from motionlab.studies.sweep.documents import CASES_MAX

if TYPE_CHECKING:
    from motionlab.motor_design.document import DesignDocument
    from motionlab.scripting.kept import KeptRun
    from motionlab.studies.identify.documents import IdentificationDocument
    from motionlab.studies.montecarlo.documents import MonteCarloDocument
    from motionlab.studies.sweep.documents import SweepDocument
    from motionlab.studies.tune.documents import TuneDocument

Source = str | Path | Mapping[str, Any] | Scenario
"""A scenario: name of a shipped one, a ``.toml`` file, its tables, or one that was loaded."""

Changes = Mapping[str, Any] | None
"""Dotted path to value, SI, such as ``{"variants.B.controller.x.k_p": 312e3}``."""

Values = Sequence[Any] | NDArray[Any] | Mapping[str, Any]
"""Values of a swept field, or ``{"start": ..., "stop": ..., "count": ..., "scale": "log"}``."""


Table = Mapping[str, Any] | None
Axis = Literal["x", "y"]
AxisChoice = Literal["x", "y", "both"]
Objective = Literal["peak", "rms", "itae", "settling", "effort"]


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
        run = self._run(scenario, changes_of(set), keep=keep, name=name)
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
        scheduler: str | None = None,
    ) -> StudyResult[SweepDocument]:
        """Run a scenario over a grid, or a list, of values of any fields (docs/sweep.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        grid : mapping of str to values
            Dotted path to a sequence of values, SI or names, or to a range such as
            ``{"start": 1e5, "stop": 1e6, "count": 10, "scale": "log"}``.
        combine : str
            ``grid``: every combination; ``list``: first values together, then second ones.
        scheduler : str
            As for `tune`.
        """
        if not isinstance(grid, Mapping):
            raise ConfigError(FieldError("grid", "is no mapping of paths to values", grid))
        fields = [{"path": path} | _dimension(path, values) for path, values in grid.items()]
        return self._study("sweep", scenario, set, scheduler, grid=fields, combine=combine)

    def tune(  # noqa: PLR0913 - the fields of its request
        self,
        scenario: Source = "circle",
        set: Changes = None,
        *,
        variant: str | None = None,
        axis: AxisChoice = "both",
        objective: Mapping[Objective, float] | None = None,
        bounds: Table = None,
        window: Table = None,
        plants: Sequence[str] = (),
        constraints: Table = None,
        also: Mapping[str, tuple[float, float]] | None = None,
        starts: int = 4,
        evaluations: int = 200,
        scheduler: str | None = None,
    ) -> StudyResult[TuneDocument]:
        """Search gains of one variant by the simplex, under constraints (docs/tune.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        variant : str
            Whose gains; the second variant, or the only one, when left out.
        axis : str
            ``x``, ``y`` or ``both``.
        objective : mapping of str to float
            Weights of ``peak``, ``rms`` (um), ``itae`` (um s^2), ``settling`` (10 ms) and
            ``effort`` (N); ``{"rms": 1.0}`` when left out.
        bounds : mapping
            ``k_p`` (N/m) and ``k_d`` (N s/m), each low and high.
        window : mapping
            ``start`` and ``end`` of the metrics, s; the second lap when left out.
        plants : sequence of str
            Shipped motors on which the gains must do as well; the worst one counts.
        constraints : mapping
            ``gain_margin`` (1), ``phase_margin`` (rad), ``Ms`` (1), ``saturated`` (1), ``force``
            (N); None switches one off.
        also : mapping of str to (low, high)
            Further numbers of the controller to search, such as ``compensation.gain``.
        starts : int
            Starts of the simplex, the first from the present gains.
        evaluations : int
            Most evaluations of a start.
        scheduler : str
            Who computes: ``threads``, ``processes``, ``processes:N`` or a Dask scheduler
            (docs/cluster.md); that of MOTIONLAB_SCHEDULER when left out.

        Returns
        -------
        StudyResult
            ``result.set`` puts the best gains into the scenario.
        """
        request = {
            "variant": variant,
            "axis": axis,
            "objective": objective,
            "bounds": bounds,
            "window": window,
            "plants": plants,
            "constraints": constraints,
            "also": also,
            "starts": starts,
            "evaluations": evaluations,
        }
        return self._study("tune", scenario, set, scheduler, **request)

    def identify(  # noqa: PLR0913 - the fields of its request
        self,
        scenario: Source = "circle",
        set: Changes = None,
        *,
        axis: AxisChoice = "both",
        speeds: Sequence[float] | NDArray[Any] | None = None,
        time_max: float = 20.0,
        pitches_max: int | None = None,
        presliding: Table = None,
        variant: str | None = None,
        apply_to: str | None = None,
        run: str | None = None,
        record: Table = None,
        compare: bool = False,
        scheduler: str | None = None,
    ) -> StudyResult[IdentificationDocument]:
        """Identify friction by an experiment on the motor, or from a run (docs/identify.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        axis : str
            ``x``, ``y`` or ``both``.
        speeds : sequence of float
            Speeds of the uniform motions, m/s, each run both ways; 32 from 0.5 to 150 mm/s when
            left out.
        time_max : float
            Time after which a uniform motion takes no further pole pitch, s.
        pitches_max : int
            Most pole pitches that a force is averaged over.
        presliding : mapping
            ``enabled``, ``rates`` (N/s), ``share`` (of the stiction) and ``places`` of the force
            ramps.
        variant : str
            Whose gains and force map drive the motor; the first when left out.
        apply_to : str
            Whose model the result is for; the second, or the only one, when left out.
        run : str
            Identifier of a kept run to identify from; nothing moves then.
        record : mapping
            What of that run: ``position``, ``force``, ``mass`` (kg), ``bandwidth`` (Hz), ``start``
            and ``end`` (s).
        compare : bool
            Whether to run the circle with the old model and the new one.
        scheduler : str
            As for `tune`.

        Returns
        -------
        StudyResult
            ``result.set`` puts what was identified into the controller's model.
        """
        request = {
            "axis": axis,
            "speeds": speeds,
            "time_max": time_max,
            "pitches_max": pitches_max,
            "presliding": presliding,
            "variant": variant,
            "apply_to": apply_to,
            "run": run,
            "record": record,
            "compare": compare,
        }
        return self._study("identify", scenario, set, scheduler, **request)

    def montecarlo(  # noqa: PLR0913 - the fields of its request
        self,
        scenario: Source = "circle",
        set: Changes = None,
        *,
        cases: int = 300,
        seed: int | None = None,
        vary: Sequence[Mapping[str, Any]] | None = None,
        spec: Mapping[Axis, float] | None = None,
        table: bool = True,
        scheduler: str | None = None,
    ) -> StudyResult[MonteCarloDocument]:
        """Run a scenario on many plausible motors (docs/montecarlo.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        cases : int
            Motors to draw, 2 to 5000.
        seed : int
            Of the draws; the scenario's when left out.
        vary : sequence of mapping
            How the motors differ: ``path``, ``kind`` and ``sigma``, ``low`` and ``high``, or
            ``value``.
        spec : mapping of str to float
            Largest following error allowed on an axis, m.
        table : bool
            Whether `rows` has every metric and drawn number, or the largest errors alone.
        scheduler : str
            As for `tune`.
        """
        request = {"cases": cases, "seed": seed, "vary": vary, "spec": spec, "table": table}
        return self._study("monte-carlo", scenario, set, scheduler, **request)

    def design(
        self,
        *,
        preset: Literal["paper", "previous"] = "paper",
        requirements: Table = None,
        dimensions: Table = None,
    ) -> StudyResult[DesignDocument]:
        """Size a motor by equations (1) to (14), as printed beside corrected (docs/design.md).

        Parameters
        ----------
        preset : str
            ``paper``, its example, or ``previous``, the design before it.
        requirements : mapping
            ``f_max`` (N), ``v_max`` (m/s), ``i`` (A), ``tau`` (m) and others, from which dimensions
            follow.
        dimensions : mapping
            Dimensions from which limits follow; the preset's when left out.
        """
        request = {"preset": preset, "requirements": requirements, "dimensions": dimensions}
        return self._study("design", None, None, None, **request)

    @abstractmethod
    def kept(self, run: str) -> KeptRun:
        """Return a kept run: its metrics, its scenario, and every channel.

        Parameters
        ----------
        run : str
            Its identifier; in this process also a name that no other run has.
        """

    @abstractmethod
    def _run(self, scenario: Source, changes: dict[str, Any], *, keep: bool, name: str) -> Run:
        """Return a run."""

    @abstractmethod
    def _study(
        self,
        kind: str,
        scenario: Source | None,
        set: Changes,
        scheduler: str | None,
        **request: Any,
    ) -> Any:
        """Return the result of a study; fields of the request that are None are left out."""


def present(request: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fields of a request that are not left out."""
    return {name: value for name, value in request.items() if value is not None}


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
    raise ConfigError(FieldError("scenario", f"must be {kinds}", scenario))


def path_of(text: str | Path, loc: str) -> str | Path:
    """Return text that ends with ``.toml`` as a path."""
    if "\0" in str(text):
        raise ConfigError(FieldError(loc, "holds a zero byte", str(text)))
    return Path(text) if str(text).endswith(".toml") else text


def changes_of(value: object) -> dict[str, Any]:
    """Return changes in types of JSON, the files that they name for a part read."""
    return with_files(tables(value, "set"))


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
        return _with_motion(plain(value))
    except RecursionError:
        raise ConfigError(FieldError(loc, "is nested too deeply")) from None


def _with_motion(value: dict[str, Any]) -> dict[str, Any]:
    """Return a table in which samples of a kept run stand in its place."""
    own = value.get("kind") == "samples"
    motion = value if own else value.get("trajectory")
    if not (isinstance(motion, dict) and motion.get("kind") == "samples" and "run" in motion):
        return value
    with naming_extras("the motion of a kept run"):
        from motionlab.exchange.run_motion import motion_of_run

    others = {key: item for key, item in motion.items() if key != "run"}
    table = motion_of_run(str(motion["run"]), "trajectory.run") | others
    return table if own else value | {"trajectory": table}


def plain(value: Any) -> Any:
    """Return a value in types of JSON: arrays and numbers of numpy become Python's."""
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return value.tolist()
    if isinstance(value, list | tuple | range):
        return [plain(item) for item in value]
    return str(value) if isinstance(value, Path) else value


_HOLDS = {
    "minimum": operator.ge,
    "exclusive_minimum": operator.gt,
    "maximum": operator.le,
    "exclusive_maximum": operator.lt,
}


def check_number(
    loc: str, value: object, *, unit: str = "", whole: bool = False, **bounds: float
) -> None:
    """Check a number that no request does.

    Raises
    ------
    ConfigError
        If it is none, or beyond its bounds.
    """
    kinds = (int, np.integer) if whole else (int, float, np.integer, np.floating)
    if not isinstance(value, kinds) or isinstance(value, bool):
        message = "must be a whole number" if whole else "must be a number"
    elif not all(_HOLDS[name](value, bound) for name, bound in bounds.items()):
        message = "is out of range"
    else:
        return
    raise ConfigError(FieldError(loc, message, value, unit=unit, bounds=bounds))


def check_words(loc: str, value: object) -> None:
    """Check text that no request does.

    Raises
    ------
    ConfigError
        If it is something else.
    """
    if not isinstance(value, str):
        raise ConfigError(FieldError(loc, "must be text", value))


@contextlib.contextmanager
def shown_share(title: str) -> Iterator[Callable[[float], None]]:
    """Show the share of long work that is done in a terminal or a notebook, nowhere else."""
    with progress_shown(shows_progress() and has_bars()), share_done(title) as progress:
        yield progress


def _dimension(path: str, values: Values) -> dict[str, Any]:
    if isinstance(values, Mapping):
        return tables(values, f"grid.{path}")
    if isinstance(values, str) or not isinstance(values, Iterable):
        raise ConfigError(FieldError(f"grid.{path}", "is no list of values", values))
    # One more than is allowed, so that an endless one is refused.
    return {"values": plain(list(itertools.islice(values, CASES_MAX + 1)))}
