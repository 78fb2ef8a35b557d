"""A selection among friction models as text."""

from __future__ import annotations

from motionlab.reports.tables import table
from motionlab.studies.friction.candidates import CANDIDATES
from motionlab.studies.friction.documents import FrictionModel, FrictionModelsDocument


def report(result: FrictionModelsDocument) -> str:
    """Return what is selected and why, errors of the models, and parameters of what remains."""
    unit = result.force_unit
    labels = {each.name: each.label for each in (*CANDIDATES, *result.models)}
    if result.selected is not None:
        verdict = labels[result.selected]
    else:
        verdict = "cannot tell: " + ", ".join(labels[name] for name in result.among)
    if not result.describes:
        verdict += "; none of the models describes this friction"
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
    shown = [model for model in result.models if model.name in result.among and model.parameters]
    if shown and result.selected is None:
        lines += ["", "Parameters differ by the model, and which model holds cannot be told:"]
    for model in shown:
        lines += ["", _parameters(model)]
    return "\n".join(lines)


def _parameters(model: FrictionModel) -> str:
    rows = [
        [
            name,
            f"{p.value:.5g}",
            "not determined" if p.high is None else f"{p.high - p.value:.2g}",
            p.unit,
        ]
        for name, p in model.parameters.items()
    ]
    return table((model.label, "value", "95 %, +-", "unit"), rows, right=(1, 2))
