"""The computation of all rows, with progress, figures and errata, and the report as text."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Mapping, Sequence

from motionlab import __version__
from motionlab.errors import MotionLabError
from motionlab.lanes import model_hash
from motionlab.paper import errata, figures
from motionlab.paper.documents import (
    KINDS,
    Erratum,
    JudgedRow,
    Kind,
    Number,
    PaperFigure,
    PartialReproduce,
    ReproduceDocument,
    ReproduceRequest,
    RowCount,
    RowSpread,
    RowSummary,
    RowValue,
)
from motionlab.paper.experiments import Experiments
from motionlab.paper.judgement import holds, is_better, known_failures, lax, status
from motionlab.paper.printed_number import PrintedNumber, RowResult
from motionlab.paper.registry import GROUPS, SOURCE, quantities
from motionlab.reports.units import Scale, scale_for
from motionlab.studies.montecarlo.documents import Quantiles

_PEAK = "max_abs_following_error"


def spread_of(row: PrintedNumber, experiments: Experiments) -> RowSpread | None:
    """Return the Monte Carlo study's quantiles for a row.

    Returns
    -------
    RowSpread or None
        None without a study, or where no motor has the number.
    """
    spread = row.spread
    if spread is None:
        return None
    document = experiments.study(spread.scenario)
    share = None
    quantiles: Quantiles | None
    if spread.variant is None:
        quantiles = document.improvement[spread.axis][spread.metric]
    else:
        statistics = document.variants[spread.variant].axes[spread.axis]
        quantiles = statistics.metrics[spread.metric]
        if spread.metric == _PEAK and row.paper is not None and row.band is not None:
            ends = row.paper if isinstance(row.paper, tuple) else (row.paper,)
            most = max(abs(end) for end in ends) + row.band
            kept = [peak is not None and peak <= most for peak in statistics.peaks]
            share = sum(kept) / len(kept)
    if quantiles is None:
        return None
    return RowSpread(
        what=spread.what,
        low=quantiles.q05,
        median=quantiles.q50,
        high=quantiles.q95,
        plants=quantiles.cases,
        share=share,
        cli=f"motionlab montecarlo {spread.scenario} --json",
    )


_PREFIXED = frozenset({"m", "s", "A/m", "W", "Hz"})
_WORDS = {
    "holds": ("holds", "32"),
    "fails": ("FAILS", "31;1"),
    "known_failure": ("known failure", "31"),
    "not_comparable": ("not comparable", "2"),
}
_TITLES = {kind.id: kind.title for kind in KINDS}
_KIND = max(map(len, _TITLES.values()))
_WIDE = 56
_WIDTH = 120


def report(document: ReproduceDocument, *, colour: bool = False) -> str:
    """Return tables of printed numbers and ours, group by group, then errata and the count.

    Parameters
    ----------
    document : ReproduceDocument
        From `motionlab.paper.reproduce.reproduce`.
    colour : bool
        Whether the words of the last column are coloured too, for a terminal.
    """
    lines = []
    for group in document.groups:
        lines += [f"{group.title} ({group.about})"]
        lines += [_line(row, colour) for row in document.rows if row.group == group.id]
        lines.append("")
    for row in document.rows:
        if row.status in {"fails", "known_failure"} or (row.holds and row.known):
            lines += _explained(row)
    if conflicts := [row for row in document.rows if row.conflict]:
        lines += ["", "Printed values in conflict with each other"]
        lines += [f"  {row.id}: {row.conflict}" for row in conflicts]
    if lax := [row for row in document.rows if row.lax]:
        lines += ["", "Lax: these rows would hold with nearly any model"]
        lines += [f"  {row.id}: lax: {row.lax}" for row in lax]
    if document.errata:
        lines += ["", "Errata"]
        for erratum in document.errata:
            lines += _erratum(erratum)
    return "\n".join([*lines, "", *_summary(document)])


def _summary(document: ReproduceDocument) -> list[str]:
    """Return a line on all rows and one on each kind of them."""
    s = document.summary
    total = (
        f"{s.holds} hold ({s.better} better than a bound asks for, {s.lax} lax), {s.fails} fail, "
        f"{s.known_failure} known failures, {s.not_comparable} not comparable; of these"
    )
    lines = [total]
    for kind in document.kinds:
        if count := s.kinds.get(kind.id):
            words = (
                (count.holds, "hold"),
                (count.lax, "of them lax"),
                (count.fails, "fail"),
                (count.known_failure, "known failures"),
                (count.not_comparable, "not comparable"),
            )
            counted = ", ".join(f"{n} {word}" for n, word in words if n)
            lines.append(f"  {kind.title:{_KIND}}  {counted:40}  {kind.about}")
    return lines


def _line(row: JudgedRow, colour: bool) -> str:
    word, code = _WORDS[row.status]
    word += ", better" * bool(row.better) + ", lax" * bool(row.lax)
    if colour:
        word = f"\x1b[{code}m{word}\x1b[0m"
    band = "" if row.band is None else f"+-{number(row.band, row.unit)}"
    quantity = row.quantity if len(row.quantity) <= _WIDE else row.quantity[: _WIDE - 1] + "…"
    paper = row.printed if row.paper is None else number(row.paper, row.unit)
    ours = number(row.ours, row.unit)
    state = f"{_TITLES[row.kind]:{_KIND}}  {word}"
    return f"  {row.id:26} {quantity:{_WIDE}} {paper:>20} {ours:>20} {band:>12}  {state}"


def _explained(row: JudgedRow) -> list[str]:
    head = f"{row.id}: {number(row.paper, row.unit)} printed, {number(row.ours, row.unit)} ours"
    why = row.error or row.known or row.reason
    if row.holds:
        why = "known_failures.toml lists it, but it holds now: remove it from that file"
    return textwrap.wrap(f"{head}. {why}", _WIDTH, subsequent_indent="    ")


def _erratum(erratum: Erratum) -> list[str]:
    scanned = " (as scanned)" if erratum.as_scanned else ""
    lines = textwrap.wrap(
        f"{erratum.place}{scanned}: {erratum.printed}",
        _WIDTH,
        initial_indent="  ",
        subsequent_indent="      ",
    )
    lines += textwrap.wrap(
        f"corrected: {erratum.corrected}",
        _WIDTH,
        initial_indent="    ",
        subsequent_indent="      ",
    )
    return lines + [f"      {step.what}: {number(step.value, step.unit)}" for step in erratum.steps]


def number(value: Number | None, unit: str) -> str:
    """Return a number, or both ends of a range, with an SI prefix where its unit takes one."""
    if value is None:
        return "-"
    ends = value if isinstance(value, tuple) else (value,)
    scale = Scale(1.0, "" if unit == "1" else unit)
    if unit in _PREFIXED:
        scale = scale_for([float(f"{end:.3e}") for end in ends], unit, micro="u")
    digits = " to ".join(f"{end / scale.size:.4g}" for end in ends)
    return f"{digits} {scale.unit}".rstrip()


Progress = Callable[[float, PartialReproduce | None], None]
"""Takes the share done, 0 to 1, and the rows so far when they have changed."""

_COST = {
    "force map by finite elements": 20.0,
    "identification of friction": 6.0,
    "fig5, 180 s": 2.0,
    "Fig. 5 by normal force": 8.0,
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


def has_failed(document: ReproduceDocument) -> bool:
    """Return whether a row fails, or a known failure now holds."""
    return not is_reproduced(document)


class _Reproduction:
    """One computation of the rows."""

    def __init__(self, only: Sequence[str], progress: Progress | None) -> None:
        self.quantities = quantities(only)
        self.whole = not only
        self.known = known_failures()
        self.progress = progress
        self.doing = ""
        self.done = 0.0
        self.pending: dict[str, float] = {q.doing: _cost(q) for q in self.quantities if q.source}
        self.pending |= {_study(q): _STUDY for q in self.quantities if q.spread}
        self.total = sum(self.pending.values()) + _QUICK
        self.rows: list[JudgedRow] = []
        self.figures: list[PaperFigure] = []
        self.experiments = Experiments(self._share)

    def document(self) -> ReproduceDocument:
        for group in GROUPS:
            group_rows = [q for q in self.quantities if q.group == group.id]
            for quantity in group_rows:
                self.rows.append(self._row(quantity))
            self.figures += figures.of_group(
                group.id, group_rows, self.experiments, whole=self.whole
            )
            self._tell()
            self.experiments.forget_long_runs()
        self.doing = "errata"
        all_errata = errata.errata(self.experiments) if self.whole else []
        return ReproduceDocument(
            version=__version__,
            model=model_hash(),
            source=SOURCE,
            groups=[g for g in GROUPS if any(row.group == g.id for row in self.rows)],
            kinds=list(KINDS),
            rows=self.rows,
            figures=self.figures,
            errata=all_errata,
            summary=summary(self.rows),
        )

    def _row(self, quantity: PrintedNumber) -> JudgedRow:
        self.doing = quantity.doing
        result = RowResult(None)
        if quantity.source is not None:
            try:
                result = quantity.source.compute(self.experiments)
            except MotionLabError as error:
                result = RowResult(None, error=str(error))
            self.done += self.pending.pop(quantity.doing, 0.0)
        spread = None
        if quantity.spread is not None:
            self.doing = _study(quantity)
            spread = spread_of(quantity, self.experiments)
            self.done += self.pending.pop(self.doing, 0.0)
        row = judged(quantity, result, self.known, spread)
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
    result: RowResult,
    known: Mapping[str, str],
    spread: RowSpread | None = None,
) -> JudgedRow:
    """Return the judged row of a printed number and its computation."""
    held = better = None
    too_easy = ""
    if quantity.comparison != "none" and quantity.paper is not None and quantity.band is not None:
        if result.ours is None:
            held = False  # a number that could not be computed does not hold
        else:
            judge = {"paper": quantity.paper, "ours": result.ours, "band": quantity.band}
            held = holds(quantity.comparison, **judge)
            better = is_better(quantity.comparison, **judge)
            too_easy = lax(quantity.comparison, **judge, rival=quantity.rival) if held else ""
    error = result.error
    if held is False and result.ours is None and error is None:
        error = "nothing was computed"
    return JudgedRow(
        **quantity.row(known).model_dump(),
        ours=result.ours,
        holds=held,
        status=status(held, known=quantity.id in known),
        better=better,
        lax=too_easy,
        values=[RowValue(label=label, value=value) for label, value in result.values.items()],
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
        kinds={kind: _count(of_kind) for kind, of_kind in of.items() if of_kind},
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
