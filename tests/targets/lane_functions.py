"""Lane functions to be recorded, which need every way in which C is not Python."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes, Mask, compiled, round_down, select, square_root

TURNS = 3
HALF = 0.5  # of anything


class Spring(NamedTuple):
    """A spring and a damper."""

    stiffness: Lanes  # N/m
    damping: Lanes  # N s/m
    unread: Lanes  # anywhere


class Mass(NamedTuple):
    """State of a mass."""

    p: Lanes  # position, m
    v: Lanes  # velocity, m/s
    forgotten: Lanes  # read for its own next value only


class Report(NamedTuple):
    """What is put out."""

    largest: Lanes  # m
    default: Lanes  # a word of C
    swapped: Lanes
    far: Mask  # beyond 1 m


@compiled
def _force(spring: Spring, p: Lanes, v: Lanes) -> Lanes:
    """Return ``-(k p + d v)``, N."""
    return -(spring.stiffness * p + spring.damping * v)


@compiled
def both(x: Lanes, y: Lanes) -> tuple[Lanes, Lanes]:
    """Return the smaller and the larger one."""
    low = select(x < y, x, y)
    return low, x + y - low


@compiled
def round(x: Lanes) -> Lanes:
    """Return `x`: not what C's function of this name does."""
    return x + 0.0


@compiled
def swing(spring: Spring, s: Mass, kick: Lanes, kind: float) -> tuple[Mass, Report]:
    """Swing for some turns.

    The names `double`, `register` and `explicit` are no names in C.
    """
    double, register = s.p + kick, s.v
    explicit = double * HALF
    mass = Mass(explicit, register, s.forgotten * 2.0)
    before = mass.p
    for _ in range(TURNS):
        v = mass.v + 0.125 * _force(spring, mass.p, mass.v)  # by its old velocity
        mass = Mass(mass.p + 0.125 * v, v, mass.forgotten)

    mass = Mass(mass.v, mass.p, mass.forgotten)
    mass = Mass(mass.v, mass.p, mass.forgotten)

    # kept while its variable changes
    a, b = before, mass.p
    a, b = b, a
    old = a
    a = a + 1.0
    low, high = both(old, b)
    _, highest = both(a, high)
    root = square_root(abs(low * high))
    if kind == 1.0:
        root = round_down(root)
    largest = round(select(highest > root, highest, root))
    report = Report(largest, b, a - b, (abs(old) > 1.0) & ~(b > 2.0))
    return mass, report


@compiled
def branching(x: Lanes) -> Lanes:
    """Return nothing of use."""
    return 1.0 if x > 0.0 else x


@compiled
def remainder(x: Lanes) -> Lanes:
    """Return what lanes do not compute."""
    return x % 2.0
