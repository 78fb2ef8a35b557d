"""Force sharing as tables for people."""

from __future__ import annotations

from collections.abc import Sequence

from motionlab.studies.sharing.sharing import FitDocument, SharingDocument, UsedMap
from motionlab.tables import table


def report(found: Sequence[SharingDocument]) -> str:
    """Return the comparison of several sharing functions for one command, a row each."""
    first = found[0]
    lines = [
        f"{first.force:g} N commanded over one pole pitch of {first.controller.tau * 1e3:g} mm, "
        f"currents up to {first.current_limit:g} A",
        f"Controller's map: {_name(first.controller)}; plant's map: {_name(first.plant)}",
        "",
    ]
    rows = []
    for each in found:
        relative = each.thrust.relative
        share = "" if relative is None else f" {relative * 100:.2f} %"
        loss = f"{each.loss.squared_current:.2f} A^2"
        if each.loss.power is not None:
            loss = f"{each.loss.power:.2f} W"
        if each.loss.relative is not None:
            loss += f" ({each.loss.relative:.4f})"
        rows.append(
            (
                each.law,
                f"{each.linear_up_to:.2f} N",
                f"{each.linear_up_to:.1f} to {each.reachable_most:.1f} N",
                f"{each.thrust.mean:.2f} N",
                f"{each.thrust.peak_to_peak:.3f} N{share}",
                f"{each.thrust.rms:.3f} N",
                loss,
                f"{each.max_current:.2f} A",
            )
        )
    heads = ("law", "linear to", "reachable", "mean", "ripple p-p", "rms", "copper loss", "i max")
    lines += [
        table(heads, rows, right=range(1, len(heads))),
        "",
        "Ripple is that of the plant's thrust. Copper loss is the sum of the squared currents,",
        "times the resistance where there is one, mean over the pitch; in brackets over that of",
        "force-per-ampere.",
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


def _name(used: UsedMap) -> str:
    return f"{used.name or 'numbers'} ({used.kind})"
