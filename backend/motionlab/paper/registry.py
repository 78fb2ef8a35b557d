"""Every printed number, in the order in which it is computed and shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motionlab.config.shipped import did_you_mean
from motionlab.errors import ConfigError, FieldError
from motionlab.paper import (
    chosen_values,
    circle,
    forces,
    friction,
    motions,
    other_machines,
    platforms,
    sizing,
    stability,
    steady_state_errors,
    table1,
)
from motionlab.paper.document import PaperDocument, PaperGroup
from motionlab.paper.evidence import KINDS
from motionlab.paper.known_failures import known_failures
from motionlab.paper.printed_number import PrintedNumber

SOURCE = (
    "Huang, Cao, Peng, Wu, Liang, He, Design and Analysis of a Long-Stroke Planar Switched "
    "Reluctance Motor for Positioning Applications, IEEE Access 2019, doi "
    "10.1109/ACCESS.2019.2899038"
)

GROUPS = (
    PaperGroup(id=sizing.GROUP, title="Dimensions", about="Section II-A, equations (1) to (14)"),
    PaperGroup(id=forces.GROUP, title="Forces", about="Fig. 2, sections II-A and IV-A"),
    PaperGroup(id=platforms.GROUP, title="Moving platforms", about="Section II-B, Fig. 3"),
    PaperGroup(
        id=platforms.LIMITS, title="Velocities and accelerations", about="Sections II-B and IV-A"
    ),
    PaperGroup(id=stability.GROUP, title="Stability proof", about="Section III-C, (25) to (38)"),
    PaperGroup(
        id=steady_state_errors.GROUP,
        title="Control performance",
        about="Sections III-D, E, (39) to (42)",
    ),
    PaperGroup(id=friction.GROUP, title="Identified friction", about="Section IV-A, (43) to (48)"),
    PaperGroup(id=circle.GROUP, title="Circle, compensation from 90 s on", about="Fig. 5"),
    PaperGroup(id=table1.GROUP, title="Position errors", about="Table 1"),
    PaperGroup(id=motions.GROUP, title="Motions", about="Section IV-A, Figs 6 to 8"),
    PaperGroup(
        id=other_machines.GROUP,
        title="Other machines",
        about="Sections I, II-A and IV-B: what the paper quotes",
    ),
    PaperGroup(
        id=chosen_values.GROUP,
        title="Given as input",
        about="Choices, hardware and gains that the rest is computed from, so not judged",
    ),
)

_MODULES = (
    sizing,
    forces,
    platforms,
    stability,
    steady_state_errors,
    friction,
    circle,
    table1,
    motions,
    other_machines,
    chosen_values,
)


def quantities(only: Sequence[str] = ()) -> list[PrintedNumber]:
    """Return the printed numbers, group by group.

    Parameters
    ----------
    only : sequence of str
        Identifiers of rows or of groups; all rows when empty.

    Raises
    ------
    ConfigError
        Naming unknown identifiers.
    """
    every = [row for module in _MODULES for row in module.QUANTITIES]
    order = [group.id for group in GROUPS]
    every.sort(key=lambda row: order.index(row.group))
    known = [*order, *(row.id for row in every)]
    if wrong := [name for name in only if name not in known]:
        raise ConfigError(
            *(
                FieldError(
                    loc="only",
                    message=f"no row or group of that name{did_you_mean(name, known)}",
                    value=name,
                    range="a row or one of the groups " + ", ".join(order),
                )
                for name in wrong
            )
        )
    return [row for row in every if not only or row.id in only or row.group in only]


def paper() -> PaperDocument:
    """Return every printed number before anything is computed."""
    known: Mapping[str, str] = known_failures()
    return PaperDocument(
        source=SOURCE,
        groups=list(GROUPS),
        kinds=list(KINDS),
        rows=[q.row(known) for q in quantities()],
    )
