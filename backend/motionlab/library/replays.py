"""Many runs simulated again: which of them have moved, by how much, and why."""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

from pydantic import BaseModel, Field

from motionlab import __version__
from motionlab.errors import MotionLabError
from motionlab.executors.code import processor
from motionlab.lanes import model_hash
from motionlab.library.library import Library
from motionlab.library.replay import FirstDifference, again, replay, samples_size
from motionlab.library.replayed_errors import ErrorChange
from motionlab.library.run import Run
from motionlab.library.search import LIMIT_MAX, Search
from motionlab.telemetry.channels import stream_columns

_SIMULATED = {"simulation", "live"}
"""Kinds of runs that can be simulated again."""

Outcome = Literal["identical", "moved", "not replayable"]


class RunReplay(BaseModel):
    """What became of one run when it was simulated again."""

    run: str = Field(description="Its identifier")
    name: str
    outcome: Outcome = Field(description="identical: of all samples that were recorded")
    first: FirstDifference | None = Field(default=None, description="Of one that has moved")
    samples: int = Field(default=0, description="Samples that differ")
    change: float | None = Field(
        default=None,
        description="Largest change of a largest or RMS following error, m; null where a variant "
        "diverges now, or no longer, and of what did not move",
    )
    errors: list[ErrorChange] = Field(
        default_factory=list, description="Of one that has moved: of each variant and axis"
    )
    reasons: list[str] = Field(
        default_factory=list, description="What may be why, or why it cannot be simulated again"
    )

    @property
    def distance(self) -> tuple[int, float, int]:
        """What runs are sorted by: that which moved most has the largest."""
        size = max((error.size for error in self.errors), default=0.0)
        rank: dict[Outcome, int] = {"identical": 0, "not replayable": 1, "moved": 2}
        return rank[self.outcome], size, self.samples


class Replays(BaseModel):
    """Kept runs simulated again: those that moved most first, the identical ones last."""

    version: str = Field(
        default_factory=lambda: __version__, description="Version that simulated them again"
    )
    model: str = Field(description="Hash of the model's sources")
    processor: str
    total: int = Field(description="Runs that the search finds")
    interrupted: bool = Field(description="Whether runs are missing because it was interrupted")
    identical: int = Field(description="Runs that are identical")
    moved: int = Field(description="Runs that have moved")
    not_replayable: int = Field(description="Runs that cannot be simulated again")
    runs: list[RunReplay]


class Demand(NamedTuple):
    """What it takes to simulate runs again.

    Attributes
    ----------
    work : float
        Simulated time summed over runs and variants, s.
    size : int
        Memory of the largest run's samples, bytes.
    """

    work: float
    size: int


def demand(library: Library, search: Search) -> Demand:
    """Return what it takes to simulate all runs again that a search finds."""
    work, size = 0.0, 0
    for run in _listed(library, search):
        if run.kind in _SIMULATED:
            work += run.duration * len(run.variants)
            size = max(size, samples_size(len(stream_columns(run.variants)), run.ticks))
    return Demand(work, size)


def replay_all(
    library: Library,
    search: Search,
    progress: Callable[[float], None] = lambda _: None,
    hold: Callable[[int], None] = lambda _: None,
) -> Replays:
    """Simulate all runs that a search finds again, one at a time, and say which have moved.

    An interruption (KeyboardInterrupt) ends it with the runs known by then.

    Parameters
    ----------
    library : Library
        Whose runs they are.
    search : Search
        Which of them.
    progress : callable
        Called with the share that is done.
    hold : callable
        Called with the memory of each run, bytes, before it is simulated.

    Raises
    ------
    StoreError
        If the list of runs cannot be read.
    """
    total, interrupted = library.index.page(search, limit=1).total, False
    replayed: list[RunReplay] = []

    def share(of_run: float) -> None:
        progress(min(1.0, (len(replayed) + of_run) / max(1, total)))

    try:
        for run in _listed(library, search):
            replayed.append(replay_one(library, run, share, hold))
            share(0.0)
    except KeyboardInterrupt:
        interrupted = True
    counts = {outcome: 0 for outcome in ("identical", "moved", "not replayable")}
    for each in replayed:
        counts[each.outcome] += 1
    return Replays(
        model=model_hash(),
        processor=processor(),
        total=max(total, len(replayed)),
        interrupted=interrupted,
        identical=counts["identical"],
        moved=counts["moved"],
        not_replayable=counts["not replayable"],
        runs=sorted(replayed, key=operator.attrgetter("distance"), reverse=True),
    )


def replay_one(
    library: Library, run: Run, progress: Callable[[float], None], hold: Callable[[int], None]
) -> RunReplay:
    """Simulate a run again, or say why it cannot be."""
    from pyarrow import ArrowException  # noqa: PLC0415 - the server starts without it

    answer = RunReplay(run=run.id, name=run.name, outcome="not replayable")
    try:
        prepared = again(library.complete(run.id))
        hold(prepared.size)
        with library.files.open(run.id) as file:
            comparison = replay(prepared, file, progress)
    except MemoryError:  # Arrow's, too; the others' results are kept
        answer.reasons = ["to simulate it again needs more memory than this process may have"]
        return answer
    except MotionLabError as error:
        answer.reasons = str(error).splitlines()
        return answer
    except (OSError, ArrowException) as error:
        answer.reasons = [f"its telemetry cannot be read: {error}"]
        return answer
    if not comparison.ticks or not comparison.channels:
        answer.reasons = ["the record has no channel that is simulated"]
    elif comparison.first is None:  # also of a record that lacks ticks, or a newer channel
        answer.outcome = "identical"
    else:
        answer.outcome = "moved"
        answer.first, answer.samples = comparison.first, comparison.samples
        answer.errors, answer.reasons = comparison.errors, comparison.reasons
        size = max((error.size for error in comparison.errors), default=0.0)
        answer.change = size if size != float("inf") else None
    return answer


def _listed(library: Library, search: Search) -> Iterator[Run]:
    """Yield the runs of a search, the oldest first, a page at a time."""
    cursor: str | None = None
    while True:
        page = library.index.page(search, sort="created", limit=LIMIT_MAX, cursor=cursor)
        yield from page.runs
        cursor = page.cursor
        if cursor is None:
            return
