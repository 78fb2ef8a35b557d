"""Steps without torque: the drives on the bus, their identity and limits, encoders by hand."""

from __future__ import annotations

import time
from collections.abc import Sequence
from typing import Any

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.commissioning.record import ConfigChange, Finding, FoundFigure

TRAVEL = 500e-6
"""How far an axis is moved by hand until its direction is known, m."""


class ByHand:
    """A mover pushed by hand from a position, m, and which way each axis was moved first."""

    def __init__(self, start: Sequence[float]) -> None:
        self._start = tuple(start)
        self._now = self._start
        self.travel: list[float | None] = [None, None]

    @property
    def moved(self) -> tuple[float, float]:
        """How far each axis is from where it was, m."""
        x, y = (now - start for now, start in zip(self._now, self._start, strict=True))
        return x, y

    @property
    def complete(self) -> bool:
        """Whether both axes have been moved far enough."""
        return None not in self.travel

    def note(self, position: Sequence[float]) -> None:
        """Take a position; the first move beyond `TRAVEL` tells the direction of its axis."""
        self._now = tuple(position)
        for axis, moved in enumerate(self.moved):
            if self.travel[axis] is None and abs(moved) >= TRAVEL:
                self.travel[axis] = moved


def find_drives(config: DriveConfig, drives: Sequence[dict[str, Any]]) -> Finding:
    """Return what was found on the bus."""
    expected = len(config.nodes)
    right = len(drives) == expected
    names = ", ".join(dict.fromkeys(drive["name"] for drive in drives))
    return Finding(
        at=time.time(),
        holds=right,
        text=f"{len(drives)} of {expected} found, in OP: {names}",
    )


def compare_identity(config: DriveConfig, drives: Sequence[dict[str, Any]]) -> Finding:
    """Return identity, rated current and limits of each drive beside the configuration."""
    rows, matching = [], 0
    for number, (node, drive) in enumerate(zip(config.nodes, drives, strict=True), start=1):
        name = f"{number} {node.axis} {node.phase}"
        right = (drive["vendor"], drive["product"]) == (node.vendor, node.product)
        right = (
            right and abs(drive["rated_current"] - node.rated_current) < 1e-3
        )  # the drive reports mA
        matching += right
        rows.append(
            FoundFigure(
                name=name,
                found=_identity(drive["vendor"], drive["product"], drive["rated_current"])
                + f", serial {drive['serial']}",
                expected=_identity(node.vendor, node.product, node.rated_current),
                holds=right,
            )
        )
        rows += [
            FoundFigure(
                name=f"{name}, {limit['name']}",
                found=str(limit["read"]),
                expected=str(limit["written"]),
                holds=limit["read"] == limit["written"],
            )
            for limit in drive["limits"]
        ]
    rated = " and ".join(f"{value:g} A" for value in _rated(config))
    limits = [row for row in rows if ", object" in row.name]
    held = sum(row.holds for row in limits)
    return Finding(
        at=time.time(),
        holds=all(row.holds for row in rows),
        text=f"{matching} of {len(drives)} match; {rated} rated; "
        f"{held} of {len(limits)} limits as asked for",
        rows=rows,
    )


def judge_encoders(config: DriveConfig, by_hand: ByHand) -> Finding:
    """Return whether positions grew when the mover was pushed towards positive positions."""
    rows, changes = [], []
    for axis, travel in zip(AXES, by_hand.travel, strict=True):
        direction = getattr(config, axis).direction
        right = travel is not None and travel > 0  # both are pushed towards positive positions
        rows.append(
            FoundFigure(
                name=axis,
                found=f"{1e3 * (travel or 0.0):+.3f} mm",
                expected="positive",
                holds=right,
            )
        )
        if not right:
            changes.append(ConfigChange(path=f"{axis}.direction", now=direction, then=-direction))
    wrong = " and ".join(row.name for row in rows if not row.holds)
    return Finding(
        at=time.time(),
        holds=not wrong,
        text=f"{wrong} counts the wrong way" if wrong else "both signs right",
        rows=rows,
        changes=changes,
    )


def _identity(vendor: int, product: int, rated: float) -> str:
    return f"0x{vendor:08X}, 0x{product:04X}, {rated:g} A"


def _rated(config: DriveConfig) -> list[float]:
    return sorted({node.rated_current for node in config.nodes})
