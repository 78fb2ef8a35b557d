"""Force sharing as tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from motionlab.reports.tables import table
from motionlab.studies.sharing.sharing import FitDocument, SharingDocument, UsedMap


def report(found: Sequence[SharingDocument]) -> str:
    """Return the comparison of several sharing functions for one command, a row each."""
    first = found[0]
    lines = [
        f"{first.force:g} N commanded over one pole pitch of {first.controller.tau * 1e3:g} mm, "
        f"currents up to {first.current_limit:g} A",
        f"Controller's map: {_name(first.controller)}; plant's map: {_name(first.plant)}",
        "",
    ]
    power = all(each.loss.power is not None for each in found)
    rows = [
        (
            each.law,
            f"{each.linear_up_to:.2f}",
            f"{each.reachable_most:.1f}",
            f"{each.thrust.mean:.2f}",
            f"{each.thrust.peak_to_peak:.3f}",
            _figure(each.thrust.relative, 100.0, 2),
            f"{each.thrust.rms:.3f}",
            f"{each.loss.power if power else each.loss.squared_current:.2f}",
            _figure(each.loss.relative, 1.0, 4),
            f"{each.max_current:.2f}",
        )
        for each in found
    ]
    heads = ("law", "linear to", "reaches", "mean", "ripple p-p", "ripple", "rms")
    heads += ("copper loss", "ratio", "i max")
    units = ("", "N", "N", "N", "N", "%", "N", "W" if power else "A^2", "", "A")
    lines += [
        table(heads, rows, right=range(1, len(heads)), units=units),
        "",
        "Ripple is that of the plant's thrust. Copper loss is the sum of the squared currents,",
        "times the resistance where there is one, mean over the pitch; its ratio is to that of",
        "force-per-ampere. Reaches: the largest thrust at the best place of the pitch.",
    ]
    return "\n".join(lines)


def fit_report(found: FitDocument) -> str:
    """Return a fitted analytic map."""
    m = found.force_map
    return (
        f"Fit of the analytic map to {found.name}: "
        f"F_pk = {m.F_pk:.2f} N, I_knee = {m.I_knee:.3f} A, h_2 = {m.h_2:.4f}, h_3 = {m.h_3:.4f}\n"
        f"Residual of the thrust: {found.relative_rms * 100:.1f} % rms of the largest at the same "
        f"current; {found.rms:.2f} N rms, {found.worst:.2f} N at most, at "
        f"x = {found.worst_position * 1e3:.2f} mm from aligned and {found.worst_current:g} A\n"
        f"As numbers for a controller's model: {{ tau = {m.tau:g}, F_pk = {m.F_pk:.5g}, "
        f"N_pk = {m.N_pk:.5g}, I_pk = {m.I_pk:g}, I_knee = {m.I_knee:.5g}, h_2 = {m.h_2:.5g}, "
        f"h_3 = {m.h_3:.5g} }}"
    )


def _figure(value: float | None, factor: float, digits: int) -> str:
    return "-" if value is None else f"{value * factor:.{digits}f}"


def _name(used: UsedMap) -> str:
    return f"{used.name or 'numbers'} ({used.kind})"
