"""A force map as text for people."""

from __future__ import annotations

import numpy as np

from motionlab.motor_design.fem.force_map import ForceMap
from motionlab.motor_design.fem.uncertainty import published, uncertainty

_CURRENTS = 6
_FINE = 361


def summary(force_map: ForceMap) -> dict[str, float]:
    """Return the figures by which maps are compared, SI.

    Returns
    -------
    dict
        ``peak_thrust`` and ``peak_position`` at the largest current, ``normal_force_aligned`` and
        ``normal_force_unaligned`` there, ``inductance_ratio`` aligned over unaligned at a tenth of
        it, and ``spline_error``, the largest difference of dW'/dx from the stress tensor.
    """
    d, i = force_map.document, force_map.i_max
    x = np.linspace(-force_map.tau / 2, 0.0, _FINE)
    thrust = force_map.thrust(x, i)
    at = int(np.argmax(thrust))
    aligned, unaligned = 0.0, force_map.tau / 2
    ratio = force_map.linkage(aligned, i / 10) / force_map.linkage(unaligned, i / 10)
    nodes = force_map.thrust(np.array(d.positions)[:, None], np.array(d.currents)[None, :])
    return {
        "peak_thrust": float(thrust[at]),
        "peak_position": float(x[at]),
        "normal_force_aligned": float(force_map.normal_force(aligned, i)),
        "normal_force_unaligned": float(force_map.normal_force(unaligned, i)),
        "inductance_ratio": float(ratio),
        "spline_error": float(np.max(np.abs(nodes - d.thrust))),
    }


def report(force_map: ForceMap) -> str:
    """Return thrust and normal force over position and current as tables, and the peaks.

    Parameters
    ----------
    force_map : ForceMap
        Any.

    Returns
    -------
    str
        Several lines.
    """
    d, s, i_max = force_map.document, summary(force_map), force_map.i_max
    g = d.geometry
    currents = np.linspace(0.0, i_max, _CURRENTS)[1:]
    x = np.array(d.positions)[len(d.positions) // 2 :: 2]
    lines = [
        f"Force map of one phase, {d.preset}: {d.method}",
        f"  tau = {g.tau * 1e3:g} mm, p = {g.p * 1e3:g} mm, g = {g.g * 1e3:g} mm, n = {g.n}, "
        f"l_m = {g.l_m * 1e3:g} mm, N = {g.N}",
        f"  content hash {d.content_hash}",
        "",
    ]
    for title, table in (
        ("thrust dW'/dx, N", force_map.thrust),
        ("normal force, N", force_map.normal_force),
    ):
        lines.append(f"{title:18}" + "".join(f"{f'{i:g} A':>10}" for i in currents))
        for position in x:
            row = "".join(f"{_plain(float(table(position, i))):>10}" for i in currents)
            lines.append(f"  x = {position * 1e3:8.3f} mm{row}")
        lines.append("")
    return "\n".join(
        [
            *lines,
            f"At {i_max:g} A: thrust {s['peak_thrust']:.2f} N at "
            f"x = {s['peak_position'] * 1e3:.2f} mm, normal force "
            f"{s['normal_force_aligned']:.1f} N aligned, "
            f"{s['normal_force_unaligned']:.1f} N unaligned",
            *_published(force_map),
            f"At {i_max / 10:g} A: inductance aligned over unaligned {s['inductance_ratio']:.3f}, "
            "of this map; the lambda of `motionlab design` is solved from the stack length",
            f"dW'/dx of the spline is within {s['spline_error']:.3f} N of the stress tensor",
        ]
    )


def _published(force_map: ForceMap) -> list[str]:
    """Return the paper's values for the same motor, with the model's stated uncertainty."""
    g = force_map.document.geometry
    trust = uncertainty(force_map.document.preset, g)
    return [
        *(
            f"  the paper, {p.method}: {p.thrust:g} N and {p.normal_force:g} N"
            + (f"; not comparable: {p.not_comparable}" if p.not_comparable else "")
            for p in published(g)
        ),
        f"  take thrust as good to {trust.thrust * 100:.0f} % and normal force to "
        f"{trust.normal_force * 100:.0f} %: {trust.reason}",
    ]


def _plain(force: float) -> str:
    return f"{force + 0.0:.2f}".replace("-0.00", "0.00")
