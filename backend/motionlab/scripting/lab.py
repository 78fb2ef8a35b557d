"""The calls of a lab: `local.Local` computes in this process, `client.Client` asks a server."""

from __future__ import annotations

import contextlib
import itertools
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import NDArray

from motionlab.errors import ConfigError, FieldError, RunWarning
from motionlab.executors.progress import has_bars, progress_shown, share_done, shows_progress
from motionlab.library.run import check_name
from motionlab.scripting.arguments import Changes, Source, changes_of, plain, tables
from motionlab.scripting.run import Run
from motionlab.scripting.study_result import StudyResult
from motionlab.studies.sweep.request import CASES_MAX, Searcher
from motionlab.studies.table import BY_KIND

if TYPE_CHECKING:
    from motionlab.motor_design.document import DesignDocument
    from motionlab.scripting.kept import KeptRun
    from motionlab.studies.identify.documents import IdentificationDocument
    from motionlab.studies.montecarlo.documents import MonteCarloDocument
    from motionlab.studies.sensitivity.documents import SensitivityDocument
    from motionlab.studies.sweep.documents import SweepDocument
    from motionlab.studies.tune.documents import TuneDocument

Values = Sequence[Any] | NDArray[Any] | Mapping[str, Any]
"""Values of a swept field, or ``{"start": ..., "stop": ..., "count": ..., "scale": "log"}``."""


Table = Mapping[str, Any] | None
Axis = Literal["x", "y"]
AxisChoice = Literal["x", "y", "both"]
Combination = Literal["grid", "list", "random", "latin-hypercube", "sobol", "search"]
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

    def sweep(  # noqa: PLR0913 - the fields of its request
        self,
        scenario: Source,
        grid: Mapping[str, Values],
        set: Changes = None,
        *,
        combine: Combination = "grid",
        samples: int | None = None,
        sampling_seed: int | None = None,
        searcher: Searcher | None = None,
        objectives: Sequence[str] = (),
        limits: Sequence[Mapping[str, Any]] = (),
        scheduler: str | None = None,
    ) -> StudyResult[SweepDocument]:
        """Run a scenario over values of any fields, listed, drawn or searched (docs/sweep.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        grid : mapping of str to values
            Dotted path to a sequence of values, SI or names, or to a range such as
            ``{"start": 1e5, "stop": 1e6, "count": 10, "scale": "log"}``, without ``count`` where
            `samples` is the number of cases.
        combine : str
            ``grid``: every combination; ``list``: first values together, then second ones;
            ``random``, ``latin-hypercube``, ``sobol``: drawn; ``search``: for least objectives.
        samples : int
            Cases that are drawn or searched.
        sampling_seed : int
            Of what is drawn or searched; 0 when left out.
        searcher : str
            ``cma-es``, ``nsga-ii``, ``tpe`` or ``gp``; chosen by the request when left out.
        objectives : sequence of str
            Such as ``B.worst.max_abs_following_error``: less is better, of margins more.
        limits : sequence of mapping
            Such as ``{"of": "B.x.gain_margin", "at_least": 2.0}``.
        scheduler : str
            As for `tune`.
        """
        if not isinstance(grid, Mapping):
            raise ConfigError(FieldError("grid", "is no mapping of paths to values", grid))
        request = {
            "grid": [{"path": path} | _dimension(path, values) for path, values in grid.items()],
            "combine": combine,
            "samples": samples,
            "sampling_seed": sampling_seed,
            "searcher": searcher,
            "objectives": list(objectives),
            "limits": list(limits),
        }
        return self._study("sweep", scenario, set, scheduler, **request)

    def sensitivity(  # noqa: PLR0913 - the fields of its request
        self,
        scenario: Source = "circle",
        set: Changes = None,
        *,
        fields: Sequence[str] = (),
        step: float = 0.01,
        margins: bool = False,
        scheduler: str | None = None,
    ) -> StudyResult[SensitivityDocument]:
        """Find how every metric changes with each number of a scenario (docs/sweep.md).

        Parameters
        ----------
        scenario, set
            As for `run`.
        fields : sequence of str
            Numbers, or tables for all numbers in them, by dotted path; all when left out.
        step : float
            Share by which each is changed, down and up.
        margins : bool
            Also of gain and phase margins.
        scheduler : str
            As for `tune`.
        """
        request = {"fields": list(fields), "step": step, "margins": margins}
        return self._study("sensitivity", scenario, set, scheduler, **request)

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
            Further numbers of the controller to search, such as ``compensation.gain``: any that its
            law declares.
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

    def study(
        self,
        kind: str,
        scenario: Source | None = None,
        set: Changes = None,
        *,
        scheduler: str | None = None,
        **fields: Any,
    ) -> StudyResult[Any]:
        """Carry out a study by its name: one that ships, or one's own (docs/rest.md, Studies).

        Parameters
        ----------
        kind : str
            Such as ``response``, ``learn`` or ``minute``: the kind of its jobs.
        scenario, set
            As for `run`; the study's own scenario when left out.
        scheduler : str
            As for `tune`.
        **fields
            Further fields of its request.
        """
        if kind not in BY_KIND:
            allowed = "one of " + ", ".join(BY_KIND)
            raise ConfigError(FieldError("kind", "is no study", kind, allowed))
        return self._study(kind, scenario, set, scheduler, **fields)

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
