"""Errata of the paper, each with the computation that shows it."""

from __future__ import annotations

from motionlab.paper import errata_control, errata_design, errata_results
from motionlab.paper.document import Erratum
from motionlab.paper.experiments import Experiments


def errata(experiments: Experiments) -> list[Erratum]:
    """Return every erratum, in the paper's order, computed anew.

    Parameters
    ----------
    experiments : Experiments
        Source of runs, map and sizing for the computations.
    """
    modules = (errata_design, errata_control, errata_results)
    return [build(experiments) for module in modules for build in module.ERRATA]
