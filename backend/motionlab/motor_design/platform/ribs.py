"""Stiffness contributions of ribs below a plate."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.motor_design.platform.inputs import Shape


class Rib(NamedTuple):
    """Stiffness of one rib beyond that of the plate, and where it runs."""

    bending: float  # E I, N m^2
    torsion: float  # G J, N m^2
    places: tuple[float, ...]  # of the ribs' middles, across, m


def rib(shape: Shape, count: int, *, along: float, across: float) -> Rib:
    """Return the contribution of each of `count` ribs.

    The rib and the flange of plate that works with it bend about their common neutral axis. Beyond
    the flange's own bending, which the plate has, by the parallel axes

        I = w h^3/12 + A_r A_f/(A_r + A_f) ((t + h)/2)^2,  A_r = w h,  A_f = b_f t

    with the flange's width b_f = min(across/count, along/4): the rib's share of the plate, or what
    shear lag leaves of it. Its torsion is that of a rectangle,
    ``J = l s^3/3 (1 - 0.63 s/l + 0.052 (s/l)^5)`` with the longer side l and the shorter s.

    Parameters
    ----------
    shape : Shape
        Plate and section of the rib.
    count : int
        Ribs side by side, the outer ones flush with the plate's edges; one lies in the middle.
    along, across : float
        Size of the plate along the ribs and across them, m.
    """
    w, h, t = shape.rib_width, shape.rib_height, shape.thickness
    if count == 0 or h == 0:
        return Rib(0.0, 0.0, ())
    area, flange = w * h, min(across / count, along / 4) * t
    inertia = w * h**3 / 12 + area * flange / (area + flange) * ((t + h) / 2) ** 2
    short, long = sorted((w, h))
    slender = short / long
    torsion = long * short**3 / 3 * (1 - 0.63 * slender + 0.052 * slender**5)
    shear = shape.E / (2 * (1 + shape.nu))
    first = -(across - w) / 2
    apart = (across - w) / (count - 1) if count > 1 else 0.0
    places = tuple(first + apart * k for k in range(count)) if count > 1 else (0.0,)
    return Rib(shape.E * inertia, shear * torsion, places)
