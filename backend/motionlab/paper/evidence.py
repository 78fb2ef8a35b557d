"""Kinds of rows: the evidence that agreement with a printed value provides."""

from __future__ import annotations

from motionlab.paper.document import PaperKind

KINDS = (
    PaperKind(
        id="printed", title="printed value", about="A value or range that is printed, beside ours"
    ),
    PaperKind(id="claim", title="claim", about="What the text claims in words, beside ours"),
    PaperKind(
        id="formula",
        title="formula",
        about="A formula is printed: what it gives for the circle's gains, beside our run",
    ),
    PaperKind(
        id="recovered",
        title="recovered input",
        about="The motor was given the printed value, an experiment finds it again: this tests the "
        "experiment, not the machine",
    ),
    PaperKind(
        id="arithmetic",
        title="arithmetic",
        about="Other printed numbers put into a formula: it proves nothing of a machine",
    ),
    PaperKind(id="fit", title="fit", about="Ours was fitted to what is printed: it proves nothing"),
    PaperKind(
        id="input",
        title="input",
        about="Chosen by the paper, or given by its machine: no result of it",
    ),
    PaperKind(
        id="no_data",
        title="no data",
        about="A result that the paper prints without what it would take to compute it",
    ),
)
"""Every kind, in the order in which they are counted; only the last two are not comparable."""
