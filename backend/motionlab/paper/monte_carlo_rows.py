"""A row's number over many plausible motors."""

from __future__ import annotations

from motionlab.paper.document import RowSpread
from motionlab.paper.experiments import Experiments
from motionlab.paper.printed_number import PrintedNumber
from motionlab.studies.montecarlo.documents import Quantiles

_PEAK = "max_abs_following_error"


def spread_of(row: PrintedNumber, experiments: Experiments) -> RowSpread | None:
    """Return the Monte Carlo study's quantiles for a row.

    Parameters
    ----------
    row : PrintedNumber
        With or without a study.
    experiments : Experiments
        Runs it, once for each scenario.

    Returns
    -------
    RowSpread or None
        None without a study, or where no motor has the number.
    """
    asked = row.spread
    if asked is None:
        return None
    document = experiments.study(asked.scenario)
    share = None
    quantiles: Quantiles | None
    if asked.variant is None:
        quantiles = document.improvement[asked.axis][asked.metric]
    else:
        found = document.variants[asked.variant].axes[asked.axis]
        quantiles = found.metrics[asked.metric]
        if asked.metric == _PEAK and row.paper is not None and row.band is not None:
            ends = row.paper if isinstance(row.paper, tuple) else (row.paper,)
            most = max(abs(end) for end in ends) + row.band
            kept = [peak is not None and peak <= most for peak in found.peaks]
            share = sum(kept) / len(kept)
    if quantiles is None:
        return None
    return RowSpread(
        what=asked.what,
        low=quantiles.q05,
        median=quantiles.q50,
        high=quantiles.q95,
        plants=quantiles.cases,
        share=share,
        cli=f"motionlab montecarlo {asked.scenario} --json",
    )
