"""A platform's bending as text for people."""

from __future__ import annotations

from motionlab.motor_design.plate.document import Deflection, PlatformDocument
from motionlab.motor_design.plate.inputs import Shape


def report(document: PlatformDocument) -> str:
    """Return both designs side by side, the movers' gaps, and the paper's figures.

    Parameters
    ----------
    document : PlatformDocument
        Two designs, bent.

    Returns
    -------
    str
        Several lines.
    """
    forces = f"of the map {document.map}" if document.map else "as given"
    lines = [f"The {document.axis} platform under four normal forces, {forces}", ""]
    for name, design in document.designs.items():
        lines += [*_design(name, design), ""]
    if document.change is not None:
        lines.append(f"Largest deflection, new against previous: {document.change:+.1%}")
    p = document.paper
    return "\n".join(
        [
            *lines,
            f"The paper prints {p.previous * 1e6:.2f} and {p.new * 1e6:.2f} um, and "
            f"{p.change_printed:+.1%} (these figures give {p.change:+.1%}); not comparable:",
            f"  {p.reason}",
        ]
    )


def _design(name: str, d: Deflection) -> list[str]:
    lines = [
        f"{name}: {_shape(d.shape)}, {d.mass:.2f} kg",
        f"  largest deflection {d.largest * 1e6:.2f} um at x = {d.largest_x * 1e3:.0f} mm, "
        f"y = {d.largest_y * 1e3:.0f} mm; half the mesh changes it by {d.mesh_error * 1e6:.2g} um",
    ]
    for m in d.movers:
        gap = "" if m.gap is None else f", gap {m.gap * 1e3:.4f} mm"
        lines.append(
            f"  mover at x = {m.x * 1e3:4.0f} mm, y = {m.y * 1e3:4.0f} mm: {m.force:.1f} N, "
            f"{m.gap_change * 1e6:.2f} um nearer to the stator{gap}"
        )
    if d.mean_gap is not None and d.thrust_ratio is not None:
        lines.append(
            f"  at the mean gap of {d.mean_gap * 1e3:.4f} mm the largest thrust is "
            f"{d.thrust_ratio - 1:+.2%}, by the magnetic circuit; "
            f"motionlab map --set g={d.mean_gap:.4g} computes it"
        )
    return lines


def _shape(s: Shape) -> str:
    ribs = "no ribs"
    if s.rib_height > 0 and s.ribs_x + s.ribs_y > 0:
        ribs = (
            f"{s.ribs_x} by {s.ribs_y} ribs {s.rib_width * 1e3:g} mm wide, "
            f"{s.rib_height * 1e3:g} mm high"
        )
    return (
        f"{s.length * 1e3:g} x {s.width * 1e3:g} x {s.thickness * 1e3:g} mm, {ribs}, on {s.support}"
    )
