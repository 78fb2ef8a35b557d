"""``python -m tests.bench.unrecorded``: ``motionlab`` whose sessions are not recorded."""

from __future__ import annotations

import sys

from motionlab.__main__ import main
from motionlab.server.live.session_recorder import SessionRecorder

SessionRecorder.advanced = lambda *_, **__: None  # type: ignore[method-assign]
SessionRecorder.note = lambda *_: None  # type: ignore[method-assign]
SessionRecorder.end = lambda *_: None  # type: ignore[method-assign]
sys.exit(main())
