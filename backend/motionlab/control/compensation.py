"""Which law of friction compensation a lane has; what the laws are: `motionlab.laws`."""

from __future__ import annotations

from typing import NamedTuple

from motionlab.lanes import Lanes


class Compensation(NamedTuple):
    """Parameters of each lane, beside those of its law."""

    law: Lanes  # number of the law in the kernel
    enabled: Lanes  # 1: add the estimate to the command; 0: only run the law
