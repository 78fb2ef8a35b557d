"""No compensation: the LuGre observer runs, so that its estimate can be seen, but adds nothing."""

from __future__ import annotations

import dataclasses

from motionlab.laws import lugre_observer

LAW = dataclasses.replace(
    lugre_observer.LAW,
    name="off",
    label="no compensation",
    description="No friction is compensated; the observer runs all the same",
    parameters=(),
    adds=False,
)
