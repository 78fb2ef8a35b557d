"""Every printed number, in the order in which it is computed and shown."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from motionlab.config.named_configs import did_you_mean
from motionlab.errors import ConfigError, FieldError
from motionlab.paper.by_load import BY_LOAD_ROWS
from motionlab.paper.control import PERFORMANCE, PERFORMANCE_ROWS, STABILITY, STABILITY_ROWS
from motionlab.paper.design import LIMITS, PLATFORM_ROWS, PLATFORMS, SIZING, SIZING_ROWS
from motionlab.paper.documents import KINDS, PaperDocument, PaperGroup
from motionlab.paper.forces import FORCE_ROWS, FORCES, FRICTION, FRICTION_ROWS
from motionlab.paper.judgement import known_failures
from motionlab.paper.motions import CIRCLE, CIRCLE_ROWS, MOTION_ROWS, MOTIONS, TABLE, TABLE_ROWS
from motionlab.paper.printed_number import PrintedNumber
from motionlab.paper.uncomputed import (
    CHOSEN_VALUE_ROWS,
    CHOSEN_VALUES,
    OTHER_MACHINE_ROWS,
    OTHER_MACHINES,
)

SOURCE = (
    "Huang, Cao, Peng, Wu, Liang, He, Design and Analysis of a Long-Stroke Planar Switched "
    "Reluctance Motor for Positioning Applications, IEEE Access 2019, doi "
    "10.1109/ACCESS.2019.2899038"
)

GROUPS = (
    PaperGroup(id=SIZING, title="Dimensions", about="Section II-A, equations (1) to (14)"),
    PaperGroup(id=FORCES, title="Forces", about="Fig. 2, sections II-A and IV-A"),
    PaperGroup(id=PLATFORMS, title="Moving platforms", about="Section II-B, Fig. 3"),
    PaperGroup(id=LIMITS, title="Velocities and accelerations", about="Sections II-B and IV-A"),
    PaperGroup(id=STABILITY, title="Stability proof", about="Section III-C, (25) to (38)"),
    PaperGroup(
        id=PERFORMANCE,
        title="Control performance",
        about="Sections III-D, E, (39) to (42)",
    ),
    PaperGroup(id=FRICTION, title="Identified friction", about="Section IV-A, (43) to (48)"),
    PaperGroup(id=CIRCLE, title="Circle, compensation from 90 s on", about="Fig. 5"),
    PaperGroup(id=TABLE, title="Position errors", about="Table 1"),
    PaperGroup(id=MOTIONS, title="Motions", about="Section IV-A, Figs 6 to 8"),
    PaperGroup(
        id=OTHER_MACHINES,
        title="Other machines",
        about="Sections I, II-A and IV-B: what the paper quotes",
    ),
    PaperGroup(
        id=CHOSEN_VALUES,
        title="Given as input",
        about="Choices, hardware and gains that the rest is computed from, so not judged",
    ),
)

_ROWS = (
    *SIZING_ROWS,
    *FORCE_ROWS,
    *PLATFORM_ROWS,
    *STABILITY_ROWS,
    *PERFORMANCE_ROWS,
    *FRICTION_ROWS,
    *CIRCLE_ROWS,
    *BY_LOAD_ROWS,
    *TABLE_ROWS,
    *MOTION_ROWS,
    *OTHER_MACHINE_ROWS,
    *CHOSEN_VALUE_ROWS,
)


def quantities(only: Sequence[str] = ()) -> list[PrintedNumber]:
    """Return the printed numbers, group by group.

    Raises
    ------
    ConfigError
        Naming unknown identifiers.
    """
    order = [group.id for group in GROUPS]
    every = sorted(_ROWS, key=lambda row: order.index(row.group))
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
