"""A lab in this process: runs, studies and the kept runs of MOTIONLAB_DATA."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from motionlab.config.load import load_scenario
from motionlab.errors import naming_extras
from motionlab.executors.executor import executing
from motionlab.executors.progress import first_use, tick_bar
from motionlab.scripting.arguments import (
    Changes,
    Source,
    changes_of,
    check_number,
    check_words,
    present,
    readable,
    tables,
)
from motionlab.scripting.lab import Lab, shown_share
from motionlab.scripting.run import Run, record_of
from motionlab.scripting.study_result import StudyResult
from motionlab.studies.table import BY_KIND

if TYPE_CHECKING:
    from motionlab.library.library import Library
    from motionlab.scripting.kept import KeptRun


class Local(Lab):
    """A lab in this process, with the runs of MOTIONLAB_DATA."""

    def kept(self, run: str) -> KeptRun:
        """Return a kept run: its metrics, its scenario, and every channel.

        Parameters
        ----------
        run : str
            Its identifier, or a name that no other run has.

        Raises
        ------
        ConfigError
            If there is none.
        """
        from motionlab.scripting.kept import KeptRun

        check_words("run", run)
        ours = _kept_runs("kept")
        detail = ours.complete(ours.named(run, "run"))
        return KeptRun(detail.model_dump(mode="json"), lambda: ours.files.open(detail.id))

    def kept_runs(self, search: str = "", *, limit: int = 50) -> list[dict[str, Any]]:
        """Return the kept runs that a search finds, the newest first (docs/runs.md).

        Parameters
        ----------
        search : str
            Such as ``circle tag:good B.x.max<1um``; all runs when left out.
        limit : int
            At most so many, up to 200.
        """
        from motionlab.library.search import LIMIT_MAX, parse

        check_words("search", search)
        check_number("limit", limit, whole=True, minimum=1, maximum=LIMIT_MAX)
        ours = _kept_runs("kept_runs")
        ours.recover()  # what a server that was killed has left
        while ours.add_margins():
            pass
        page = ours.index.page(parse(search), limit=limit)
        return [run.model_dump(mode="json") for run in page.runs]

    @first_use()
    def _run(self, scenario: Source, changes: dict[str, Any], *, keep: bool, name: str) -> Run:
        from motionlab.simulation.prepare import prepare
        from motionlab.simulation.result import document
        from motionlab.simulation.run import run

        prepared = prepare(load_scenario(readable(scenario), changes))
        ours = _kept_runs("run(keep=True)") if keep else None
        with tick_bar(prepared.reference.ticks) as progress:
            recording = run(prepared, progress)
        result = document(prepared, recording)
        if ours is not None:
            result["run"] = ours.keep(prepared, recording, result, name=name).id
        return Run(result, lambda: record_of(recording, prepared.scenario))

    @first_use()
    def _study(
        self,
        kind: str,
        scenario: Source | None,
        set: Changes,
        scheduler: str | None,
        **request: Any,
    ) -> Any:
        if scheduler is not None:
            check_words("scheduler", scheduler)
        study = BY_KIND[kind]
        source = None if scenario is None else readable(scenario)
        if scenario is not None or set is not None:
            request["set"] = changes_of(set)
        with naming_extras(kind):
            plan = study.plan(tables(present(request), kind), source)
        if study.direct:
            return StudyResult(study, study.document(study.run(plan, lambda *_: None)))
        with executing(scheduler), shown_share(kind) as progress:
            result = study.run(plan, lambda share, _partial=None: progress(share))
        return StudyResult(study, study.document(result))


def _kept_runs(caller: str) -> Library:
    with naming_extras(caller):
        from motionlab.library.library import library

        return library()
