"""A selection among friction models as text."""

from __future__ import annotations

from motionlab.reports.tables import table
from motionlab.studies.friction.candidates import CANDIDATES
from motionlab.studies.friction.documents import FrictionModelsDocument


def report(result: FrictionModelsDocument) -> str:
    """Return what is selected and why, errors of the models, and the selected one's parameters."""
    unit = result.force_unit
    labels = {each.name: each.label for each in (*CANDIDATES, *result.models)}
    if result.selected is not None:
        verdict = labels[result.selected]
    else:
        verdict = "cannot tell: " + ", ".join(labels[name] for name in result.among)
    lines = [
        f"{result.name} {result.axis}, {result.duration:.3g} s at {result.rate:.4g} Hz, "
        f"{result.reversals} reversals: {verdict}",
        *(f"  {reason}" for reason in [*result.reasons, *result.notes]),
        "",
    ]
    rows = [
        [
            model.label,
            str(model.complexity),
            f"{model.error:.4g}",
            f"{model.difference:.2g} +- {model.difference_error:.1g}",
        ]
        for model in result.models
    ]
    heads = ("model", "parameters", f"held-out error, {unit}", "more than the least")
    lines.append(table(heads, rows, right=(1, 2, 3)))
    shown = next(m for m in result.models if m.name == (result.selected or result.best))
    if not shown.parameters:
        return "\n".join(lines)
    rows = [
        [
            name,
            f"{p.value:.5g}",
            "not determined" if p.high is None else f"{p.high - p.value:.2g}",
            p.unit,
        ]
        for name, p in shown.parameters.items()
    ]
    lines += ["", table((shown.label, "value", "95 %, +-", "unit"), rows, right=(1, 2))]
    return "\n".join(lines)
