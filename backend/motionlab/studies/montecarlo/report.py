"""A Monte Carlo study as text for people."""

from __future__ import annotations

from motionlab.studies.montecarlo.document import MonteCarloDocument, Quantiles

_SHOWN = {
    "max_abs_following_error": ("max |e|", 1e6, "um"),
    "rms_following_error": ("rms e", 1e6, "um"),
    "steady_state_error": ("steady |e|", 1e6, "um"),
    "settling_time": ("settling", 1e3, "ms"),
    "rms_force": ("rms force", 1.0, "N"),
    "saturated_fraction": ("saturated", 100.0, "%"),
}
_WIDTH = 10
_DECIDING = 5
"""Parameters told of an axis, those that decide most."""


def report(found: MonteCarloDocument) -> str:
    """Return tables of quantiles, the improvement, the spec, what decides, and the worst cases.

    Parameters
    ----------
    found : MonteCarloDocument
        From `motionlab.studies.montecarlo.cases.study`.

    Returns
    -------
    str
        Several lines.
    """
    lines = [
        f"{found.scenario}, {found.cases} plants around {found.plant}, seed {found.seed}; metrics "
        f"over {found.window['start']:g} s to {found.window['end']:g} s",
        *found.notes,
        "",
        f"{'':24}" + "".join(head.rjust(_WIDTH) for head in ("min", "5 %", "50 %", "95 %", "max")),
    ]
    for name, variant in found.variants.items():
        for axis, part in variant.axes.items():
            for metric, (title, factor, unit) in _SHOWN.items():
                quantiles = part.metrics[metric]
                if quantiles is not None:
                    lines.append(_row(f"{name} {axis}  {title}, {unit}", quantiles, factor))
        if variant.diverged:
            lines.append(f"{name} diverged in {variant.diverged} cases")
    if found.infeasible:
        lines.append(f"{found.infeasible} plants cannot follow the motion: in no row above")
    lines.append("")
    for axis, metrics in found.improvement.items():
        quantiles = metrics["max_abs_following_error"]
        if quantiles is not None:
            lines.append(_row(f"1 - B/A {axis}  max |e|, %", quantiles, 100.0))
    limits = [
        f"{limit * 1e6:g} um on {axis}"
        for axis in ("x", "y")
        if (limit := getattr(found.spec, axis)) is not None
    ]
    for name, variant in found.variants.items():
        if variant.meets is not None:
            meets = variant.meets
            lines.append(
                f"{name} stays within {' and '.join(limits)} in {meets.share:.1%} of all cases "
                f"(95 % interval {meets.low:.1%} to {meets.high:.1%})"
            )
    lines += _what_decides(found)
    lines.append("worst cases, --case N for what makes one:")
    seen: set[tuple[str, str]] = set()
    for worst in found.worst:
        if (worst.variant, worst.axis) not in seen:
            value = "diverged" if worst.value is None else f"{worst.value * 1e6:.3g} um"
            lines.append(f"  {worst.variant} {worst.axis}  case {worst.case}: {value}")
        seen.add((worst.variant, worst.axis))
    return "\n".join(lines)


def _what_decides(found: MonteCarloDocument) -> list[str]:
    """Return the parameters that correlate most with the largest following error.

    Of value and deviation of a parameter only the one that correlates more.
    """
    lines = [
        "rank correlation of max |e| with what was drawn, over the drawn range; chance exceeds "
        f"{found.significant:.2f} for any of them once in twenty studies:"
    ]
    for name, variant in found.variants.items():
        for axis, part in variant.axes.items():
            rhos = part.correlations["max_abs_following_error"]
            strongest: dict[str, tuple[float, str]] = {}
            for parameter, rho in zip(found.parameters[axis], rhos, strict=True):
                known = abs(strongest.get(parameter.path, (found.significant, ""))[0])
                if rho is not None and abs(rho) > known:
                    strongest[parameter.path] = rho, parameter.of
            most = sorted(strongest.items(), key=lambda one: -abs(one[1][0]))
            told = ", ".join(
                f"{'deviation of ' * (of == 'deviation')}{path} {rho:+.2f}"
                for path, (rho, of) in most[:_DECIDING]
            )
            lines.append(f"  {name} {axis}  {told or 'none beyond chance'}")
    return lines


def _row(title: str, quantiles: Quantiles, factor: float) -> str:
    values = (quantiles.min, quantiles.q05, quantiles.q50, quantiles.q95, quantiles.max)
    return title.ljust(24) + "".join(f"{value * factor:.3g}".rjust(_WIDTH) for value in values)
