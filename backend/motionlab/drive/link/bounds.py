"""What a motion or an open-loop test may ask of the drives, checked before it begins."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from motionlab.config.drive import DriveConfig
from motionlab.config.planar import AXES
from motionlab.drive.link.carrier import LinkError
from motionlab.drive.link.shared import RUN_TICKS_MAX, TEST_CURRENT
from motionlab.timing import CONTROL_PERIOD


@dataclass(frozen=True)
class OpenLoopTest:
    """Phase currents tick by tick, without a controller, and how far they may move the axes."""

    currents: NDArray[np.float64]  # (ticks, 3, 2), of the phases a, b, c of x and y, A
    travel: tuple[float, float]  # of x and y from where it begins, m
    rest_ticks: int = 0  # at rest with current, after which it ends; 0 for never
    rest_from: int = 0  # first tick that counts as rest


def check_test(test: OpenLoopTest, config: DriveConfig) -> None:
    """Refuse a test that is too long, or beyond the bound of currents.

    Raises
    ------
    LinkError
        Saying which bound.
    """
    if len(test.currents) > RUN_TICKS_MAX:
        raise LinkError(f"a test takes at most {RUN_TICKS_MAX * CONTROL_PERIOD:.0f} s")
    for i, name in enumerate(AXES):
        most = TEST_CURRENT * getattr(config, name).current_max
        currents = test.currents[:, :, i]
        if not (currents.min() >= 0.0 and currents.max() <= most):  # NaN too
            raise LinkError(f"a test of {name} has currents beyond 0 to {most:g} A")


def check_reference(reference: NDArray[np.float64], config: DriveConfig) -> None:
    """Refuse a motion that is too long, or beyond the limits of position and speed.

    Raises
    ------
    LinkError
        Saying which limit.
    """
    if len(reference) > RUN_TICKS_MAX:
        raise LinkError(
            f"the motion takes {len(reference) * CONTROL_PERIOD:.0f} s; "
            f"at most {RUN_TICKS_MAX * CONTROL_PERIOD:.0f} s"
        )
    # Before the limits, with which every comparison of NaN is false.
    if not np.isfinite(reference).all():
        raise LinkError("the motion has a reference that is not a number")
    for i, name in enumerate(AXES):
        axis = getattr(config, name)
        least, most = reference[:, 0, i].min(), reference[:, 0, i].max()
        speed = np.abs(reference[:, 1, i]).max()
        if least < axis.position_min or most > axis.position_max:
            raise LinkError(
                f"the motion goes from {least * 1e3:.2f} to {most * 1e3:.2f} mm in {name}; "
                f"allowed {axis.position_min * 1e3:.2f} to {axis.position_max * 1e3:.2f} mm"
            )
        if speed > axis.velocity_max:
            raise LinkError(
                f"the motion is up to {speed * 1e3:.0f} mm/s fast in {name}; "
                f"at most {axis.velocity_max * 1e3:.0f} mm/s"
            )
