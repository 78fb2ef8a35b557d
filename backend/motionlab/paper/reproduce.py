"""Computing every row, one after another, with progress; figures and errata with them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from motionlab import __version__
from motionlab.errors import MotionLabError
from motionlab.lanes import model_hash
from motionlab.paper import errata, figures
from motionlab.paper.document import (
    JudgedRow,
    Kind,
    PaperFigure,
    PartialReproduce,
    ReproduceDocument,
    RowCount,
    RowSpread,
    RowSummary,
    RowValue,
)
from motionlab.paper.evidence import KINDS
from motionlab.paper.experiments import Experiments
from motionlab.paper.known_failures import known_failures
from motionlab.paper.loose_bands import lax
from motionlab.paper.monte_carlo_rows import spread_of
from motionlab.paper.printed_number import PrintedNumber, RowResult
from motionlab.paper.registry import GROUPS, SOURCE, quantities
from motionlab.paper.request import ReproduceRequest
from motionlab.paper.verdict import holds, is_better, status

Progress = Callable[[float, PartialReproduce | None], None]
"""Takes the share done, 0 to 1, and the rows so far when they have changed."""

_COST = {
    "force map by finite elements": 20.0,
    "identification of friction": 6.0,
    "fig5, 180 s": 2.0,
}
"""Duration of the slow computations, s; all others _QUICK. Only the progress depends on it."""
_QUICK = 0.3
_STUDY = 3.0


def reproduce(only: Sequence[str] = (), progress: Progress | None = None) -> ReproduceDocument:
    """Compute the paper's numbers and judge them.

    Parameters
    ----------
    only : sequence of str
        Identifiers of rows or groups; everything when empty. The errata come with everything only.
    progress : callable, optional
        Called with the share done, and with the rows so far after each row; what it raises ends the
        work.

    Returns
    -------
    ReproduceDocument
        A row that fails, or could not be computed, is in it as such.

    Raises
    ------
    ConfigError
        If `only` holds an unknown identifier.
    """
    return _Reproduction(only, progress).document()


def plan(request: ReproduceRequest, source: object = None) -> list[str]:
    """Return the selected rows and groups; raise ConfigError for unknown ones."""
    quantities(request.only)
    return request.only


def has_failed(found: ReproduceDocument) -> bool:
    """Return whether a row fails, or a known failure now holds."""
    return not is_reproduced(found)


class _Reproduction:
    """One computation of the rows."""

    def __init__(self, only: Sequence[str], progress: Progress | None) -> None:
        self.wanted = quantities(only)
        self.whole = not only
        self.known = known_failures()
        self.progress = progress
        self.doing = ""
        self.done = 0.0
        self.pending: dict[str, float] = {q.doing: _cost(q) for q in self.wanted if q.source}
        self.pending |= {_study(q): _STUDY for q in self.wanted if q.spread}
        self.total = sum(self.pending.values()) + _QUICK
        self.rows: list[JudgedRow] = []
        self.figures: list[PaperFigure] = []
        self.experiments = Experiments(self._share)

    def document(self) -> ReproduceDocument:
        for group in GROUPS:
            wanted = [q for q in self.wanted if q.group == group.id]
            for quantity in wanted:
                self.rows.append(self._row(quantity))
            self.figures += figures.of_group(group.id, wanted, self.experiments, whole=self.whole)
            self._tell()
            self.experiments.forget_long_runs()
        self.doing = "errata"
        found = errata.errata(self.experiments) if self.whole else []
        return ReproduceDocument(
            version=__version__,
            model=model_hash(),
            source=SOURCE,
            groups=[g for g in GROUPS if any(row.group == g.id for row in self.rows)],
            kinds=list(KINDS),
            rows=self.rows,
            figures=self.figures,
            errata=found,
            summary=summary(self.rows),
        )

    def _row(self, quantity: PrintedNumber) -> JudgedRow:
        self.doing = quantity.doing
        found = RowResult(None)
        if quantity.source is not None:
            try:
                found = quantity.source.compute(self.experiments)
            except MotionLabError as error:
                found = RowResult(None, error=str(error))
            self.done += self.pending.pop(quantity.doing, 0.0)
        spread = None
        if quantity.spread is not None:
            self.doing = _study(quantity)
            spread = spread_of(quantity, self.experiments)
            self.done += self.pending.pop(self.doing, 0.0)
        row = judged(quantity, found, self.known, spread)
        self._tell(row)
        return row

    def _share(self, share: float) -> None:
        """Report the progress of the present experiment."""
        if self.progress is not None:
            ahead = self.pending.get(self.doing, 0.0) * min(share, 1.0)
            self.progress(min(1.0, (self.done + ahead) / self.total), None)

    def _tell(self, *more: JudgedRow) -> None:
        if self.progress is not None:
            partial = PartialReproduce(
                doing=self.doing, rows=[*self.rows, *more], figures=[*self.figures], errata=[]
            )
            self.progress(min(1.0, self.done / self.total), partial)


def _study(quantity: PrintedNumber) -> str:
    """Return the progress label of a row's Monte Carlo study."""
    return "" if quantity.spread is None else f"Monte Carlo, {quantity.spread.scenario}"


def judged(
    quantity: PrintedNumber,
    found: RowResult,
    known: Mapping[str, str],
    spread: RowSpread | None = None,
) -> JudgedRow:
    """Return the judged row of a printed number and its computation.

    Parameters
    ----------
    quantity : PrintedNumber
        The printed number.
    found : RowResult
        Computed result; empty for a row that is not comparable.
    known : mapping of str to str
        Identifiers of known failures and their reasons.
    spread : RowSpread, optional
        The number over many plausible motors; it judges nothing.
    """
    held = better = None
    too_easy = ""
    if quantity.comparison != "none" and quantity.paper is not None and quantity.band is not None:
        if found.ours is None:
            held = False  # a number that could not be computed does not hold
        else:
            judge = {"paper": quantity.paper, "ours": found.ours, "band": quantity.band}
            held = holds(quantity.comparison, **judge)
            better = is_better(quantity.comparison, **judge)
            too_easy = lax(quantity.comparison, **judge, rival=quantity.rival) if held else ""
    error = found.error
    if held is False and found.ours is None and error is None:
        error = "nothing was computed"
    return JudgedRow(
        **quantity.row(known).model_dump(),
        ours=found.ours,
        holds=held,
        status=status(held, known=quantity.id in known),
        better=better,
        lax=too_easy,
        values=[RowValue(label=label, value=value) for label, value in found.values.items()],
        monte_carlo=spread,
        error=error,
    )


def summary(rows: Sequence[JudgedRow]) -> RowSummary:
    """Return the number of rows by status, in all and of each kind."""
    of: dict[Kind, list[JudgedRow]] = {
        kind.id: [row for row in rows if row.kind == kind.id] for kind in KINDS
    }
    return RowSummary(
        **_count(rows).model_dump(),
        kinds={kind: _count(found) for kind, found in of.items() if found},
        come_to_hold=[row.id for row in rows if row.holds and row.known is not None],
    )


def _count(rows: Sequence[JudgedRow]) -> RowCount:
    count = [row.status for row in rows].count
    return RowCount(
        holds=count("holds"),
        fails=count("fails"),
        known_failure=count("known_failure"),
        not_comparable=count("not_comparable"),
        better=sum(bool(row.better) for row in rows),
        lax=sum(bool(row.lax) for row in rows),
    )


def is_reproduced(document: ReproduceDocument) -> bool:
    """Return whether no row fails and no known failure now holds."""
    return document.summary.fails == 0 and not document.summary.come_to_hold


def _cost(quantity: PrintedNumber) -> float:
    return _COST.get(quantity.doing, _QUICK)
