"""Forces learnt of shipped motions, made up."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from motionlab.config.learnt_force import LearntForce, encoded
from motionlab.config.load import load_scenario
from motionlab.simulation.learnt import lap_of, places
from motionlab.trajectories.reference import sample


def known(force: NDArray[np.floating], motion: str = "circle") -> LearntForce:
    """Return a force, N, (ticks, 2), as if it had been learnt of a shipped motion."""
    reference = sample(load_scenario(motion).trajectory)
    return LearntForce(
        laps=1,
        places=places(reference, lap_of(reference)),
        x=encoded(force[:, 0]),
        y=encoded(force[:, 1]),
    )
