"""The machine of a session: a simulated one, or drives of a real one."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from motionlab.config.scenario import Scenario
from motionlab.simulation.simulation import ReadyEpoch
from motionlab.simulation.timeline import Timeline


class Machine(Protocol):
    """A machine under control, tick by tick.

    Attributes
    ----------
    tick : int
        The next tick.
    timeline : Timeline
        Reference and load.
    """

    tick: int
    timeline: Timeline

    @property
    def blocks(self) -> int:
        """Blocks of lanes, which advance one after another."""
        ...

    @property
    def scenario(self) -> Scenario:
        """The parameters in effect."""
        ...

    @property
    def failed_ticks(self) -> list[int | None]:
        """Of each variant the tick at which it diverged, or None while it has not."""
        ...

    @property
    def stopped(self) -> bool:
        """Whether a stop has come to its end."""
        ...

    def advance(self, samples: NDArray[np.float32]) -> int:
        """Advance as far as is possible at once; see `Simulation.advance`."""
        ...

    def references(self, start: int, stop: int) -> NDArray[np.float32]:
        """Return the reference over some ticks; see `Simulation.references`."""
        ...

    def adopt(self, changes: Sequence[ReadyEpoch]) -> int:
        """Replace the parameters, and return from which tick on."""
        ...

    def push(self, axis: int, force: float, ticks: int) -> None:
        """Push the mover of every variant with `force`, N."""
        ...

    def stop(self) -> None:
        """Brake the reference to rest, then command no current."""
        ...
