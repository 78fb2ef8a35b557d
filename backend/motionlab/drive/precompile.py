"""Compile what a drive link and a virtual drive need, for later processes to find.

``python -m motionlab.drive.precompile``
"""

from __future__ import annotations

import contextlib
import os
import sys

from motionlab.drive.ethercat import BRD, Datagram, frame
from motionlab.drive.link.process import compile_loop
from motionlab.drive.virtual.frame_thread import STOP, carrier, run_loop
from motionlab.drive.virtual.segment import Segment, default_drive


def main() -> int:
    """Compile missing functions at low priority."""
    with contextlib.suppress(OSError):
        os.nice(10)
    segment = Segment()
    segment.exchange(frame([Datagram(BRD, 0, 0, bytes(1))]), 1)
    segment.advance(2)
    stopped = carrier(-1, 0, -1, 0.0)
    stopped.numbers[STOP] = 1
    run_loop(segment.arrays, stopped)
    compile_loop(default_drive())
    return 0


if __name__ == "__main__":
    sys.exit(main())
